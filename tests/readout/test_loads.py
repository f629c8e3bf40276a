"""Which loads a table holds: those that vary, those that do not."""

import numpy as np
import xarray as xr

from sits_mech.quantities import Wrench
from sits_mech.readout.loads import at_middle, ends_of, fixed, points, several, varied, wrench_of


def made(**loads: object) -> xr.Dataset:
    """A table over the loads that are lists, the others as scalars; L_v tells each load by its number."""
    dims = [name for name, values in loads.items() if isinstance(values, list)]
    shape = [len(loads[name]) for name in dims]
    number = np.arange(np.prod(shape), dtype=float).reshape(shape)
    status = np.full(shape, "ok", dtype=object)
    data = xr.Dataset({"L_v": (dims, number), "status": (dims, status)}, coords=loads)
    return data.assign(L0=(("coil", "coil_2"), np.eye(2)))


def test_what_varies_and_what_does_not() -> None:
    """In the order of a wrench; each point knows its whole load."""
    data = made(F_x=[-1.0, 1.0], F_z=2.0, F_y=[0.0, 0.5, 1.0], M_z=1e-3)
    assert several(made(F_x=[0.5], F_y=[0.0, 1.0])) == ("F_y",)
    assert varied(data) == ("F_x", "F_y") and fixed(data) == {"F_z": 2.0, "M_z": 1e-3}
    assert wrench_of(list(points(data))[4]) == Wrench(1.0, 2.0, F_y=0.5, M_z=1e-3)


def test_ends_of_loads_and_of_what_is_shown() -> None:
    data = made(F_x=[-1.0, 0.5], F_z=[0.0, 2.0, 3.0])
    assert ends_of(data, ("F_x", "L_v")) == {"F_x": (-1.0, 0.5), "L_v": (0.0, 5.0)}


def test_the_middle_of_the_others() -> None:
    """A slice over what is kept, and where it is, in words."""
    data, words = at_middle(made(F_x=[-1.0, 0.0, 1.0], F_z=[0.0, 2.0], M=[-1.0, 0.5, 1.0]), ["F_x", "F_z"])
    assert data["L_v"].dims == ("F_x", "F_z") and words == "M = 0.5 N m"
    np.testing.assert_array_equal(data["L_v"], [[1.0, 4.0], [7.0, 10.0], [13.0, 16.0]])
