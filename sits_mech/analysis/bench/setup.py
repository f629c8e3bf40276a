"""Model how a bench may differ from the scene: pose of the target, leads and tank, any number of the scene.

    L_i = L_model,i(pose, scene, l) (1 + c / C)

    modulus, stiffening, factor of all stresses of the silicone, what it stiffens by besides (scene/parameters.py), how
    thickness            much thicker the layer is, where loads were measured, see `loaded` [-, -, m]
    cell, frame,         load over what the load cell shows, and how the cell is turned about y, x and z, right hand,
    frame_x, frame_z     there as well [-, rad]
    gap, d_h, d_y        how much higher, further along x and y the target is than was set or computed [m]
    alpha, alpha_x,      how far it is turned on its holder, before the stages turn it: R = R_set R_holder, rotation
    alpha_z              vectors, each component one of them [rad]
    axis_x, axis_z       where the axis is that stages turn it about, from the centre of its bottom face, which goes to
                         c + a - R_set a with a = (axis_x, 0, axis_z) [m]
    lead                 l, in series with each coil besides the scene's leads, shorted idle ones too [H]
    capacitance          c, of the tank besides the scene's C, with which frequencies became inductances; nothing to
                         those that a meter shows [F]
    target.width, ...    a number of the scene by its key, a star for every entry of a list; L is the parabola through
                         the models at v and v +- 2 s for what is v +- s beforehand, and several keys add up

Neglected: what two keys do together; that a change of the gap also changes the layer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.analysis.bench.unknowns import CELL, PARAMETERS, PriorParameter
from sits_mech.analysis.built.fit import Free
from sits_mech.analysis.readings.bench import absolute, henries
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.geometry.collision import clearance
from sits_mech.magnetics.pose_slopes import pose_slopes
from sits_mech.maps.differences import SECOND_ORDER
from sits_mech.quantities import POSE, UNITS, Array, Impedance, MagneticModel, Pose
from sits_mech.rotations import rotation_matrix, rotation_vector
from sits_mech.scene.parameters import keys_of
from sits_mech.scene.sensor import Sensor, changed

_SERIES = ("modulus", *CELL, "capacitance")  # no magnetic solve
_REACH = 0.25  # of the smallest clearance: how far lengths may move of which nothing is known
_WIDE = 4.0  # deviations: how far from what is known
_NODES = (-2.0, 0.0, 2.0)  # deviations: scenes that are solved for a key
_CLEAR = 0.25  # of the set clearance: what brings a target closer to the coils has no answer
_LEAD = 2e-6  # [H] most
_SHIFT, _TURN = 1e-9, 1e-7  # of a pose, for derivatives of how it is moved: linear but for products of rotations
_SIDES = SECOND_ORDER[0]  # of slopes by the pose: gap, lead and capacitance are alike to percents, quick ones are not
_LOOP = 1e-9  # [H], of leads for the derivative by them
_KEY = 0.1  # deviations of a key, for differences of its parabola, which are exact
_PLACE = {"gap": "d_v", "d_h": "d_h", "d_y": "d_y", "alpha": "alpha", "alpha_x": "alpha_x", "alpha_z": "alpha_z",
          "axis_x": "d_h", "axis_z": "d_h"}


class ParameterSlopes(NamedTuple):
    """Derivatives by v variables at m places of targets."""

    places: Array  # (m, 6)
    moved: Array  # of the places, (v, m, 6)
    by_pose: Array  # of the readings through the places, (m, n, v)
    direct: Array  # of the readings besides, (m, n, v)


@dataclass(frozen=True)
class Setup:
    """A bench: the scene, the parameters by which it may differ, and what makes the magnetic model of a scene."""

    sensor: Sensor
    parameters: tuple[PriorParameter, ...]  # in the order of the columns of P below
    model: Callable[[Sensor], MagneticModel]
    tank: bool = True  # whether inductances are read by the tank's frequency, not by a meter

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters."""
        return tuple(each.name for each in self.parameters)

    def readings(self, poses: Array, P: Array, L: Array | None = None, rests: Array | None = None) -> Array:
        """Return what the bench shows, shape (k, m, n) [H]; NaN where a target would touch the coil plane.

        `poses` (k, m, 6) are set or computed, d_v infinite without target; `P` (k, p) are the parameters; `L` (k, m, n)
        [H] replaces the model at the terminals with nothing changed, where it is known better; `rests` (k, m, 6) are
        poses of the changed layer, the same by default.
        """
        here = self._here(P)
        if L is None or rests is not None or not here.keys() <= set(_SERIES):
            moved = _moved(poses if rests is None else rests, here)
            clear = self._clearances(moved) > _CLEAR * self._clearances(poses)
            shown_L = np.full((*poses.shape[:2], len(self.sensor.coils)), np.nan)
            inside = {name: values[clear] for name, values in here.items()}
            if np.any(clear):
                shown_L[clear] = self._changed(moved[clear], inside)
            L = shown_L if L is None else L + shown_L - self._shown(0, poses)
        more = here.get("capacitance", np.zeros(len(P)))[:, None, None]
        return L * (1.0 + more / self.sensor.readout.parallel_capacitance)

    def slopes(self, rests: Array, p: Array, by: Array) -> ParameterSlopes:
        """Return where the targets are, and derivatives by v variables, at rests (m, 6) of the changed layer.

        `p` are the parameters, `by` (v, m, 6) the derivatives of the rests by the variables, of which the first are the
        parameters.
        """
        places, moved = self._placed(rests, p, by)
        scene, model = self._scenes[0]
        components = [name for k, name in enumerate(POSE) if np.any(moved[..., k])]
        field, by_pose, _ = pose_slopes(scene, model, Pose.of(places), scene.frequency, components, stencil=_SIDES)
        own = np.einsum("mnnk->mnk", by_pose) * henries(scene, field.unit_L, field.L0)[:, None]
        slopes = np.einsum("mnk,vmk->mnv", own, moved[..., [POSE.index(name) for name in components]])
        gain = 1.0 + self._here(p[None]).get("capacitance", np.zeros(1))[0] / self.sensor.readout.parallel_capacitance
        return ParameterSlopes(places, moved, gain * slopes, self._direct(field, places, p, len(by)))

    def _placed(self, rests: Array, p: Array, by: Array) -> tuple[Array, Array]:
        """Return where the set-up has targets, (m, 6), and derivatives by the variables, (v, m, 6); as `slopes`."""
        here = self._here(p[None])
        steps = np.array([_TURN if unit == "rad" else _SHIFT for unit in map(UNITS.get, POSE)])
        here_moved = _moved(rests[None], here)[0]
        ways = [_moved((rests + h * one)[None], here)[0] - here_moved for h, one in zip(steps, np.eye(6), strict=True)]
        moved = np.einsum("kmj,vmk->vmj", np.array(ways) / steps[:, None, None], by)
        for number, each in enumerate(self.parameters):
            if each.name in _PLACE:
                h = steps[POSE.index(_PLACE[each.name])]
                other = _moved(rests[None], here | {each.name: here[each.name] + h})[0]
                moved[number] += (other - here_moved) / h
        return here_moved, moved

    def _direct(self, field: Impedance, places: Array, p: Array, count: int) -> Array:
        """Return what derivatives of the readings by `count` variables are besides those by poses, (m, n, count).

        `field` is the impedance at the places.
        """
        here, C, none = self._here(p[None]), self.sensor.readout.parallel_capacitance, np.zeros(1)
        gain, lead = 1.0 + here.get("capacitance", none)[0] / C, here.get("lead", none)[0]
        slopes = np.zeros((len(places), len(self.sensor.coils), count))
        for number, each in enumerate(self.parameters):
            if each.name == "lead":
                low, high = (shown_inductances(self.sensor, field, lead + step) for step in (-_LOOP, _LOOP))
                slopes[..., number] += gain * (high - low) / (2.0 * _LOOP)
            if each.name == "capacitance" and self.tank:
                slopes[..., number] += shown_inductances(self.sensor, field, lead) / C
            if each in self._keys:
                ends = [here | {each.name: here[each.name] + way * each.deviation} for way in (-_KEY, _KEY)]
                low, high = (self._changed(places[None], end)[0] for end in ends)
                slopes[..., number] += gain * (high - low) / (2.0 * _KEY * each.deviation)
        return slopes

    def _here(self, P: Array) -> dict[str, Array]:
        """Return the values of each parameter that readings depend on by name, shape (k,)."""
        each = zip(self.names, P.T, strict=True)
        return {name: values for name, values in each if self.tank or name != "capacitance"}

    def free(self, poses: Array, ends: Mapping[str, Free]) -> tuple[Free, ...]:
        """Return the parameters to be fitted with first values, ends and sizes.

        `poses` (m, 6) are the measurement's or the table's; `ends` holds parameters that are decided elsewhere.
        """
        reach = _REACH * float(np.min(self._clearances(poses[None])))
        half = 0.0 if self.sensor.target is None else 0.5 * max(self.sensor.target.extent)
        lengths = {"m": reach, "rad": reach / max(half, reach), "H": _LEAD}
        lengths["F"] = 0.5 * self.sensor.readout.parallel_capacitance
        found = []
        for each in self.parameters:
            own = ends.get(each.name)
            if each.value is not None:
                own = own or Free(each.name, 0.0, -np.inf, np.inf, 1.0)
                size, ratio = each.deviation, each.name == "modulus"
                own = replace(own, start=each.value, size=size, deviation=size, ratio=ratio)
                own = replace(own, low=max(own.value(-_WIDE), own.low), high=min(own.value(_WIDE), own.high))
            elif own is None:
                most = lengths[PARAMETERS[each.name]]
                own = Free(each.name, 0.0, -most, most, 1e-8 if each.name == "lead" else most)
            found.append(own)
        return tuple(found)

    @cached_property
    def _scenes(self) -> tuple[tuple[Sensor, MagneticModel], ...]:
        """The scene and those of each key's nodes, with their models."""
        scenes = [self.sensor]
        for each in self._keys:
            for node in _NODES:
                value = (each.value or 0.0) + node * each.deviation
                scenes.append(changed(self.sensor, [f"{key}={value!r}" for key in keys_of(self.sensor, each.name)]))
        return tuple((scene, self.model(scene)) for scene in scenes)

    @property
    def _keys(self) -> tuple[PriorParameter, ...]:
        """The parameters that are keys of the scene."""
        return tuple(each for each in self.parameters if each.name not in PARAMETERS)

    def _changed(self, poses: Array, here: Mapping[str, Array]) -> Array:
        """Return L at the terminals of changed scenes at poses (k, m, 6)."""
        lead = here.get("lead", np.zeros(1))
        base = self._shown(0, poses, lead)
        total = base.copy()
        for number, each in enumerate(self._keys):
            x = (here[each.name] - (each.value or 0.0)) / each.deviation
            for k, node in enumerate(_NODES):
                others = [other for other in _NODES if other != node]
                share = np.prod([(x - other) / (node - other) for other in others], axis=0)
                if self._scenes[1 + 3 * number + k][0] != self.sensor:  # which the middle one mostly is
                    total += share[:, None, None] * (self._shown(1 + 3 * number + k, poses, lead) - base)
        return total

    def _shown(self, number: int, poses: Array, lead: Array | None = None) -> Array:
        """Return L at the terminals of one of the scenes at poses (k, m, 6), shape (k, m, n); equal poses once.

        `lead` (k,) is in series with each coil besides [H].
        """
        scene, model = self._scenes[number]
        flat, back = np.unique(poses.reshape(-1, len(POSE)), axis=0, return_inverse=True)
        there = np.isfinite(flat[:, POSE.index("d_v")])
        found = model.impedance(Pose.of(flat[there]), scene.frequency)
        parts = {name: getattr(found, name) for name in ("L", "R", "error_L", "error_R")}
        empty = {"L": found.L0, "R": 0.0 * found.L0, "error_L": 0.0 * found.L0, "error_R": 0.0 * found.L0}
        for name, part in parts.items():
            whole = np.tile(empty[name], (len(flat), 1, 1))
            whole[there] = part
            parts[name] = whole[back.reshape(poses.shape[:-1])]
        return shown_inductances(scene, replace(found, **parts), None if lead is None else lead[:, None, None])

    def _clearances(self, poses: Array) -> Array:
        """Return the smallest clearance of each set of poses (k, m, 6), shape (k,) [m]."""
        there = np.isfinite(poses[..., POSE.index("d_v")])
        safe = np.where(there[..., None], poses, 1.0)
        return np.asarray(np.min(np.where(there, clearance(self.sensor, Pose.of(safe)), np.inf), axis=-1))


