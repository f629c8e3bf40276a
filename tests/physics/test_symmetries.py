"""What physics says of any sensor: mirrors, turns, scalings, reciprocity, passivity, objectivity, batches.

Scenes, loads and poses are drawn; nothing here knows a number of its own.
"""

from dataclasses import astuple
from functools import cache

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.quantities import Pose, Wrench
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
FEW = settings(max_examples=4, phases=[Phase.explicit, Phase.generate])  # each solves a pad or prepares a plate
forces = st.floats(-0.05, 0.05).filter(lambda force: abs(force) > 1e-3)  # [N]


@st.composite
def pads(draw):
    """Sizes [m] and a shear modulus [Pa] of a square target on a square layer."""
    thickness, width = draw(st.floats(1.0, 3.0)) * MM, draw(st.floats(6.0, 10.0)) * MM
    return thickness, width, width + draw(st.floats(4.0, 8.0)) * MM, draw(st.floats(2e4, 2e5))


@st.composite
def poses(draw, count=1):
    """Poses of six components, clear of the coils, shape (count, 6)."""
    spans = np.array([0.5 * MM, 0.4 * MM, 0.03, 0.5 * MM, 0.03, 0.2])
    return [0.0, 1.5 * MM, 0.0, 0.0, 0.0, 0.0] + spans * draw(
        st.lists(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), min_size=count, max_size=count).map(np.array)
    )


def pad(thickness, width, layer, shear_modulus, plate=0.2 * MM):
    """The section of a pad under a plate of some thickness, on whose top forces act."""
    material = f'{{law="neo-hookean", shear_modulus={shear_modulus!r}, bulk_modulus={500.0 * shear_modulus!r}}}'
    return mechanical_model(load_sensor("biorob2018", [
        f"elastomer={{material={material}, width={layer!r}, length={layer!r}, thickness={thickness!r}}}",
        f'target={{material="copper", shape="rectangle", width={width!r}, length={width!r}, thickness={plate!r}}}',
        f"target.load_height={plate!r}",
    ]), "planar", 3e-2)[0]


def motion(model, thickness, **forces):
    """How a load moves the target: d_h, sink, alpha, d_y, alpha_x, alpha_z [m, rad]."""
    found = np.array(astuple(model.equilibrium(Wrench(**forces)).pose))
    found[1] = thickness - found[1]
    return found


@cache
def plate(turned=False):
    """The published sensor in space, or the same turned about z by a quarter."""
    sensor = load_sensor("biorob2018", ['target.length="6 mm"'])
    if turned:
        coils = [coil.model_copy(update={"centre": (-coil.centre[1], coil.centre[0])}) for coil in sensor.coils]
        target = sensor.target.model_copy(update={"width": sensor.target.length, "length": sensor.target.width})
        sensor = sensor.model_copy(update={"coils": tuple(coils), "target": target, "elastomer": None})
    return magnetic_model(sensor, "sheets", 0.1)[0]


@FEW
@given(pads(), forces, forces.map(abs))
def test_a_pad_is_its_mirror_image(sizes, F_x, F_z):
    """The other way the motion is the other way."""
    model = pad(*sizes)
    one, other = (motion(model, sizes[0], F_x=each, F_z=F_z) for each in (F_x, -F_x))
    np.testing.assert_allclose(other, one * [-1, 1, -1, 1, 1, 1], rtol=1e-7, atol=1e-12)


@FEW
@given(pads(), forces, forces.map(abs), st.floats(0.3, 3.0), st.floats(0.3, 3.0))
def test_a_pad_of_another_size_and_stiffness_is_the_same_pad(sizes, F_x, F_z, length, stiffness):
    """Lengths by s, moduli by m, forces by m s^2: displacements by s, the same rotation."""
    *lengths, modulus = sizes
    model, scaled = pad(*sizes), pad(*(length * size for size in lengths), stiffness * modulus, 0.2 * MM * length)
    force = stiffness * length**2
    one = motion(model, sizes[0], F_x=F_x, F_z=F_z)
    other = motion(scaled, length * sizes[0], F_x=force * F_x, F_z=force * F_z)
    np.testing.assert_allclose(other, one * [length, length, 1.0, length, 1.0, 1.0], rtol=1e-5, atol=1e-12)


