"""Derivatives of the chain: differences of its answers, symmetry, signals in closed form, refusals."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
import pytest

from sits_mech.chain.derivatives.gradient import Gradient, gradient, symmetry_kept
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.rests import aimed_rest
from sits_mech.chain.simulate import simulate
from sits_mech.magnetics.slopes import slopes
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

LOAD = Wrench(F_x=0.3, F_z=1.0)
PLANE = {"mechanics": "planar", "magnetics": "planar", "tolerance": 1e-2}
NAMES = (
    "elastomer.thickness", "elastomer.width", "modulus", "elastomer.material.c20", "elastomer.standoff", "frequency",
)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """Two coils under a plate, a film between."""
    return load_sensor("biorob2018-w15", ['elastomer.standoff="0.1 mm"', 'target.width="14 mm"'])


@pytest.fixture(scope="module")
def found(sensor: Sensor) -> Gradient:
    """Its derivatives in the plane."""
    return gradient(sensor, LOAD, NAMES, **PLANE)


@pytest.mark.parametrize(
    "name", [NAMES[0], *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES[1:])]
)
def test_derivatives_are_those_of_differences(sensor: Sensor, found: Gradient, name: str) -> None:
    """Pose, L and signals of answers made anew, over a step of 1e-3: to 1e-5; R to 1e-4."""
    number, k = parameter(sensor, name), NAMES.index(name)
    h = 1e-3 * number.value
    ways = (1, -1, 2, -2)
    each = {way: simulate(number.changed(way * h), LOAD, **PLANE) for way in ways}

    def slope(of) -> np.ndarray:
        return (8.0 * (of(each[1]) - of(each[-1])) - (of(each[2]) - of(each[-2]))) / (12.0 * h)

    for within, own, of in (
        (1e-5, found.L[..., k], lambda one: one.impedance.L),
        (1e-4, found.R[..., k], lambda one: one.impedance.R),
        (1e-5, found.signals["dL_v"][k], lambda one: np.asarray(one.signals.dL_v)),
        (1e-5, found.signals["L_h_percent"][k], lambda one: np.asarray(one.signals.L_h_percent)),
    ):
        expected = slope(of)
        np.testing.assert_allclose(own, expected, atol=within * np.max(np.abs(expected)), rtol=0.0)


def test_errors_are_a_small_part_of_derivatives(
    sensor: Sensor, found: Gradient, numerics_alone: Callable[[], AbstractContextManager[None]]
) -> None:
    """At a tolerance of 1e-2 in the pose: the numbers that count are known to percents, but for what is left out."""
    main = [NAMES.index(name) for name in ("elastomer.thickness", "modulus", "elastomer.standoff")]
    whole = found
    with numerics_alone():
        found = gradient(sensor, LOAD, NAMES, **PLANE)
    np.testing.assert_allclose(found.L, whole.L, rtol=1e-6, atol=1e-9 * np.abs(found.L).max())
    assert np.all(whole.errors["dL_v"][main] > 5.0 * found.errors["dL_v"][main])
    for value, error in ((found.L, found.error_L), (found.R, found.error_R)):
        assert np.all(error >= 0.0)
        assert np.max(error[..., main] / np.max(np.abs(value[..., main]), axis=(0, 1))) < 0.05
    assert np.all(found.errors["dL_v"][main] < 0.05 * np.abs(found.signals["dL_v"][main]))


def test_the_sum_signal_is_the_mean_of_the_coils(found: Gradient) -> None:
    """In percent of the mean L0, which no number of the layer changes."""
    L0 = np.diagonal(found.simulation.impedance.L0)
    mean = 100.0 * np.einsum("iik->k", found.L) / L0.sum()
    np.testing.assert_allclose(found.signals["dL_v"], mean, rtol=1e-6, atol=1e-6 * np.max(np.abs(mean)))


def test_the_other_shear_swaps_the_coils(sensor: Sensor, found: Gradient) -> None:
    """The mirror image of the load: d_h and alpha change their signs, L_1 and L_2 their places."""
    other = gradient(sensor, Wrench(F_x=-0.3, F_z=1.0), NAMES[:3], **PLANE)
    signs = np.array([-1.0, 1.0, -1.0])[:, None]
    np.testing.assert_allclose(other.pose[:3], signs * found.pose[:3, :3], rtol=1e-6, atol=1e-9)
    size = np.max(np.abs(found.L[..., :3]), axis=(0, 1))
    np.testing.assert_allclose(other.L[::-1, ::-1] / size, found.L[..., :3] / size, atol=1e-5)


def test_lengths_of_coils_change_what_signals_are_percents_of(sensor: Sensor) -> None:
    """Both coils grow alike: the sum by differences of the chain, L0 in it as well."""
    name = "coils.*.inner_diameter"
    own = gradient(sensor, LOAD, [name], **PLANE)
    number = parameter(sensor, name)
    h = 3e-3 * number.value
    one, other = (simulate(number.changed(way * h), LOAD, **PLANE) for way in (1, -1))
    expected = (one.signals.dL_v - other.signals.dL_v) / (2.0 * h)
    assert own.signals["dL_v"][0] == pytest.approx(expected, rel=2e-3)
    assert np.all(own.pose == 0.0)


def test_coils_aside_are_the_target_moved_back(sensor: Sensor) -> None:
    """All of them by a star: minus the derivative by d_h of the pose, which stays; the sum signal with it."""
    found = gradient(sensor, LOAD, ("coils.*.centre.0", "elastomer.thickness"), **PLANE)
    own = mechanical_model(sensor, "planar", loads=[LOAD])
    rest = aimed_rest(sensor, [LOAD], own, ("planar", 1e-2), symmetry_of(sensor))
    pose, field = found.simulation.equilibrium.pose, rest.field
    by_pose = slopes(sensor, field, pose, sensor.frequency, components=["d_h"])
    for own, expected in ((found.L, by_pose.L), (found.R, by_pose.R)):
        size = np.abs(expected).max()
        np.testing.assert_allclose(own[..., 0], -expected[..., 0], rtol=0.0, atol=1e-6 * size)
    assert np.all(found.pose[:, 0] == 0.0) and np.any(found.pose[:, 1] != 0.0)
    L0 = np.trace(found.simulation.impedance.L0)
    assert found.signals["dL_v"][0] == pytest.approx(-100.0 * np.trace(by_pose.L[..., 0]) / L0, rel=1e-6)


def test_numbers_keep_the_symmetry_that_their_scenes_share() -> None:
    """A square pad under a square target that grows in one direction alone is a rectangle; a disc stays one."""
    parts = (
        'target={shape="disc", diameter="8 mm", material="copper", thickness="0.2 mm"}',
        'elastomer={diameter="12 mm", material="ecoflex-00-30", thickness="2 mm"}',
    )
    square, disc = load_sensor("biorob2018"), load_sensor("biorob2018", parts)

    def kind(sensor: Sensor, *names: str) -> str:
        """Return the kind that is kept when some numbers change."""
        return symmetry_kept(sensor, [parameter(sensor, name) for name in names]).kind

    assert kind(square, "modulus", "elastomer.thickness") == "square" and kind(disc, "target.diameter") == "disc"
    assert kind(square, "modulus", "target.width") == "rectangle"


def test_a_load_along_y_on_a_square_has_the_derivatives_of_one_along_x() -> None:
    """Turned: half the pad is solved for both, and compliances by all components are known of the one along y."""
    sensor, asked = load_sensor("biorob2018"), {"mechanics": "block", "tolerance": 5e-2}
    x, y = (gradient(sensor, load, ["modulus"], sideways=True, **asked)
            for load in (Wrench(F_x=0.1, F_z=0.2), Wrench(F_y=0.1, F_z=0.2)))
    places, signs = [3, 1, 4, 0, 2, 5], np.array([1.0, 1.0, -1.0, 1.0, -1.0, -1.0])
    size = np.abs(x.pose).max()
    np.testing.assert_allclose(y.pose[:, 0], signs * x.pose[places, 0], rtol=0.0, atol=1e-9 * size)
    assert np.all(np.isfinite(y.compliance))


@pytest.mark.slow
def test_a_disc_on_its_axis_changes_with_the_gap_alone() -> None:
    """A press along the axis, by differences of the chain; coils moved aside change nothing, as symmetry has it."""
    coil = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (0.0, 0.0)})
    disc = ['target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}']
    sensor, load = load_sensor("biorob2018", disc).model_copy(update={"coils": (coil,)}), Wrench(F_z=0.05)
    names = ("elastomer.thickness", "target.thickness", "coils.*.centre.0", "modulus")
    found = gradient(sensor, load, names, mechanics="linear", magnetics="axisymmetric")
    for k in (0, 3):
        number = parameter(sensor, names[k])
        h = 1e-3 * number.value
        one, other = (
            simulate(number.changed(way * h), load, mechanics="linear", magnetics="axisymmetric") for way in (1, -1)
        )
        expected = (one.impedance.L - other.impedance.L) / (2.0 * h)
        assert found.L[0, 0, k] == pytest.approx(expected[0, 0], rel=1e-4)
    assert found.L[0, 0, 2] == found.R[0, 0, 2] == 0.0 and found.L[0, 0, 1] != 0.0


@pytest.mark.slow
@pytest.mark.parametrize("load", [Wrench(F_y=-0.2, F_z=1.0), Wrench(F_x=0.1, F_z=1.0, F_y=0.2)])
def test_loads_that_leave_the_plane_have_images_in_mirrors_alone(load: Wrench) -> None:
    """A round target on a square pad: by a width that makes it a rectangle, against differences."""
    scene = load_sensor("triaxial-4", ['elastomer.width="19 mm"', 'target.diameter="11 mm"'])
    found = gradient(scene, load, ["elastomer.width", "modulus"], tolerance=2e-2)
    for k, name in enumerate(found.names):
        number = parameter(scene, name)
        h = 1e-3 * number.value
        one, other = (simulate(number.changed(way * h), load, tolerance=2e-2) for way in (1, -1))
        expected = (one.impedance.L - other.impedance.L) / (2.0 * h)
        np.testing.assert_allclose(found.L[..., k], expected, atol=1e-3 * np.max(np.abs(expected)))
    assert np.all(np.isfinite(found.compliance))


@pytest.mark.parametrize(
    ("name", "words"),
    [("coils.C1.turns", "can go up and down"), ("target.conductivity", "target.conductivity has no derivative"),
     ("elastomer.hight", "elastomer.hight")],
)
def test_what_has_no_derivative_is_refused(sensor: Sensor, name: str, words: str) -> None:
    """By its name, in one line, before anything is solved."""
    with pytest.raises(SceneError, match=words) as error:
        gradient(sensor, LOAD, [name], **PLANE)
    assert "\n" not in str(error.value)


def test_a_model_without_derivatives_is_refused(sensor: Sensor) -> None:
    """The closed form."""
    flush = load_sensor("biorob2018", ['target.width="20 mm"', 'target.length="20 mm"'])
    with pytest.raises(SceneError, match="mechanics: must be block, planar, axisymmetric or linear"):
        gradient(flush, Wrench(F_z=0.1), ["modulus"], mechanics="closed-form", magnetics="planar")
