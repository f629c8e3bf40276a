"""What all magnetic models have in common: refusals in one order, poses of any shape, nothing asked without metal."""

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.answer import Kind, Reaction, answer
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Impedance, Pose, SolveFailed
from sits_mech.scene.sensor import Sensor, load_sensor

PLANE = Kind("plane", "H/m", plane=True)
SAID = Note.of(NoteKind.STATED, text="said")


def alone() -> tuple[Array, Array]:
    """Two coils of 2 and 3 H that know each other, of 5 and 7 ohm."""
    return np.array([[2.0, 0.5], [0.5, 3.0]]), np.array([5.0, 7.0])


def react(pose: Pose, frequency: float) -> Reaction:
    """Delta Z = (1 - j omega d_v) in all entries; errors of 1 % and 2 %."""
    Z = 1.0 - 2j * np.pi * frequency * pose.d_v[:, None, None] * np.ones((1, 2, 2))
    return Reaction(Z, 0.01 * Z.real - 0.02j * Z.imag, 0.02, 9, 3, 1e-9, (SAID,))


def asked(pose: Pose, *, kind: Kind = PLANE, sensor: Sensor | None = None, frequency: float = 1e6) -> Impedance:
    """Ask the model above."""
    return answer(kind, sensor or load_sensor("biorob2018"), pose, frequency, alone, react)[0]


def test_values_and_report_by_hand() -> None:
    """L = L0 - d_v, R = 1 in all entries; one pose has no leading axis, many have theirs."""
    one, many = asked(Pose(0.0, 0.25)), asked(Pose(np.array([0.0, 1e-4]), np.array([[0.1], [0.2], [0.3]])))
    np.testing.assert_allclose(one.L, [[1.75, 0.25], [0.25, 2.75]], rtol=1e-15)
    np.testing.assert_allclose((one.R[0, 1], one.error_L[0, 1], one.error_R[1, 0]), (1.0, 5e-3, 0.01))
    assert many.L.shape == many.error_R.shape == (3, 2, 2, 2) and many.L[2, 1, 0, 0] == pytest.approx(1.7)
    report = one.report
    assert (one.unit_L, report.model) == ("H/m", "plane")
    assert (report.unknowns, report.iterations, report.residual) == (9, 3, 1e-9)
    assert (report.estimated_error, report.notes, report.left_out) == (0.02, (SAID,), ())


def test_absolute_answers_are_in_henry() -> None:
    assert asked(Pose(0.0, 0.25), kind=PLANE.of(True)).unit_L == "H" and PLANE.of(False) is PLANE


def test_nothing_is_asked_without_metal_or_poses() -> None:
    """The coils alone, of which nothing is left out; of no poses an empty answer."""
    bare = asked(Pose(np.zeros(3), -1.0), sensor=load_sensor("biorob2018").model_copy(update={"target": None}))
    np.testing.assert_array_equal(bare.L, np.broadcast_to(alone()[0], (3, 2, 2)))
    assert not bare.R.any() and bare.report.left_out == ()
    assert asked(Pose(np.zeros(0), 1.0)).L.shape == (0, 2, 2)


def test_refusals() -> None:
    """The frequency, then components by name, then the place."""
    with pytest.raises(ValueError, match="frequency: must be a positive number"):
        asked(Pose(0.0, -1.0, d_y=1e-3), frequency=0.0)
    with pytest.raises(ValueError, match="pose: d_y must be zero for the model plane, which is plane"):
        asked(Pose(0.0, -1.0, d_y=1e-3))
    with pytest.raises(Collision, match="above the coil plane"):
        asked(Pose(0.0, -1.0, d_y=1e-3), kind=Kind("space", "H"))


@pytest.mark.parametrize("lost", [np.nan, np.inf, None])
def test_what_rounding_has_lost_is_refused_by_name(lost: float | None) -> None:
    """An answer that is no number, and matrices that cannot be factored, are no answer."""

    def broken(pose: Pose, frequency: float) -> Reaction:
        if lost is None:
            np.linalg.cholesky(-np.eye(2))
        return Reaction(np.full((1, 2, 2), lost, dtype=complex), np.zeros((1, 2, 2), dtype=complex))

    with pytest.raises(SolveFailed, match="plane: .* resolved") as caught:
        answer(PLANE, load_sensor("biorob2018"), Pose(0.0, 0.25), 1e6, alone, broken)
    assert (caught.value.report.status, caught.value.half) == ("not resolved", "magnetics")
