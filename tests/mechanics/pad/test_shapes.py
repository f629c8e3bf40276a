"""Targets wider than their pad, and pillars: limits, closed forms by levers, other models, meshes of the user's."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sits_mech.mechanics.block import block_pad, solved_body
from sits_mech.mechanics.element.prolongation import along_family
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.pad.shapes import cells_of, half_bricks, shape_of
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.notes import NoteKind
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.pad import deformed_section
from sits_mech.scene.sensor import SceneError, load_sensor

MM = 1e-3
NEO_HOOKEAN = '{law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
PITCH, DIAMETER = 2.5, 1.5


def scene(target, pad, *more):
    """Target and pad of given sizes [mm], a number for a disc or a cylinder; the force acts at the bonded face."""
    plate = f'shape="disc", diameter="{target} mm"'
    if not isinstance(target, float | int):
        plate = f'shape="rectangle", width="{target[0]} mm", length="{target[1]} mm"'
    sizes = pad if isinstance(pad, str) else f'diameter="{pad} mm"'
    if isinstance(pad, tuple):
        sizes = f'width="{pad[0]} mm", length="{pad[1]} mm"'
    return load_sensor("biorob2018", [
        f'target={{material="copper", {plate}, thickness="0.2 mm", load_height="0 mm"}}',
        f'elastomer={{material={NEO_HOOKEAN}, thickness="2 mm", {sizes}}}', *more,
    ])


def pillars(pitch=PITCH, diameter=DIAMETER):
    return f'shape="pillars", pitch="{pitch} mm", diameter="{diameter} mm"'


def stiffness(found):
    """Of d_h, d_z, alpha against the forces, scaled, shape (3, 3)."""
    return np.linalg.inv(small_strain_compliance(found.body)[0]) / found.share


def small(sensor, split=2):
    return stiffness(bonded_block(sensor, split))


@pytest.mark.parametrize(
    ("wide", "flush", "pad"),
    [((10, 11), (8, 8), (8, 8)), (12, (8, 8), (8, 8)), (10, 8, 8), ((8, 9), 8, 8), ((10, 6), (8, 6), (8, 8))],
)
def test_what_is_beyond_the_pad_takes_no_part_until_silicone_gets_there(wide, flush, pad):
    """Bonded over what lies under the target: the stiffness is that of a target cut to the pad."""
    np.testing.assert_allclose(small(scene(wide, pad), 1), small(scene(flush, pad), 1), rtol=1e-12)


def test_in_the_plane_as_well():
    wide, flush = (linear_layer(scene((size, 80), (8, 80))).stiffness[0] for size in (10, 8))
    np.testing.assert_allclose(wide, flush, rtol=1e-12)
    load = Wrench(F_x=0.2, F_z=2.0)
    wide, flush = (planar_layer(scene((size, 80), (8, 80))).equilibrium(load).pose for size in (10, 8))
    np.testing.assert_allclose(wide.components, flush.components, rtol=1e-12)


@pytest.mark.slow
def test_a_disc_over_a_box_lies_between_its_limits():
    """From the disc within the box to the one that covers it the pad grows stiffer, and nothing jumps at either end."""
    k = np.array([np.diag(small(scene(size, (8, 8)), 1)) for size in (7.9, 8.3, 9.0, 10.0, 11.0, 11.4)])
    assert np.all(np.diff(k[:-1, 1:], axis=0) > 0.0)
    np.testing.assert_allclose(k[-2, :2], k[-1, :2], rtol=0.025)  # the coarsest meshes, of other kinds


@pytest.mark.slow
def test_a_rectangle_over_a_cylinder_lies_between_its_limits():
    k = np.array([np.diag(small(scene((size, size), 8), 1)) for size in (5.5, 6.0, 6.5, 7.0, 7.5, 7.8, 8.0)])
    assert np.all(np.diff(k[:-1, 1:], axis=0) > 0.0)
    np.testing.assert_allclose(k[-2], k[-1], rtol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("target", "pad"), [(10, (8, 8)), ((7, 7), 8), (10, (8, 12))])
def test_where_rims_cross_the_stiffness_falls_towards_the_truth(target, pad):
    """Energies of finer meshes are closer from above, and shrink at first order or better, where arcs are round."""
    sensor = scene(target, pad)
    k = np.array([np.diag(small(sensor, split)) for split in (2, 3, 4)])
    drops = -np.diff(k, axis=0) / k[-1]
    assert np.all(drops > 0.0) and np.all(drops[1] < drops[0]) and np.all(drops[1] < 4e-3)


def test_crossing_rims_too_near_each_other_are_refused_by_name():
    with pytest.raises(SceneError, match=r"target: the rims of target and pad must not cross at less than 10 deg"):
        block_pad(scene(8.1, (8, 8)))


def levers(k, middles):
    """Stiffness of equal pillars under a rigid target, from one: d_z at a pillar is that of the centre - alpha x."""
    found = np.zeros((3, 3))
    for x, _ in middles:
        T = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])
        found += T.T @ k @ T
    return found


@pytest.mark.parametrize(("target", "count"), [((8, 8), 9), ((9, 9), 16), (8, 5), ((6, 2), 2)])
def test_pillars_are_so_many_times_one(target, count):
    """They meet in the rigid target alone, so that one pillar's stiffness and the levers give that of all."""
    sensor = scene(target, pillars())
    shape = shape_of(sensor.target, sensor.elastomer)
    assert len(shape.middles) == count
    one, every = small(scene((1.6, 1.6), pillars()), 1), small(sensor, 1)
    np.testing.assert_allclose(every, levers(one, shape.middles), rtol=1e-8, atol=1e-9 * every[1, 1])


