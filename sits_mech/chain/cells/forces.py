"""Which forces act on cells on one pad, by what each reads?

A calibration, and the firmware made of it, is that of a cell alone: in the middle of the pad, without slots, under a
cover of its own. Of signals s_i it makes a_i = H_i^-1 s_i, H_i = S_ii C_i with C_i the compliance of its target there.
On the pad s_i = sum_j G_ij f_j (chain/cells/crosstalk.py), so that

    a = A f + B g,      A_ij, B_ij = H_i^-1 G_ij,

f the forces that the cells read, g those that they do not (F_x of a cell with one coil). A_ij is the crosstalk but for
H_i^-1 G_ii, what the place on the pad makes of a force on the cell itself. A is square, and

    f = M a,      M = A^-1,

is off by M (dA f + B g + e), of which g cannot be known. |dA| <= D, the estimated errors of A, and A + dA is regular
for all of these where |M| D has row sums below one (Neumann's series); other cells are refused: what they read does not
resolve the forces on them.

Both pads have meshes of the same levels. Parts of what levels change cancel in A, so that D is the error of its limit
and what the last level changed: on six pads of two cells a fourth level was up to 1.4 D away from three (0.35 D in the
middle), on four of them 0.7 D from two but for one element, 5.5 D. Errors of S_ii, which H_i has, too, count by what
C_ij differs from C_i A_ij.

e is finite strain: by each force alone, of a given size and either sign, Newton's second step p_k of the poses,

    e_i = H_i^-1 sum_k S_ik p_k,

less that of the cell alone for the force's own cell, whose calibration has it. It grows with the square of forces; what
two add to the sum of theirs is left out.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.chain.cells.crosstalk import FORCES, CellCrosstalk, crosstalk_by, in_forces, inverses, own_of, places_of
from sits_mech.mechanics.cells.targets import CellsPad, cells_pad
from sits_mech.quantities import Array, Mask, Wrench
from sits_mech.scene.cells import Cells
from sits_mech.threads import one_thread
from sits_mech.units import SceneError


@dataclass(frozen=True)
class CellForces:
    """What turns the forces that n cells read, each as if it were alone, into those on them; made by `cell_forces`.

    Attributes
    ----------
    crosstalk : CellCrosstalk
        The cells, what they read by calibrations in place, a load and its share of finite strain.
    mixing : ndarray
        A and B of the module docstring, shape (n, r, n, 3), as `CellCrosstalk.total`: what a cell reads, by the
        calibration of that cell alone, per newton on each; zeros where it does not read a force [N/N].
    mixing_error : ndarray
        Its estimated error, in the same shape [N/N].
    finite_strain : ndarray
        e of the module docstring by each force as large as the crosstalk's load, shape (n, r, n, r); infinite where it
        is not bounded [N].
    inverse : ndarray
        M, shape (n, r, n, r); zeros of what is not read [N/N].
    seconds : float
        Processor time.
    """

    crosstalk: CellCrosstalk
    mixing: Array
    mixing_error: Array
    finite_strain: Array
    inverse: Array
    seconds: float

    @property
    def reads(self) -> tuple[str, ...]:
        """The forces that any cell reads, r of `FORCES`."""
        return self.crosstalk.reads

    @property
    def known(self) -> Mask:
        """Which forces each cell reads, (n, r)."""
        return np.isfinite(own_of(self.crosstalk.total)[..., 0])

    @property
    def by_mixing(self) -> Array:
        """|M| D, error of forces by that of the mixing, per newton on each cell, (n, r, n, r) [N/N]."""
        return _through(self.inverse, self.mixing_error[..., in_forces(self.reads)])

    @property
    def by_finite_strain(self) -> Array:
        """|M| e over the crosstalk's load, per newton of a force as large as that, (n, r, n, r) [N/N]."""
        return _through(self.inverse, self.finite_strain / self.crosstalk.load)

    @property
    def by_unread(self) -> Array:
        """M B: what forces that a cell does not read make of those that are found, (n, r, n, 3) [N/N]."""
        found = np.einsum("irks,ksjw->irjw", self.inverse, self.mixing)
        at = in_forces(self.reads)
        found[..., at] = np.where(self.known, 0.0, found[..., at])
        return np.asarray(found)

    def forces(self, read: Array) -> tuple[Array, Array]:
        """Return the forces on cells, and their errors, of those that they read, each (..., n, r) [N].

        Errors by the mixing's, and by finite strain, which grows with the square of forces; not by forces that a cell
        does not read. NaN where it does not read one.
        """
        f = np.einsum("irjs,...js->...ir", self.inverse, np.where(self.known, read, 0.0))
        error = np.einsum("irjs,...js->...ir", self.by_mixing, np.abs(f))
        error += np.einsum("irjs,...js->...ir", self.by_finite_strain, f**2 / self.crosstalk.load)
        return np.where(self.known, f, np.nan), np.where(self.known, error, np.nan)


