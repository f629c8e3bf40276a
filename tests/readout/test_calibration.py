"""Round trips, refusals and folds of maps known in closed form."""

import re
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from sits_mech.quantities import Wrench
from sits_mech.readout.calibration import Calibration, calibration, calibration_of
from sits_mech.units import SceneError

F_X, F_Z = np.linspace(-1.0, 1.0, 9), np.linspace(0.0, 4.0, 9)


def pair(F_x: np.ndarray, F_z: np.ndarray) -> np.ndarray:
    """A sensor by hand [H]: pressing lowers both coils, shear parts them, each a little by the other."""
    common = 2.0e-6 * np.exp(-0.02 * F_z) * (1.0 + 0.004 * F_x**2)
    odd = 3e-8 * np.sin(0.8 * F_x) * (1.0 + 0.1 * F_z)
    return np.stack([common + odd, common - odd], -1)


def table(function=pair, F_x: np.ndarray = F_X, F_z: np.ndarray = F_Z) -> xr.Dataset:
    """The table of a function, as a calibration leaves it."""
    x, z = np.meshgrid(F_x, F_z, indexing="ij")
    own = function(x, z)
    names = [f"C{i + 1}" for i in range(own.shape[-1])]
    L = own[..., None] * np.eye(len(names))
    data = xr.Dataset(coords={"F_x": F_x, "F_z": F_z, "coil": names, "coil_2": names}, attrs={"unit_L": "H"})
    data["L"] = (("F_x", "F_z", "coil", "coil_2"), L)
    data["L0"] = (("coil", "coil_2"), 2.1e-6 * np.eye(len(names)))
    data["status"] = (("F_x", "F_z"), np.full(x.shape, "ok", dtype=object))
    return data


def loads(cal: Calibration, count: int) -> np.ndarray:
    """Random loads of a table."""
    return np.random.default_rng(7).uniform(cal.low, cal.high, (count, len(cal.forces)))


def test_round_trip_and_work(counted: Callable) -> None:
    """Force to inductance to force: of the map to rounding, of the function itself to 1e-4 of full scale; in two steps,
    2 us a reading (measured).
    """
    cal = calibration(table())
    assert cal.forces == ("F_x", "F_z") and cal.coils == ("C1", "C2") and cal.unit == "H" and cal.domain.regions == ()
    F = loads(cal, 50_000)
    found, evaluations = counted(cal, cal.forward(F))
    assert evaluations < 2.1
    assert np.all(found.status == "ok")
    np.testing.assert_allclose(found.forces, F, atol=1e-10)
    true = cal.inverse(pair(*F.T))
    off = np.abs(true.forces - F)
    assert np.max(off / (cal.high - cal.low)) < 1e-4
    assert np.all(off <= true.error + 1e-8) and cal.error < 1e-4


def test_slopes_are_derivatives() -> None:
    """Of the function by hand."""
    cal = calibration(table())
    x, z, h = np.array([0.3]), np.array([1.7]), 1e-5
    by_x, by_z = (pair(x + h, z) - pair(x - h, z)) / (2 * h), (pair(x, z + h) - pair(x, z - h)) / (2 * h)
    np.testing.assert_allclose(cal.slopes(F_x=x, F_z=z)[0], np.stack([by_x[0], by_z[0]], -1), rtol=2e-4)


def test_outside_is_said() -> None:
    """Beyond the table, far beyond, and not a number: no force."""
    cal = calibration(table())
    asked = np.array([pair(0.2, 4.4), pair(0.2, 40.0), [np.inf, 2e-6], pair(0.2, -0.01)])
    found = cal.inverse(asked)
    assert found.status.tolist() == ["outside", "outside", "no solution", "ok"]
    assert np.all(np.isnan(found.forces[:3])) and found.forces[3, 1] == pytest.approx(-0.01, abs=1e-4)
    just = cal.inverse([pair(0.2, -0.0399), pair(0.2, -0.0401), pair(1.0199, 2.0), pair(1.0201, 2.0)])
    assert just.status.tolist() == ["ok", "outside"] * 2  # 0.02 of half the range, 2 N and 1 N, is let pass
    with pytest.raises(ValueError, match=r"must be of 2 coils \(C1, C2\); got shape \(3,\)"):
        cal.inverse([1.0, 2.0, 3.0])


