"""Errors of a table between its loads, and beside failed ones."""

import numpy as np
import pytest
import xarray as xr

from sits_mech.readout.table_errors import table_errors

F_X, F_Z = np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 4.0, 5)
AT = np.array([[0.3, 1.0], [-0.5, 3.0]])


def test_between_loads_and_where_some_failed() -> None:
    """Parts are linear between the loads, those of the nearest load where one failed, those of the edge beyond."""
    size = 1e-12 * (1.0 + F_X[:, None, None] + 2.0 * F_Z[None, :, None] * np.ones(2))
    names = ("F_x", "F_z", "coil")
    data = xr.Dataset({"error_L": (names, 3.0 * size), "shared_L": (("part", *names), size[None])},
                      {"F_x": F_X, "F_z": F_Z, "coil": ["C1", "C2"]})
    shared, own = table_errors(data, ("F_x", "F_z")).at(np.array([[0.3, 1.7], [1.01, -0.01]]))
    np.testing.assert_allclose(shared[0], 1e-12 * np.array([[4.7, 4.7], [2.0, 2.0]]))
    np.testing.assert_allclose(own, 2.0 * shared[0])
    failed = data.where((data["F_x"] != 1.0) | (data["F_z"] != 4.0))
    shared, _ = table_errors(failed, ("F_x", "F_z")).at(np.array([[1.0, 4.0]]))
    assert shared[0, 0, 0] == pytest.approx(9.5e-12) or shared[0, 0, 0] == pytest.approx(8e-12)
    backwards = table_errors(data.isel(F_z=slice(None, None, -1)), ("F_x", "F_z"))
    np.testing.assert_allclose(backwards.at(AT)[0], table_errors(data, ("F_x", "F_z")).at(AT)[0])


def test_at_most_has_signs() -> None:
    """A part that moves both coils alike cancels in their difference; what is a coil's own adds up."""
    names = ("F_x", "coil")
    parts = {"error_L": (names, np.full((2, 2), 3e-12)), "shared_L": (("part", *names), np.full((1, 2, 2), 2e-12))}
    data = xr.Dataset(parts, {"F_x": [0.0, 1.0], "coil": ["C1", "C2"]})
    errors, at = table_errors(data, ("F_x",)), np.array([[0.5]])
    for other, total in ((-1.0, 2e-12), (1.0, 6e-12)):
        assert errors.at_most(np.array([[[1.0, other]]]), at) == pytest.approx(total)
