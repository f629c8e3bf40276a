"""Scenes for the three-dimensional model: one coil and metal by chance, at a pose.

The first forty have copper and aluminium of twelve kinds, then come a close foil, and twenty coaxial permeable parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Conductor, Sensor, Target, load_sensor

METAL, COUNT = 41, 61  # scenes without permeable parts, all
KINDS = ("foil", "disc", "block", "foil r", "plate r", "block r", "two", "two r", "ground", "ground drawn", "ring",
         "disc")
THICKNESS = {"foil": (1e-5, 7e-5), "disc": (1e-4, 5e-4), "block": (1e-3, 5e-3)}  # [m]
GAP, FREQUENCY = (5e-5, 5e-3), (5e3, 2.5e7)  # [m], [Hz]
PERMEABLE = {  # relative permeability, conductivity [S/m], thickness [m], loss tangent of fixed parts
    "steel": ((50.0, 500.0), (1e6, 1e7), (1e-4, 2e-3), 0.0),
    "ferrite": ((20.0, 2000.0), (1e-3, 1e-1), (3e-4, 3e-3), 0.05),
    "rubber": ((1.5, 5.0), (1e-6, 1e-3), (5e-4, 3e-3), 0.02),
}
FIXED = 0.4  # share of these that lie behind the coil
PERMEABLE_GAP, PERMEABLE_FREQUENCY = (1e-4, 3e-3), (5e3, 1e6)  # [m], [Hz]
COILS = (  # the catalogue's, a flat one, a large one
    {}, {"layers": 1, "turns": 20, "inner_diameter": 3e-3},
    {"layers": 2, "turns": 25, "inner_diameter": 6e-3, "track_width": 2e-4, "track_gap": 1.5e-4,
     "track_thickness": 7e-5, "layer_pitch": 3e-4},
)
SIGNS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


class SheetScene(NamedTuple):
    """A scene and its pose."""

    kind: str
    sensor: Sensor
    pose: Pose
    coaxial: bool  # whether all its metal are discs about the coil's axis


def sheet_scene(number: int) -> SheetScene:
    """Return a scene, the same in every run; after forty a foil whose finer answers were once worse."""
    if number == METAL - 1:
        return close_foil()
    rng, base = np.random.default_rng([65, number]), load_sensor("biorob2018")

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    changed = {"centre": (0.0, 0.0), **COILS[int(rng.choice(3, p=[0.5, 0.25, 0.25]))]}
    coil = base.coils[0].model_copy(update=changed)
    if number >= METAL:
        return permeable(tuple(PERMEABLE)[number % len(PERMEABLE)], base, coil, log, bool(rng.uniform() < FIXED))
    kind = KINDS[number % len(KINDS)]
    a, gap, frequency = coil.outer_diameter / 2, log(*GAP), log(*FREQUENCY)
    r, thick = a * log(0.4, 2.0), {"f": "foil", "b": "block"}.get(kind[0], "disc")
    if kind.startswith(("two", "ring")):
        thick = tuple(THICKNESS)[int(rng.integers(3))]
    if kind.startswith("ground"):
        thick = tuple(THICKNESS)[int(rng.integers(2))]
    t = min(log(*THICKNESS[thick]), r)
    metal = {"material": "copper" if rng.uniform() < 0.6 else "aluminium", "thickness": t}
    ratio = log(0.5, 2.0) ** 0.5
    (x, y), tilt = (rng.uniform(-0.3, 0.3, 2) * a).tolist(), float(rng.uniform(-0.3, 0.3)) * min(gap / r, 0.3)
    low, wide = log(1e-4, 1e-3), a * log(0.8, 2.0)
    rectangle = {"shape": "rectangle", "width": 2 * r * ratio, "length": 2 * r / ratio}
    target, parts, pose = None, (), Pose(0.0, gap)
    if kind in ("foil", "disc", "block", "two"):
        target = Target(shape="disc", diameter=2 * r, **metal)
    if kind.endswith(" r"):
        target, pose = Target(**rectangle, **metal), Pose(x, gap, tilt, y)
    if kind == "ring":
        target = Target(shape="ring", diameter=2 * r, inner_diameter=r, **metal)
    if kind.startswith("two"):
        form = {"shape": "disc", "diameter": 2 * wide}
        if kind == "two r":
            form = {"shape": "rectangle", "width": 2 * wide, "length": 2 * wide * ratio}
        parts = (Conductor(name="G", material="copper", thickness=3.5e-5,
                           centre=(0.0, 0.0, -coil.height - low - 3.5e-5), **form),)
    if kind == "ground":
        parts = (Conductor(name="G", shape="disc", diameter=2 * r, centre=(0.0, 0.0, -coil.height - gap - t), **metal),)
    if kind == "ground drawn":
        corners = tuple((p * r * ratio, q * r / ratio) for p, q in SIGNS)
        parts = (Conductor(name="G", shape="outline", points=corners, centre=(x, y, -coil.height - gap - t), **metal),)
    sensor = base.model_copy(update={
        "coils": (coil,), "target": target, "conductors": parts, "frequency": frequency, "elastomer": None,
    })
    return SheetScene(kind, sensor, pose, kind in ("foil", "disc", "block", "two", "ground", "ring"))


def permeable(
    kind: str, base: Sensor, coil: Coil, log: Callable[[float, float], float], fixed: bool
) -> SheetScene:
    """Return a coaxial disc of steel, ferrite or filled rubber, a target or fixed, up to four coils wide."""
    (mu, sigma, thickness, loss), a = PERMEABLE[kind], coil.outer_diameter / 2
    gap, r = log(*PERMEABLE_GAP), a * log(0.4, 4.0)
    part = {"shape": "disc", "diameter": 2 * r, "thickness": min(log(*thickness), r), "conductivity": log(*sigma),
            "relative_permeability": log(*mu)}
    z = -coil.height - gap - part["thickness"]
    metal = {"target": None if fixed else Target(**part),
             "conductors": (Conductor(name="P", loss_tangent=loss, centre=(0.0, 0.0, z), **part),) * fixed}
    changed = {"coils": (coil,), "frequency": log(*PERMEABLE_FREQUENCY), "elastomer": None, **metal}
    return SheetScene(kind, base.model_copy(update=changed), Pose(0.0, gap), True)


def close_foil() -> SheetScene:
    """Return 18 um of copper, 3 mm wide, 0.1 mm over the catalogue's coil at 25 MHz."""
    base = load_sensor("biorob2018")
    foil = Target(shape="disc", diameter=3e-3, thickness=18e-6, material="copper")
    coil = base.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    changed = {"coils": (coil,), "target": foil, "frequency": 25e6, "elastomer": None}
    return SheetScene("foil", base.model_copy(update=changed), Pose(0.0, 1e-4), True)
