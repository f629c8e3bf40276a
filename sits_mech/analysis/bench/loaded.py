"""Model what a bench of loads shows of a sensor whose silicone, layer, set-up and load cell are not quite known.

    f = c R (F + u) / s,    p = map(f) + sum_k q_k(f) a_k + sum_j m_j(f) t_j,
    L = L_map(f) + L(p') - L(map(f)) + sum_j n_j(f) t_j

    F, u    load as read, and what the reading is off [N, N m]
    c, R    factor and rotation of the load cell; s modulus of the silicone over the scene's
    a, q    thickness and stiffening, and the derivatives of the pose by them
    t, m, n factors of the parts of the errors that all loads of the table share, |t| about 1/2, and these parts: of the
            poses, and of the inductances by the magnetic model
    p'      p as the set-up moves it (`setup`)

A hyperelastic layer under dead loads, all of whose moduli are s times as large, rests under F where it rested under
F/s: no layer is solved again. Loads f may leave the table while the map can be followed: its first missing term, of
the size of its error e on [-1, 1], is e T_(P+1)(x) beyond, and may be 5 e. The way down of the target from where it
rests without load is an output as well, where it was measured. Neglected: what thickness and stiffening do to each
other; that a gap of adhesive also changes the layer; rate, friction, temperature.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.analysis.bench.force_maps import ForceMaps, mapped, moduli
from sits_mech.analysis.bench.setup import ParameterSlopes, Setup
from sits_mech.analysis.bench.unknowns import LAYER
from sits_mech.analysis.built.fit import EndReached, Free
from sits_mech.maps.surrogate import SmoothMap
from sits_mech.quantities import POSE, Array
from sits_mech.rotations import rotation_matrix

_AXES, _UPWARDS = ("F_x", "F_y", "F_z"), (1.0, 1.0, -1.0)  # of a load cell
_STEP = 1e-4  # of a load's range or a parameter's size, for differences of polynomials


@dataclass(frozen=True)
class LoadedBench:
    """Rows of loads on a sensor, and what they show as a function of what is unknown.

    Unknowns stand in the order: parameters of the set-up, shared factors t where `shared`, readings' errors u where
    `loose`, row by row.
    """

    setup: Setup
    table: ForceMaps
    forces: Array  # (m, d), as read [N, N m]
    layer: SmoothMap | None = None  # forces to the derivatives of the pose by `LAYER`, (2 * 6)
    shared: bool = False
    loose: bool = False
    depth: bool = False  # whether the target's way down is an output, the last one [m]

    @property
    def count(self) -> tuple[int, int, int]:
        """The numbers of parameters, shared factors, and readings' errors."""
        shared = self.table.shared if self.shared else 0
        return len(self.setup.parameters), shared, self.forces.size if self.loose else 0

    def free(self) -> tuple[Free, ...]:
        """Return the parameters to be fitted, the modulus where the table's map holds every load; or refuse loads."""
        expected = next((each.softest for each in self.setup.parameters if each.name == "modulus"), 1.0)
        (softest, stiffest), why = moduli(self.forces, self.table, self.table.map.names, expected)
        if "modulus" not in self.setup.names and not softest <= 1.0 <= stiffest:
            words = f"table: must reach beyond the measured forces; {why[int(softest <= 1.0)]}"
            raise EndReached(words, "modulus", softest if softest > 1.0 else stiffest)
        modulus = Free("modulus", 1.0, softest, stiffest, 1.0, beyond=why)
        found = self.setup.free(self.table.poses, {"modulus": modulus})
        if not all(each.low < each.high for each in found):
            raise EndReached(f"table: must reach beyond the measured forces; {why[0] or why[1]}", "modulus", softest)
        return found

    def model(self, P: Array) -> Array:
        """Return what the rows show for unknowns (k, p), shape (k, m, n) [H], with `depth` the way down last [m]."""
        loads = self._loads(P)
        L, poses = self.table.at(loads)
        changed = self._rests(P, loads)
        own = P[:, : self.count[0]]
        found = self.setup.readings(poses, own, L, changed if np.any(changed != poses) else None)
        found = found + self._moved(P, loads)
        return np.concatenate([found, self._depth(P, changed)[..., None]], axis=-1) if self.depth else found

    def by_factors(self, p: Array) -> Array:
        """Return what the factors of unknowns (p,) move the inductances by, beside the poses, shape (m, n) [H]."""
        return np.asarray(self._moved(p[None], self._loads(p[None]))[0])

    def _moved(self, P: Array, loads: Array) -> Array:
        """Return sum n_j t_j of the module docstring at loads (k, m, d), shape (k, m, n) [H]."""
        p, q, _ = self.count
        parts = self.table.parts_at(loads)[1][..., :q, :]  # none where factors are not unknown
        return np.asarray(np.einsum("kq,kmqn->kmn", P[:, p : p + q], parts))

    def derivatives(self, p: Array) -> tuple[Array, Array]:
        """Return derivatives of the outputs by parameters and factors, (m, n, p), and by each row's load, (m, n, d)."""
        count, (parts, deeper) = sum(self.count[:2]), self.parts(p)
        found = parts.by_pose + parts.direct
        if self.depth:
            found = np.concatenate([found, deeper.T[:, None, :]], axis=1)
        return found[..., :count], found[..., count:]

    def parts(self, p: Array) -> tuple[ParameterSlopes, Array]:
        """Return derivatives by parameters, factors and loads in their parts, and those of the ways down, (v, m)."""
        count = sum(self.count[:2])
        sizes = {"thickness": 1e-4, "stiffening": 0.1}  # of parameters; of factors one
        own = [sizes.get(name, 1.0) for name in self.setup.names]
        steps = _STEP * np.array((own + [1.0] * count)[:count])
        ways = np.concatenate([np.eye(len(p))[:count] * steps[:, None], np.zeros((self.forces.shape[1], len(p)))])
        pushes = _STEP * (self.table.map.high - self.table.map.low)
        moves = np.concatenate([np.zeros((count, len(pushes))), np.diag(pushes)])[:, None, :]
        whole = np.concatenate([steps, pushes])

        def stepped(sign: float) -> tuple[Array, Array]:
            """Return where all rows rest a step away, and their ways down."""
            P = p + sign * ways
            rests = self._rests(P, self._loads(P, sign * moves))
            return rests, self._depth(P, rests)

        (up, low), (down, high) = stepped(1.0), stepped(-1.0)
        by = (up - down) / (2.0 * whole)[:, None, None]
        deeper = (low - high) / (2.0 * whole)[:, None]
        first, loads = self.count[0], self._loads(p[None])
        found = self.setup.slopes(self._rests(p[None], loads)[0], p[:first], by)
        if count > first:
            found.direct[..., first:count] += self.table.parts_at(loads)[1][0].swapaxes(1, 2)
        return found, deeper

    def slopes(self, p: Array) -> Array:
        """Return derivatives of the outputs by all unknowns (p,), shape (m, n, p)."""
        own, by_load = self.derivatives(p)
        if not self.loose:
            return own
        m, n, d = by_load.shape
        each = np.zeros((m, n, m, d))
        each[np.arange(m), :, np.arange(m)] = by_load @ self.by_reading(p)
        return np.concatenate([own, each.reshape(m, n, m * d)], axis=-1)

    def by_reading(self, p: Array) -> Array:
        """Return the derivatives of a true load by what is read, shape (d, d)."""
        whole = _turned(self.table.map.names, np.eye(self.forces.shape[1])[None], self._turns(p[None]))[0].T
        return np.asarray(self._value(p[None], "cell", 1.0)[0] * whole)

    def _turns(self, P: Array) -> Array:
        """Return the rotation vectors of the load cell, shape (k, 3) [rad]."""
        return np.concatenate([self._value(P, name, 0.0)[:, 0] for name in ("frame_x", "frame", "frame_z")], axis=-1)

    def _value(self, P: Array, name: str, usual: float) -> Array:
        """Return a parameter's values, shape (k, 1, 1)."""
        names = self.setup.names
        own = P[:, names.index(name)] if name in names else np.full(len(P), usual)
        return own[:, None, None]

    def _loads(self, P: Array, more: Array | float = 0.0) -> Array:
        """Return the loads f of the module docstring, shape (k, m, d); `more` is added to the true ones."""
        off = P[:, -self.forces.size :].reshape(len(P), *self.forces.shape) if self.loose else np.zeros((len(P), 1, 1))
        turned = _turned(self.table.map.names, self.forces + off, self._turns(P))
        return (self._value(P, "cell", 1.0) * turned + more) / self._value(P, "modulus", 1.0)

    def _rests(self, P: Array, loads: Array) -> Array:
        """Return the poses p of the module docstring, shape (k, m, 6)."""
        poses = mapped(self.table.places, loads)
        names, (p, q, _) = self.setup.names, self.count
        if self.layer is not None:
            by = mapped(self.layer, loads).reshape(*loads.shape[:-1], len(LAYER), len(POSE))
            for number, name in enumerate(LAYER):
                if name in names:
                    poses = poses + P[:, names.index(name), None, None] * by[..., number, :]
        if q:
            poses = poses + np.einsum("kq,kmqj->kmj", P[:, p : p + q], self.table.parts_at(loads)[0])
        return poses

    def _depth(self, P: Array, rests: Array) -> Array:
        """Return the way down of the target from where it rests without load, shape (k, m) [m]."""
        none = self._rests(P, np.zeros((len(P), 1, self.forces.shape[1])))
        return (none - rests)[..., POSE.index("d_v")]


def _turned(names: Sequence[str], forces: Array, turns: Array) -> Array:
    """Return forces (k, m, d) turned by rotation vectors (k, 3); components that no load has stay out."""
    if not np.any(turns):
        return forces
    found = forces.copy()
    own = [(names.index(name), axis) for axis, name in enumerate(_AXES) if name in names]
    whole = np.zeros((*forces.shape[:-1], 3))
    for place, axis in own:
        whole[..., axis] = _UPWARDS[axis] * forces[..., place]
    whole = np.einsum("kij,kmj->kmi", rotation_matrix(turns), whole)
    for place, axis in own:
        found[..., place] = _UPWARDS[axis] * whole[..., axis]
    return found
