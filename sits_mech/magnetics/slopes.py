"""Differentiate L and R by pose, frequency and the scene's lengths, for any model of the magnetics.

A model's answer is a smooth function of pose and frequency down to rounding (`answer`), so that differences of a fourth
order (`maps.differences`) over steps h far above rounding and far below the lengths on which the field changes hold to
some 1e-8; h is a share of the room around the target, for a turn of what moves its rim as far; for the frequency in
ln f. All poses of all components are one batch of warm poses.

By lengths, at a fixed pose: what no coil and no plate has (the layer's) changes nothing. Lengths of coils change what
these drive in the plates, not the plates: all coils with a length a little changed stand in one scene with the coils as
they are, the plates prepared once, and

    d Delta Z_cd = Delta Z(dc, d) + Delta Z(c, dd);

L0 has its closed forms. All coils moved aside in space under a target alone are the target moved back. Lengths of
plates change their modes. The cells of a rectangle or disc alone in space are stretched with it, so that differences
are free of jumps: two preparations are enough, from the tolerance `_SINGLE` on of the coarsest division, with a few
times what it is off in the change as the error. Others take four, `axisymmetric` for lengths of its coil, too. Their
divisions follow in whole cells: where one jumps in a difference the error tells; others may be better.

If all lengths grow by one share, the pose's with them, L does as well at a frequency smaller by the square of that:

    sum of l dL/dl - 2 f dL/df = L,    sum of l dR/dl - 2 f dR/df = -R.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.geometry.collision import room
from sits_mech.magnetics.axis_fem import AxisymmetricFem
from sits_mech.magnetics.pose_slopes import STEP, KnownImpedance, pose_slopes, solver_of
from sits_mech.magnetics.rings import Axisymmetric
from sits_mech.magnetics.sheets import Sheets
from sits_mech.maps.differences import BACKWARD, CENTRAL, FORWARD, SECOND_ORDER, WIDE, best_slopes
from sits_mech.quantities import POSE, Array, Complex, MagneticModel, Pose, SolveFailed, SolveReport
from sits_mech.scene.parameters import Parameter, keys_of, parameter
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.threads import one_thread

_SHARE, _LEAST = 0.005, 0.01  # step of a length over the length, which is at least a share of the largest winding
_ROOM = 0.05  # of the room around the target: that step at most
_ROUGH, _USELESS = 1e-3, 0.5  # error of a slope, by length and change, that asks for other differences; that is none
_SINGLE, _OFF = 3e-2, 8.0  # tolerance; error of a single division's slopes over that of its changes, as measured
_BEND = 3e-4  # error of differences of second order over a slope, three times what was seen
_PLATES = ("target", "conductors", "substrate_radius")  # of a scene, what has to be prepared
_Values = Mapping[int, tuple[Array, Array]]  # L and R by places, each of shape (p, n, n)


@dataclass(frozen=True)
class Slopes:
    """Derivatives of the impedance matrices.

    Attributes
    ----------
    components : tuple of str
        k components of the pose, of `POSE`.
    lengths : tuple of str
        m keys of the scene.
    L, R : ndarray, shape (..., n, n, k)
        By each component [H/m or H/rad, ohm/m or ohm/rad; per metre of depth for a planar model].
    L_frequency, R_frequency : ndarray, shape (..., n, n)
        By the frequency [H/Hz, ohm/Hz].
    L_lengths, R_lengths : ndarray, shape (..., n, n, m)
        By each length at the fixed pose [H/m, ohm/m].
    error_L_lengths, error_R_lengths : ndarray
        What differences may be off, beside the model's own error.
    """

    components: tuple[str, ...]
    lengths: tuple[str, ...]
    L: Array
    R: Array
    L_frequency: Array
    R_frequency: Array
    L_lengths: Array
    R_lengths: Array
    error_L_lengths: Array
    error_R_lengths: Array


@dataclass(frozen=True)
class _Asked:
    """A model of a scene, p poses (p, 6), and a frequency."""

    model: Any
    rows: Array
    frequency: float

    def answer(self, sensor: Sensor, *, single: bool = False) -> tuple[Array, Array]:
        """Return L and R of its scene or of another."""
        found = self.varied(sensor, single=single).impedance(Pose.of(self.rows), self.frequency)
        return found.L, found.R

    def varied(self, sensor: Sensor, *, single: bool = False) -> Any:
        """Return the model of its scene or of another, divided alike where that can be."""
        sheets = isinstance(self.model, Sheets)
        return self.model.varied(sensor, single=single) if sheets else replace(self.model, sensor=sensor)

    def free(self, sensor: Sensor) -> Array:
        """Return L0 of another scene."""
        return np.asarray(self.varied(sensor).impedance(Pose.of(np.zeros((0, len(POSE)))), self.frequency).L0)


@dataclass(frozen=True)
class _Length:
    """A length of a scene with the step of its differences [m], its size [m], and what is solved, by steps."""

    number: Parameter
    size: float
    scenes: dict[int, Sensor]

    def changes(self, solved: Sensor, *parts: str) -> bool:
        """Tell whether scenes have other parts than what is solved."""
        one = next(iter(self.scenes.values()))
        return any(getattr(one, part) != getattr(solved, part) for part in parts)

    def reached(self, solved: Sensor, places: Sequence[int]) -> bool:
        """Tell whether scenes at all places are possible; they are then at hand, with the solved conductors."""
        new = [place for place in places if place and place not in self.scenes]
        found = self.number.scenes(new)
        if len(found) < len(new):
            return False
        for place, scene in found.items():
            by_name = {part.name: part for part in scene.conductors}
            near = tuple(by_name.get(part.name, part) for part in solved.conductors)
            self.scenes[place] = scene.model_copy(update={"conductors": near})
        return True


@checked_arguments
def slopes(
    sensor: Sensor, model: MagneticModel, pose: Pose, frequency: float, *, components: Sequence[str] = POSE,
    lengths: Sequence[str] = (),
) -> Slopes:
    """Return the derivatives of L and R at one pose or many.

    Parameters
    ----------
    sensor : Sensor
        With a target, where there are components.
    model : MagneticModel
        Of the sensor.
    pose : Pose
    frequency : float
        [Hz]
    components : sequence of str
        Of the pose: those that the model takes; a planar one the first three, none for lengths alone.
    lengths : sequence of str
        Keys of the scene such as "target.width", "coils.C1.inner_diameter", "coils.*.track_width" (of every coil).

    Raises
    ------
    ValueError
        If a component has no such name, a length is no `parameter` (SceneError); as the model's `impedance`.
    SolveFailed
        If the model's answers jump by more than a length changes them.

    Examples
    --------
    >>> sensor = sm.load_sensor("biorob2018")
    >>> model, _ = sm.magnetic_model(sensor, "planar")
    >>> result = sm.slopes(sensor, model, sm.Pose(0.0, 2e-3), 5e6, components=["d_v"])
    >>> result.L.shape, round(float(result.L[0, 0, 0]), 4)  # H/m a metre
    ((2, 2, 1), 0.0125)
    """
    for name in components:
        if name not in POSE:
            raise ValueError(f"components: must be of {', '.join(POSE)}, got {name!r}")
    rows = pose.components.reshape(-1, len(POSE))
    of_frequency = by_frequency(model, rows, frequency)  # first: what is prepared for several serves the one
    _, *by_pose = pose_slopes(sensor, model, Pose.of(rows), frequency, components)
    found = (*by_pose, *of_frequency, *by_lengths(sensor, model, rows, frequency, lengths))
    each = (part.reshape(*pose.components.shape[:-1], *part.shape[1:]) for part in found)
    return Slopes(tuple(components), tuple(lengths), *each)


def by_frequency(model: MagneticModel, rows: Array, frequency: float) -> list[Array]:
    """Return derivatives of L and R by the frequency at poses (p, 6), shape (p, n, n) [H/Hz, ohm/Hz]."""
    ways = [place for place in CENTRAL.places if place]
    found = {place: model.impedance(Pose.of(rows), frequency * np.exp(STEP * place)) for place in ways}
    slopes = []
    for name in ("L", "R"):
        values = {place: getattr(one, name) for place, one in found.items()}
        slopes.append(CENTRAL.slope(values | {0: 0.0 * values[1]}, STEP * frequency))
    return slopes


def by_lengths(
    sensor: Sensor, model: MagneticModel, rows: Array, frequency: float, keys: Sequence[str],
    known: KnownImpedance | None = None,
) -> list[Array]:
    """Return derivatives of L and R by lengths at poses (p, 6), and their errors, shapes (p, n, n, m) [H/m, ohm/m].

    Where the impedance at the poses is `known`, all coils aside are quick slopes of the pose (pose_slopes.py).
    """
    asked = _asked(model, rows, frequency, keys)
    n, solved = len(sensor.coils), getattr(asked.model, "sensor", sensor)
    found = np.zeros((4, len(asked.rows), n, n, len(keys)))
    coils, plates = dict[int, _Length](), dict[int, _Length]()
    for k, key in enumerate(keys):
        length = _length(sensor, solved, asked.rows, key)
        aside = _aside(asked.model, solved, length.number)
        if aside:
            at = Pose.of(rows)
            _, *slope = pose_slopes(solved, asked.model, at, frequency, [aside], quick=known is not None, known=known)
            found[:2, ..., k] = -np.stack(slope)[..., 0]
        elif length.changes(solved, *_PLATES):
            plates[k] = length
        elif length.changes(solved, "coils"):
            (plates if isinstance(asked.model, Axisymmetric | AxisymmetricFem) else coils)[k] = length
    if not coils and not plates:
        return list(found)
    centre = asked.answer(solved)
    changed = np.abs([centre[0] - asked.free(solved), centre[1]])
    largest = changed.max(axis=(1, 2, 3), initial=1e-300).tolist()
    for k, values in zip(coils, _of_coils(asked, list(coils.values()), centre), strict=True):
        found[..., k], _ = _slope(coils[k], values, largest)
    for k, length in plates.items():
        found[..., k] = _of_plates(asked, keys[k], length, (centre, largest))
    return list(found)


def _asked(model: MagneticModel, rows: Array, frequency: float, keys: Sequence[str]) -> _Asked:
    """Return what answers for lengths; the model itself without any."""
    solver = solver_of(model) if keys else model
    return _Asked(solver.prepared_at(Pose.of(rows)) if isinstance(solver, Sheets) else solver, rows, frequency)


def _length(sensor: Sensor, solved: Sensor, rows: Array, key: str) -> _Length:
    """Return a length with the scenes around."""
    number = parameter(sensor, key)
    least = _LEAST * max(coil.outer_diameter for coil in sensor.coils)
    size = max(least, *(abs(value) for _, value in number.numbers))
    near = float(np.min(room(sensor, Pose.of(rows)), initial=np.inf))
    size, most = (number.reach, np.inf) if number.reach else (size, _ROOM * near)
    length = _Length(replace(number, step=min(_SHARE * size, most)), size, {})
    if not any(length.reached(solved, stencil.places) for stencil in (CENTRAL, FORWARD, BACKWARD)):
        raise SceneError(f"{key}: must leave a possible scene where it goes up or down a little; it does not")
    return length


def _aside(model: Any, solved: Sensor, number: Parameter) -> str:
    """Return the component of the pose that all coils are moved along in space, beside no metal; nothing for others."""
    if not isinstance(model, Sheets) or solved.target is None or solved.conductors:
        return ""
    keys = [key for key, _ in number.numbers]
    return next((way for k, way in enumerate(("d_h", "d_y")) if keys == keys_of(solved, f"coils.*.centre.{k}")), "")


def _of_coils(asked: _Asked, lengths: Sequence[_Length], centre: tuple[Array, Array]) -> list[_Values]:
    """Return L and R at the places of each length of the coils alone: all windings over plates prepared once."""
    sensor, n = asked.model.sensor, len(asked.model.sensor.coils)
    added: list[Any] = []
    which: list[dict[int, list[tuple[int, int]]]] = [{} for _ in lengths]
    for length, own in zip(lengths, which, strict=True):
        for place, scene in length.scenes.items():
            for c in range(n):
                if scene.coils[c] != sensor.coils[c]:
                    own.setdefault(place, []).append((c, n + len(added)))
                    added.append(scene.coils[c].model_copy(update={"name": f"{scene.coils[c].name} {len(added)}"}))
    found, omega = list[_Values](), 2.0 * np.pi * asked.frequency
    if added:
        L0 = asked.free(sensor)
        change = _reaction(asked, sensor.model_copy(update={"coils": (*sensor.coils, *added)}))
    for length, own in zip(lengths, which, strict=True):
        values = {0: centre}
        for place, pairs in own.items():
            Z = np.zeros((len(asked.rows), n, n), dtype=complex)
            for c, k in pairs:
                Z[:, c, :] += change[:, k, :n] - change[:, c, :n]
                Z[:, :, c] += change[:, :n, k] - change[:, :n, c]
            free = asked.free(length.scenes[place]) - L0
            values[place] = centre[0] + free + Z.imag / omega, centre[1] + Z.real
        found.append(values)
    return found


def _reaction(asked: _Asked, sensor: Sensor) -> Complex:
    """Return Delta Z of a scene whose coils may lie in each other; none without plates."""
    shape = len(asked.rows), len(sensor.coils), len(sensor.coils)
    if sensor.target is None and not sensor.conductors:
        return np.zeros(shape, dtype=complex)
    react = one_thread(asked.varied(sensor)._reaction)
    return np.broadcast_to(react(Pose.of(asked.rows), asked.frequency).change, shape)


def _of_alike(asked: _Asked, length: _Length, centre: tuple[Array, Array]) -> Array:
    """Return derivatives and errors by a length of a plate that is divided alike, (4, p, n, n)."""
    sensor, single = asked.model.sensor, asked.model.tolerance >= _SINGLE
    stencil = next(one for one in SECOND_ORDER if length.reached(sensor, one.places))
    found = {m: np.stack(asked.answer(length.scenes.get(m, sensor), single=single)) for m in stencil.places}
    slopes = stencil.slope(found, length.number.step)
    off, largest = (np.abs(part).max(axis=(1, 2, 3), keepdims=True) for part in (found[0] - np.stack(centre), slopes))
    return np.concatenate([slopes, np.broadcast_to(_BEND * largest + _OFF * off / length.size, slopes.shape)])


def _of_plates(asked: _Asked, key: str, length: _Length, known: tuple[tuple[Array, Array], Sequence[float]]) -> Array:
    """Return derivatives and errors by a length that changes what is prepared (4, p, n, n); `known` L, R, changes."""
    sensor, (centre, largest) = asked.model.sensor, known
    if getattr(asked.varied(next(iter(length.scenes.values()))), "like", None):
        return _of_alike(asked, length, centre)
    values = {0: centre}
    values |= {place: asked.answer(scene) for place, scene in length.scenes.items()}
    best, worst = _slope(length, values, largest)
    if worst > _ROUGH:
        wider = [stencil.places for stencil in (FORWARD, BACKWARD, WIDE) if length.reached(sensor, stencil.places)]
        new = {place for places in wider for place in places} - set(values)
        values |= {place: asked.answer(length.scenes[place]) for place in sorted(new)}
        best, worst = _slope(length, values, largest)
    if worst > _USELESS:
        words = f"slopes: by {key} the answers of {type(asked.model).__name__} jump by as much as they change"
        report = SolveReport("slopes", 0, len(values), 0.0, float(worst), 0.0, "not smooth")
        raise SolveFailed(f"{words}; ask for a smaller tolerance, or for another model", report, half="magnetics")
    return best


def _slope(length: _Length, values: _Values, largest: Sequence[float]) -> tuple[Array, float]:
    """Return slopes of L and R and their errors, shape (4, p, n, n); the worst over the largest changes, by size."""
    parts = [{place: value[k] for place, value in values.items()} for k in (0, 1)]
    return best_slopes(parts, length.number.step, [most / length.size for most in largest])
