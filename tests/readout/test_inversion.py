"""Many small inverses at once, and answers that are a reading's own."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.readout.inversion import pseudo_inverse

FORCES = ("F_x", "F_y", "F_z")
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def coils(F: np.ndarray, corners: np.ndarray = CORNERS) -> np.ndarray:
    """Coils around a centre [H]: pressing lowers all, shear parts them, each a little by the others."""
    x, y, z = F.T
    common = 2.0e-6 * np.exp(-0.02 * z) * (1.0 + 0.004 * (x**2 + y**2))
    odd = [(a * np.sin(0.8 * x) + b * np.sin(0.8 * y)) * (1.0 + 0.1 * z) + 0.02 * a * b * x * y for a, b in corners]
    return common[:, None] + 3e-8 * np.stack(odd, -1)


def grid(size: int) -> np.ndarray:
    """Loads of three forces."""
    axes = [np.linspace(-0.5, 0.5, size)] * 2 + [np.linspace(0.0, 2.0, size)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def three_forces(corners: np.ndarray = CORNERS, function=coils, noise=None) -> Calibration:
    """A calibration by hand."""
    names = [f"C{k + 1}" for k in range(len(corners))]
    free, L = ("H", np.full(len(corners), 2e-6)), function(grid(5), corners)
    return calibration_of(grid(5), L, forces=FORCES, coils=names, free=free, noise=noise)


def loads(count: int) -> np.ndarray:
    """Random loads."""
    return np.random.default_rng(3).uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 2.0], (count, 3))


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (3, 2), (4, 3), (9, 6)])
def test_pseudo_inverses(shape: tuple[int, int]) -> None:
    """As by singular values; a column that depends on others leaves the least squares of those."""
    A = np.random.default_rng(1).standard_normal((7, *shape)) * 10.0 ** np.arange(-3, 4)[:, None, None]
    found = np.moveaxis(pseudo_inverse(np.moveaxis(A, 0, 2)), 2, 0)
    np.testing.assert_allclose(found @ A, np.broadcast_to(np.eye(shape[1]), (7, shape[1], shape[1])), atol=1e-11)
    np.testing.assert_allclose(found, np.linalg.pinv(A), rtol=1e-9, atol=1e-11 * np.abs(found).max())
    twice = np.repeat(A[..., :1], 2, axis=-1)
    once = np.moveaxis(pseudo_inverse(np.moveaxis(twice, 0, 2)), 2, 0)
    np.testing.assert_allclose(once[:, 0], np.linalg.pinv(A[..., :1])[:, 0], rtol=1e-9)
    assert np.all(once[:, 1] == 0.0)


@pytest.mark.parametrize("count", [3, 4])
def test_three_forces_come_back(count: int, counted: Callable) -> None:
    """From three and from four coils: to rounding of the map, of the function within the stated error; in four steps,
    9 us a reading (measured).
    """
    corners = CORNERS if count == 4 else np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
    cal, F = three_forces(corners), loads(20_000)
    assert cal.domain.regions == () and cal.domain.share == 1.0
    found, evaluations = counted(cal, cal.forward(F))
    assert evaluations < 4.0
    assert np.all(found.status == "ok") and np.max(found.residual) < 1e-9
    np.testing.assert_allclose(found.forces, F, atol=1e-10)
    true = cal.inverse(coils(F, corners))
    assert np.all(true.status == "ok") and np.all(np.abs(true.forces - F) <= true.error + 1e-9)
    assert np.max(true.error / (cal.high - cal.low)) < 0.05


def test_an_answer_is_its_readings_own() -> None:
    """Alone, in another order, among others that are outside or broken: the same digits."""
    cal, F = three_forces(), loads(4200)
    L = coils(F)
    L[5], L[7, 1], L[9] = 1e-6, np.nan, coils(np.array([[0.2, 0.1, 2.3]]))
    whole = cal.inverse(L)
    forward = cal.forward(F)
    assert whole.status[[5, 7, 9]].tolist() == ["outside", "no solution", "outside"]
    for rows in ([0], [5], [7], [9], [4100], list(range(20, 3, -1))):
        part = cal.inverse(L[rows])
        for name in ("forces", "status", "error", "residual"):
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows])
        np.testing.assert_array_equal(cal.forward(F[rows]), forward[rows])


def folded(F: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The common part has its least value at F_z = 1.5: loads below and above it show the same reading."""
    x, y, z = F.T
    odd = [2e-8 * (a * x + b * y) for a, b in corners]
    return 2e-6 + (5e-9 * (z - 1.5) ** 2)[:, None] + np.stack(odd, -1)