def test_one_pillar_is_a_flush_cylinder():
    """Of fewer cells around: within what either is off by."""
    one, cylinder = small(scene((1.6, 1.6), pillars())), small(scene(1.5, 1.5))
    np.testing.assert_allclose(np.diag(one), np.diag(cylinder), rtol=3e-3)


@pytest.mark.slow
def test_pressed_pillars_share_the_force():
    one, nine = (block_pad(scene(size, pillars())) for size in ((1.6, 1.6), (8, 8)))
    single, all_nine = one.equilibrium(Wrench(F_z=0.01)), nine.equilibrium(Wrench(F_z=0.09))
    assert abs(all_nine.pose.d_v - single.pose.d_v) < all_nine.error.d_v + single.error.d_v  # of one level more or less
    assert single.pose.d_v < 1.9 * MM


@pytest.fixture(scope="module")
def four():
    """Two by two pillars, and where their target rests under a little shear along y."""
    pad = block_pad(scene((5, 5), pillars()), 0.5)
    return pad, pad.equilibrium(Wrench(F_y=1e-3))


@pytest.mark.slow
def test_pillars_bear_loads_beside_the_plane_as_a_square_does(four):
    pad, found = four
    along, across = pad.equilibrium(Wrench(F_x=1e-3)).pose, found.pose
    assert across.d_y == pytest.approx(along.d_h, rel=2e-3)
    assert -across.alpha_x == pytest.approx(along.alpha, rel=5e-3)


@pytest.mark.slow
def test_a_slanted_section_is_empty_between_pillars(four):
    """Along the diagonal of two by two pillars, 3.5 mm apart: two of 1.5 mm, to a piece of the grid."""
    points, quads, *_ = deformed_section(*four, np.pi / 4)
    s = points[quads][..., 0]
    length = np.ptp(s, axis=1).sum() / 12  # as many pieces one above the other
    assert length == pytest.approx(2 * DIAMETER * MM, rel=0.1)
    assert not np.any(np.abs(s.mean(axis=1)) < (2.5 / np.sqrt(2.0) - 0.85) * MM)


@pytest.mark.slow
def test_pillars_that_touch_are_held_against_each_other():
    """Three in a row, 0.1 mm apart: of a pillar pressed by a tenth the middle grows by a thirtieth of its width."""
    pad = block_pad(scene((9.5, 3.1), pillars(3.1, 3.0)), 0.5)
    gently, hard = (pad.equilibrium(Wrench(F_z=force)) for force in (0.05, 0.3))
    assert hard.pose.d_v < 1.8 * MM
    assert not any(note.kind is NoteKind.FACES_TOUCH for note in gently.report.notes)
    assert any(note.kind is NoteKind.FACES_TOUCH for note in hard.report.notes)


SHAPES = (((8, 8), (20, 20)), ((10, 6), (8, 8)), (8, 10), (10, (8, 8)), ((7, 7), 8), ((4.5, 2), pillars()))