@FEW
@given(pads(), st.floats(1e-4, 1e-3))
def test_work_of_one_load_along_another_is_mutual(sizes, small):
    """Betti: F_x, at its height above the target's underside, along what M moves is M along what F_x moves."""
    model, M = pad(*sizes), small * MM
    by_force, by_moment = motion(model, sizes[0], F_x=small), motion(model, sizes[0], M=M)
    np.testing.assert_allclose(small * (by_moment[0] + 0.2 * MM * by_moment[2]), M * by_force[2], rtol=1e-3)


@FEW
@given(poses(3))
def test_inductances_are_mutual_passive_and_the_same_in_a_batch(rows):
    """L and R are symmetric, metal takes power and adds none, a pose has the answer that it has alone."""
    found = plate().impedance(Pose.of(rows), 5e6)
    for values in (found.L, found.R):
        np.testing.assert_allclose(values, np.swapaxes(values, -1, -2), rtol=1e-9)
    assert (np.linalg.eigvalsh(found.R) > 0.0).all()
    assert (np.linalg.eigvalsh(found.L0 - found.L) > 0.0).all()  # L0 - L of copper stores less
    alone = plate().impedance(Pose.of(rows[1:2]), 5e6)
    np.testing.assert_array_equal(alone.L[0], found.L[1])
    np.testing.assert_array_equal(alone.R[0], found.R[1])


@FEW
@given(poses())
def test_turned_and_mirrored_sensors_show_the_same(rows):
    """The whole by a quarter about z; mirrored in x = 0, its coils change places."""
    (d_h, d_v, alpha, d_y, alpha_x, alpha_z), one = rows[0], plate().impedance(Pose.of(rows), 5e6)
    mirrored = plate().impedance(Pose.of(np.array([[-d_h, d_v, -alpha, d_y, alpha_x, -alpha_z]])), 5e6)
    np.testing.assert_allclose(mirrored.L[0], one.L[0][::-1, ::-1], rtol=1e-8)
    flat = Pose.of(np.array([[d_h, d_v, 0.0, d_y, 0.0, alpha_z]]))
    turned = Pose.of(np.array([[-d_y, d_v, 0.0, d_h, 0.0, alpha_z]]))
    np.testing.assert_allclose(plate(True).impedance(turned, 5e6).L, plate().impedance(flat, 5e6).L, rtol=1e-5)


@FEW
@given(st.floats(0.3, 3.0), st.floats(0.5, 3.0), st.floats(1e5, 5e6))
def test_a_sensor_of_another_size_shows_the_same_at_its_frequency(size, gap, frequency):
    """Lengths by s, frequency by 1/s^2: L by s, R by 1/s, within their errors; a coil under a disc."""
    coil = '[{{name="A", shape="circle", centre=[0, 0], layers=1, turns=5, inner_diameter={0!r}, track_width={1!r}, ' \
           'track_gap={1!r}, track_thickness={2!r}}}]'
    shown = []
    for s in (1.0, size):
        sensor = load_sensor("biorob2018", [
            "coils=" + coil.format(3e-3 * s, 2e-4 * s, 3.5e-5 * s), f"frequency={frequency / s**2!r}",
            f'target={{material="copper", shape="disc", diameter={8e-3 * s!r}, thickness={3e-4 * s!r}}}',
        ]).model_copy(update={"elastomer": None})
        found = magnetic_model(sensor, "axisymmetric", 1e-2)[0].impedance(Pose(0.0, gap * s * MM), frequency / s**2)
        shown.append([(found.L[0, 0] / s, found.R[0, 0] * s), (found.error_L[0, 0] / s, found.error_R[0, 0] * s)])
    (one, error), (other, its) = np.array(shown)
    assert (abs(other - one) < error + its).all()  # prepared for other steps of gap and frequency
