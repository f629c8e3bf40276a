"""What do the coils of cells see of targets: their own, and each other's as these move?

With s_i the signals of cell i and q_k the pose of target k, S_ik = ds_i/dq_k about rest.

S_ii is that of a cell alone. S_ik is solved with both targets, the other one k moving: eddy currents in the cell's own
target, which shields its coils, cut it to a quarter at 1.2 widths of pitch. It takes the coarsest division of plates
(`sheets`); how far that is off all divisions show for a nearest pair, one of each two kinds of cells that are as near
as any, relative to the largest slope; the most counts for all. A third target is left out: it changes S_ik of next
neighbours by up to 2 % of the largest slope at 1.2 widths and at 1.06, which counts as 5 %, and more distant ones, a
hundred times smaller, by up to three quarters: those count whole in the error. (In rows of targets 4.5 to 12 mm wide,
1.6 mm apart, one 1 mm thick, by up to 0.7 and 10 %.)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from sits_mech.chain.propagation import diagonals, levers, unloaded_pose
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.pose_slopes import pose_slopes
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.quantities import POSE, Array, Pose
from sits_mech.scene.cells import Cells
from sits_mech.scene.parts.metal import Conductor, Plate
from sits_mech.scene.sensor import Sensor

_THIRD, _BEYOND = 0.05, 1.0  # of S_ik that a third target may change, of next neighbours and of others
_NEXT = 1.01  # times the smallest gap of two targets


def alone_at(cells: Cells, poses: Array, tolerance: float) -> tuple[Array, Array, Array]:
    """Return inductances of each cell's coils alone, at rest and at poses (n, 6), (n, c) [H]; and relative errors (n,).

    With uneven current in tracks, without which L of two coils changed by 1 and 3 % more. NaN where a cell has no such
    coil.
    """
    still, kinds = np.full((len(poses), len(cells.coil_names)), np.nan), np.array(cells.kinds)
    there, unsure = still.copy(), np.zeros(len(poses))
    for k in sorted(set(cells.kinds)):
        sensor, own = cells.sensors[k], kinds == k
        model = Tracked(sheets(sensor, tolerance), sensor)
        at = np.ix_(own, np.isin(cells.coil_names, sensor.coil_names))
        rest, moved = (
            model.impedance(Pose.of(each), sensor.frequency)
            for each in (unloaded_pose(sensor).components[None], poses[own])
        )
        still[at], there[at], unsure[own] = diagonals(rest.L), diagonals(moved.L), rest.report.estimated_error
    return still, there, unsure


def cell_levers(cells: Cells) -> Array:
    """Return what turns components of each target's pose into displacements, (n, 6) [m]."""
    return np.array([levers(sensor) for sensor in cells.sensors])


def signal_slopes(cells: Cells, weights: Array, tolerance: float) -> tuple[Array, Array]:
    """Return S of the module docstring and its error, (n, r, n, 6) [H/m, H/rad], by weights (n, r, c) of cells' coils.
    """
    n, lever, gaps = len(cells.targets), cell_levers(cells), cells.gaps
    pose, alone = unloaded_pose(cells.sensor), {k: sheets(cells.sensors[k], tolerance) for k in set(cells.kinds)}
    slopes = cache(_Fields(cells, weights, alone, pose).slopes)
    away = (np.round(cells.centres[:, None] - cells.centres, 12) + 0.0).tolist()
    pairs = {(i, k): (cells.kinds[i], cells.kinds[k], *away[i][k]) for i, k in np.ndindex(n, n)}
    S = np.array([slopes(*pair) for pair in pairs.values()]).reshape(n, n, *weights.shape[1:2], 6)
    near, missed = gaps < _NEXT * gaps.min(), 0.0
    for i, k in {pairs[pair][:2]: pair for pair in sorted(pairs, key=gaps.__getitem__)[::-1] if near[pair]}.values():
        exact, coarse = (slopes(*pairs[i, k], single=single) / lever[k] for single in (False, True))
        missed = max(missed, float(np.abs(exact - coarse).max() / np.abs(exact).max()))
    third = np.where(near, _THIRD, _BEYOND) if n > 2 else np.zeros((n, n))
    off = (missed + third)[..., None, None] * lever[:, None] * np.abs(S / lever[:, None]).max(axis=3, keepdims=True)
    unsure = {k: each.impedance(pose, each.sensor.frequency).report.estimated_error for k, each in alone.items()}
    for i, k in enumerate(cells.kinds):
        off[i, i] = unsure[k] * np.abs(S[i, i])
    return S.swapaxes(1, 2), off.swapaxes(1, 2)


@dataclass(frozen=True, eq=False)
class _Fields:
    """What moves the signals of cells, about rest."""

    cells: Cells
    weights: Array  # (n, r, c), as of `signal_slopes`
    alone: Mapping[int, Sheets]  # of each kind
    pose: Pose  # at rest

    def slopes(self, i: int, k: int, x: float, y: float, single: bool = True) -> Array:
        """Return the slopes of signals of a cell of kind i, at (x, y) from a target of kind k that moves, (r, 6)."""
        cells = self.cells
        scene = self.pair(i, k, (x, y)) if (x, y) != (0.0, 0.0) else cells.sensors[i]
        model = replace(self.alone[i], sensor=scene, single=single and scene is not cells.sensors[i])
        _, by_pose, _ = pose_slopes(scene, model, Pose.of(self.pose.components[None]), scene.frequency, POSE)
        own = self.weights[i][:, np.isin(cells.coil_names, cells.sensors[i].coil_names)]
        return np.asarray(own @ np.diagonal(by_pose[0], axis1=0, axis2=1).T)

    def pair(self, i: int, k: int, place: tuple[float, float]) -> Sensor:
        """Return a cell's coils and its target, fixed at a place from the target that moves, at rest."""
        target = self.cells.plates[i]
        own = {key: getattr(target, key) for key in Plate.model_fields}
        plate = Conductor(name="own target", centre=(*place, float(self.pose.d_v) + target.thickness / 2.0), **own)
        parts = {"coils": self.cells.coils_at(i, np.array(place)), "elastomer": None, "conductors": (plate,)}
        return self.cells.sensors[k].model_copy(update=parts)
