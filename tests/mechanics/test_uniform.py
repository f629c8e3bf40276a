"""Layers without edges: closed forms of neo-Hooke, layers in series, where a law ends, films beside a section."""

import math

import numpy as np
import pytest

from sits_mech.mechanics.closed_form import edges_share
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import SmallStrain, linear_layer
from sits_mech.mechanics.models import strain_bound
from sits_mech.mechanics.uniform import bonded_area, uniform_layer, uniform_strain
from sits_mech.quantities import Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.material import silicone_from

MU, K = 20e3, 20e6  # [Pa]
SOFT = silicone_from({"law": "neo-hookean", "shear_modulus": MU, "bulk_modulus": K})


@pytest.mark.parametrize("stress", [(0.0, -5e4), (1e3, 0.0), (3e4, -2e5), (-5e4, 1e5)])
def test_stresses_of_neo_hooke(stress: tuple[float, float]) -> None:
    """w = mu/2 (J^(-2/3) (2 + g^2 + l^2) - 3) + K/2 (l - 1)^2, J = l, by hand."""
    strain = uniform_strain(SOFT, np.array(stress))
    assert strain is not None
    g, l = strain[0], 1.0 + strain[1]  # noqa: E741
    along, down = MU * l ** (-2 / 3) * g, MU * l ** (-2 / 3) * (l - (2.0 + g**2 + l**2) / (3.0 * l)) + K * (l - 1.0)
    assert (along, down) == pytest.approx(stress, abs=1e-4)


def test_shear_lifts_the_target() -> None:
    """By mu g^2/3 over K + 4/3 mu, to second order; the mirror image alike."""
    for F_x in (1.0, -1.0):
        strain = uniform_strain(SOFT, np.array([0.1 * MU * F_x, 0.0]))
        assert strain is not None and strain[0] == pytest.approx(0.1 * F_x, rel=1e-3)
        assert strain[1] == pytest.approx(MU * 0.01 / 3.0 / (K + 4.0 / 3.0 * MU), rel=1e-2)


def test_a_law_that_softens_holds_no_more_than_its_largest_stress() -> None:
    """Of Yeoh's law 2 g (c10 + 2 c20 g^2) is largest at g^2 = -c10/(6 c20), 13.6 kPa."""
    c10, c20 = 10e3, -1e3
    law = silicone_from({"law": "yeoh", "c10": c10, "c20": c20, "c30": 0.0, "bulk_modulus": 1e3 * K})
    g = math.sqrt(-c10 / (6.0 * c20))
    most = 2.0 * g * (c10 + 2.0 * c20 * g**2)
    there = uniform_strain(law, np.array([0.99 * most, 0.0]))
    assert there is not None and 0.8 * g < there[0] < g
    assert uniform_strain(law, np.array([1.01 * most, 0.0])) is None


def test_thick_pads_are_no_films() -> None:
    """From 30 thicknesses on, unless the silicone is swollen."""
    for keys, film in (([], False), (["elastomer.thickness=2.6e-4"], True), (["elastomer.thickness=2.7e-4"], False),
                       (["elastomer.thickness=1e-4", "elastomer.free_stretch=1.01"], False)):
        found = uniform_layer(load_sensor("biorob2018", [*keys, "elastomer.standoff=0"]), Wrench(0.1, 1.0))
        assert (found is not None) == film


def test_layers_add_up() -> None:
    """Halves of one silicone move as one; a layer of twice the modulus by half as much in shear."""
    law = f'elastomer.material={{law="neo-hookean", shear_modulus={MU}, bulk_modulus={K}}}'
    one = load_sensor("biorob2018", [law, "elastomer.thickness=1e-4", "elastomer.standoff=0"])
    assert one.elastomer is not None
    load, half = Wrench(0.5, 1.0), 0.5 * one.elastomer.thickness

    def stacked(*moduli: float) -> np.ndarray:
        layers = [{"material": silicone_from({"law": "neo-hookean", "shear_modulus": mu, "bulk_modulus": K}),
                   "thickness": half} for mu in moduli]
        pad = type(one.elastomer).model_validate({"width": 0.02, "length": 0.02, "layers": layers})
        found = uniform_layer(one.model_copy(update={"elastomer": pad}), load)
        assert found is not None and len(found.each) == 2
        return found.moved

    single = uniform_layer(one, load)
    assert single is not None
    np.testing.assert_allclose(stacked(MU, MU), single.moved, rtol=1e-12)
    np.testing.assert_allclose(stacked(MU, 2.0 * MU)[0], 0.75 * single.moved[0], rtol=1e-3)


