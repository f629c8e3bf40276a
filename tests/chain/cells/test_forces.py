"""Forces on cells by what they read alone: the inverse, its errors, cells in place and alone, one touch read back."""

import numpy as np
import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.cells.crosstalk import FORCES, CellCrosstalk, cell_touch, forces_read
from sits_mech.chain.cells.fields import signal_slopes
from sits_mech.chain.cells.forces import CellForces, _alone, _check_resolved, _mixing, cell_forces
from sits_mech.mechanics.cells.targets import cells_pad
from sits_mech.readout.calibration import calibration
from sits_mech.scene.cells import load_cells
from sits_mech.units import SceneError

COIL = (
    '{{name="{}", centre=["{}", 0], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}}'
)
ONE = f"coils=[{COIL.format('C', '0 mm')}]"
PLACES = 'targets=[{name="A", centre=["-4.8 mm", 0]}, {name="B", centre=["4.8 mm", 0]}]'
PAIR = f"coils=[{COIL.format('L', '-2 mm')}, {COIL.format('R', '2 mm')}]"
TWO = f"coils=[{COIL.format('M', '0 mm')}, {COIL.format('L', '-2 mm')}, {COIL.format('R', '2 mm')}]"


def made(A: np.ndarray, off: float, load: float = 2.0, *keys: str) -> CellForces:
    """Cells A, which reads F_z alone, and B, which reads F_x, too, of a mixing (2, 2, 2, 3)."""
    cells = load_cells("biorob2018", [TWO, PLACES, 'targets.A.coils=["M"]', 'targets.B.coils=["L", "R"]', *keys])
    known = np.array([[True, False], [True, True]])
    total = np.where(known[..., None, None], 0.0, np.nan) * np.ones((2, 2, 2, 3))
    crosstalk = CellCrosstalk(cells, ("F_z", "F_x"), total, 0.0 * total, total, load, 0.1, 1.0, ("ok",))
    A = np.where(known[..., None, None], A, 0.0)
    square = np.eye(4)
    rows = np.flatnonzero(known)
    square[np.ix_(rows, rows)] = A[..., :2].reshape(4, 4)[np.ix_(rows, rows)]
    M = np.linalg.inv(square).reshape(2, 2, 2, 2) * known[..., None, None] * known
    strain = np.full((2, 2, 2, 2), 0.5 * off)
    return CellForces(crosstalk, A, np.full((2, 2, 2, 3), off), strain, M, 1.0)


def mixed(seed: int = 0) -> np.ndarray:
    """A mixing near one."""
    own = np.eye(4).reshape(2, 2, 2, 2)
    return np.concatenate([own, np.zeros((2, 2, 2, 1))], axis=3) + 0.2 * np.random.default_rng(seed).normal(
        size=(2, 2, 2, 3)
    )


def test_forces_are_those_that_were_mixed_within_stated_errors():
    """Of any mixing within the errors of the one known, by forces small enough that finite strain is none."""
    found, random = made(mixed(), 0.01), np.random.default_rng(1)
    assert found.known.tolist() == [[True, False], [True, True]]
    f = random.normal(size=(50, 2, 2)) * 1e-6 * found.known
    read = np.einsum("irjs,njs->nir", found.mixing[..., :2], f)
    force, error = found.forces(read)
    assert np.all(np.isnan(force[:, 0, 1])) and force[:, found.known] == pytest.approx(f[:, found.known], abs=1e-20)
    off = found.mixing_error[..., :2] * random.choice([-1.0, 1.0], size=(50, 2, 2, 2, 2))
    wrong = read + np.einsum("nirjs,njs->nir", off, f)
    force, error = found.forces(wrong)
    share = (np.abs(force - f) / error)[:, found.known]
    assert 0.3 < share.max() < 1.05  # f is not known in the error, but as it is found


def test_what_a_cell_does_not_read_is_an_error_of_what_it_does():
    """F_x on A, and F_y on both, move forces that are found by M times what they are read as."""
    found = made(mixed(2), 0.01)
    for j, w in ((0, 1), (0, 2), (1, 2)):
        force, _ = found.forces(found.mixing[:, :, j, w])
        assert found.by_unread[:, :, j, w][found.known] == pytest.approx(force[found.known])
    assert not np.any(found.by_unread[:, :, 1, :2]) and not np.any(found.by_unread[:, :, 0, 0])


def test_finite_strain_grows_with_the_square_of_forces_and_may_be_unbounded():
    found = made(mixed(), 0.0)
    small, large = (found.forces(scale * np.ones((2, 2)))[1] for scale in (0.1, 0.2))
    none = np.nan_to_num(made(mixed(), 0.1).finite_strain)
    assert np.all(none > 0.0) and not np.any(small[found.known])  # no errors of any kind
    bent = made(mixed(), 0.1)
    object.__setattr__(bent, "mixing_error", 0.0 * bent.mixing_error)
    small, large = (bent.forces(scale * np.ones((2, 2)))[1] for scale in (0.1, 0.2))
    assert large[bent.known] == pytest.approx(4.0 * small[bent.known])
    bent.finite_strain[:, :, 1, 0] = np.inf
    assert np.all(np.isinf(bent.by_finite_strain[:, :, 1, 0][bent.known]))
    assert np.all(np.isfinite(bent.by_finite_strain[:, :, 0, 0]))


