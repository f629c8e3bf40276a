"""Round pads and targets: an independent code's numbers, one shape between two others, corners in rings."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Elastomer, Target, load_sensor

MU, MM = 3e4, 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
SQUARE, DISC = {"width": 8 * MM, "length": 8 * MM}, {"diameter": 8 * MM}


def scene(pad, target):
    """A pad 2 mm thick; the force acts at the bonded face."""
    base = load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN])
    shape = {"shape": "disc" if "diameter" in target else "rectangle", "material": "copper", "load_height": 0.0}
    plate = Target.model_validate({**target, **shape, "thickness": 0.2 * MM})
    layer = Elastomer.model_validate({**pad, "material": base.elastomer.material, "thickness": 2 * MM})
    return base.model_copy(update={"target": plate, "elastomer": layer})


def stiffness(sensor, cells, grading=2.0):
    """kz, kx [N/mm], kxa [N/rad], ka [N mm/rad] about the centre of the bonded face."""
    found = bonded_block(sensor, cells, grading, 0.0)
    k = np.linalg.inv(small_strain_compliance(found.body)[0]) * MU * 2e-3 / found.share
    return np.array([k[1, 1] * MM, k[0, 0] * MM, k[0, 2] * 2 * MM, k[2, 2] * 4 * MM])


CYLINDER = scene({"diameter": 15 * MM}, {"diameter": 15 * MM})


# NGSolve 6.2, graded elements, radius 7.5 mm, height 2 mm, mu 30 kPa, K/mu 1000; to 1e-4.
@pytest.mark.parametrize(("cells", "allowed"), [(2, 1.5e-3), (3, 1e-3), pytest.param(4, 4e-4, marks=pytest.mark.slow)])
def test_small_strain_stiffness_of_a_cylinder(cells, allowed):
    np.testing.assert_allclose(stiffness(CYLINDER, cells), [60.579, 2.56733, -2.56733, 386.547], rtol=allowed)


@pytest.mark.parametrize(("F_z", "sink"), [(1.2, 0.0194572), pytest.param(-10.0, -0.2005098, marks=pytest.mark.slow)])
def test_a_cylinder_pressed_and_pulled(F_z, sink):
    """NGSolve 6.2, Q5 on graded meshes, to 5e-5 (studies/common/reference_pads.json); errors to a factor of two."""
    found = block_pad(CYLINDER).equilibrium(Wrench(F_z=F_z))
    away = abs(2.0 - found.pose.d_v / MM - sink)
    assert away < 2.0 * found.error.d_v / MM + 5e-5 * abs(sink) and found.report.estimated_error < 0.01
    assert abs(found.pose.d_h) < 1e-10


def test_a_round_pad_is_alike_in_all_directions():
    """The rings' mesh knows x from y, the pad does not: work in the field turned by 90 degrees is the same."""
    found = bonded_block(CYLINDER, 2, 2.0, 0.0)
    x, y, _ = found.body.mesh.nodes.T
    rim = np.hypot(x, y)[found.body.faces.nodes]
    np.testing.assert_allclose(rim, 3.75, rtol=1e-12)
    assert found.body.mesh.inside.weights.sum() == pytest.approx(np.pi * 3.75**2 / 2, rel=1e-4)


def test_a_disc_lies_between_two_squares():
    """A pad under a larger target is stiffer: square inside the disc, disc, square around it."""
    box = {"width": 20 * MM, "length": 20 * MM}
    inside = {side: size / np.sqrt(2) for side, size in SQUARE.items()}
    small, middle, large = (stiffness(scene(box, plate), 2)[[0, 1, 3]] for plate in (inside, DISC, SQUARE))
    assert np.all(small < middle) and np.all(middle < large)


def mixed(width, length, *, disc=8.0):
    """A box under a disc [mm]."""
    return scene({"width": width * MM, "length": length * MM}, {"diameter": disc * MM})


@pytest.mark.parametrize(
    ("sensor", "volume"),
    [
        (mixed(8, 8), 128.0), (mixed(8, 12), 192.0), (mixed(12, 8), 192.0), (mixed(12, 10), 240.0),
        (CYLINDER, 112.5 * np.pi), (scene({"diameter": 12 * MM}, SQUARE), 72.0 * np.pi),
        (scene({"diameter": 12 * MM}, DISC), 72.0 * np.pi),
    ],
)
def test_the_whole_pad_is_meshed(sensor, volume):
    """Half of it, 2 mm thick; a box whose side a disc touches is taken a quarter of a percent wider."""
    body = bonded_block(sensor, 2, 2.0, 0.0).body
    assert 16.0 * body.mesh.inside.weights.sum() == pytest.approx(volume, rel=6e-3)


def test_a_disc_that_touches_the_sides_of_its_box():
    """As one that nearly does, and softer than a disc in the middle of a larger box."""
    touching, nearly, far = (stiffness(mixed(size, size), 2)[[0, 1, 3]] for size in (8.0, 8.2, 12.0))
    np.testing.assert_allclose(touching, nearly, rtol=0.05)
    assert np.all(touching < nearly) and np.all(nearly < far)


def test_rings_hold_a_square_as_a_tensor_grid_does():
    """A square on a round pad that is far larger than it: the pad's own outline plays no part."""
    round_pad = stiffness(scene({"diameter": 40 * MM}, SQUARE), 2, 2.5)
    box = stiffness(scene({"width": 40 * MM, "length": 40 * MM}, SQUARE), 2, 2.5)
    np.testing.assert_allclose(round_pad[[0, 1, 3]], box[[0, 1, 3]], rtol=0.01)


@pytest.mark.slow
def test_sheared_and_turned_cylinder_keeps_its_error_on_the_coarse_side():
    wrench = Wrench(1.5, 5.0, 1e-3)
    coarse, fine = (block_pad(CYLINDER, tolerance).equilibrium(wrench) for tolerance in (2e-2, 1e-4))
    assert coarse.report.unknowns < fine.report.unknowns
    for name in ("d_h", "d_v"):
        away = abs(getattr(coarse.pose, name) - getattr(fine.pose, name))
        assert away < getattr(coarse.error, name) + getattr(fine.error, name)


def test_moment_that_holds_the_tilt_of_a_flush_pad():
    """Exact for a pad that is its own image under a half turn: sheared by F_x, its target needs the moment F_x t/2."""
    for pad, target in (({"diameter": 8 * MM}, DISC), (SQUARE, SQUARE)):
        k = stiffness(scene(pad, target), 1)
        assert k[2] == pytest.approx(-0.5 * k[1] * 2.0, rel=1e-9)


def test_stiffness_falls_towards_the_truth_at_second_order_or_better():
    """16.68 N/mm and 55.4 N mm/rad: three divisions extrapolated; a conforming element comes from the stiff side."""
    sensor = scene({"width": 20 * MM, "length": 20 * MM}, SQUARE)
    errors = np.array([stiffness(sensor, cells, 2.5)[[0, 3]] / [16.68, 55.4] - 1.0 for cells in (1, 2)])
    assert np.all(errors > 0.0) and np.all(np.log2(errors[0] / errors[1]) > 2.0)