@pytest.mark.parametrize("count", [3, 4])
def test_a_fold_of_three_forces(count: int) -> None:
    """Loads of 1..2 N have two answers, those below 1 N one."""
    corners = CORNERS if count == 4 else np.array([[0.0, 1.0], [-0.87, -0.5], [0.87, -0.5]])
    cal = three_forces(corners, folded)
    assert any("F_z 1.6" in region and "sign turns" in region for region in cal.domain.regions)
    assert cal.domain.share == pytest.approx(0.75, abs=0.05)
    F = np.array([[0.1, -0.2, 0.5], [0.1, -0.2, 1.3], [0.1, -0.2, 1.7], [-0.4, 0.3, 0.9]])
    found = cal.inverse(folded(F, corners))
    assert found.status.tolist() == ["ok", "ambiguous", "ambiguous", "ok"]
    np.testing.assert_allclose(found.forces[[0, 3]], F[[0, 3]], atol=1e-9)


def wound(F: np.ndarray, coils: np.ndarray) -> np.ndarray:
    """A ribbon that goes round its y axis by more than one turn; a fourth coil, where there is one, is wound up."""
    x, y, z = F.T
    angle, radius = 2.0 * np.pi * 1.15 * z / 2.0, 2.0 + x
    shown = [radius * np.cos(angle), radius * np.sin(angle), y, z]
    return 2e-6 + 1e-8 * np.stack(shown[: len(coils)], -1)


