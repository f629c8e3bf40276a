"""Lines of the axisymmetric cells: on every face and rim, graded to them, as fine as skin and tracks ask."""

import numpy as np
import pytest

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.axis.lines import CoaxialDisc, divide_axis
from sits_mech.magnetics.modes import skin_depth
from sits_mech.scene.sensor import Coil

MM = 1e-3
TRACKS = coil_sections(Coil(
    name="C", centre=(0.0, 0.0), layers=1, turns=10, inner_diameter=4 * MM, track_width=0.2 * MM, track_gap=0.2 * MM,
    track_thickness=35e-6,
))
STEEL = CoaxialDisc(8 * MM, 1 * MM, 2 * MM, 5e6, 100.0)
GROUND = CoaxialDisc(8 * MM, -1 * MM, -0.8 * MM, 5.8e7, 1.0)


def test_lines_lie_on_faces_and_rims_and_grow_from_them() -> None:
    lines = divide_axis([STEEL, GROUND], TRACKS, 1e5, 1.0)
    assert {STEEL.bottom, STEEL.top, GROUND.bottom, GROUND.top} <= set(lines.z)
    assert lines.r[0] == 0.0 and list(lines.r).count(8 * MM) == 1  # rims that are equal are one
    for edges in (lines.r, lines.z):
        cells = np.diff(edges)
        assert np.all(cells > 0.0) and np.all(cells[1:] / cells[:-1] < 4.0) and np.all(cells[:-1] / cells[1:] < 4.0)
    face = int(np.flatnonzero(lines.z == STEEL.bottom)[0])
    first = np.diff(lines.z)[[face - 1, face]]
    assert np.all(first < 2.0 * STEEL.first_cell(1e5, 1.0))


def test_first_cells_follow_skin_thickness_and_permeability() -> None:
    copper = CoaxialDisc(8 * MM, 1 * MM, 2 * MM, 5e6, 1.0)
    assert STEEL.first_cell(1e7, 1.0) == pytest.approx(0.7 * skin_depth(1e7, 5e6, 100.0))
    assert copper.first_cell(1.0, 1.0) == pytest.approx(0.5 * MM)
    assert STEEL.first_cell(1.0, 1.0) == pytest.approx(0.02 * MM)
    assert STEEL.first_cell(1.0, 0.5) == pytest.approx(0.02 * MM / 8)  # sharper than others


def test_cells_see_the_tracks() -> None:
    """Closer, and smaller: as many as the distance asks; away from the coil nothing changes."""
    assert STEEL.away(TRACKS) == pytest.approx(1 * MM) and GROUND.away(TRACKS) == pytest.approx(0.765 * MM)
    few, many = (
        divide_axis([CoaxialDisc(8 * MM, gap, gap + 1 * MM, 5e6, 1.0)], TRACKS, 1e5, 1.0).r
        for gap in (1 * MM, 0.1 * MM)
    )
    over = [np.diff(r[(r > 2 * MM) & (r < 5 * MM)]).max() for r in (few, many)]
    assert over[1] < 0.25 * MM < over[0] and many.size > few.size


def test_finer_cells_are_more() -> None:
    sizes = [divide_axis([STEEL], TRACKS, 1e5, fineness).unknowns(3) for fineness in (1.0, 0.7, 0.5)]
    assert sizes[0] * 1.5 < sizes[1] and sizes[1] * 1.5 < sizes[2]
