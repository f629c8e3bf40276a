"""Divisions of plates: their sheets against the closed form of a plate, their cells as levels of one family."""

from __future__ import annotations

import math
import tracemalloc
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sits_mech.geometry.sheet_plan import Grading, graded_axis
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import divisions
from sits_mech.magnetics.space.divisions import _family, _interfaces, field_box, memory_of
from sits_mech.magnetics.space.fields import to_coefficients
from sits_mech.magnetics.space.loops import most_unknowns
from sits_mech.magnetics.space.modes import prepare_sheets
from sits_mech.magnetics.space.near import prepare_near
from sits_mech.magnetics.space.rungs import LADDER, ROUGHEST, PlateRung, TooLarge, extrapolated_rest, rungs_for
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import GIB, MEMORY, SECONDS
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

MESHES = Path(__file__).parents[3] / "meshes"

RATIOS = (0.05, 0.2, 0.5, 0.7)  # skin depth prepared for, over the skin depth


def sheet_impedance(heights: np.ndarray, ratio: float, parity: int) -> complex:
    """E/H at the face of a plate of sheets with uniform current, lengths over the depth prepared for.

    Each sheet holds its mean field, ``J = <E>``; ``E' = 2j ratio^2 H``, ``H' = J``. Even E: H = 0 in the middle.
    """
    n, k2 = heights.size, 2j * ratio**2
    A, E, H = np.zeros((n + 1, n + 1), complex), np.zeros(n + 1, complex), np.zeros(n + 1, complex)
    (E if parity > 0 else H)[n] = 1.0
    for i, h in enumerate(heights):
        own = np.eye(n + 1)[i]  # current of the sheet
        A[i] = E + k2 * (H * h / 2 + own * h / 6) - own / h
        E, H = E + k2 * (H * h + own * h / 2), H + own
    A[n] = H
    return complex(E @ np.linalg.solve(A, np.eye(n + 1)[n]))


@pytest.mark.parametrize("asked, rung", (ROUGHEST, *LADDER))
@pytest.mark.parametrize("half", [0.2, 0.7, 2.0, 4.8, 7.6, 15.0, 60.0])
def test_sheets_carry_the_skin_effect(asked: float, rung: PlateRung, half: float) -> None:
    """The extrapolated resistance of both faces together and against each other: coth and tanh of (1 + j) half."""
    for ratio in RATIOS:
        k = (1 + 1j) * ratio
        for parity, exact in ((1, k / np.tanh(k * half)), (-1, k * np.tanh(k * half))):
            found = [sheet_impedance(np.diff(_interfaces(half, 1.0, m)), ratio, parity) for m in rung.across]
            values = [np.array([[Z.real]]) for Z in found]
            R = float((values[-1] + extrapolated_rest(*np.diff(values, axis=0), rung.across, 2.0)[0])[0, 0])
            assert abs(R - exact.real) < 2.0 * asked * (k / np.tanh(k * half)).real


@pytest.mark.parametrize("thickness", [0.2e-3, 2e-3, 1e-2])
def test_polynomials_carry_a_charge_below_the_near_face(thickness: float) -> None:
    """The potential 1/r of a charge a clearance below a plate, on the face next to it, to the digits of the rung."""
    plate, (_, rung) = load_sensor("biorob2018").target, LADDER[0]
    assert plate is not None
    box = field_box(plate.model_copy(update={"thickness": thickness}), 2e-3, rung)

    def potential(x: Any, y: Any, z: Any) -> Any:
        return 1.0 / np.hypot(np.hypot(x * box.half[0] - 1e-3, y * box.half[1]), (z + 1.0) * box.half[2] + 2e-3)

    nodes = [np.cos(np.pi * (np.arange(n) + 0.5) / n) for n in box.order]
    values = potential(*np.meshgrid(*nodes, indexing="ij"))
    coefficients = np.einsum("ia,jb,kc,abc->ijk", *map(to_coefficients, box.order), values)
    x = np.linspace(-1.0, 1.0, 41)
    face = np.polynomial.chebyshev.chebgrid3d(x, x, np.array([-1.0]), coefficients)[..., 0]
    exact = potential(x[:, None], x, -1.0)
    assert np.abs(face - exact).max() < np.exp(-rung.terms / 2) * exact.max()


@pytest.mark.parametrize("length", [1e-4, 4e-3, 2e-2])
def test_axes_of_one_family_follow_one_map(length: float) -> None:
    sizes = Grading(2e-5, 1.9, 1e-3).coarser(5.5)
    axes = {m: graded_axis(length, Grading(sizes.first, sizes.growth, sizes.largest, m)) for m in (1, 2, 3, 6)}
    for axis in axes.values():
        assert axis[0] == 0.0 and axis[-1] == length and (np.diff(axis) > 0.0).all()
    for m in (2, 3, 6):
        np.testing.assert_allclose(axes[m][::m], axes[1], rtol=0.0, atol=1e-5 * length)
    cells = np.diff(axes[6])
    assert all(after <= before * (1.0 + 1e-9) for before, after in pairwise(cells))


