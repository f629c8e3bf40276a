"""What models refuse by name: loads that are no numbers, components that leave the plane."""

import math

import numpy as np
import pytest

from sits_mech.quantities import Pose, Wrench, refuse_infinite, refuse_out_of_plane


def test_a_plane_model_refuses_what_leaves_the_plane() -> None:
    """Of one pose, or of any of many; zeros are in the plane."""
    many = Pose(0.0, 1e-3, d_y=np.array([0.0, 1e-6]))
    refuse_out_of_plane("planar", Pose(1e-3, 1e-3, 0.1), "sheets")
    with pytest.raises(ValueError, match="pose: d_y must be zero for the model planar, which is plane: ask for sheets"):
        refuse_out_of_plane("planar", many, "sheets")


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_loads_are_finite(value: float) -> None:
    """The largest double is a load; what is none is refused."""
    refuse_infinite(Wrench(F_z=1e308))
    with pytest.raises(ValueError, match="wrench: must be finite numbers"):
        refuse_infinite(Wrench(F_z=value))
