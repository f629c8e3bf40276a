"""What do a layer's thickness and silicone do to what a light load shows? A batch of pads, side by side.

A layer of thickness t and shear modulus mu under a rigid target of width w and length b answers light loads by

    d_h = F_x t / (mu w b),    d_v = F_z t / (E_c w b),    E_c = 3 mu (1 + 2 S^2),    S = w b / (2 t (w + b)),

S being the target's shape factor [1]: while the layer is thin, d_h grows with t and d_v with t^3. Dots are solved,
lines are these formulas, which take the silicone to end where the target does, and to keep its volume.

Knobs: THICKNESSES [m], SILICONES of the catalogue, LOAD [N, N], PROCESSES. Cases are kept in the folder, and the same
command goes on where it was stopped.

[1] A. N. Gent, P. B. Lindley, The compression of bonded rubber blocks, Proc. Inst. Mech. Eng. 173 (1959) 111.

Run ``python studies/batch.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import xarray as xr
from common.outputs import study_arguments

import sits_mech as sm
from sits_mech.report.pictures.style import new_figure, save_figure

SENSOR = "biorob2018"
THICKNESSES = (0.5e-3, 1e-3, 2e-3, 4e-3)  # [m]
SILICONES = ("ecoflex-00-30", "dragon-skin-30")
LOAD = sm.Wrench(F_x=0.02, F_z=0.05)  # [N]
PROCESSES = 2


def sensor(thickness: float, silicone: str) -> sm.Sensor:
    """Return the sensor with another layer."""
    return sm.load_sensor(SENSOR, [f"elastomer.thickness={thickness}", f'elastomer.material="{silicone}"'])


def case(thickness: float, silicone: str, tolerance: float) -> dict[str, float]:
    """Return displacements [m], and what the load adds to the inductance of each coil [H]."""
    loaded, idle = (sm.simulate(sensor(thickness, silicone), each, tolerance=tolerance) for each in (LOAD, sm.Wrench()))
    pose, change = loaded.equilibrium.pose, np.diagonal(loaded.impedance.L - idle.impedance.L)
    return {"d_h": pose.d_h, "d_v": thickness - pose.d_v, "C1": change[0], "C2": change[1]}


def closed_form(t: np.ndarray, silicone: str) -> dict[str, np.ndarray]:
    """Return displacements [m] of layers of thickness t [m], shape (n,)."""
    scene = sensor(THICKNESSES[0], silicone)
    (w, b), mu = scene.target.extent, scene.elastomer.silicone.shear_modulus
    S = w * b / (2.0 * t * (w + b))
    E_c = 3.0 * mu * (1.0 + 2.0 * S**2)
    return {"d_h": LOAD.F_x * t / (mu * w * b), "d_v": LOAD.F_z * t / (E_c * w * b)}


def draw(data: xr.Dataset, path: Path) -> None:
    """Draw what shears, what is pressed, and what is read, over the thickness."""
    t = np.geomspace(THICKNESSES[0], THICKNESSES[-1], 50)
    labels = {"d_h": "sheared by $d_h$ [um]", "d_v": "pressed by $d_v$ [um]", "C2": "fall of C2 [nH]"}
    with new_figure(height=0.42, columns=3, width=7.0) as (figure, axes):
        for each, (name, label) in zip(axes, labels.items(), strict=True):
            for k, silicone in enumerate(SILICONES):
                found = (-1e9 if name == "C2" else 1e6) * data[name].sel(silicone=silicone)
                each.plot(1e3 * data["thickness"], found, "os"[k], color=f"C{k}", label=f"{silicone}, solved")
                if name != "C2":
                    form = 1e6 * closed_form(t, silicone)[name]
                    each.plot(1e3 * t, form, color=f"C{k}", label=f"{silicone}, closed form")
            each.set(xlabel="thickness [mm]", ylabel=label, xscale="log", yscale="log")
            each.set_xticks([1e3 * thickness for thickness in THICKNESSES], [f"{1e3 * t:g}" for t in THICKNESSES])
            each.minorticks_off()
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        save_figure(figure, path)


def main() -> None:
    """Solve the batch and draw it."""
    coarse, folder = study_arguments(__doc__ or "")
    thicknesses, tolerance = (THICKNESSES[:3:2], 0.05) if coarse else (THICKNESSES, 1e-2)
    grid = {"thickness": thicknesses, "silicone": SILICONES, "tolerance": [tolerance]}
    with ProcessPoolExecutor(PROCESSES) as executor:
        data = sm.sweep(case, grid, executor=executor, folder=folder / "cases").squeeze("tolerance")
    draw(data, folder / "batch.png")
    table = data[["d_h", "d_v", "C1", "C2"]].drop_vars("tolerance").to_dataframe()
    print(table.to_string(float_format="{:.3e}".format))


if __name__ == "__main__":
    main()
