"""Which scenes does the loader accept? Random ones from the bounds of its keys, each with something to ask of it.

All keys, shapes, laws and kinds are drawn. Three scenes of four are drawn about a length of their own from 0.1 mm to
1 m, their parts within some decades of it, as somebody might build them; in the fourth each number comes, with a chance
of one in eight, from all that bounds.py allows: 1 nm to 1 km, 1 uHz to 1 THz, 1e-9 to 1e20 S/m. What the loader
refuses (parts that overlap, sizes that cannot be) is drawn again: `random_case` returns what it accepts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sits_mech.quantities import Pose, Wrench
from sits_mech.readout.converter import CONVERTERS
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.sensor import SceneError, Sensor, sensor_from

Table = dict[str, Any]
LAWS = ("neo-hookean", "mooney-rivlin", "yeoh", "ogden", "gent")
_TRIES = 400
_FINE = {"inductance": 0.06, "pose": 0.02, "simulate": 0.02}  # share that is asked to better than 0.1, a third of
# whose time the others take: whether an answer stands shows in them


@dataclass(frozen=True)
class Case:
    """A scene and what is asked of it: `kind` is "inductance" at a pose, "pose" under a load, or "simulate"."""

    number: int
    sensor: Sensor
    kind: str
    given: Pose | Wrench
    model: str
    tolerance: float

    @property
    def words(self) -> str:
        """What is asked, in short."""
        scene = self.sensor
        layer = "" if scene.elastomer is None else f", {scene.elastomer.kind} of {scene.elastomer.silicone.law or ''}"
        plate = "no target" if scene.target is None else scene.target.shape
        coils = f"{len(scene.coils)} {scene.coils[0].shape}"
        metal = f", {len(scene.conductors)} plates" if scene.conductors else ""
        return f"{self.number}: {self.kind} by {self.model} to {self.tolerance:.0e}: {coils}, {plate}{layer}{metal}"


@dataclass(frozen=True)
class Dice:
    """Random numbers about a length; `wild` is the chance of one from all of a key's bounds."""

    rng: np.random.Generator
    size: float
    wild: float

    def log(self, low: float, high: float, bounds: tuple[float, float] | None = None) -> float:
        """Return a number between two, its logarithm uniform; by chance one from the bounds of its key."""
        if bounds is not None and self.chance(self.wild):
            low, high = bounds
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def length(self, low: float, high: float) -> float:
        """Return a length between two shares of the scene's [m]."""
        return min(max(self.log(low * self.size, high * self.size, (1e-9, 1e3)), 1e-9), 1e3)

    def count(self, high: int, bound: int = 1000) -> int:
        """Return a whole number from one."""
        return int(self.log(1.0, high + 0.99, (1.0, bound + 0.99)))

    def chance(self, share: float) -> bool:
        """Whether something happens that does so in a share of all cases."""
        return bool(self.rng.random() < share)

    def one_of(self, *choices: Any) -> Any:
        """Return one of some."""
        return choices[int(self.rng.integers(len(choices)))]

    def sign(self, size: float) -> float:
        """Return a number of a size, of either sign."""
        return size if self.chance(0.5) else -size


def random_case(number: int) -> Case:
    """Return the case of a number: always the same, one that the loader accepts."""
    for attempt in range(_TRIES):
        rng = np.random.default_rng([18, number, attempt])
        wild = 0.125 if number % 4 == 3 else 0.0
        dice = Dice(rng, float(np.exp(rng.uniform(np.log(1e-4), 0.0))), wild)
        try:
            sensor = sensor_from(_scene(dice), f"random {number}")
        except SceneError:
            continue
        return _case(number, dice, sensor)
    raise SceneError(f"random {number}: must be drawn within {_TRIES} tries; none was accepted")


