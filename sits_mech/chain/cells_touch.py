"""What do cells on one pad read of one touch: the poses of all targets, their coils' inductances, forces read.

With q_k the change of the pose of target k by the touch (mechanics/pressed.py), S_ik the derivatives of the coils of
cell i by it (chain/cells.py) and L(q) the inductances of a cell alone,

    Delta L_i = L(q_i) - L(0) + sum_(k != i) S_ik q_k,

and what a cell reads, by its own calibration at small loads, are the forces G_ii^-1 w (sum_k S_ik q_k), w the weights
of its coils in its signals.

Finite strain is in poses and inductances by Newton's second step from the answer at small strain; of that, its size
over that answer's is left, three halves of it as error. (One target pressed 2 mm off its middle: what is left is 0.1 to
1.5 times the product at 0.3, 1 and 2 N, sinks of 2 to 8 %, against `block`.) Beyond a half nothing is bounded.

Left out: as of `cell_crosstalk`; finite strain of what cells read; what targets at rest change of the inductances of
coils beside them, which no Delta L holds.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.cells import forces_read, own_calibration, signal_slopes
from sits_mech.chain.propagation import diagonals, levers, unloaded_pose
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.cells import cells_pad
from sits_mech.quantities import Array, Pose
from sits_mech.scene.cells import Cells
from sits_mech.scene.thermal import at_temperature
from sits_mech.status import flags_of
from sits_mech.threads import one_thread
from sits_mech.units import SceneError

_AIM = 0.5  # of the tolerance: of the poses at small strain, so that with all else it holds
_MOST, _LEFT = 0.5, 1.5  # share of finite strain that is bounded; of its square, what is left


@dataclass(frozen=True)
class CellTouch:
    """What a touch does to n cells of c coils each; made by `cell_touch`.

    Attributes
    ----------
    cells : Cells
        The scene.
    force : float
        Of the touch [N].
    poses, pose_error : ndarray
        Of the targets, in the order of `Pose`, each from its own cell's origin, shape (n, 6) [m, rad].
    L, L_error : ndarray
        Inductances of the coils, of which the error is that of their change, shape (n, c) [H].
    L_rest : ndarray
        Those of a cell alone and untouched, shape (c,) [H].
    reads : tuple of str
        The forces that a cell reads.
    read, read_error : ndarray
        What each reads by its own calibration at small loads, shape (n, r) [N].
    finite_strain : float
        The share by which finite strain changes how far targets move: in poses and L, not in `read`.
    seconds : float
        Processor time.
    flags : tuple of str
        What holds of poses and inductances, worst first, as of `status.flags_of`.
    """

    cells: Cells
    force: float
    poses: Array
    pose_error: Array
    L: Array
    L_error: Array
    L_rest: Array
    reads: tuple[str, ...]
    read: Array
    read_error: Array
    finite_strain: float
    seconds: float
    flags: tuple[str, ...]


@checked_arguments
@one_thread
def cell_touch(cells: Cells, tolerance: float = 1e-2, force: float | None = None) -> CellTouch:
    """Return what the touch of a scene does to all its cells.

    Parameters
    ----------
    cells : Cells
        From `load_cells`, with a touch.
    tolerance : float
        Asked error of poses and of changes of inductances, of the largest one.
    force : float, optional
        Of the touch [N]; its own by default.

    Returns
    -------
    CellTouch

    Raises
    ------
    ValueError
        Without a touch or its force, for a rigid touch that meets a target beside the silicone that it presses, and
        when memory does not hold the pad.

    Examples
    --------
    >>> places = '[{name="A", centre=["-5 mm", "0 mm"]}, {name="B", centre=["5 mm", "0 mm"]}]'
    >>> one = ['coils=[{name="C1", centre=[0, 0], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    ...        'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]']
    >>> touch = 'touch={shape="pressure", width="4 mm", length="4 mm", x="3 mm", force="0.1 N"}'
    >>> found = sm.cell_touch(sm.load_cells("biorob2018", [f"targets={places}", *one, touch]))
    >>> found.reads, found.read[:, 0].round(3).tolist()
    (('F_z',), [-0.003, 0.098])
    """
    given = cells.touched.force if force is None else force
    if given is None or not 0.0 < given < np.inf:
        raise SceneError(f"touch.force must be a press above 0 N; got {'none' if given is None else f'{given:g} N'}")
    began = time.process_time()
    cells = cells.model_copy(update={"sensor": at_temperature(cells.sensor)})
    sensor, (reads, weights) = cells.sensor, forces_read(cells)
    r, lever, rest = len(reads), levers(sensor), unloaded_pose(sensor).components
    pad = cells_pad(cells, _AIM * tolerance, given)
    S, off = signal_slopes(cells, np.concatenate([weights, np.eye(len(sensor.coils))]), tolerance)
    moved, read = pad.levels.limit(pad.moved), pad.levels.limit([
        np.einsum("irs,iskp,kp->ir", own_calibration(S[:, :r], own, reads), S[:, :r], by)
        for own, by in zip(pad.compliances, pad.moved, strict=True)
    ])
    strain = float(np.abs(pad.second * lever).max() / np.abs(moved.value * lever).max())
    bounded = strain < _MOST
    second = pad.second if bounded else np.zeros_like(pad.second)
    q, pose_error = moved.value + second, moved.error + pad.spread + _LEFT * strain * np.abs(second)
    missed, through = np.einsum("irkp,kp->ir", off, np.abs(q)), np.einsum("irkp,kp->ir", np.abs(S), pad.spread)
    L_error = (missed + np.einsum("irkp,kp->ir", np.abs(S), pose_error))[:, r:]
    alone, beside = sheets(sensor, tolerance), S[:, r:].copy()
    beside[np.arange(len(S)), :, np.arange(len(S))] = 0.0
    still, there = (alone.impedance(Pose.of(at), sensor.frequency) for at in (rest[None], rest + q))
    change = diagonals(there.L) - diagonals(still.L) + np.einsum("ickp,kp->ic", beside, q)
    inverse = np.abs(own_calibration(S[:, :r], pad.compliances[-1], reads))
    read_error = read.error + np.einsum("irs,is->ir", inverse, (missed + through)[:, :r])
    read_error += still.report.estimated_error * np.abs(read.value)  # of G_ii
    off_by = max(float(part.max() / np.abs(of).max()) for part, of in (
        (pose_error * lever, q * lever), (L_error, change), (read_error, read.value),
    ))
    flags = flags_of(off_by, tolerance, bounded=bounded)
    return CellTouch(
        cells, given, rest + q, pose_error, diagonals(still.L) + change, L_error, diagonals(still.L)[0], reads,
        read.value, read_error, strain, time.process_time() - began, flags,
    )
