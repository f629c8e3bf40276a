"""How stiff is rubber bonded between plates? Published closed forms and one measured disc against the pad's model.

A disc of diameter D and thickness t between rigid plates, shape factor ``S = D/(4 t)``, force over area and strain:

    E_a = E (1 + 2 S^2)                          Gent and Lindley 1959; a square block likewise, S = side/(4 t)
    E_a = K (1 - 2 I_1(y)/(y I_0(y))),  y = S sqrt(48 mu/K)      compressible, thin (Chalhoub and Kelly 1990)
    E_c = 4/3 E (1 + S^2)                        long strip, S = width/(2 t)

Measured: a disc of 20 mm by 1.9 mm, E = 18 kg/cm^2, pulled (A. N. Gent and P. B. Lindley, Proc. R. Soc. A 249 (1959)
195, figure 2, digitised in the repository cmaurini/poker-chip, reference/gent_lindley_data.py). The testing machine
gives way too: Kumar and Lopez-Pamies (J. Mech. Phys. Solids 150 (2021) 104359) correct the slope, as digitised there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from elsewhere.rows import Row
from scipy.special import i0, i1

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.linear import linear_layer, linear_pad
from sits_mech.quantities import Array, Wrench
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

GENT = "Gent and Lindley 1959 (Proc. Inst. Mech. Eng. 173, 111), as in Strojniski vestnik 60 (2014) 506"
THIN = "Chalhoub and Kelly, Int. J. Solids Struct. 26 (1990) 743"
TAKEN = "no tolerance stated; 10 % taken"
SQUARE = "; the formula of the disc is low for a square: its thin limit is 2.25 E S^2 (6.75 mu S^2), Kelly 1997"
PULLED = "Gent and Lindley 1959 (Proc. R. Soc. A 249, 195), figure 2, by cmaurini/poker-chip"
MU, BULK = 30e3, 30e9  # [Pa]; nearly incompressible
SQUARE_CM = 98066.5  # one kg/cm^2 [Pa]
EXTENSION = np.array([0.0086, 0.0173, 0.0328, 0.0691])
STRESS = np.array([0.2718, 1.0873, 2.4465, 5.3130]) * SQUARE_CM
CORRECTED = 0.5854e6 / 0.02475  # slope freed of the machine [Pa]
MEASURED_E, MEASURED_K = 18 * SQUARE_CM, 2e9  # the bulk modulus of natural rubber, to some 20 %



def pad(shape: str, width: float, thickness: float, mu: float = MU, bulk: float = BULK) -> Sensor:
    """Return a bonded pad under a target of its own outline, or a strip of one metre; sizes in millimetres."""
    size = {
        "disc": f'diameter="{width} mm"', "square": f'width="{width} mm", length="{width} mm"',
        "strip": f'width="{width} mm", length="1 m"',
    }[shape]
    law = f'{{law="neo-hookean", shear_modulus={mu}, bulk_modulus={bulk}}}'
    plate = f'material="copper", shape="{"disc" if shape == "disc" else "rectangle"}", {size}, thickness="0.2 mm"'
    rubber = f'{size}, thickness="{thickness} mm", contact="never", material={law}'
    return load_sensor("biorob2018", [f"elastomer={{{rubber}}}", f"target={{{plate}, load_height=0.0}}"])


def modulus(shape: str, width: float, thickness: float, tolerance: float, **silicone: float) -> tuple[float, float]:
    """Return force over area and strain of a pad at small strain, and its estimated error [Pa]; sizes in mm."""
    made = (linear_layer if shape == "strip" else linear_pad)(pad(shape, width, thickness, **silicone), tolerance)
    stiffness, error = made.stiffness
    area = {"disc": np.pi * width**2 / 4 * 1e-6, "square": width**2 * 1e-6, "strip": width * 1e-3}[shape]
    value = float(abs(stiffness[1, 1])) * thickness * 1e-3 / area
    return value, error * value


def blocks(coarse: bool) -> tuple[list[Row], dict[str, Array]]:
    """Return the rows of closed forms, and shape factor, computed and published over E of each kind."""
    rows, curves = list[Row](), dict[str, Array]()
    factors = (0.5, 2.0) if coarse else (0.25, 0.5, 1.0, 2.0, 4.0)
    tolerance, E = (0.05 if coarse else 1e-2), 3 * MU
    for shape in ("disc", "square", "strip"):
        points = []
        for S in factors:
            t = 10.0 / (2 * S if shape == "strip" else 4 * S)
            value, error = modulus(shape, 10.0, t, tolerance)
            published = 4 / 3 * (1 + S**2) if shape == "strip" else 1 + 2 * S**2
            points.append((S, value / E, published))
            remark = TAKEN + (SQUARE if shape == "square" else "")
            rows.append(Row("bonded blocks", f"E_a/E of a {shape}, S = {S:g}", "-", published, value / E,
                            0.1 * published, GENT, error=error / E, remark=remark))
        curves[shape] = np.array(points)
    return [*rows, thin(tolerance)], curves


def thin(tolerance: float) -> Row:
    """Return the row of a compressible thin disc."""
    S, mu, K = 10.0, MU, 1000 * MU
    value, error = modulus("disc", 10.0, 0.25, tolerance, bulk=K)
    y = S * np.sqrt(48 * mu / K)
    thin_one = float(K * (1 - 2 * i1(y) / (y * i0(y))))
    return Row("bonded blocks", "E_c of a disc, S = 10, K = 1000 mu", "kPa", thin_one / 1e3, value / 1e3,
               thin_one / 1e3 / S, THIN, error=error / 1e3, remark="terms of order 1/S are left out")


def pulled(coarse: bool) -> tuple[list[Row], Array]:
    """Return the rows of the measured disc, and its extension and stress as computed at finite strain [-, Pa]."""
    tolerance = 0.05 if coarse else 1e-2
    silicone = {"mu": MEASURED_E / 3, "bulk": MEASURED_K}
    value, error = modulus("disc", 20.0, 1.9, tolerance, **silicone)
    raw = float(np.polyfit(EXTENSION, STRESS, 1)[0])
    open_ = "E given to 3 %, thickness to 0.01 cm (5 % of S^2 taken), digitised to 2 %: 10 %"
    rows = [
        Row("disc pulled", "E_a as read from the curve, to 7 %", "MPa", raw / 1e6, value / 1e6, 0.1 * raw / 1e6, PULLED,
            error=error / 1e6, remark=f"{open_}; the testing machine's own extension is in the curve"),
        Row("disc pulled", "E_a freed of the machine", "MPa", CORRECTED / 1e6, value / 1e6, 0.1 * CORRECTED / 1e6,
            "Kumar and Lopez-Pamies 2021, by cmaurini/poker-chip", error=error / 1e6, remark=open_),
    ]
    model = block_pad(pad("disc", 20.0, 1.9, **silicone), 5 * tolerance)
    area, loads = np.pi * 1e-4, STRESS[1:3:1] if coarse else STRESS[1:]
    found = [model.equilibrium(Wrench(F_z=-float(stress) * area)) for stress in loads]
    curve = np.array([((each.pose.d_v - 1.9e-3) / 1.9e-3, stress) for each, stress in zip(found, loads, strict=True)])
    return rows, curve


def draw(curves: dict[str, Array], curve: Array, folder: Path) -> None:
    """Draw the apparent modulus over shape factor, and the pulled disc."""
    with new_figure() as (figure, (axes,)):
        for number, (shape, points) in enumerate(curves.items()):
            S, computed, published = points.T
            axes.plot(S, 100 * (computed / published - 1), f"C{number}o-", label=shape)
        for limit in (-10.0, 10.0):
            axes.axhline(limit, color="k", linewidth=0.6, linestyle="--", label="10 %" if limit > 0.0 else None)
        axes.set(xlabel="shape factor S [-]", ylabel="computed minus closed form [%]")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        save_figure(figure, folder / "bonded_blocks.png")
    with new_figure() as (figure, (axes,)):
        axes.plot(100 * EXTENSION, STRESS / 1e6, "C0o", label="measured, machine included")
        axes.plot(100 * curve[:, 0], curve[:, 1] / 1e6, "C1s-", label="computed (block)")
        axes.plot([0, 2.4], [0, 0.024 * CORRECTED / 1e6], "k--", label="corrected for the machine")
        axes.set(xlabel="extension [%]", ylabel="stress [MPa]")
        axes.legend()
        save_figure(figure, folder / "disc_pulled.png")
