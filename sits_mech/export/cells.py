"""Write what turns the forces that cells read into those on them as a C header, in integers alone.

The inverse M of chain/cells/forces.py becomes N = round(2^b M), and forces are (N a + 2^(b-1)) >> b of integers a. With
sums over rows of |N| below 2^31 and |a| <= 2^31 no sum exceeds 2^62; b is the most bits, up to 30, that have it so. The
integers are off by half a unit and by |N/2^b - M| |a|.

Forces stand in the order of firmware.h.in, that of a wrench.
"""

from __future__ import annotations

from collections.abc import Sequence
from string import Template

import numpy as np

from sits_mech.chain.cells.crosstalk import FORCES, in_forces
from sits_mech.chain.cells.forces import CellForces
from sits_mech.export.firmware import c_rows
from sits_mech.export.source import comment
from sits_mech.quantities import WRENCH, Array, Integers
from sits_mech.report.page.explorer import page_file
from sits_mech.scene.cells import Cells
from sits_mech.units import SceneError
from sits_mech.version import __version__

_MICRO, _BITS = 1e6, 30  # of a newton; fractional bits at most
_CHECK = """#if defined(SITS_FORCES) && SITS_FORCES != SITS_CELL_FORCES
#error "cells read {names}: sits_forces() must be of a calibration over these {r}"
#endif
"""


def inverse_integers(M: Array) -> tuple[Integers, int]:
    """Return the integers of an inverse (m, m) and their fractional bits; SceneError where there is no room for any."""
    for bits in range(_BITS, 0, -1):
        found = np.rint(M * 2.0**bits)
        if np.abs(found).sum(axis=1).max() < 2.0**31:
            return found.astype(np.int64), bits
    raise SceneError(f"--header: must have an inverse with rows below 2^30; got {np.abs(M).sum(axis=1).max():.3g}")


def cells_header(found: CellForces, title: str) -> str:
    """Return the header of some cells."""
    cells, load = found.crosstalk.cells, found.crosstalk.load
    order = sorted(range(len(found.reads)), key=lambda s: WRENCH.index(found.reads[s]))
    names, known = [found.reads[s] for s in order], found.known[:, order]
    n, r = known.shape
    M = found.inverse[:, order][..., order].reshape(n * r, n * r)
    N, bits = inverse_integers(M)
    rounding = 0.5 + _MICRO * load * float(np.abs(N / 2.0**bits - M).sum(axis=1).max())
    aside = ", ".join(f"{found.reads[s]} of {cells.names[i]}" for i, s in np.argwhere(~found.known))
    return Template(page_file("cells.h.in", "export")).substitute(
        name=comment(title), version=__version__, n=n, r=r, cells=comment(", ".join(cells.names)), bits=bits,
        forces=", ".join(f"{name} [uN]" for name in names), rows=c_rows(N), products=(n * r) ** 2,
        check="" if len(set(cells.kinds)) > 1 else _CHECK.format(names=", ".join(names), r=r), load=f"{load:g}",
        headers=_headers(cells), rounding=f"{rounding:.2g}",
        left_aside="\n * " + comment(f"Left aside, and zero in force: {aside}.") if aside else "",
        beyond=_beyond(found, names), by_mixing=_words(load * found.by_mixing),
        by_finite_strain=_words(load * found.by_finite_strain), by_unread=_by_unread(found),
        gain=f"{np.abs(M).sum(axis=1).max():.3g}",
        names=", ".join(f"SITS_CELL_{name.upper()} = {i}" for i, name in enumerate(names)),
    )


def _headers(cells: Cells) -> str:
    """Return which headers of calibrations cells have."""
    kinds = cells.kinds
    if len(set(kinds)) == 1:
        return "the same for all, which are alike"
    alike = [[name for name, k in zip(cells.names, kinds, strict=True) if k == own] for own in sorted(set(kinds))]
    of = comment("; ".join(", ".join(names) for names in alike))
    return f"one for each of\n * {of}: each in a file of C of its own, as two do not stand in one"


def _beyond(found: CellForces, names: Sequence[str]) -> str:
    """Return what cells read by forces on others, as large as the load, at most."""
    A, n = np.abs(found.mixing[..., in_forces(found.reads)]), np.arange(len(found.known))
    A[n, :, n] = 0.0
    most = dict(zip(found.reads, found.crosstalk.load * A.sum(axis=(2, 3)).max(axis=0), strict=True))
    return ", ".join(f"{most[name]:.3g} N of {name}" for name in names)


def _by_unread(found: CellForces) -> str:
    """Return what forces that cells do not read make of others."""
    off, own = found.crosstalk.load * found.by_unread, np.arange(len(found.known))
    each = zip(FORCES, np.moveaxis(off, 3, 0), strict=True)
    words = [f"\n *   {_words(by[..., None])} by {name}, which is not read" for name, by in each if np.any(by[own])]
    return ";".join(["", *words])


def _words(off: Array) -> str:
    """Return errors (n, r, n, s) [N] of forces on the cell that is under a force, and on others, in words."""
    size = np.abs(off).max(axis=(1, 3))
    own = np.eye(len(size), dtype=bool)
    if not np.all(np.isfinite(size)):
        return "not bounded"
    return f"{1e3 * size[own].max():.3g} mN and {1e3 * size[~own].max():.3g} mN"
