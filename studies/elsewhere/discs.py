"""Does a modulus measured one way foretell a bonded disc loaded another way? Natural rubber in compression and tension.

Compression. Discs 6.35 mm thick, S = D/(4 t), between plates on which they cannot slip. P. B. Lindley, Engineering
Design with Natural Rubber (Malaysian Rubber Producers' Research Association), table 3 and pages 26 to 28, sums up
experiments on vulcanizates by their hardness:

    E_c = E (1 + 2 k S^2)/(1 + E_c/E_inf),      F = E_c A e (1 + e),    e the compression over t, up to 15 %

with E, k, E_inf (the bulk modulus) and G of simple shear; those of 30 to 45 IRHD have no black. The readings themselves
are in its figures only. As transcribed by R. Holland in rivt-example-04 (MIT), with table and pages. The disc is
computed from G alone, and after s of pressed.py is fitted to two of its points.

Tension. The disc of rubber.py, pulled, by cmaurini/poker-chip (MIT), reference/gent_lindley_data.py, with the two
points that follow those there. The machine of stiffness k_m lengthens too:

    extension(sigma) = e(sigma) + sigma A/(k_m t),      e by the stated E.

As given there is no machine; 1/k_m is fitted to two points and predicts two. The same file corrects the curve with
k_m = 1930 N/mm (stiffness_KT_oscar; N/m by its comment, but used with mm and MPa).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from elsewhere.pressed import factor, upright
from elsewhere.rows import Row
from elsewhere.rubber import EXTENSION, MEASURED_E, MEASURED_K, PULLED, SQUARE_CM, STRESS, modulus, pad

from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import Array, Wrench
from sits_mech.report.pictures.style import new_figure, save_figure

LINDLEY = "Lindley, Engineering Design with Natural Rubber, table 3, by rivt-example-04 (MIT)"
MATERIALS = {40: (1.50, 0.45, 0.85), 30: (0.92, 0.30, 0.93), 45: (1.80, 0.54, 0.80)}
"""E and G [MPa] and k [-] by hardness [IRHD], which is stated to +-2."""
BULK = 1000.0  # E_inf of all of them [MPa]
THICKNESS, DIAMETER = 6.35, 25.4  # of the disc of S = 1 [mm]
FACTORS = np.array([0.5, 1.0, 2.0, 4.0])  # S; s is fitted to the first two
HARDNESS = 0.08  # of G, for 2 IRHD: 0.45 to 0.54 MPa are 5 of them
ROUNDED = 0.01  # of the table's numbers
HARD = "tolerance: hardness is stated to +-2"
STRAINS = np.array([0.05, 0.10, 0.15])  # e; s is fitted to the first
PULLS = np.array([*EXTENSION[2:], 0.1157, 0.1295]), np.array([*STRESS[2:], 8.8221 * SQUARE_CM, 9.7858 * SQUARE_CM])
PULLED_T, PULLED_A = 1.9e-3, np.pi * 1e-4  # [m, m^2]
MACHINE = 1930e3  # [N/m]
OPEN, READ = 0.10, 0.02  # of the disc's own extension, as in rubber.py, and of what was digitised


@dataclass(frozen=True)
class Computed:
    """Published values, those computed from what is given and after adaptation, and their estimated errors."""

    x: Array
    published: Array
    given: Array
    adapted: Array
    error: Array

    def at(self, k: int) -> tuple[float, float, float, float]:
        """Return what is published, given, adapted and open at a point."""
        return float(self.published[k]), float(self.given[k]), float(self.adapted[k]), float(self.error[k])


def apparent(hardness: int, S: Array) -> Array:
    """Return E_c by the table [MPa]."""
    E, _, k = MATERIALS[hardness]
    alone = E * (1.0 + 2.0 * k * S**2)
    return np.asarray(alone / (1.0 + alone / BULK))


def compressed(hardness: int, tolerance: float) -> Computed:
    """Return E_c over S at small strain [MPa]."""
    G = MATERIALS[hardness][1] * 1e6
    found = [modulus("disc", DIAMETER * S, THICKNESS, tolerance, mu=G, bulk=BULK * 1e6) for S in FACTORS]
    given, error = np.array(found).T / 1e6
    published = apparent(hardness, FACTORS)
    s = factor(given[:2], published[:2], ROUNDED, HARDNESS)
    return Computed(FACTORS, published, given, s * given, error)


def loaded(hardness: int) -> Computed:
    """Return the force over e of the disc of S = 1 [N]."""
    model = block_pad(pad("disc", DIAMETER, THICKNESS, mu=MATERIALS[hardness][1] * 1e6, bulk=BULK * 1e6), 0.05)
    found = [model.controlled(upright(e * THICKNESS * 1e-3)) for e in STRAINS]
    given = np.array([each.wrench.F_z for each in found])
    error = np.array([each.report.estimated_error for each in found]) * given
    published = apparent(hardness, np.ones(1)) * np.pi / 4 * DIAMETER**2 * STRAINS * (1 + STRAINS)
    s = factor(given[:1], published[:1], ROUNDED, HARDNESS)
    return Computed(STRAINS, published, given, s * given, error)


def pulled() -> tuple[Computed, float]:
    """Return extension over stress of the pulled disc, and the machine's compliance after two points [m/N]."""
    extension, stress = PULLS
    model = block_pad(pad("disc", 20.0, PULLED_T * 1e3, mu=MEASURED_E / 3, bulk=MEASURED_K), 0.05)
    found = [model.equilibrium(Wrench(F_z=-float(each) * PULLED_A)) for each in stress]
    given = np.array([each.pose.d_v / PULLED_T - 1.0 for each in found])
    error = np.array([each.report.estimated_error for each in found]) * given
    per = stress * PULLED_A / PULLED_T  # extension per compliance
    compliance = float((extension - given)[:2] @ per[:2] / (per[:2] @ per[:2]))
    return Computed(stress, extension, given, given + compliance * per, error), compliance


