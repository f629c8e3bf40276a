"""The ladder of divisions: what is taken where memory has no room, and what is told of it."""

import numpy as np
import pytest

from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.rungs import ImpedanceLimit, PlateRung
from sits_mech.memory import GIB, MEMORY
from sits_mech.notes import NoteKind
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Conductor, load_sensor


@pytest.mark.slow
def test_what_memory_does_not_hold_is_divided_coarser_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The answer is that of the coarser division, with its error, and lies within it of the finer one's."""
    sensor = load_sensor("biorob2018", ['target.width="7.9 mm"'])
    pose = Pose(0.0, 2e-3)
    coarse = sheets(sensor, 5e-3).impedance(pose, 5e6)
    monkeypatch.setenv(MEMORY.variable, "0.05")
    found = sheets(sensor, 2e-3).impedance(pose, 5e6)
    (said,) = (note for note in found.report.notes if note.kind is NoteKind.PLATE_TOO_LARGE)
    assert (said.known["width"], said.known["length"]) == pytest.approx((7.9e-3, 8e-3), rel=1e-9)
    assert said.known["needed"] > said.known["limit"] == pytest.approx(0.05 * GIB)
    np.testing.assert_array_equal((found.L, found.error_L), (coarse.L, coarse.error_L))
    monkeypatch.delenv(MEMORY.variable)
    fine = sheets(sensor, 2e-3).impedance(pose, 5e6)
    assert not any(note.kind is NoteKind.PLATE_TOO_LARGE for note in fine.report.notes)
    assert abs(found.L - fine.L)[0, 0] < (found.error_L + fine.error_L)[0, 0]


def test_coarse_triangles_in_place_of_fine_ones_are_within_their_error(monkeypatch: pytest.MonkeyPatch) -> None:
    square = ((-2e-3, -2e-3), (2e-3, -2e-3), (2e-3, 2e-3), (-2e-3, 2e-3))
    plane = Conductor(name="GND", material="copper", shape="outline", centre=(-4e-3, 0.0, -2e-3), points=square,
                      thickness=35e-6)
    monkeypatch.setenv(MEMORY.variable, "0.005")
    sensor = load_sensor("biorob2018").model_copy(update={"target": None, "conductors": (plane,)})
    found = sheets(sensor, 1e-2).impedance(Pose(0.0, 2e-3), 1e5)
    assert any(note.kind is NoteKind.PLATE_TOO_LARGE for note in found.report.notes)
    monkeypatch.delenv(MEMORY.variable)
    fine = sheets(sensor, 1e-2).impedance(Pose(0.0, 2e-3), 1e5)
    assert max(fine.error_L[0, 0], abs(found.L - fine.L)[0, 0]) < found.error_L[0, 0]


@pytest.mark.slow
def test_where_memory_holds_no_default_rung_the_roughest_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """By all of what is extrapolated from so few cells; a plate that no other test has divided."""
    sensor, pose = load_sensor("biorob2018", ["frequency=2.1e4", 'target.width="7.7 mm"']), Pose(0.0, 2e-3)
    monkeypatch.setenv(MEMORY.variable, "0.01")
    rough = sheets(sensor, 1e-2).impedance(pose, sensor.frequency)
    assert any(note.kind is NoteKind.PLATE_TOO_LARGE for note in rough.report.notes)
    monkeypatch.delenv(MEMORY.variable)
    fine = sheets(sensor, 1e-3).impedance(pose, sensor.frequency)
    assert not any(note.kind is NoteKind.PLATE_TOO_LARGE for note in fine.report.notes)
    change = abs(fine.L - fine.L0)[0, 0]
    assert abs(rough.error_L)[0, 0] < 4e-2 * change
    assert np.all(abs(rough.L - fine.L) < rough.error_L + fine.error_L)
    assert np.all(abs(rough.R - fine.R) < rough.error_R + fine.error_R)


@pytest.mark.parametrize(("along", "left"), [((2, 3, 4), 0.01 / 4), ((4, 5, 6), 0.0)])
@pytest.mark.parametrize("depths", [1e-3, 1e3])
def test_levels_from_two_parts_on_tell_a_quarter_of_their_rest(
    along: tuple[int, int, int], left: float, depths: float
) -> None:
    """Of a plate whose values y + a / m^2 show it, nothing is left but what no division shows; thick ones tell more."""
    Z = [np.array([[(1.0 + 1.0j) * (1.0 - 0.16 / m**2)]]) for m in (*along[::-1], along[0], along[0])]
    limit = ImpedanceLimit(PlateRung(along, (1, 2, 3), 7.0), depths, depths)
    forms = limit.forms(Z)
    found, error = forms[0].item(), limit.errors(forms).item()
    if depths < 1.0:
        assert found == pytest.approx(1.0 + 1.0j, abs=1e-12)
        assert error - 5e-5 * found == pytest.approx(left * (1.0 + 1.0j), abs=1e-8)
    assert error.real > left and error.imag > left