@pytest.mark.parametrize(
    ("target", "pad", "area"),
    [
        ('shape="rectangle", width=6e-3, length=8e-3', "width=7e-3, length=7e-3", 42e-6),
        ('shape="disc", diameter=6e-3', "diameter=7e-3", 9e-6 * math.pi),
        ('shape="disc", diameter=6e-3', "width=6e-3, length=7e-3", 9e-6 * math.pi),
        ('shape="rectangle", width=6e-3, length=8e-3', "diameter=10e-3", 48e-6),
        ('shape="rectangle", width=6e-3, length=8e-3', "diameter=9.9e-3", None),
    ],
)
def test_areas_that_are_bonded(target: str, pad: str, area: float | None) -> None:
    """Of the outline that lies within the other."""
    sensor = load_sensor("biorob2018", [
        f'target={{material="copper", thickness=2e-4, {target}}}',
        f'elastomer={{material="ecoflex-00-30", thickness=1e-4, {pad}}}',
    ])
    assert sensor.target is not None and sensor.elastomer is not None
    assert bonded_area(sensor.target, sensor.elastomer) == pytest.approx(area)
    assert edges_share(sensor.target, sensor.elastomer) in (0.6, 1.0)


def film(wider: float) -> tuple[list[str], float, float]:
    """Keys of a long film 40 thicknesses wide on a pad so many times as wide, of `ecoflex-00-30`; area, modulus."""
    width, length = 0.04, 0.8 * wider
    keys = [f"target.width={width}", f"elastomer.width={width * wider}", f"target.length={length}",
            f"elastomer.length={length}", "elastomer.thickness=1e-3", "target.load_height=0",
            'elastomer.contact="never"']
    sensor = load_sensor("biorob2018", keys)
    assert sensor.elastomer is not None
    return keys, width * length, sensor.elastomer.silicone.shear_modulus


@pytest.mark.parametrize(
    ("wider", "shear"),
    [(1.0, 0.6), pytest.param(1.0, 1.0, marks=pytest.mark.slow), pytest.param(2.0, 0.6, marks=pytest.mark.slow)],
)
def test_films_shear_as_their_section_says(wider: float, shear: float) -> None:
    """Within the error, which is the bound's at most; one compliance would be off by as much as the law stiffens."""
    keys, area, mu = film(wider)
    sensor, load = load_sensor("biorob2018", keys), Wrench(shear * mu * area, 0.5 * shear * mu * area)
    full, small = planar_layer(sensor, 1e-3).equilibrium(load), linear_layer(sensor, 1e-3)
    found, tiny = small.equilibrium(load), small.equilibrium(Wrench(1e-4 * load.F_x, 1e-4 * load.F_z))
    assert abs(found.pose.d_h - full.pose.d_h) < found.error.d_h < strain_bound(sensor, [load]) * found.pose.d_h
    assert abs(found.pose.d_v - full.pose.d_v) < found.error.d_v
    assert abs(1e4 * tiny.pose.d_h - full.pose.d_h) > 3.0 * abs(found.pose.d_h - full.pose.d_h)
    assert tiny.report.stretch is None
    assert found.report.stretch is not None and found.report.error_stretch is not None
    assert 0.0 < full.report.stretch - found.report.stretch < found.report.error_stretch


def test_derivatives_of_films() -> None:
    """By load and thickness, beside differences of poses."""
    keys, area, mu = film(1.0)
    load = Wrench(0.8 * mu * area, 2.0 * mu * area)

    def model_of(thickness: float) -> SmallStrain:
        return linear_layer(load_sensor("biorob2018", [*keys, f"elastomer.thickness={thickness}"]), 0.1)

    def pose(model: SmallStrain, F_x: float = 0.0, F_z: float = 0.0) -> np.ndarray:
        return np.array(model.equilibrium(Wrench(load.F_x + F_x, load.F_z + F_z)).pose.components[:2])

    own, h, t = model_of(1e-3), 1e-3 * load.F_x, 1e-6
    slopes = own.slopes(own.equilibrium(load), [parameter(own.sensor, "elastomer.thickness")])
    for column, name in enumerate(("F_x", "F_z")):
        by_load = (pose(own, **{name: h}) - pose(own, **{name: -h})) / (2.0 * h)
        np.testing.assert_allclose(slopes.compliance[:2, column], by_load, rtol=1e-4)
    by_thickness = (pose(model_of(1e-3 + t)) - pose(model_of(1e-3 - t))) / (2.0 * t)
    np.testing.assert_allclose(slopes.pose[:2, 0], by_thickness, rtol=1e-3)
