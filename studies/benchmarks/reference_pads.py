"""Where does an independent code put the target of each reference pad, and how sure is it?

NGSolve's high-order mixed elements, graded geometrically towards the edges of the bond (common/ngsolve_pad.py), for
every pad and load of common/reference_cases.py. Each is solved on three meshes with more and more layers towards the
edges, and on one of them with elements of another order. The value is the last of the three, carried on along the
measured ratio of their differences where they shrink; its error is the larger of what that adds and of what the other
order changes there, over the size of the displacement, an angle counted at the target's end. Small shear and moments
are stiffnesses at rest: of round pads as waves around the axis, of boxes on quarters with the symmetry of the load.

Where a load creases the free face next to the bond's edge, finer meshes follow the crease into ever smaller ones and
stop carrying the load: such rows come from fewer layers, and their errors say so. Boxes at finite strain, and films
under rectangles, stand on families of meshes instead, on the lines of the package's own: value and error are the limits
of two orders of elements, each by the order that its last three meshes show. So do sections that are sheared, and pads
by chance in space, of which two meshes and the order of their edges must do; those that neither carries have no row.

NGSolve is no dependency: ``pip install ngsolve`` beside the package; without it the study says so and ends. Run
``python -m benchmarks.reference_pads [--coarse] --output DIR``; `--only WORD` makes the cases with that word in their
names, added to what is in DIR. common/reference_pads.json is its full run: half an hour of processor time and more.
"""

from __future__ import annotations

import numpy as np
from common.ngsolve_solve import Reference, reference
from common.outputs import add_references
from common.reference_cases import CASES, Case

QUICK = ("flush disc 15 x 2, small shear", "flush disc 20 x 0.1, film")
ABOUT = (
    "Motion of the target [m, rad] on bonded pads under a load [N, N m], contact off; a layer in plane strain is 1 m "
    "long. error: of the reference, over the size of the displacement, an angle counted at the target's end. Made by "
    "benchmarks/reference_pads.py with NGSolve 6.2; source: elements and meshes, how their differences shrink."
)


def row_of(case: Case, found: Reference) -> dict[str, object]:
    """Return a reference as a row of the file, in SI."""
    d_h, sink, alpha = (float(f"{x:.8g}") for x in found.pose * [1e-3, 1e-3, 1.0])
    F_x, F_z, M = (float(f"{x:.8g}") for x in np.array(case.load) * [1.0, 1.0, 1e-3])
    wrench, moved = {"F_x": F_x, "F_z": F_z, "M": M}, {"d_h": d_h, "sink": sink, "alpha": alpha}
    if case.turned:  # x to y, y to -x: what turns about y turns about -x
        wrench, moved = {"F_y": F_x, "F_z": F_z, "M_x": -M}, {"d_y": d_h, "sink": sink, "alpha_x": -alpha}
    if case.twist:
        wrench, moved = {"M_z": 1e-3 * case.twist}, {"alpha_z": alpha}
    row: dict[str, object] = {"name": case.name, "model": case.model}
    row |= {"wrench": {name: value for name, value in wrench.items() if value}}
    row |= {"moved": {name: value for name, value in moved.items() if value}}
    return row | {"error": float(f"{found.error:.2g}"), "source": found.words, "scene": case.changes}


def main() -> None:
    """Solve and write, case by case."""
    rows = {case.name: lambda _, case=case: row_of(case, reference(case)) for case in CASES}
    add_references(__doc__, ABOUT, "reference_pads.json", QUICK, rows)


if __name__ == "__main__":
    main()