@pytest.mark.slow
def test_an_edge_that_crosses_itself_in_three_dimensions() -> None:
    """One sign is not enough; ends of a spiral that lie on each other are refused, and a fourth coil parts them."""
    axes = [np.linspace(-0.5, 0.5, 5)] * 2 + [np.linspace(0.0, 2.0, 13)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    F = np.array([[0.1, 0.2, 0.1], [0.1, 0.2, 1.0], [-0.3, -0.4, 1.9], [0.0, 0.0, 0.4]])
    for count, status in ((3, ["ambiguous", "ok", "ambiguous", "ok"]), (4, ["ok"] * 4)):
        names = [f"C{k + 1}" for k in range(count)]
        L = wound(points, np.zeros((count, 2)))
        cal = calibration_of(points, L, forces=FORCES, coils=names, free=("H", np.full(count, 2e-6)))
        assert any("crosses itself" in region for region in cal.domain.regions) == (count == 3)
        found = cal.inverse(wound(F, np.zeros((count, 2))))
        assert found.status.tolist() == status
        ok = found.status == "ok"
        assert np.max(np.abs(found.forces[ok] - F[ok])) < 0.02


def test_a_reading_of_no_load() -> None:
    """Four coils, three forces: what leaves the table's plane has a residual, and beyond a fiftieth no answer."""
    cal, F = three_forces(), loads(50)
    twist = 1e-9 * np.array([1.0, -1.0, 1.0, -1.0])
    for times, status in ((1.0, "ok"), (10.0, "no solution")):
        found = cal.inverse(coils(F) + times * twist)
        assert np.all(found.status == status)
        np.testing.assert_allclose(found.residual, times * 1e-9 / cal.full_scale.max(), rtol=0.2)


@pytest.mark.slow
def test_noise_weighs_the_coils() -> None:
    """A coil of ten times the noise is hardly asked: forces of a disturbed reading follow the others."""
    F = loads(100)
    off = coils(F) + [0.0, 0.0, 0.0, 4e-10]
    alike = three_forces().inverse(off)
    weighed = three_forces(noise=[1e-12, 1e-12, 1e-12, 1e-11]).inverse(off)
    exact = three_forces().inverse(coils(F)).forces
    assert np.median(np.abs(weighed.forces - exact)) < 0.05 * np.median(np.abs(alike.forces - exact))


def test_both_errors_of_a_force() -> None:
    """By noise of one coil and by the table's error, of a plane of slopes by hand."""
    slopes = np.array([[1e-8, 0.0, 2e-8], [0.0, 1e-8, 2e-8], [-1e-8, -1e-8, 2e-8]])
    names = ["C1", "C2", "C3"]
    free = ("H", [2e-6] * 3)
    cal = calibration_of(grid(4), 2e-6 + grid(4) @ slopes.T, forces=FORCES, coils=names, free=free, noise=[1e-12] * 3)
    found = replace(cal, model_error=np.array([0.0, 0.0, 6e-10])).inverse(2e-6 + slopes @ [0.1, 0.2, 0.5])
    inverse = np.linalg.inv(slopes)
    np.testing.assert_allclose(found.error_by_noise, 1e-12 * np.linalg.norm(inverse, axis=1), rtol=1e-6)
    np.testing.assert_allclose(found.error_by_model, 6e-10 * np.abs(inverse[:, 2]), rtol=1e-6)
    assert np.all(np.isnan(cal.inverse(2e-6 + slopes @ [0.1, 0.2, 0.5]).error_by_model))


def test_a_force_that_no_coil_resolves() -> None:
    """Coils in a row do not see what parts others across it, to rounding or to the table's errors; it is named."""
    row, noise = np.array([[-1.0, 0.0], [0.2, 0.0], [1.0, 0.0], [-0.3, 0.0]]), np.array([1.0, -2.0, 0.5, 1.0])
    for across in (0.0, 1e-13):

        def blind(F: np.ndarray, corners: np.ndarray, size: float = across) -> np.ndarray:
            return coils(F * [1, 0, 1], corners) + size * F[:, 1:2] * noise

        cal = replace(three_forces(row, blind), model_error=np.full(4, 1e-10))
        assert cal.unresolved == ("F_y",) and cal.condition > 1e3
        with pytest.raises(ValueError, match=r"C4 do not resolve F_y of F_x, F_y, F_z: condition number [\d.e+]+, err"):
            cal.inverse(coils(loads(2), row))
    assert three_forces().unresolved == () and three_forces().condition < 10.0


def bent(F: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Coils [H] whose slopes change by more than half over the loads."""
    x, y, z = 2.0 * F[:, 0], 2.0 * F[:, 1], F[:, 2] - 1.0
    each = [a * x + b * y - 0.7 * z + 0.3 * (a * z + b * x) ** 2 + 0.25 * a * b * y * z for a, b in corners]
    return 2e-6 + 3e-8 * np.stack(each, -1)


@pytest.mark.parametrize(("count", "function"), [(3, coils), (4, bent)])
def test_an_answer_does_not_depend_on_the_start(count: int, function: Callable[..., np.ndarray]) -> None:
    """From a sixtieth of the starting points: the same statuses, beyond the table and far off too, the same forces."""
    cal, random = three_forces(CORNERS[:count], function), np.random.default_rng(8)
    few = replace(cal, seeds=tuple(part[::60] for part in cal.seeds))
    middle, half = 0.5 * (cal.high + cal.low), 0.5 * (cal.high - cal.low)
    L = cal.forward(middle + half * random.uniform(-1.3, 1.3, (4000, 3)), beyond=True)
    L += random.choice([0.0, 1e-3, 0.05, 1.0], (len(L), 1)) * cal.full_scale * random.normal(size=L.shape)
    every, some = cal.inverse(L), few.inverse(L)
    assert set(every.status) == {"ok", "outside", *(["no solution"] if count == 4 else [])}
    np.testing.assert_array_equal(every.status, some.status)
    np.testing.assert_allclose(every.forces, some.forces, rtol=0.0, atol=1e-8)


@pytest.mark.slow
def test_beyond_every_load_is_outside() -> None:
    """As many coils: what no load shows. More: what leads further than any load's reading; no other has a solution."""
    pressed = np.array([[0.1, 0.0, 4.0]])
    for corners in (CORNERS, CORNERS[:3]):
        assert three_forces(corners).inverse(coils(pressed, corners)).status.tolist() == ["outside"]
    cal = three_forces()
    wrong = coils(np.array([[0.1, 0.0, 1.0]])) + 0.3 * cal.full_scale * [1.0, -1.0, 1.0, -1.0]
    found = cal.inverse(wrong)
    assert found.status.tolist() == ["no solution"] and found.residual[0] > 0.02
    assert not cal.domain.beyond(wrong)[0] and cal.domain.beyond(coils(pressed))[0]