def drawn(name: str) -> Sensor:
    """The catalogue's sensor with a target of a mesh file's outline."""
    target = f'target={{material="copper", thickness="0.2 mm", shape="outline", mesh="{MESHES / name}.msh"}}'
    return load_sensor("biorob2018", [target])


def family(target: Any, tolerance: float, near: bool = False) -> Any:
    """Divisions of a target; by default of the catalogue's."""
    target = load_sensor("biorob2018").target if target is None else target
    rung = rungs_for(tolerance, [target])[0]
    return _family(target, rung, (1.5e-3, 1e7, (8e-3, 8e-3), 2e-3), near)


def peak(run: Callable[[], object]) -> int:
    """Most memory that is held at once, beyond what was [bytes]."""
    tracemalloc.start()
    try:
        run()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.parametrize("mesh, tolerance", [("cross", 2e-2), (None, 1e-3)])
def test_memory_is_known_before_it_is_taken(mesh: str | None, tolerance: float) -> None:
    """Of triangles over all of an outline, and of a quarter of a rectangle; a million pairs of prisms take 90 MB."""
    found = family(mesh and drawn(mesh).target, tolerance)
    (plan, levels), box = found.divisions[0], found.box
    known = memory_of(plan, levels.size - 1, found.depth, math.prod(box.order)).max()
    taken = peak(lambda: prepare_sheets([(plan, levels)], 5.8e7, box, found.resolved, found.depth))
    assert 1 / 1.5 < known / taken < 1.5


@pytest.mark.slow
def test_memory_of_a_near_plate_has_what_is_kept_of_all_divisions() -> None:
    sensor = load_sensor("biorob2018")
    found = family(sensor.target, 1e-2, near=True)
    seen = Posed(sensor.coils, "rings", np.eye(3)[None], np.array([[0.0, 0.0, 1e-3]]))
    def asked() -> None:
        plates = prepare_near(found.divisions, (5.8e7, found.depth), found.box, found.resolved)
        plates[0].reactions(plates, seen, 1e7)

    assert 1 / 1.5 < found.needed / peak(asked) < 1.5


def test_memory_grows_like_the_square_of_the_cells() -> None:
    """Of an outline with narrow places at 2e-2, several GiB: what finer cells take is no matter of their making."""
    slotted = drawn("slotted_disc").target
    fine, coarse = family(slotted, 2e-2), family(slotted, 5e-2)
    cells = [max(len(plan.cells) * (z.size - 1) for plan, z in each.divisions) for each in (fine, coarse)]
    assert fine.needed / coarse.needed == pytest.approx((cells[0] / cells[1]) ** 2, rel=0.2)
    assert fine.needed > 4 * GIB > coarse.needed
    plan = fine.divisions[0][0]
    assert most_unknowns(plan, 1.0) == (plan.loop < 0).sum() + len(plan.cells)


def test_a_plate_that_no_division_fits_is_refused_before_it_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(MEMORY.variable, "0.01")
    model = sheets(drawn("slotted_disc"), 1e-2)

    def refused() -> None:
        with pytest.raises(TooLarge, match=r"^memory: \d+ cells of the plate of .* mm take some .* GiB, more than the "
                           r"limit of 0.01 GiB \(--memory, or SITS_MECH_MEMORY\)$"):
            model.impedance(Pose(0.0, 2e-3), 5e6)

    assert peak(refused) < 0.1 * GIB


def test_the_time_of_prisms_is_known_before_it_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tall cells of a thick disc are all near each other, a hundred and sixty times as dear as far ones."""
    target = 'target={material="copper", shape="disc", diameter="12 mm", thickness="1 m"}'
    monkeypatch.setenv(SECONDS.variable, "3")
    monkeypatch.setattr(divisions, "prepare_near", None)  # is not reached
    model = sheets(load_sensor("triaxial-4", [target, "frequency=1e-6"]), 0.1)
    with pytest.raises(SceneError, match=r"^sheets: the preparation of a plate of .* GiB must take at most 3 s"):
        model.impedance(Pose(0.0, 2e-3), 1e-6)


def test_cells_without_number_are_refused_before_they_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A strip a nanometre wide: counting its cells, some 1e8, took 18 GiB where 4 are the limit."""
    monkeypatch.setattr(divisions, "target_plan", None)  # is not reached
    model = sheets(load_sensor("biorob2018", ['target.width="1 nm"']), 0.1)
    with pytest.raises(TooLarge, match=r"^memory: \d{7,} cells of the plate of 1e-06 x 8 mm take some"):
        model.impedance(Pose(0.0, 2e-3), 5e6)