def _scene(dice: Dice) -> Table:
    """Return the tables of a scene."""
    table: Table = {"name": "random", "frequency": dice.log(1.0, 1e9, (1e-6, 1e12)), "coils": _coils(dice)}
    if dice.chance(0.9):
        table["target"] = _target(dice)
        if dice.chance(0.75):
            table["elastomer"] = _layer(dice, table["target"])
    if dice.chance(0.3):
        table["conductors"] = [_plate(dice, number) for number in range(dice.count(3, 6))]
    if dice.chance(0.06):
        table["substrate_radius"] = dice.length(0.5, 100.0)
    table["readout"] = {
        "converter": dice.one_of(*CONVERTERS, "none"),
        "parallel_capacitance": dice.log(1e-11, 1e-8, (1e-15, 1.0)),
        "idle_coil": dice.one_of("shorted", "open"),
    }
    return table


def _coils(dice: Dice) -> list[Table]:
    """Return equal coils on a square grid."""
    shape = dice.one_of("circle", "circle", "circle", "rectangle", "path")
    one = _path(dice) if shape == "path" else _turned(dice, shape)
    coil = Coil.model_validate(one | {"name": "C", "centre": (0.0, 0.0)}) if _is_coil(one) else None
    count = dice.one_of(*3 * (1, 1, 2, 2, 3, 4, 4), 9, 16, 64)
    row = count if count < 4 else round(count**0.5)
    pitch = (coil.outer_diameter if coil else dice.size) * (1.0 + dice.log(1e-3, 1.0))
    places = [(k % row - 0.5 * (row - 1), k // row - 0.5 * ((count - 1) // row)) for k in range(count)]
    return [one | {"name": f"C{k}", "centre": (pitch * x, pitch * y)} for k, (x, y) in enumerate(places)]


def _is_coil(table: Table) -> bool:
    """Whether a coil's table is accepted."""
    try:
        Coil.model_validate(table | {"name": "C", "centre": (0.0, 0.0)})
    except ValueError:
        return False
    return True


def _turned(dice: Dice, shape: str) -> Table:
    """Return a coil of turns."""
    turns, layers = dice.count(60), dice.count(4)
    table: Table = {"shape": shape, "turns": turns, "layers": layers, "track_width": dice.length(0.01, 0.4) / turns}
    table |= {"track_gap": dice.length(0.01, 0.2) / turns, "track_thickness": dice.length(1e-4, 1e-2)}
    table["layer_pitch"] = table["track_thickness"] * (1.0 + dice.log(0.1, 30.0))
    if dice.chance(0.2):
        table["directions"] = [dice.one_of(1, -1) for _ in range(layers)]
    if shape == "circle":
        return table | {"inner_diameter": dice.length(0.01, 1.0), "winding": dice.one_of("rings", "rings", "spiral")}
    sides = {"inner_width": dice.length(0.05, 1.0), "inner_length": dice.length(0.05, 1.0)}
    most = (min(sides.values()) + table["track_width"]) / 2
    rounded = {"corner_radius": dice.log(table["track_width"] / 2, most)} if dice.chance(0.5) else {}
    return table | sides | rounded


def _path(dice: Dice) -> Table:
    """Return free tracks: a square spiral, or a walk that goes to and fro."""
    count, size, width = dice.count(20), dice.length(0.2, 1.0), dice.length(1e-3, 1e-2)
    thickness = dice.length(1e-4, 1e-2)
    z = -0.5 * thickness - (dice.length(1e-3, 0.1) if dice.chance(0.3) else 0.0)
    if dice.chance(0.5):
        radii = 0.5 * size * (1.0 + np.arange(4 * count) / 8.0)
        angles = 0.25 * np.pi + 0.5 * np.pi * np.arange(4 * count)
        points = [(r * np.cos(a), r * np.sin(a), z) for r, a in zip(radii, angles, strict=True)]
    else:
        step = size / count
        corners = ((k * step, size * (((k + 1) // 2) % 2)) for k in range(count + 1))
        points = [(x + dice.rng.uniform(-0.2, 0.2) * step, y, z) for x, y in corners]
    return {"shape": "path", "path": [points], "track_width": width, "track_thickness": thickness}


def _metal(dice: Dice) -> Table:
    """Return what a plate is made of."""
    if dice.chance(0.4):
        return {"material": dice.one_of(*4 * ("copper", "aluminium", "brass"), "ferrite")}
    table = {"conductivity": dice.log(1e2, 1e9, (1e-9, 1e20))}
    return table | ({"relative_permeability": dice.log(1.0, 1e4, (1.0, 1e7))} if dice.chance(0.1) else {})


def _outline(dice: Dice) -> Table:
    """Return shape and sizes of a plate."""
    shape = dice.one_of("rectangle", "rectangle", "disc", "disc", "outline")
    if shape == "rectangle":
        return {"shape": shape, "width": dice.length(0.1, 10.0), "length": dice.length(0.1, 10.0)}
    if shape == "disc":
        return {"shape": shape, "diameter": dice.length(0.1, 10.0)}
    corners, size = 3 + dice.count(20), dice.length(0.1, 5.0)
    angles = 2.0 * np.pi * (np.arange(corners) + dice.rng.uniform(0.0, 0.9, corners)) / corners
    radii = 0.5 * size * dice.rng.uniform(0.3, 1.0, corners)
    rim = [(r * np.cos(a), r * np.sin(a)) for r, a in zip(radii, angles, strict=True)]
    hole = 0.05 * size * dice.log(1e-2, 1.0)
    holes = [[(-hole, -hole), (hole, -hole), (hole, hole), (-hole, hole)]]
    return {"shape": shape, "points": rim} | ({"holes": holes} if dice.chance(0.3) else {})


def _target(dice: Dice) -> Table:
    """Return a target."""
    table = _outline(dice) | _metal(dice) | {"thickness": dice.log(1e-8, 1e-2, (1e-9, 1e3))}
    if dice.chance(0.15):
        table |= {"net_current": "free", "planar_boundary_radius": dice.length(10.0, 1e3)}
    return table | ({"load_height": dice.length(1e-3, 1.0)} if dice.chance(0.2) else {})


def _layer(dice: Dice, target: Table) -> Table:
    """Return a layer about as wide as its target."""
    kind, thickness = dice.one_of("box", "box", "box", "cylinder", "pillars"), dice.length(1e-3, 5.0)
    if target["shape"] == "outline":
        across = along = 2.0 * max(max(abs(x), abs(y)) for x, y in target["points"])
    else:
        across, along = (target.get(key, target.get("diameter")) for key in ("width", "length"))
    overhang = [dice.one_of(1.0, dice.log(0.2, 5.0)) for _ in range(2)]
    table: Table = {"material": _silicone(dice), "thickness": thickness}
    table["contact"] = dice.one_of("auto", "always", "never")
    if kind == "pillars":
        pitch = min(across, along) / dice.count(6)
        table |= {"shape": kind, "pitch": pitch, "diameter": pitch * dice.rng.uniform(0.2, 0.95)}
    elif kind == "cylinder":
        table["diameter"] = across * overhang[0]
    else:
        table |= {"width": across * overhang[0], "length": along * overhang[1]}
    if dice.chance(0.3):
        table["standoff"] = thickness * dice.log(1e-3, 1.0)
    if dice.chance(0.15) and table["contact"] != "never":
        table["friction"] = dice.log(1e-3, 2.0, (1e-6, 10.0))
    return table | ({"edge_radius": thickness * dice.log(1e-3, 0.5)} if dice.chance(0.15) else {})


def _silicone(dice: Dice) -> Table | str:
    """Return a silicone: of the catalogue, or one of a law with constants of a stable one."""
    if dice.chance(0.2):
        return str(dice.one_of("ecoflex-00-30", "dragon-skin-30", "rtv615"))
    law, mu = dice.one_of(*LAWS), dice.log(1e3, 1e7, (1e-3, 1e12))
    constants: Table = {"shear_modulus": mu}
    if law == "gent":
        constants["j_m"] = dice.log(0.1, 100.0)
    elif law == "mooney-rivlin":
        share = dice.rng.uniform(-0.2, 1.0)
        constants = {"c10": 0.5 * mu * (1.0 - share), "c01": 0.5 * mu * share}
    elif law == "yeoh":
        constants = {"c10": 0.5 * mu, "c20": dice.sign(mu * dice.log(1e-5, 1e-1)), "c30": mu * dice.log(1e-6, 1e-2)}
    elif law == "ogden":
        count = dice.count(3, 3)
        alpha = [dice.sign(dice.log(0.5, 10.0)) for _ in range(count)]
        constants = {"mu": [mu / count] * count, "alpha": alpha}
    return {"law": law, **constants, "bulk_modulus": mu * dice.log(0.5, 1e6, (1e-3, 1e9))}


def _plate(dice: Dice, number: int) -> Table:
    """Return a fixed plate: below, above or beside the coils."""
    thickness = dice.length(1e-4, 0.2)
    away = dice.length(1e-2, 20.0)
    z = dice.sign(away) - 0.5 * thickness
    centre = (dice.sign(dice.length(1e-2, 3.0)), 0.0, z) if dice.chance(0.5) else (0.0, z)
    return _outline(dice) | _metal(dice) | {"name": f"P{number}", "centre": centre, "thickness": thickness}


def _case(number: int, dice: Dice, sensor: Sensor) -> Case:
    """Return what is asked of a scene."""
    kinds = ("inductance",) if sensor.elastomer is None else ("inductance", "pose", "simulate")
    kind = dice.one_of(*kinds)
    tolerance = dice.log(1e-6, 0.1) if dice.chance(_FINE[kind]) else dice.log(0.1, 0.3)
    models = {"pose": ("planar", "linear", "block", "closed-form")}
    names = models.get(kind, ("planar", "planar-fem", "axisymmetric", "sheets"))
    model = "auto" if kind == "simulate" or dice.chance(0.75) else dice.one_of(*names)
    given = _pose(dice, sensor) if kind == "inductance" else _load(dice, sensor)
    return Case(number, sensor, kind, given, model, tolerance)


def _pose(dice: Dice, sensor: Sensor) -> Pose:
    """Return a pose from near the coils to far; half of them tilted, by up to 85 % of what touches them."""
    gap = dice.log(1e-5, 1e-5 + 2.0 * dice.size)
    if sensor.target is None:
        return Pose(0.0, gap)
    half = 0.5 * np.array(sensor.target.extent)
    most = 0.85 * np.arcsin(np.minimum(gap / half, 1.0))
    tilt = dice.rng.uniform(-1.0, 1.0, 2) * most if dice.chance(0.5) else np.zeros(2)
    aside = dice.sign(dice.length(1e-3, 1.0)) if dice.chance(0.6) else 0.0
    if dice.chance(0.25) and not (tilt[0] and tilt[1]):
        return Pose(aside, gap, float(tilt[0]), aside, 0.0, float(dice.rng.uniform(-np.pi, np.pi)))
    return Pose(aside, gap, float(tilt[0]))


def _load(dice: Dice, sensor: Sensor) -> Wrench:
    """Return a load: shares of the shear modulus times the target's area, some of them far too much."""
    assert sensor.target is not None and sensor.elastomer is not None
    a, b = sensor.target.extent
    force = sensor.elastomer.silicone.shear_modulus * a * b
    amount = dice.log(1e-6, 3.0)
    parts = [dice.sign(force * amount * dice.rng.random()) * dice.chance(0.7) for _ in range(4)]
    down = abs(parts[1]) if dice.chance(0.8) else -abs(parts[1])
    sideways = parts[3] if dice.chance(0.25) else 0.0
    return Wrench(parts[0], down, 0.5 * a * parts[2] * dice.chance(0.5), sideways)
