"""How hard does silicone push back between plates? Measured cylinders of Ecoflex against the pad's model.

Cylinders 50 mm across and 30 mm high, of Ecoflex 00-10, 00-30 and 00-50 without thinner, were pressed by 20 mm at
10 mm/min (Instron 5900, load cell of 10 kN), compression and load recorded every 0.1 s. A. B. Dawood, Z. Zhang and
others, Hyperelastic Characterisation of Silicone Tissue Phantoms (2026), CC BY 4.0, repository
abubakardawood/tissue-phantom-material-database, data/EF10_0T/EF10_0T_A1.csv, .../EF30_0T_A1.csv and .../EF50_0T_A1.csv:
of each the first test of the first specimen, and of that some of the readings nearest to 5, 10, 15, 20 and 23 %,
unchanged. Moduli and deviations of ten tests, in an earlier version: abubakardawood/phantom-material-database,
data/processed/phantoms_table.csv, CC BY 4.0. Nothing is said of the plates' friction: the model's pad is bonded, and a
cylinder that slides freely stays one,

    F = A P(1 - u/t),    P the law's engineering stress in uniaxial compression.

As given: the catalogue's law, fitted to others' tensile tests. Adapted: under s times the load, a law of s times the
moduli rests at the same place, so s needs no new solution. It is fitted to the two smallest readings and predicts the
others; ln s is known beforehand as in sits_mech/analysis/bench/unknowns.py. Stiffening is not fitted, because the
laws' second terms carry 2 to 3 % of these forces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from elsewhere.rows import Row

from sits_mech.analysis.bench.unknowns import priors
from sits_mech.analysis.built.fit import Free, fit_parameters
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.quantities import Array, SolveFailed
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor
from sits_mech.silicone.homogeneous import engineering_stress

SOURCE = "Dawood and others 2026, repository abubakardawood/tissue-phantom-material-database (CC BY 4.0)"
DIAMETER, HEIGHT, PRESSED = 0.050, 0.030, 0.020  # [m]
TESTS = {  # compression [mm] and load [N]
    "ecoflex-00-30": np.array([(1.496570, 9.976390), (2.996640, 21.727590), (5.996600, 47.015070),
                               (6.996590, 56.569900)]),
    "ecoflex-00-10": np.array([(2.996580, 11.626680), (4.496600, 17.820620), (5.996570, 24.776710)]),
    "ecoflex-00-50": np.array([(2.996660, 33.769050), (4.496540, 53.589340), (5.996520, 74.784040),
                               (6.996610, 90.071670)]),
}
MODULI = {"ecoflex-00-10": (54.21, 2.38), "ecoflex-00-30": (97.26, 4.16), "ecoflex-00-50": (152.7, 4.8)}  # [kPa]
REPEATED = np.array([744.31079, 764.02661])  # first and fifth test of one specimen of 00-30 at 20 mm [N]
FITTED = 2  # readings that s is fitted to


@dataclass(frozen=True)
class Pressed:
    """A pressed cylinder: measured forces, those of the bonded one and of one that slides freely, as given [m, N]."""

    name: str
    u: Array
    measured: Array
    bonded: Array
    sliding: Array
    error: Array  # of the bonded one, relative
    spread: float  # of the law's sources
    factors: tuple[float, float]  # s of the bonded and of the sliding one


def cylinder(material: str) -> Sensor:
    """Return a pad of that silicone under a disc of its own outline."""
    size = f'diameter="{DIAMETER * 1e3} mm"'
    plate = f'material="copper", shape="disc", {size}, thickness="0.2 mm", load_height=0.0'
    return load_sensor("biorob2018", [f'elastomer={{{size}, thickness="{HEIGHT * 1e3} mm", material="{material}"}}',
                                      f"target={{{plate}}}"])


def upright(u: float) -> Control:
    """Return the control that presses by u [m] and holds the target upright and in place."""
    return Control(sink=u, d_h=0.0, alpha=0.0)


def factor(computed: Array, measured: Array, scatter: float, deviation: float) -> float:
    """Return what the moduli must be multiplied by: `scatter` of readings is relative, `deviation` is of ln s."""
    free = Free("modulus", 1.0, 0.1, 10.0, 0.1, deviation, ratio=True)
    found = fit_parameters(lambda P: P[:, :, None] * computed[:, None], measured[:, None], [free],
                           noise=scatter * measured[:, None])
    return float(found.values[0])


def scatter() -> float:
    """Return by how much repeated tests of one specimen differ, relative."""
    return float(np.ptp(REPEATED) / REPEATED.mean())


def pressed(material: str) -> Pressed:
    """Return a cylinder as measured and as computed."""
    sensor = cylinder(material)
    u, measured = TESTS[material].T * np.array([[1e-3], [1.0]])
    model = block_pad(sensor, 0.05)
    found = [model.controlled(upright(float(each))) for each in u]
    bonded = np.array([each.wrench.F_z for each in found])
    silicone = sensor.elastomer.silicone if sensor.elastomer is not None else None
    if silicone is None or silicone.spread is None:
        raise ValueError(f"material: must have sources whose spread is known; got {material}")
    sliding = -np.pi / 4 * DIAMETER**2 * engineering_stress(silicone.law, silicone.constants, -u / HEIGHT)
    known = priors(sensor, ("modulus",))[0].deviation
    two = slice(0, FITTED)
    s, free = (factor(each[two], measured[two], scatter(), known) for each in (bonded, sliding))
    return Pressed(material, u, measured, bonded, sliding, np.array([each.report.estimated_error for each in found]),
                   silicone.spread, (s, free))


def tests(coarse: bool) -> list[Pressed]:
    """Return all cylinders, or the first."""
    return [pressed(material) for material in (list(TESTS)[:1] if coarse else TESTS)]


def rows(found: list[Pressed]) -> Iterator[Row]:
    """Yield the forces that s was not fitted to, by the law as given and after adaptation."""
    for one in found:
        s, free = one.factors
        mean, deviation = MODULI[one.name]
        name = one.name.replace("ecoflex-", "Ecoflex ")
        for k in range(FITTED, one.u.size):
            F, bonded, sliding = (float(each[k]) for each in (one.measured, one.bonded, one.sliding))
            what, error = f"{name}, force at {one.u[k] * 1e3:.2f} mm", float(one.error[k])
            yield Row("silicone pressed", f"{what}, as given", "N", F, bonded, 2 * deviation / mean * F, SOURCE,
                      error * bonded, "tolerance: two deviations of the moduli of ten tests. The law's tensile test is "
                      "another laboratory's, its strain is crosshead travel; sources of this silicone go from this to "
                      f"{1 + one.spread:.1f} times as much, and {F / bonded:.2f} times as much was measured")
            yield Row("silicone pressed", f"{what}, after two of its points", "N", F, s * bonded, scatter() * F, SOURCE,
                      error * s * bonded, f"tolerance: repeated tests of one specimen differ by {100 * scatter():.1f} "
                      f"%. Moduli {s:.2f} times the catalogue's; a cylinder that slides freely would have "
                      f"{free:.2f} times, and {free * sliding:.1f} N. Open: partial slip on the plates and relaxation "
                      "over the test, which both lower later readings, and the zero of compression")


def followed() -> Iterator[Row]:
    """Yield the largest compression that the model follows, beside the test's."""
    try:
        reached = block_pad(cylinder("ecoflex-00-30"), 0.05).controlled(upright(PRESSED))
    except SolveFailed as failure:
        if failure.last is None:
            raise
        reached = failure.last
    yield Row("silicone pressed", "Ecoflex 00-30, compression that is followed", "%", 100 * PRESSED / HEIGHT,
              100 * (1 - reached.pose.d_v / HEIGHT), 0.0, SOURCE, remark="free faces have begun to fold onto the "
              "plates, and the model finds its equilibrium unstable beyond, with friction of 1 there at 26 %; the test "
              "goes on to the end without a drop in load")


def draw(found: list[Pressed], folder: Path) -> None:
    """Draw measured forces, and both cylinders as given and adapted."""
    with new_figure() as (figure, (axes,)):
        for number, one in enumerate(found):
            u, (s, free), colour = one.u * 1e3, one.factors, f"C{number}"
            axes.plot(u, one.measured, f"{colour}o", label=one.name.replace("ecoflex-", "Ecoflex "))
            for force, style in ((one.bonded, "--"), (s * one.bonded, "-"), (free * one.sliding, ":")):
                axes.plot(u, force, f"{colour}{style}")
        for style, label in (("--", "bonded, as given"), ("-", "bonded, adapted to two points"),
                             (":", "sliding freely, adapted")):
            axes.plot([], [], f"k{style}", label=label)
        axes.set(xlabel="compression of 30 mm [mm]", ylabel="force [N]")
        axes.legend()
        save_figure(figure, folder / "silicone_pressed.png")