@checked_arguments
@one_thread
def cell_forces(cells: Cells, tolerance: float = 1e-2, load: float = 1.0) -> CellForces:
    """Return what turns the forces that cells read, each by the calibration of it alone, into the forces on them.

    Parameters
    ----------
    cells, tolerance, load
        As of `cell_crosstalk`; the load is the size of forces whose finite strain is an error of those found.

    Returns
    -------
    CellForces

    Raises
    ------
    ValueError
        As `cell_crosstalk`, and for cells whose readings do not resolve the forces on them.

    Examples
    --------
    >>> places = '[{name="A", centre=["-5 mm", "0 mm"]}, {name="B", centre=["5 mm", "0 mm"]}]'
    >>> one = ['coils=[{name="C1", centre=[0, 0], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    ...        'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]']
    >>> result = sm.cell_forces(sm.load_cells("biorob2018", [f"targets={places}", *one]), tolerance=0.1)
    >>> force, error = result.forces(np.array([[0.0], [1.0]]))  # A reads none, B 1 N
    >>> force[:, 0].round(2).tolist()
    [0.04, 0.95]
    """
    began = time.process_time()
    found, (S, off), pad = crosstalk_by(cells, tolerance, load)
    alone = {kind: _alone(found.cells, kind, len(pad.compliances)) for kind in set(found.cells.kinds)}
    pads = [alone[kind] for kind in found.cells.kinds]
    A, D, H = _mixing(S, off, pad, pads, found.reads)
    at, known = in_forces(found.reads), np.isfinite(own_of(found.total)[..., 0])
    strain = _finite_strain(found, S, H, pad, pads)
    made = CellForces(found, A, D, strain, _inverse(A[..., at], known), time.process_time() - began)
    _check_resolved(made)
    return made


def _alone(cells: Cells, k: int, count: int) -> CellsPad:
    """Return the pad with the target of a cell alone in its middle, of so many levels."""
    cell = cells.targets[k].model_copy(update={"centre": (0.0, 0.0)})
    only = {"targets": (cell,), "sensors": (cells.sensors[k],), "slots": (), "touch": None}
    return cells_pad(cells.model_copy(update=only), np.finfo(float).tiny, most=count)


def _mixing(
    S: Array, off: Array, pad: CellsPad, alone: Sequence[CellsPad], reads: tuple[str, ...]
) -> tuple[Array, Array, Array]:
    """Return A and B with D, (n, r, n, 3), of what levels have in common, and H_i^-1, (n, r, r)."""
    each = zip(*(only.compliances for only in alone), strict=False)
    own = [np.stack(level)[:, 0, :, 0][..., places_of(reads)] for level in each]
    together = [C[..., places_of(FORCES)] for C in pad.compliances[: len(own)]]
    inverse = [inverses(own_of(S) @ C) for C in own]
    found = [np.einsum("irs,iskp,kpjw->irjw", H, S, C) for H, C in zip(inverse, together, strict=False)]
    limit = pad.levels.limit(found)
    error = limit.error + np.abs(found[-1] - found[-2])
    A, C, H = limit.value, together[-1], inverse[-1]
    differs, n = np.abs(C - np.einsum("ips,isjw->ipjw", own[-1], A)), np.arange(len(C))
    others = off.copy()
    others[n, :, n] = 0.0
    wrong = np.einsum("isp,ipjw->isjw", own_of(off), differs) + np.einsum("iskp,kpjw->isjw", others, np.abs(C))
    return A, error + np.einsum("irs,isjw->irjw", np.abs(H), wrong), H


def _finite_strain(found: CellCrosstalk, S: Array, H: Array, pad: CellsPad, alone: Sequence[CellsPad]) -> Array:
    """Return e of the module docstring by each force, (n, r, n, r); infinite where a second step is not bounded."""
    n, r = H.shape[:2]
    e, signs = np.zeros((n, r, n, r)), (found.load, -found.load)
    for j, s, F in product(range(n), range(r), signs):
        p, own = (each.steps(k, Wrench(**{found.reads[s]: F}))[1] for each, k in ((pad, j), (alone[j], 0)))
        p[j] -= own[0]
        by = np.einsum("irs,iskp,kp->ir", H, S, p) if np.all(np.isfinite(p)) else np.inf
        e[:, :, j, s] = np.maximum(e[:, :, j, s], np.abs(by))
    return e


def _inverse(A: Array, known: Mask) -> Array:
    """Return M, (n, r, n, r), of A, (n, r, n, r), of what is known; infinite where it is singular."""
    square = A[known][:, known]
    found, (rows,) = np.zeros((known.size, known.size)), np.nonzero(known.ravel())
    singular = np.linalg.matrix_rank(square) < len(rows)
    found[np.ix_(rows, rows)] = np.inf if singular else np.linalg.inv(square)
    return found.reshape(*known.shape, *known.shape)


def _through(M: Array, off: Array) -> Array:
    """Return |M| |off|, each (n, r, n, r), zeros where M has none; infinite by what is."""
    bounded = np.all(np.isfinite(off), axis=(0, 1))
    size = np.einsum("irks,ksjt->irjt", np.abs(M), np.where(bounded, np.abs(off), 0.0))
    own = np.einsum("irir->ir", M) != 0.0
    return np.where(own[..., None, None] & own, np.where(bounded, size, np.inf), 0.0)


def _check_resolved(found: CellForces) -> None:
    """Refuse cells whose readings do not resolve the forces on them."""
    share = np.nan_to_num(found.by_mixing.sum(axis=(2, 3)), nan=np.inf)
    i, r = np.unravel_index(share.argmax(), share.shape)
    if not share[i, r] < 1.0:
        name = f"{found.reads[r]} on targets.{found.crosstalk.cells.names[i]}"
        raise SceneError(f"targets must be so far apart, or the tolerance so small, that what cells read resolves the "
                         f"forces on them to 100 % of the largest; got {name} to {100.0 * share[i, r]:.3g} %")