def test_forces_by_name() -> None:
    """A table, names or a wrench; what is missing, unknown or beyond the table is refused in a line."""
    cal = calibration(table())
    np.testing.assert_array_equal(cal.forward([0.2, 1.0]), cal.forward(F_z=1.0, F_x=0.2))
    np.testing.assert_array_equal(cal.forward([0.2, 1.0]), cal.forward(Wrench(F_x=0.2, F_z=1.0)))
    assert cal.forward(F_x=[0.1, 0.2], F_z=1.0).shape == (2, 2) and np.all(np.isfinite(cal.forward(F_x=0.0, F_z=-0.03)))
    for asked, words in (
        ({}, "forces: must be F_x, F_z; got none"),
        ({"F_x": 1.0}, "forces: must be F_x, F_z; got F_x"),
        ({"F_x": 0.5, "F_z": 1.0, "F_y": 5.0}, "forces: must be F_x, F_z; got F_x, F_z, F_y"),
        ({"F_x": 0.0, "F_z": 500.0}, "F_z: must lie from 0 to 4 N, as the table does; got 500 N"),
    ):
        with pytest.raises(ValueError, match=re.escape(words)):
            cal.forward(**asked)
    with pytest.raises(ValueError, match="got F_x, F_z, F_y"):
        cal.slopes(Wrench(F_x=0.5, F_y=1.0))
    with pytest.raises(ValueError, match="a table whose last axis holds F_x, F_z"):
        cal.forward(1.0)
    assert np.all(np.isfinite(cal.forward(F_x=0.0, F_z=5.0, beyond=True)))
    assert np.all(np.isfinite(cal.slopes(F_x=0.0, F_z=5.0, beyond=True)))


def folded(F_x: np.ndarray, F_z: np.ndarray) -> np.ndarray:
    """The sum has its least value at F_z = 3: loads below and above it show the same reading."""
    common, odd = 2e-6 + 1e-8 * (F_z - 3.0) ** 2, 2e-8 * F_x
    return np.stack([common + odd, common - odd], -1)


def test_a_fold_is_named_and_refused() -> None:
    """A parabola turns at F_z = 3: readings of 2..4 N have two answers, those below 2 N one."""
    cal = calibration(table(folded))
    assert any("F_z 3" in region and "sensitivity" in region for region in cal.domain.regions)
    assert 0.7 < cal.domain.share < 0.76
    found = cal.inverse(folded(np.array([0.1, 0.1, 0.1, -0.9]), np.array([1.0, 2.5, 3.5, 1.9])))
    assert found.status.tolist() == ["ok", "ambiguous", "ambiguous", "ok"]
    np.testing.assert_allclose(found.forces[[0, 3]], [[0.1, 1.0], [-0.9, 1.9]], atol=1e-9)
    assert cal.inverse(folded(0.1, 3.0005)).status == "ambiguous"  # on the fold itself, where both answers meet
    assert np.all(np.isnan(found.forces[1:3]))


def wound(F_x: np.ndarray, F_z: np.ndarray) -> np.ndarray:
    """A spiral ribbon of more than one turn: the determinant keeps its sign, the ends lie on each other."""
    angle, radius = 1.7 * np.pi * F_z / 4.0 * 1.3, 2.0 + 0.5 * F_x
    return 2e-6 + 1e-8 * np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1)


def test_an_edge_that_crosses_itself_is_seen() -> None:
    """One sign is not enough: distant loads that show the same reading are refused, others answered."""
    cal = calibration(table(wound, F_z=np.linspace(0.0, 4.0, 17)))
    assert any("crosses itself" in region for region in cal.domain.regions)
    found = cal.inverse(wound(np.array([0.1, 0.1, 0.1]), np.array([0.1, 2.0, 3.8])))
    assert found.status.tolist() == ["ambiguous", "ok", "ambiguous"]


def test_three_coils_by_least_squares() -> None:
    """Noise is shared out by its size, the residual tells a coil that is off, and one that is broken is refused."""

    def three(F_x: np.ndarray, F_z: np.ndarray) -> np.ndarray:
        return np.concatenate([pair(F_x, F_z), 1.5e-6 * np.exp(-0.03 * F_z)[..., None]], -1)

    cal = calibration(table(three), noise=[1e-11, 1e-11, 1e-10])
    F = loads(cal, 200)
    exact = cal.inverse(three(*F.T))
    assert np.all(exact.status == "ok") and np.max(np.abs(exact.forces - F)) < 4e-4
    off = three(*F.T) + [0.0, 0.0, 1e-9]
    plain = calibration(table(three)).inverse(off)
    assert np.median(np.abs(cal.inverse(off).forces - F)) < 0.05 * np.median(np.abs(plain.forces - F))
    assert np.all(cal.inverse(off).residual > 1e-3)
    broken = cal.inverse(three(*F.T) + [0.0, 0.0, 2e-7])
    assert not np.any(broken.status == "ok")