def shown_inductances(sensor: Sensor, found: Impedance, lead: ArrayLike | None = None) -> Array:
    """Return the inductances at the terminals, shape (..., n) [H]; without idle coils where losses are not known.

    `lead` (..., 1) or one is in series with each coil besides the scene's [H].
    """
    henry, _ = absolute(sensor, found)
    if lead is not None:
        henry = replace(henry, L=henry.L + np.asarray(lead)[..., None] * np.eye(len(sensor.coils)))
    seen, _ = at_terminals(sensor, henry)
    own = np.diagonal(henry.L, axis1=-2, axis2=-1) + sensor.readout.lead_inductance
    return own if seen is None else seen.L


def _moved(poses: Array, here: Mapping[str, Array]) -> Array:
    """Return poses (k, m, 6) as changed by the set-up; unchanged without a target."""
    zero = np.zeros(len(poses))
    part = {name: here.get(name, zero)[:, None] for name in PARAMETERS}
    moved = poses.copy()
    w = poses[..., [POSE.index(name) for name in ("alpha_x", "alpha", "alpha_z")]]
    axis = np.stack([part["axis_x"], 0.0 * part["axis_x"], part["axis_z"]], -1)
    turned = rotation_matrix(w)
    shift = axis - np.einsum("kmij,kmj->kmi", turned, np.broadcast_to(axis, w.shape))
    for place, (name, more) in enumerate((("d_h", "d_h"), ("d_y", "d_y"), ("d_v", "gap"))):
        moved[..., POSE.index(name)] += part[more] + shift[..., place]
    holder = np.stack([part[name] for name in ("alpha_x", "alpha", "alpha_z")], -1)
    if np.any(holder):
        whole = turned @ rotation_matrix(holder)
        vectors = np.array([rotation_vector(each) for each in whole.reshape(-1, 3, 3)]).reshape(w.shape)
        for place, name in enumerate(("alpha_x", "alpha", "alpha_z")):
            moved[..., POSE.index(name)] = vectors[..., place]
    return moved
