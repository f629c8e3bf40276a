"""Plates and coils at the ends of what is built and asked: is each answer within its error of a richer one?

Gaps of 10 um, tilts of 85 % of what touches, foils of 10 nm and blocks of 10 mm, plates of 100 mm, permeability 1e4,
one turn and sixty, corners of 0.01 mm, slots that close, 64 coils, a nut at 0.05 mm and at 1 m, from 1 Hz to the guard,
tolerances from 0.3 to 1e-6. Each is asked of a model and, for the reference, of a finer rung of it, of another model,
or of a scene that the asked one tends to: a plate with sharp corners, or a slot ten times as narrow. The violation is
what L is apart, in sums of the errors that both state, of which one is allowed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from extreme.plates import MM, coil, scene
from extreme.rows import DONE, Row, measured
from scipy.constants import c

from sits_mech.chain.models import MAGNETICS
from sits_mech.geometry.tracks import track_length
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Conductor, Sensor, Target

GUARD = c / track_length(coil("C", 0.0))
TOUCHING = float(np.arcsin(0.5 / 4.0))  # of 8 mm, half a millimetre up


@dataclass(frozen=True)
class Asked:
    """A scene at a pose and a frequency: model and tolerance, and those of the reference."""

    sensor: Sensor
    pose: Pose
    first: tuple[str, float] = ("planar", 1e-2)
    second: tuple[str, float] = ("planar", 1e-3)
    frequency: float = 1e6
    tends_to: Sensor | None = None  # the scene that the reference is asked for, where it is another one


def plate(thickness: float = 0.2, sigma: float = 5.8e7, mu: float = 1.0, turns: int = 12) -> Sensor:
    """Return two coils under a square plate of 8 mm [mm, S/m]."""
    bare = scene("planar", 8, thickness, sigma, mu)
    coils = tuple(each.model_copy(update={"turns": turns}) for each in bare.coils)
    return bare.model_copy(update={"coils": coils})


def with_nut(away: float) -> Sensor:
    """Return the same with a nut so far below the coils' tracks [mm]."""
    z = -(plate().coils[0].height / MM + away + 0.5)
    nut = Conductor(
        name="nut", material="copper", shape="rectangle", centre=(0.0, 0.0, z * MM), width=2 * MM, length=2 * MM,
        thickness=1 * MM,
    )
    return plate().model_copy(update={"conductors": (nut,)})


def outlined(*points: tuple[float, float]) -> Sensor:
    """Return two coils under a plate of some outline [mm]."""
    bare = plate()
    rim = tuple((x * MM, y * MM) for x, y in points)
    target = Target(conductivity=5.8e7, shape="outline", points=rim, thickness=0.2 * MM)
    return bare.model_copy(update={"target": target})


def rounded(radius: float = 0.01) -> Sensor:
    """Return a plate of 8 mm whose corners have a radius [mm]."""
    turns = np.pi / 2.0 * (np.arange(4)[:, None] + np.linspace(0.0, 1.0, 4))
    middles = (4.0 - radius) * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])[:, None, :]
    rim = middles + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    return outlined(*((float(x), float(y)) for x, y in rim.reshape(-1, 2)))


def slotted(width: float) -> Sensor:
    """Return a plate of 8 mm with a slot from its middle to its rim, along x [mm]."""
    h = 0.5 * width
    return outlined((4, h), (4, 4), (-4, 4), (-4, -4), (4, -4), (4, -h), (0, -h), (0, h))


def wound(turns: int, pitch: float, shape: str = "circle", radius: float = 0.0) -> Sensor:
    """Return two coils of so many turns, tracks as wide as their gaps; of squares the corners have a radius [mm]."""
    one = {"layers": 2, "turns": turns, "track_width": pitch * MM / 2, "track_gap": pitch * MM / 2}
    one |= {"track_thickness": 35e-6, "layer_pitch": 85e-6, "shape": shape}
    if shape == "circle":
        one |= {"inner_diameter": 2.2 * MM}
    else:
        one |= {"inner_width": 2.2 * MM, "inner_length": 2.2 * MM, "corner_radius": radius * MM}
    coils = tuple(Coil.model_validate(one | {"name": f"C{x:g}", "centre": (x * MM, 0.0)}) for x in (-4.0, 4.0))
    return plate().model_copy(update={"coils": coils})


