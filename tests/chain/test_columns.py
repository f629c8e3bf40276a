"""Columns of a table: over all loads, NaN or nothing where a load has no rest or no reading."""

import numpy as np

from sits_mech.chain.columns import over_grid


def test_columns_lie_on_the_grid_where_their_loads_are():
    axes = {"F_x": [0.0, 1.0], "F_z": [0.0, 1.0, 2.0]}
    known = [True, False, True, True, False, True]
    found = over_grid(axes, known, {"d_h": ((), [1.0, 2.0, 3.0, 4.0]), "notes": ((), ["a", "b", "c", "d"]),
                                 "L": (("coil",), np.arange(8.0).reshape(4, 2))})
    assert found["d_h"][0] == ("F_x", "F_z") and found["L"][0] == ("F_x", "F_z", "coil")
    np.testing.assert_array_equal(found["d_h"][1], [[1.0, np.nan, 2.0], [3.0, np.nan, 4.0]])
    assert found["notes"][1].tolist() == [["a", "", "b"], ["c", "", "d"]]
    assert found["L"][1].shape == (2, 3, 2) and np.isnan(found["L"][1][0, 1]).all()
    assert found["L"][1][1, 2].tolist() == [6.0, 7.0]


def test_a_table_without_any_reading_keeps_its_shape():
    values = over_grid({"F_z": [0.0, 1.0]}, [False, False], {"L": (("coil",), np.zeros((0, 4)))})["L"][1]
    assert values.shape == (2, 4) and np.isnan(values).all()