def test_close_to_coils_a_next_term_that_vanishes_by_chance_promises_nothing() -> None:
    """Of a foil 0.054 mm over a coil at 5.5 kHz levels 4, 5, 6 show their limit 3.5e-4 off Delta L; 1.9e-4 was told."""
    m4, m5, m6 = 1.0 - 1.33728e-2, 1.0 - 8.7437e-3, 1.0 - 6.2061e-3
    Z = [np.array([[1j * level]]) for level in (m6, m5, m4, m4, m4)]
    limits = [ImpedanceLimit(PlateRung((4, 5, 6), (3, 4, 5), 7.0), 0.02, 0.015, close) for close in (False, True)]
    far, close = (limit.errors(limit.forms(Z)).item().imag for limit in limits)
    assert far < abs(limits[1].forms(Z)[0].item().imag - 1.0) < close


def test_one_sheet_a_half_begins_no_family() -> None:
    """Levels across on a line of order 2 have no next term; all of their rest is the error where the first is one."""
    for across, left in (((1, 2, 3), 0.2 / 9.0), ((2, 3, 4), 0.0)):
        Z = [np.array([[(1.0 + 1.0j) * (1.0 - 0.2 / k**2)]]) for k in (*across[:1] * 3, *across[1:])]
        limit = ImpedanceLimit(PlateRung((4, 5, 6), across, 7.0), 1.0, 0.1)
        forms = limit.forms(Z)
        assert forms[0].item() == pytest.approx(1.0 + 1.0j, abs=1e-12)
        assert (limit.errors(forms) - 5e-5 * forms[0]).item() == pytest.approx(left * (1.0 + 1.0j), abs=1e-8)


def test_the_error_is_that_of_the_next_order() -> None:
    """Of y + a / m^2 + b / m^3 across what the limit is off; along, where b is taken, what 3 b / m^4 would leave."""

    def Z(m: int, k: int) -> np.ndarray:
        R, X = 1.0 + 0.3 / m**2 - 0.2 / m**3 - 0.1 / k**3, 2.0 + 0.2 / k**2 + 0.4 / m**3 + 0.3 / k**3
        return np.array([[R + 1j * X]])

    def third(m: int, n: int) -> float:
        return n**-3 + (n**-3 - m**-3) / ((n / m) ** 2 - 1.0)

    limit = ImpedanceLimit(PlateRung((4, 5, 6), (3, 4, 5), 7.0), 1e-3, 1.0)
    forms = limit.forms([Z(6, 3), Z(5, 3), Z(4, 3), Z(4, 4), Z(4, 5)])
    off, error = (forms[0] - (1.0 + 2.0j)).item(), (limit.errors(forms) - 5e-5 * forms[0]).item()
    assert (off.real, off.imag) == pytest.approx((-0.1 * third(4, 5), 0.3 * third(4, 5)), rel=1e-9)
    fourth = np.linalg.solve(np.power.outer((4.0, 5.0, 6.0), (0, -2, -3)), np.array([4.0, 5.0, 6.0]) ** -4)[0]
    expected = (abs(off.real) + 0.2 * 3.0 * fourth, abs(off.imag) + 0.4 * 3.0 * fourth)
    assert (error.real, error.imag) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("along", "order", "rim"), [((3, 4, 5), 8, 5e-3), ((4, 5, 6), 2, 1e-3)])
def test_where_current_crowds_the_error_is_between_orders(
    along: tuple[int, int, int], order: int, rim: float
) -> None:
    """Of R, whose limit is of order 8 in few cells, half of what is between 2 and 8; of L, halfway, between 2 and 3."""
    Z = [np.array([[(1.0 + 1.0j) * (1.0 - 0.3 / m**2)]]) for m in (*along[::-1], 4, 4)]
    limit = ImpedanceLimit(PlateRung(along, (3, 4, 5), 7.0), 1e3, 1e3)
    forms = limit.forms(Z)
    last = 0.3 / along[1] ** 2 - 0.3 / along[2] ** 2
    shown = {p: 1.0 / ((along[2] / along[1]) ** p - 1.0) for p in (2, 3, 8)}
    assert forms[0].item().imag == pytest.approx(1.0 - (shown[2] - shown[3]) / 2.0 * last, abs=1e-12)
    assert forms[0].item().real == pytest.approx(1.0 - (shown[2] - shown[order]) * last, abs=1e-12)
    own = (limit.errors(forms) - 5e-5 * forms[0] - rim * forms[0].real).item()
    expected = 0.5 * last * np.array([shown[2] - shown[order], shown[2] - shown[3]])
    assert (own.real, own.imag) == pytest.approx(tuple(expected), rel=1e-6)