def many() -> Sensor:
    """Return 64 coils in eight rows."""
    places = [(7.5 * (k % 8 - 3.5), 7.5 * (k // 8 - 3.5)) for k in range(64)]
    one = coil("C", 0.0).model_copy(update={"turns": 6})
    coils = [one.model_copy(update={"name": f"C{k}", "centre": (x * MM, y * MM)}) for k, (x, y) in enumerate(places)]
    return plate().model_copy(update={"coils": tuple(coils)})


def questions() -> dict[str, Asked]:
    """Return what is asked, by names; the first ones are quick."""
    up = Pose(0.3 * MM, 2 * MM)
    fem = (("planar", 1e-2), ("planar-fem", 1e-3))
    return {
        "gap 10 um": Asked(plate(), Pose(0.3 * MM, 1e-5), ("planar-fem", 1e-2), ("planar-fem", 1e-3)),
        "gap 10 um, too fine for bars": Asked(plate(), Pose(0.3 * MM, 1e-5)),
        "gap 50 um": Asked(plate(), Pose(0.3 * MM, 5e-5), *fem),
        "gap 0.5 mm, 85 % of the tilt to touching": Asked(plate(), Pose(0.0, 0.5 * MM, 0.85 * TOUCHING), *fem),
        "foil of 10 nm": Asked(plate(1e-5), up, *fem),
        "block of 10 mm": Asked(plate(10.0), up, *fem),
        "1 Hz": Asked(plate(), up, *fem, frequency=1.0),
        f"{0.99 * GUARD:.2g} Hz, below the guard": Asked(plate(), up, *fem, frequency=0.99 * GUARD),
        "1 turn": Asked(plate(turns=1), up, *fem),
        "tolerance 0.3": Asked(plate(), up, ("planar", 0.3)),
        "tolerance 1e-6": Asked(plate(), up, ("planar", 1e-3), ("planar", 1e-6)),
        "permeability 1e4": Asked(plate(sigma=1e7, mu=1e4), up, ("planar-fem", 3e-2), ("planar-fem", 3e-3)),
        "60 turns": Asked(wound(60, 0.04), up, *fem),
    } | in_space()


def in_space() -> dict[str, Asked]:
    """Return what is asked of the model in space, by names."""
    up, sheets = Pose(0.3 * MM, 2 * MM), (("sheets", 2e-2), ("sheets", 5e-3))
    leaning = Pose(0.0, 0.5 * MM, 0.42 * TOUCHING, 0.0, 0.42 * TOUCHING)
    wide = scene("axisymmetric", 100, 0.2, 5.8e7)
    return {
        "nut at 0.05 mm": Asked(with_nut(0.05), up, *sheets),
        "nut at 1 m": Asked(with_nut(1e3), up, *sheets),
        "64 coils": Asked(many(), up, *sheets),
        "gap 0.1 mm in space": Asked(plate(), Pose(0.3 * MM, 1e-4), *sheets),
        "gap 0.5 mm, 85 % of the tilt to touching, about both axes": Asked(plate(), leaning, *sheets),
        "foil of 10 nm in space": Asked(plate(1e-5), up, *sheets),
        "block of 10 mm in space": Asked(plate(10.0), up, *sheets),
        "60 turns in space": Asked(wound(60, 0.04), up, *sheets),
        "disc of 100 mm at 0.5 mm": Asked(wide, Pose(0.0, 0.5 * MM), ("sheets", 2e-2), ("axisymmetric", 1e-3)),
        "plate with corners of 0.01 mm radius": Asked(rounded(), up, *sheets, tends_to=plate()),
        "slot of 1 um that closes": Asked(slotted(1e-3), up, *sheets, tends_to=slotted(1e-4)),  # one of 10 um: 1 % more
        "coil with corners of 0.01 mm radius": Asked(
            wound(1, 0.04, "rectangle", 0.01), up, *sheets, tends_to=wound(1, 0.04, "rectangle")  # outer ones are round
        ),
    }


def poses(coarse: bool) -> Iterator[Row]:
    """Yield the rows; the coarse ones: the quick ones of one model."""
    for name, asked in questions().items():
        if not coarse or asked.second[0] == "planar":
            yield measured("magnetics", f"{asked.first[0]}: {name}", lambda asked=asked: richer(asked))


def richer(asked: Asked) -> Row:
    """Return how far an answer is from a richer one, in sums of the errors that both state."""
    found = [
        MAGNETICS[model](sensor, tolerance).impedance(asked.pose, asked.frequency)
        for sensor, (model, tolerance) in ((asked.sensor, asked.first), (asked.tends_to or asked.sensor, asked.second))
    ]
    change = [z.L - z.L0 for z in found]
    error = found[0].error_L + found[1].error_L + 1e-9 * found[0].L0.max()
    away = float(np.max(np.abs(change[0] - change[1]) / error))
    share = float(np.abs(change[0] - change[1]).max() / max(np.abs(change[1]).max(), 1e-300))
    remark = f"{share:.1e} of Delta L from {asked.second[0]} at {asked.second[1]:g}"
    return Row("", "", DONE, violation=away, allowed=1.0, estimated=found[0].report.estimated_error, remark=remark)