def test_cells_whose_readings_do_not_resolve_forces_are_refused():
    _check_resolved(made(mixed(), 0.1))
    with pytest.raises(SceneError, match=r"resolves the forces on them .* got F_[xz] on targets\.[AB] to \d+ %"):
        _check_resolved(made(mixed(), 0.5))


@pytest.mark.slow
def test_two_cells_read_each_other_as_they_do_in_place_but_for_their_places():
    """A = P X, P near one: beside a neighbour, 5 thicknesses from the pad's sides, a cell sinks as it does alone."""
    pair = cell_forces(load_cells("biorob2018", [ONE, PLACES, 'elastomer.width="30 mm"']), 0.1, 0.2)
    X, A = pair.crosstalk.total, pair.mixing
    P = A[0, 0, 0, 0]
    assert pair.reads == ("F_z",) and 0.97 < P < 1.03 and P != 1.0
    assert np.all(np.abs(A - P * X)[:, 0] < (pair.mixing_error + pair.crosstalk.error)[:, 0])
    assert A[1, 0, 1, 0] == pytest.approx(P, rel=1e-3) and pair.mixing_error[0, 0, 1, 0] < 0.1 * abs(A[0, 0, 1, 0])
    force, error = pair.forces(np.array([[A[0, 0, 1, 0]], [A[1, 0, 1, 0]]]) * 0.2)
    assert force[:, 0] == pytest.approx([0.0, 0.2], abs=1e-12) and np.all(error < 0.02)
    assert FORCES[1] == "F_x" and pair.by_unread[0, 0, 1, 1] == pytest.approx(-pair.by_unread[1, 0, 0, 1], rel=1e-3)


@pytest.mark.slow
def test_a_press_on_one_cell_is_read_back_by_calibrations_of_cells_alone():
    """Inductances of a touch at finite strain, by the calibration of the cell alone, then through the inverse."""
    keys, touch = [ONE, PLACES, 'elastomer.width="30 mm"'], 'touch={shape="sphere", radius="5 mm", x="4.8 mm"}'
    found = cell_forces(load_cells("biorob2018", keys), 0.03, 0.2)
    L = cell_touch(load_cells("biorob2018", [*keys, touch]), 0.03, 0.2)
    alone = calibration(calibrate(found.crosstalk.cells.sensor, F_z=np.linspace(-0.1, 0.3, 5), tolerance=0.01))
    read = np.array([alone.inverse(alone.forward([0.0]) + own).forces for own in L.L - L.L_rest])
    force, error = found.forces(read)
    assert read[0, 0] < -0.012 and read[1, 0] == pytest.approx(0.197, rel=0.01)
    assert np.all(np.abs(force - [[0.0], [0.2]]) < error) and abs(force[0, 0]) < 0.1 * abs(read[0, 0])


@pytest.mark.slow
def test_a_slot_through_the_pad_leaves_each_cell_a_softer_pad_of_its_own():
    """Nothing is read of the neighbour, and more of the force on itself than by the calibration on the whole pad."""
    slot = 'slots=[{x="0 mm", width="0.8 mm"}]'
    found = cell_forces(load_cells("biorob2018", [ONE, PLACES, slot]), 0.1, 0.02)
    assert found.mixing[0, 0, 0, 0] > 1.02 and abs(found.mixing[0, 0, 1, 0]) < 1e-3
    force, _ = found.forces(np.array([[0.1], [0.0]]))
    assert force[0, 0] == pytest.approx(0.1 / found.mixing[0, 0, 0, 0], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("keys", [[ONE], [PAIR]])
def test_errors_of_the_mixing_hold_what_a_further_level_changes(keys: list[str]) -> None:
    """By meshes alone; of what is larger than a thousandth."""
    cells = load_cells("biorob2018", [*keys, PLACES, 'elastomer.width="24 mm"'])
    reads, weights = forces_read(cells)
    S, off = signal_slopes(cells, weights, 0.1)

    def mixing(count: int) -> tuple[np.ndarray, np.ndarray]:
        """A and D."""
        pad, alone = cells_pad(cells, 1e-9, most=count), [_alone(cells, k, count) for k in cells.kinds]
        return _mixing(S, 0.0 * off, pad, alone, reads)[:2]

    (A, D), (finer, _) = mixing(3), mixing(4)
    large = np.abs(finer) > 1e-3
    share = (np.abs(A - finer) / np.where(large, D, 1.0))[large]
    assert 0.05 < np.median(share) and share.max() < 1.4
