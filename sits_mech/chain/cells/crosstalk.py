"""What do cells on one pad read when one is pressed, in newton per newton, and what do all of one touch?

About rest, with s_i the signals of cell i (readout/signals.py), S_ik their derivatives by the pose of target k and C_kj
those of its pose by the force on target j (mechanics/cells/targets.py), s_i = sum_j G_ij f_j with

    G_ij = sum_k S_ik C_kj,      X_ij = G_ii^-1 G_ij,

and X_ij f_j are the forces that cell i reads by its own calibration: one force a signal, F_z of dL_v, F_x of dL_x and
F_y of dL_y; G_ii is square. Of X_ij the part G_ii^-1 S_ii C_ij comes through the silicone, which moves the cell's own
target, and is called mechanical; the rest comes through fields, from targets that move beside the coils: magnetic.

S_ik is that of chain/cells/fields.py.

Cells may have other coils than each other, and read other forces by them: r are the forces that any of them reads, and
what a cell does not read is none (NaN); in G_ii stand its own.

A touch changes the poses by q_k (mechanics/cells/pressed.py), what a cell reads by G_ii^-1 sum_k S_ik q_k, and, L the
inductances of a cell alone and S those of its coils,

    Delta L_i = L(q_i) - L(0) + sum_(k != i) S_ik q_k.

Poses and L have finite strain by Newton's second step from the answer at small strain; the product of its size and its
share of that answer is left, three halves of it as error. (One target pressed 2 mm off its middle: 0.1 to 1.5 times it
at 0.3, 1 and 2 N, sinks of 2 to 8 %, against `block`.) Beyond a half nothing is bounded.

Left out: finite strain of crosstalk and of what cells read, by its first correction of a cell's own sinking, or of all
that moves; idle coils of other cells, cells that are driven at one time, and what targets at rest change of L beside.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.cells.fields import alone_at, cell_levers, signal_slopes
from sits_mech.chain.propagation import signal_weights, unloaded_pose
from sits_mech.mechanics.cells.targets import CellsPad, cells_pad
from sits_mech.mechanics.touch import check_force
from sits_mech.quantities import WRENCH, Array, Mask
from sits_mech.scene.cells import Cells
from sits_mech.scene.thermal import at_temperature
from sits_mech.status import flags_of
from sits_mech.threads import one_thread
from sits_mech.units import SceneError

FORCES = ("F_z", "F_x", "F_y")
"""Forces in the order of the signals dL_v, dL_x and dL_y, which read them."""
_ROUNDING = 1e-9  # of weights of signals
_MOST, _LEFT = 0.5, 1.5  # share of finite strain that is bounded; of its square, what is left


@dataclass(frozen=True)
class CellCrosstalk:
    """What n cells read per newton on each; made by `cell_crosstalk`.

    Attributes
    ----------
    cells : Cells
        The scene.
    reads : tuple of str
        The forces that any cell reads, r of `FORCES`.
    mechanical, magnetic : ndarray
        What comes through the silicone and through fields, shape (n, r, n, 3): cell that reads, force that it reads,
        cell under a force, which of `FORCES`; NaN where a cell does not read one [N/N].
    error : ndarray
        Estimated error of their sum, in the same shape [N/N].
    load, finite_strain : float
        A press [N], and the share by which it changes how far a cell sinks per newton, left out of all figures;
        infinite where one compliance does not hold under it.
    seconds : float
        Processor time.
    flags : tuple of str
        What holds of the figures, worst first, as of `status.flags_of`: a cell reads the force on itself as one.
    """

    cells: Cells
    reads: tuple[str, ...]
    mechanical: Array
    magnetic: Array
    error: Array
    load: float
    finite_strain: float
    seconds: float
    flags: tuple[str, ...]

    @property
    def total(self) -> Array:
        """What cells read per newton, shape (n, r, n, 3); ones where a cell reads the force on itself [N/N]."""
        return self.mechanical + self.magnetic

    @property
    def largest(self) -> tuple[Array, Array]:
        """The largest size of what cells read by each force on another cell, and its error, shape (r, 3) [N/N]."""
        own = np.eye(len(self.cells.targets), dtype=bool)[:, None, :, None]
        size, error = (
            np.moveaxis(each, 2, 1).reshape(-1, len(self.reads), len(FORCES))
            for each in np.nan_to_num([np.where(own, 0.0, np.abs(self.total)), self.error])
        )
        at = size.argmax(axis=0)[None]
        return np.take_along_axis(size, at, 0)[0], np.take_along_axis(error, at, 0)[0]


@dataclass(frozen=True)
class CellTouch:
    """What a touch does to n cells of c coils, those that any has; made by `cell_touch`.

    Attributes
    ----------
    cells : Cells
        The scene.
    force : float
        Of the touch [N].
    moved, pose_error : ndarray
        Change of the targets' poses, in the order of `Pose`, shape (n, 6) [m, rad].
    L, L_error : ndarray
        Inductances of the coils, of which the error is that of their change, shape (n, c), in the order of
        `cells.coil_names`; NaN where a cell has no such coil [H].
    L_rest : ndarray
        Those of each cell alone and untouched, shape (n, c) [H].
    reads : tuple of str
        The forces that any cell reads.
    read, read_error : ndarray
        What each reads by its own calibration at small loads, shape (n, r); NaN where it does not read one [N].
    finite_strain : float
        The share by which finite strain changes how far targets move: in poses and L, not in `read`.
    seconds : float
        Processor time.
    flags : tuple of str
        What holds of inductances and forces read, worst first, as of `status.flags_of`.
    """

    cells: Cells
    force: float
    moved: Array
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
def cell_crosstalk(cells: Cells, tolerance: float = 1e-2, load: float = 1.0) -> CellCrosstalk:
    """Return what each cell reads per newton on each other one, at small loads.

    Parameters
    ----------
    cells : Cells
        From `load_cells`.
    tolerance : float
        Requested relative error of how far a force moves its own target, and of what coils see of it; of figures [N/N].
    load : float
        Press for which `finite_strain` is given [N].

    Returns
    -------
    CellCrosstalk

    Raises
    ------
    ValueError
        For a load that is no press, and when memory does not hold the pad.

    Examples
    --------
    >>> places = '[{name="A", centre=["-5 mm", "0 mm"]}, {name="B", centre=["5 mm", "0 mm"]}]'
    >>> one = ['coils=[{name="C1", centre=[0, 0], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    ...        'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]']
    >>> result = sm.cell_crosstalk(sm.load_cells("biorob2018", [f"targets={places}", *one]), tolerance=0.1)
    >>> result.reads, round(float(result.total[0, 0, 1, 0]), 2)  # B pressed, A reads
    (('F_z',), -0.05)
    """
    return crosstalk_by(cells, tolerance, load)[0]


def crosstalk_by(cells: Cells, tolerance: float, load: float) -> tuple[CellCrosstalk, tuple[Array, Array], CellsPad]:
    """Return the crosstalk, and what it is made of: S with its error, and the pad."""
    if not 0.0 < load < np.inf:
        raise SceneError(f"load: must be a press above 0 N; got {load:g} N")
    began = time.process_time()
    cells = cells.model_copy(update={"sensors": tuple(map(at_temperature, cells.sensors))})
    reads, weights = forces_read(cells)
    pad, (S, off) = cells_pad(cells, tolerance), signal_slopes(cells, weights, tolerance)
    limit = pad.levels.limit([np.stack(_parts(S, C, reads)) for C in pad.compliances])
    mechanical, total = limit.value
    C, read = pad.compliances[-1], in_forces(reads)
    least = np.abs(own_calibration(S, C, reads))
    missed = np.einsum("irs,iskp,kpjw->irjw", least, off, np.abs(C[..., places_of(FORCES)]))
    missed += np.einsum("irs,isjw->irjw", own_of(missed)[..., read], np.abs(total))  # G_ii
    error, strain = limit.error[1] + missed, pad.softening(load)
    flags, none = flags_of(float(error.max()), tolerance, bounded=np.isfinite(strain)), _not_read(weights)
    mechanical, magnetic, error = np.where(none[:, :, None, None], np.nan, [mechanical, total - mechanical, error])
    took = time.process_time() - began
    found = CellCrosstalk(cells, reads, mechanical, magnetic, error, load, strain, took, flags)
    return found, (S, off), pad


@checked_arguments
@one_thread
def cell_touch(cells: Cells, tolerance: float = 1e-2, force: float | None = None) -> CellTouch:
    """Return what the touch of a scene does to all its cells.

    Parameters
    ----------
    cells : Cells
        From `load_cells`, with a touch.
    tolerance : float
        Asked error of changes of inductances and of forces read, of the largest one.
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
    >>> result = sm.cell_touch(sm.load_cells("biorob2018", [f"targets={places}", *one, touch]), tolerance=0.1)
    >>> result.reads, result.read[:, 0].round(3).tolist()
    (('F_z',), [-0.01, 0.093])
    """
    check_force(cells.touched, "[[targets]]")
    given = cells.touched.force if force is None else force
    if given is None or not 0.0 < given < np.inf:
        raise SceneError(f"touch.force must be a press above 0 N; got {'none' if given is None else f'{given:g} N'}")
    began = time.process_time()
    cells = cells.model_copy(update={"sensors": tuple(map(at_temperature, cells.sensors))})
    reads, weights = forces_read(cells)
    r, lever, rest = len(reads), cell_levers(cells), unloaded_pose(cells.sensor).components
    coils = np.array([np.diag(np.isin(cells.coil_names, own.coil_names)) for own in cells.sensors], dtype=float)
    S, off = signal_slopes(cells, np.concatenate([weights, coils], axis=1), tolerance)
    pad = cells_pad(cells, 0.5 * tolerance, given, S)  # with all else it holds
    inverse = own_calibration(S[:, :r], pad.compliances[-1], reads)
    shown = [np.einsum("irkp,kp->ir", S, by) for by in pad.moved]
    moved, signals = pad.levels.limit(pad.moved), pad.levels.limit(shown)
    read = pad.levels.limit([
        np.einsum("irs,is->ir", own_calibration(S[:, :r], C, reads), each[:, :r])
        for C, each in zip(pad.compliances, shown, strict=True)
    ])
    strain = float(np.abs(pad.second * lever).max() / np.abs(moved.value * lever).max())
    q, left = moved.value + (pad.second if np.isfinite(strain) else 0.0), _LEFT * strain * np.abs(pad.second)
    missed = np.einsum("irkp,kp->ir", off, np.abs(q)) + np.einsum("irkp,kp->ir", np.abs(S), pad.spread)
    L_error = (signals.error + missed + np.einsum("irkp,kp->ir", np.abs(S), left))[:, r:]
    neighbours, (still, there, unsure) = S[:, r:].copy(), alone_at(cells, rest + q, tolerance)
    neighbours[np.arange(len(S)), :, np.arange(len(S))] = 0.0
    change = there - still + np.einsum("ickp,kp->ic", neighbours, q)
    read_error = read.error + np.einsum("irs,is->ir", np.abs(inverse), missed[:, :r])
    read_error += unsure[:, None] * np.abs(read.value)  # of G_ii
    off_by = max(float(np.max(L_error) / np.nanmax(np.abs(change))), float(read_error.max() / np.abs(read.value).max()))
    flags, none = flags_of(off_by, tolerance, bounded=strain < _MOST), _not_read(weights)
    L_error, (value, error) = L_error + 0.0 * still, (np.where(none, np.nan, own) for own in (read.value, read_error))
    return CellTouch(
        cells, given, q, moved.error + pad.spread + left, still + change, L_error, still, reads, value, error, strain,
        time.process_time() - began, flags,
    )


def _parts(S: Array, C: Array, reads: tuple[str, ...]) -> tuple[Array, Array]:
    """Return the mechanical crosstalk and the whole, (n, r, n, 3), by slopes of signals and a compliance."""
    whole = np.einsum("irkp,kpjw->irjw", S, C)
    silicone = np.einsum("irp,ipjw->irjw", own_of(S), C)
    own = own_calibration(S, C, reads)
    through, every = (np.einsum("irs,isjw->irjw", own, each[..., places_of(FORCES)]) for each in (silicone, whole))
    return through, every


def forces_read(cells: Cells) -> tuple[tuple[str, ...], Array]:
    """Return the forces that cells read, r of `FORCES`, and the weights of each one's coils in its signals, (n, r, c).

    Zeros where a cell does not read a force, or has no such coil.
    """
    weights = np.zeros((len(cells.sensors), len(FORCES), len(cells.coil_names)))
    for own, sensor in zip(weights, cells.sensors, strict=True):
        own[:, np.isin(cells.coil_names, sensor.coil_names)] = signal_weights(sensor)
    weights[np.abs(weights).max(axis=2) <= _ROUNDING] = 0.0
    rows = np.any(weights != 0.0, axis=(0, 2))
    return tuple(name for name, row in zip(FORCES, rows, strict=True) if row), weights[:, rows]


def _not_read(weights: Array) -> Mask:
    """Return which forces a cell does not read, (n, r)."""
    return np.asarray(np.all(weights == 0.0, axis=2))


def own_calibration(S: Array, C: Array, reads: tuple[str, ...]) -> Array:
    """Return G_ii^-1, what each cell makes of its signals, (n, r, r) [N/H]; zeros of forces that it does not read."""
    return inverses(own_of(np.einsum("irkp,kpjw->irjw", S, C))[..., places_of(reads)])


def inverses(G: Array) -> Array:
    """Return the inverse of what each cell reads by forces on itself, (n, r, r); zeros of those that it does not."""
    found = np.zeros_like(G)
    for own, whole in zip(found, G, strict=True):
        rows = np.any(whole != 0.0, axis=1)
        own[np.ix_(rows, rows)] = np.linalg.inv(whole[np.ix_(rows, rows)])
    return found


def own_of(of_pairs: Array) -> Array:
    """Return what is of each cell itself, (n, r, m), of what is of all pairs, (n, r, n, m)."""
    return np.asarray(np.einsum("irim->irm", of_pairs))


def places_of(forces: Sequence[str]) -> list[int]:
    """Return where forces stand in a wrench."""
    return [WRENCH.index(name) for name in forces]


def in_forces(reads: Sequence[str]) -> list[int]:
    """Return where forces that are read stand in `FORCES`."""
    return [FORCES.index(name) for name in reads]