@pytest.mark.slow
@pytest.mark.parametrize("whole", [False, True])
def test_places_are_carried_along_every_family(whole):
    """From two parts a base cell to three, that do not nest: curved sides are off by h^3, straight ones by nothing."""
    for target, pad in SHAPES:
        coarse, fine = (bonded_block(scene(target, pad), split, whole=whole) for split in (2, 3))
        way = along_family(coarse.body.mesh, fine.body.mesh, (coarse.division, fine.division))
        there = way.displacements(coarse.body.mesh.nodes.ravel()).reshape(-1, 3)
        straight = isinstance(target, tuple) and isinstance(pad, tuple)
        assert np.abs(there - fine.body.mesh.nodes).max() < (1e-12 if straight else 4e-3)


@pytest.mark.slow
def test_as_many_cells_are_counted_as_there_are():
    """Or a few more, of which memory is asked."""
    for target, pad in SHAPES:
        sensor = scene(target, pad)
        shape = shape_of(sensor.target, sensor.elastomer)
        for way in ((1, 2.0, 0), (2, 2.0, 1), (4, 2.0, 0)):
            true, counted = half_bricks(shape, *way)[0].nelements, np.prod(cells_of(shape, *way))
            assert true <= counted <= 1.5 * true


def test_a_split_mesh_is_nested_for_every_shape():
    for target, pad in SHAPES:
        sensor = scene(target, pad)
        shape = shape_of(sensor.target, sensor.elastomer)
        coarse, fine = (half_bricks(shape, split, 2.0)[0] for split in (1, 2))
        assert fine.nelements == 8 * coarse.nelements
        near = cKDTree(fine.p.T).query(coarse.p[:, np.unique(coarse.t)].T)[0]
        assert near.max() < 1e-9


@pytest.mark.slow
def test_bulging_sides_lie_on_the_target_and_on_the_ground_beyond_the_pad():
    """A pad pressed by a third bulges: its faces stay between the planes."""
    pad = block_pad(scene((10, 10), (8, 8)), 0.5)
    found = pad.equilibrium(Wrench(F_z=12.0))
    touched = {note.known["surface"] for note in found.report.notes if note.kind is NoteKind.FACE_TOUCHES}
    assert {"ground", "target"} <= touched
    body = solved_body(pad, found)
    u, q = np.split(found.state[1 : 7 + body.mesh.nodes.size], [body.mesh.nodes.size])[0], found.pose
    ground, plane = (part.surface.places(u)[..., 2] for part in body.parts[:2])  # the points that are held
    assert ground.min() > -3e-3 and plane.max() < q.d_v / (2.0 * MM) + 3e-3
    place = body.mesh.nodes + u.reshape(-1, 3)
    assert np.abs(place[:, :2]).max() > 2.1  # thicknesses: beyond the pad's own half width of 2


@pytest.mark.slow
def test_a_wide_target_that_tilts_onto_the_ground_says_so_and_owns_to_it():
    layer = planar_layer(scene((30, 80), (8, 80)))
    gently, hard = (layer.equilibrium(Wrench(F_z=2.0, M=M)) for M in (0.02, 0.06))
    assert not any(note.kind is NoteKind.BELOW_GROUND for note in gently.report.notes)
    assert any(note.kind is NoteKind.BELOW_GROUND for note in hard.report.notes)
    assert gently.report.estimated_error < 0.1 <= 1.0 <= hard.report.estimated_error


@pytest.mark.parametrize("gap", [1e-9, 1e-7, 3e-4])
def test_a_rim_nearer_to_the_pads_than_any_cell_is_flush(gap):
    """Cells of no width were refused by every load; gaps up to 1e-4 thicknesses count as none."""
    for pad in ((8, 8), 8):
        near = (8.0 - gap,) * 2 if isinstance(pad, tuple) else 8.0 - gap
        flush = small(scene(pad, pad), 1)
        np.testing.assert_allclose(small(scene(near, pad), 1), flush, rtol=1e-12, atol=1e-9 * flush[1, 1])
    near, flush = (linear_layer(scene((size, 80), (8, 80))).stiffness[0] for size in (8.0 - gap, 8.0))
    np.testing.assert_allclose(near, flush, rtol=1e-12)


def test_pillars_have_no_section():
    for model in (planar_layer, linear_layer):
        with pytest.raises(ValueError, match="must be 'box' or 'cylinder' for a layer in plane strain, got 'pillars'"):
            model(scene((8, 8), pillars()))