def test_one_coil_and_one_force() -> None:
    """A single force along a single coil; a single coil cannot tell two."""
    single = table(lambda x, z: pair(0.0 * x, z)[..., :1], F_x=np.array([0.0]))
    cal = calibration(single)
    assert cal.forces == ("F_z",)
    assert cal.inverse(cal.forward([2.2])).forces[0] == pytest.approx(2.2, abs=1e-9)
    both = calibration(table(lambda x, z: pair(x, z)[..., :1]))
    with pytest.raises(ValueError, match="1 cannot resolve 2 forces"):
        both.inverse([[2e-6]])


def test_failed_loads_bound_the_domain() -> None:
    """A corner that did not converge is outside, not extrapolated."""
    data = table()
    for i, j in ((8, 8), (8, 7), (7, 8)):
        data["status"][i, j] = "failed"
        data["L"][i, j] = np.nan
    cal = calibration(data)
    assert cal.inverse(pair(0.95, 3.9)).status.item() == "outside"
    assert cal.inverse(pair(0.5, 3.4)).status.item() == "ok"


def test_relative_change_of_an_absolute_inductance() -> None:
    """A table per metre of depth and a free-space inductance in henry give henry."""
    data = table()
    data["L"], data["L0"], data.attrs["unit_L"] = 200.0 * data["L"], 200.0 * data["L0"], "H/m"
    assert calibration(data).unit == "H/m"
    cal = calibration(data, [4.2e-6, 4.2e-6])
    assert cal.unit == "H"
    np.testing.assert_allclose(cal.forward([0.0, 0.0]), 2.0 * pair(0.0, 0.0), rtol=1e-6)


def test_a_table_without_forces_is_refused() -> None:
    """One load; scattered loads are taken by another function."""
    with pytest.raises(ValueError, match="at least two values of a force; got one load"):
        calibration(table(F_x=np.array([0.0]), F_z=np.array([1.0])))
    F = np.random.default_rng(1).uniform([-1.0, 0.0], [1.0, 4.0], (60, 2))
    free = ("H", [2e-6, 2e-6])
    cal = calibration_of(F, pair(*F.T), forces=("F_x", "F_z"), coils=("a", "b"), free=free)
    assert cal.inverse(pair(0.1, 2.0)).forces == pytest.approx([0.1, 2.0], abs=1e-3)
    with pytest.raises(ValueError, match="coil b does not"):
        calibration_of(F, pair(*F.T) * [1, 0], forces=("F_x", "F_z"), coils=("a", "b"), free=free)


def test_a_force_without_a_sign_is_named_and_refused() -> None:
    """Two coils on x see how far the target goes along y, not to which side; from none on they tell it."""
    line = np.linspace(-1.0, 1.0, 9)

    def read(low: float) -> Calibration:
        """Return the calibration over F_x and F_y from `low` to 1."""
        F = np.stack(np.meshgrid(line, np.linspace(low, 1.0, 9), indexing="ij"), -1).reshape(-1, 2)
        L = pair(F[:, 0], np.zeros(len(F))) * (1.0 + 0.01 * F[:, 1:] ** 2)
        return calibration_of(F, L, forces=("F_x", "F_y"), coils=("a", "b"), free=("H", [2e-6, 2e-6]))

    assert read(-1.0).unresolved == ("F_y",)
    with pytest.raises(ValueError, match="a, b do not resolve F_y of F_x, F_y: condition number"):
        read(-1.0).inverse([1.9e-6, 1.9e-6])
    assert read(0.0).unresolved == () and read(0.0).domain.share > 0.9


@pytest.mark.parametrize("given", ["0.1 N", 0.1j, [0.1, "a"], [[0.1], [0.1, 0.2]]])
def test_what_is_no_real_number_is_named(given: object) -> None:
    F = np.linspace(0.0, 1.0, 9)[:, None]
    known = calibration_of(F, 1e-6 + 1e-8 * F, forces=("F_z",), coils=("a",), free=("H", [1e-6]))
    with pytest.raises(SceneError, match="^F_z: must be real numbers; got "):
        known.forward(F_z=given)
    with pytest.raises(SceneError, match="^L: must be real numbers; got "):
        known.inverse(given)