def stiffness(hardness: int, one: Computed) -> Iterator[Row]:
    """Yield the rows of small compression."""
    for k, S in enumerate(one.x):
        p, given, adapted, error = one.at(k)
        what = f"E_c at {hardness} IRHD, S = {S:g}"
        yield Row("bonded discs", f"{what}, by G as given", "MPa", p, given, HARDNESS * p, LINDLEY, error, HARD)
        if k > 1:
            yield Row("bonded discs", f"{what}, after two of its points", "MPa", p, adapted, 0.05 * p, LINDLEY, error,
                      "tolerance: none stated, 5 % taken. A law of one modulus has E = 3 G and k = 1; the harder these "
                      "rubbers are the less they do, and k = 0.8 alone is 20 % of a thin disc")


def forces(hardness: int, one: Computed) -> Iterator[Row]:
    """Yield the rows of large compression."""
    for k, e in enumerate(one.x):
        p, given, adapted, error = one.at(k)
        what = f"force at {hardness} IRHD, S = 1, {100 * e:.0f} %"
        form = ("the published form, not a reading: a thin disc, whose stiffness goes with t^-3, has e (1 + 3 e/2) for "
                "e (1 + e), and the model lies between")
        yield Row("bonded discs", f"{what}, by G as given", "N", p, given, HARDNESS * p, LINDLEY, error,
                  f"{HARD}; {form}")
        if k:
            yield Row("bonded discs", f"{what}, after one of its points", "N", p, adapted, e**2 * p, LINDLEY, error,
                      f"tolerance: e^2, of a form that is stated to be approximate; {form}")


def tension(one: Computed, compliance: float) -> Iterator[Row]:
    """Yield the rows of the pulled disc."""
    for k in (2, 3):
        p, given, adapted, error = (100 * each for each in one.at(k))
        what = f"extension at {one.x[k] / 1e6:.3f} MPa"
        yield Row("disc pulled", f"{what}, as given", "%", p, given, OPEN * given + READ * p, PULLED, error,
                  "tolerance: E to 3 %, thickness to 0.01 cm, 10 %, and digitised to 2 %; the machine lengthens too")
        yield Row("disc pulled", f"{what}, after two of its points", "%", p, adapted, READ * p, PULLED, error,
                  "tolerance: digitised to 2 %")
    p, given, *_ = one.at(1)
    share = (OPEN * given + READ * p) / (p - given)
    yield Row("disc pulled", "stiffness of the machine, after two points", "N/mm", MACHINE / 1e3, 1e-3 / compliance,
              share * MACHINE / 1e3, PULLED, remark="tolerance: what 10 % of the disc and 2 % of reading make of it")


def draw(tables: dict[int, Computed], pull: Computed, folder: Path) -> None:
    """Draw the compression moduli over S, and the pulled disc."""
    with new_figure() as (figure, (axes,)):
        for number, (hardness, one) in enumerate(tables.items()):
            axes.plot(one.x, one.given / one.published, f"C{number}s--", label=f"{hardness} IRHD, by G as given")
            axes.plot(one.x, one.adapted / one.published, f"C{number}o-", label="after two of its points")
        axes.axhline(1.0, color="k", linewidth=0.6)
        axes.set_ylim(0.9, 1.1)
        axes.set(xlabel="shape factor S [-]", ylabel="computed over published E_c [-]")
        axes.legend(loc="lower right")
        save_figure(figure, folder / "discs_compressed.png")
    with new_figure() as (figure, (axes,)):
        for values, style, label in ((pull.given, "C1s--", "computed, as given"),
                                     (pull.adapted, "C1-", "with the machine, by two points"),
                                     (pull.published, "C0o", "measured")):
            axes.plot(100 * values, pull.x / 1e6, style, label=label)
        axes.set(xlabel="extension [%]", ylabel="stress [MPa]", xlim=(0, None), ylim=(0, None))
        axes.legend()
        save_figure(figure, folder / "disc_and_machine.png")
