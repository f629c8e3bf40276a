"""Derivatives over a grid of loads: those of single loads, at loads solved and between; loads that fail."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.derivatives.gradient import gradient
from sits_mech.chain.derivatives.gradient_grid import WithSlopes, gradient_on_grid, slopes_under
from sits_mech.chain.interpolate import LayerGrid
from sits_mech.chain.plans.aimed import aimed_loads
from sits_mech.magnetics.slopes import slopes
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import POSE, Pose, Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, load_sensor

NAMES = ("elastomer.thickness", "modulus", "coils.*.inner_diameter", "coils.*.centre.0")
PLANE = {"mechanics": "planar", "magnetics": "planar", "tolerance": 1e-2}
LEVER = np.array([1.0, 1.0, 7e-3, 1.0, 7e-3, 7e-3])[:, None]


def test_a_load_solved_again_on_finer_meshes_has_no_derivatives_of_its_own() -> None:
    """Those of the first meshes are kept: only from elsewhere, or from rest, do slopes come with the equilibrium."""
    layer = linear_layer(load_sensor("biorob2018-w15", ["target.length=0.2", "elastomer.length=0.2"]), 0.1)
    sloped, load = WithSlopes(layer, (parameter(layer.sensor, "modulus"),)), Wrench(F_z=0.1)
    rest = sloped.equilibrium(load)
    assert np.shape(rest.slopes) == (1, len(POSE)) and np.any(rest.slopes)
    assert np.size(sloped.equilibrium(load, start=rest).slopes) == 0
    np.testing.assert_array_equal(sloped.equilibrium(load, start=replace(rest, wrench=Wrench())).slopes, rest.slopes)


@pytest.mark.slow
def test_loads_of_a_grid_have_the_derivatives_that_they_have_alone() -> None:
    """On two meshes instead of three: to 3e-3 of the largest, images and loads between the solved ones as well."""
    sensor = load_sensor("biorob2018-w15", ['elastomer.standoff="0.1 mm"', 'target.width="14 mm"'])
    loads = {"F_x": np.linspace(-0.5, 0.5, 7), "F_z": np.linspace(0.0, 3.0, 7)}
    found = gradient_on_grid(sensor, NAMES, loads, **PLANE)
    assert found.by_L.dims == ("F_x", "F_z", "coil", "coil_2", "parameter")
    assert found.by_pose.sizes["component"] == len(POSE)
    assert np.all(found.status == "ok")
    poses, signals = (np.abs(found[name].values).max(axis=(0, 1)) for name in ("by_pose", "by_dL_v"))
    for F_x, F_z in ((0.5, 3.0), (-0.5, 1.5), (1.0 / 6.0, 2.5), (-1.0 / 3.0, 0.5)):
        own = gradient(sensor, Wrench(F_x=F_x, F_z=F_z), NAMES, **PLANE)
        here = found.sel(F_x=F_x, F_z=F_z, method="nearest")
        off = np.abs(here.by_pose.values - own.pose)[:, :2] * LEVER
        assert np.all(np.max(off, axis=0) < 3e-3 * np.max(poses[:, :2] * LEVER, axis=0))
        assert np.all(np.abs(here.by_dL_v.values - own.signals["dL_v"]) < 3e-3 * signals)


@pytest.mark.slow
def test_coils_aside_are_the_target_moved_back_at_every_load() -> None:
    """All of them by a star: minus the derivative by d_h, at the poses of the table, L and R of all loads at once."""
    sensor = load_sensor("biorob2018-w15")
    loads = {"F_x": [-0.3, 0.0, 0.3], "F_z": [0.5, 1.0]}
    found = gradient_on_grid(sensor, ["coils.*.centre.0"], loads, **PLANE)
    pose = Pose.of(found.pose.transpose(*loads, "component").values)
    layer, mirrors = planar_layer(sensor, 1e-2), symmetry_of(sensor)
    field = aimed_loads(LayerGrid(sensor, layer, loads, mirrors, 1e-2), "planar").field
    by_pose = slopes(sensor, field, pose, sensor.frequency, components=["d_h"])
    for own, expected in ((found.by_L, by_pose.L), (found.by_R, by_pose.R)):
        np.testing.assert_allclose(own.values, -expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())
    assert np.all(found.by_pose.values == 0.0)
    assert np.all(np.abs(found.by_L.values).max(axis=(2, 3, 4)) > 0.0)


@pytest.mark.slow
def test_a_load_that_is_not_carried_leaves_a_gap() -> None:
    """Said by its status; the others have their numbers."""
    soft = 'elastomer.material={law="neo-hookean", shear_modulus=3e3, bulk_modulus=3e6}'
    sensor = load_sensor("biorob2018-w15", [soft])
    found = gradient_on_grid(sensor, ["modulus"], {"F_z": [0.5, 1e3]}, **PLANE)
    assert list(found.status.values == "ok") == [True, False]
    assert np.all(np.isfinite(found.by_L.values[0])) and np.all(np.isnan(found.by_L.values[1]))


@pytest.mark.slow
def test_errors_are_those_of_a_calibration() -> None:
    """L with all errors, their signed parts too, at the same loads by the same models."""
    sensor, loads = load_sensor("biorob2018-w15"), {"F_x": [-0.3, 0.0, 0.3], "F_z": [0.5, 1.0]}
    found, data = gradient_on_grid(sensor, ["modulus"], loads, **PLANE), calibrate(sensor, **loads, **PLANE)
    for name in ("L", "R", "error_L", "error_R", "shared_L", "alone_L"):
        own, expected = (each[name].transpose("F_x", "F_z", ...).values for each in (found, data))
        np.testing.assert_allclose(own, expected, rtol=1e-9, atol=1e-12 * np.abs(data.L.values).max(), err_msg=name)
    assert np.all(np.abs(np.diagonal(found.error_L.values, axis1=-2, axis2=-1)) > 0.0)


def test_what_is_no_load_is_refused() -> None:
    """By its name."""
    with pytest.raises(SceneError, match="loads: must be of F_x"):
        gradient_on_grid(load_sensor("biorob2018-w15"), ["modulus"], {"F_q": [1.0]}, **PLANE)


@pytest.mark.slow
def test_few_loads_on_finer_meshes_keep_their_derivatives() -> None:
    """Two loads, each solved as far as the signals take: slopes of the pose by the modulus go with the pose."""
    sensor = load_sensor("biorob2018-w15")
    found = gradient_on_grid(sensor, ["modulus"], {"F_z": [0.5, 1.0]}, **PLANE | {"tolerance": 3e-3})
    sunk = found.pose.sel(component="d_v").values - 2e-3
    np.testing.assert_allclose(found.by_pose.sel(component="d_v").values[:, 0], -sunk, rtol=0.1)


def test_loads_come_in_any_order() -> None:
    """A table holds what a single load has, whichever component is named first; dims are in the order of a wrench."""
    sensor = load_sensor("biorob2018")
    models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    found = gradient_on_grid(sensor, ["modulus"], {"F_z": [0.0, 1.0, 0.5], "F_x": [0.2, 0.1]}, **models)
    assert found["pose"].dims[:2] == ("F_x", "F_z")
    one = gradient(sensor, Wrench(0.1, 1.0), ["modulus"], **models)
    there = found.sel(F_x=0.1, F_z=1.0)
    np.testing.assert_allclose(there["pose"], one.simulation.equilibrium.pose.components, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(there["by_pose"], one.pose, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("loads", "message"), [
    ({"Q": [1.0]}, "loads: must be of F_x, F_z, M, F_y, M_x, M_z; got Q"),
    ({"F_z": []}, r"F_z must be one or more different finite forces \[N\]; got \[\]"),
    ({"F_z": [1.0, 1.0]}, "F_z must be one or more different finite forces"),
    ({"M": [np.nan]}, "M must be one or more different finite moments"),
])
def test_loads_that_are_none_are_refused(loads: dict[str, list[float]], message: str) -> None:
    """In one line, as of `calibrate`, with slopes alone too."""
    for asked in (gradient_on_grid, slopes_under):
        with pytest.raises(SceneError, match=message):
            asked(load_sensor("biorob2018"), ["modulus"], loads, mechanics="linear", tolerance=0.1)
