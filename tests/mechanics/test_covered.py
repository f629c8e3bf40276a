"""Covered targets: cells, bonds and faces; vanishing and rigid covers, an independent code, model beside model."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element.prolongation import along_family
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.layer import axisymmetric_pad, deformed_mesh, planar_layer
from sits_mech.mechanics.linear import linear_layer, linear_pad
from sits_mech.mechanics.models import ends_of_pad, strain_bound
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.mechanics.pad.stack import covering, layer_of_cells
from sits_mech.notes import NoteKind
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.pad import deformed_section
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import load_sensor

SOFT = '{law="mooney-rivlin", c10=7e3, c01=3e3, bulk_modulus=1e6}'
FIRM = '{law="neo-hookean", shear_modulus=80e3, bulk_modulus=4e6}'
BOX = ('width="14 mm", length="12 mm"', 'width="8 mm", length="6 mm"')
STRIP = ('width="14 mm", length="1 m"', 'width="8 mm", length="1 m"')
DISC = ('diameter="14 mm"', 'diameter="8 mm"')
DISC_ON_BOX, BOX_ON_DISC = (BOX[0], 'diameter="6 mm"'), (DISC[0], 'width="6 mm", length="5 mm"')


def scene(shape=BOX, material=FIRM, over=1.0, beyond=1.5, high=0.4, pad=SOFT):
    """A target 0.4 mm thick under a cover, or bare where its material is None [mm]."""
    plate = 'shape="disc"' if "diameter" in shape[1] else 'shape="rectangle"'
    keys = [
        f'elastomer={{{shape[0]}, material={pad}, thickness="2 mm"}}',
        f'target={{material="copper", {plate}, {shape[1]}, thickness="{high} mm", load_height="{high} mm"}}',
    ]
    cover = f'cover={{material={material}, thickness="{over} mm", overhang="{beyond} mm"}}'
    return load_sensor("biorob2018", [*keys, *([] if material is None else [cover])])


def bare(shape, pad=SOFT, high=0.4):
    return scene(shape, None, pad=pad, high=high)


def neo_hooke(mu, bulk=50.0):
    return f'{{law="neo-hookean", shear_modulus={mu}, bulk_modulus={bulk * mu}}}'


VOLUMES = [  # of silicone [mm^3]
    (BOX, 14 * 12 * 2 + 11 * 9 * 1.4 - 8 * 6 * 0.4), (DISC, np.pi * (49 * 2 + 5.5**2 * 1.4 - 16 * 0.4)),
    (DISC_ON_BOX, 14 * 12 * 2 + np.pi * (4.5**2 * 1.4 - 9 * 0.4)),
]


@pytest.mark.parametrize(("shape", "volume"), VOLUMES)
@pytest.mark.parametrize("whole", [False, True])
def test_bricks_fill_pad_and_cover_but_not_the_target(shape, volume, whole):
    body = bonded_block(scene(shape), 2, whole=whole).body
    weights, of = body.mesh.inside.weights, body.laws.of
    assert weights.min() > 0.0
    assert 8.0 * weights.sum() * (1 if whole else 2) == pytest.approx(volume, rel=2e-4)
    assert np.all(body.mesh.nodes[body.mesh.cells[of == 1]][..., 2] > 1.0 - 1e-12)
    x, y, z = np.abs(body.X.T)
    assert z.min() == 0.0 and z.max() == pytest.approx(0.2, rel=1e-12)
    inside = np.hypot(x, y) < 2.9 / 2 if "diameter" in shape[1] else (x < 3.9 / 2) & (y < 2.9 / 2)
    assert np.all((z[inside] < 1e-12) | (z[inside] > 0.2 - 1e-12))  # of the target's inside no node is there


def test_a_cover_ends_with_pad_and_target_where_these_end_together():
    flush = ('width="14 mm", length="6 mm"', BOX[1])
    body = bonded_block(scene(flush), 1, whole=True).body
    assert 8.0 * body.mesh.inside.weights.sum() == pytest.approx(14 * 6 * 2 + (11 * 1.4 - 8 * 0.4) * 6, rel=1e-12)


@pytest.mark.parametrize("shape", [BOX, DISC, BOX_ON_DISC])
@pytest.mark.parametrize("high", [0.4, 1.2])
def test_levels_of_a_covered_pad_hold_those_before(shape, high):
    """What is linear in space is carried from level to level exactly, displacements and pressures."""
    solids = [bonded_block(scene(shape, beyond=0.8, high=high), *way[:1], layers=way[1]) for way in ((1, 0), (2, 0))]
    coarse, fine = (each.body.mesh for each in solids)
    way = along_family(coarse, fine, tuple(each.division for each in solids))
    if shape is BOX:
        slope = np.array([[0.1, 0.2, -0.1], [0.0, 0.3, 0.2], [0.4, -0.2, 0.1]])
        found = way.displacements((coarse.nodes @ slope).ravel())
        assert found == pytest.approx((fine.nodes @ slope).ravel(), abs=1e-12)
    apart = [layer_of_cells(scene(shape, beyond=0.8, high=high), mesh) for mesh in (coarse, fine)]
    assert np.all(apart[0][way.parents] == apart[1])


@pytest.mark.parametrize("axial", [False, True])
def test_a_section_has_one_line_of_free_faces_around_its_cover(axial):
    sensor = scene(DISC if axial else STRIP)
    body = bonded_body(sensor, SectionFineness(4, 2.0, fan=True, axial=axial))
    mesh, (line,) = body.mesh, body.faces.lines
    along = np.linalg.norm(np.diff(mesh.nodes[line], axis=0), axis=1)
    around = 2.0 + 1.4 + 1.5 + 5.5  # sides, beside the cover, over half the target [mm]
    assert 2.0 * along.sum() == pytest.approx(around * (1 if axial else 2), rel=1e-12) and along.max() < 2.0
    weights = mesh.inside.weights.sum()
    area = 14 * 2 + 11 * 1.4 - 8 * 0.4
    assert weights == pytest.approx(VOLUMES[1][1] / 8 if axial else area / 4, rel=1e-12)
    assert np.all(np.isin(body.bonded, body.free, invert=True)) and covering(sensor).half_x == pytest.approx(2.75)


@pytest.mark.parametrize(("make", "shape", "load"), [
    (planar_layer, STRIP, Wrench(F_x=40.0, F_z=60.0)), (axisymmetric_pad, DISC, Wrench(F_z=0.5)),
    pytest.param(block_pad, BOX, Wrench(F_x=0.05, F_z=0.2), marks=pytest.mark.slow),
])
@pytest.mark.parametrize("cover", [{"material": neo_hooke(20.0)}, {"over": 0.004, "beyond": 0.004, "high": 0.01}])
def test_a_cover_that_vanishes_leaves_the_bare_pad(make, shape, load, cover):
    """A thousandth of the pad's modulus, or 4 um of silicone around a foil."""
    high = cover.get("high", 0.4)
    covered, plain = (make(each, 1e-2).equilibrium(load) for each in (scene(shape, **cover), bare(shape, high=high)))
    away = np.abs(covered.pose.components - plain.pose.components)
    assert np.all(away <= covered.error.components + plain.error.components + 1e-12)
    assert np.max(away[:2]) < 0.01 * max(plain.pose.d_h, 2e-3 - plain.pose.d_v)


@pytest.mark.parametrize("shape", [STRIP, pytest.param(DISC, marks=pytest.mark.slow)])
def test_a_rigid_cover_makes_a_target_as_wide_as_itself(shape):
    """Ten thousand times as stiff, at small strain."""
    make = linear_pad if shape is DISC else linear_layer
    size = 'diameter="11 mm"' if shape is DISC else 'width="11 mm", length="1 m"'
    (own, error), (wide, other) = (
        make(each, 1e-2).stiffness for each in (scene(shape, neo_hooke(1e8)), bare((shape[0], size)))
    )
    assert np.diag(own) == pytest.approx(np.diag(wide), rel=error + other + 1e-3)
    assert error < 0.05


def test_a_wider_or_thicker_cover_is_stiffer():
    """At small strain more silicone, bonded to what there is, can only be stiffer; a second millimetre adds less."""
    sink = {None: linear_pad(bare(DISC), 0.1).compliances[0][1, 1]}
    for over, beyond in ((1.0, 0.5), (1.0, 1.5), (1.0, 3.0), (2.0, 1.5)):
        sink[over, beyond] = linear_pad(scene(DISC, over=over, beyond=beyond), 0.1).compliances[0][1, 1]
    assert sink[None] > sink[1.0, 0.5] > sink[1.0, 1.5] > sink[1.0, 3.0]
    assert 0.0 < sink[1.0, 1.5] - sink[2.0, 1.5] < 0.5 * (sink[None] - sink[1.0, 1.5])


@pytest.mark.slow
def test_small_shear_and_tilt_of_a_pressed_meridian_are_those_in_space():
    own, solid = (make(scene(DISC), 1e-2) for make in (axisymmetric_pad, block_pad))
    first, second = (each.slopes(each.equilibrium(Wrench(F_z=0.4)), [], sideways=True) for each in (own, solid))
    away = np.abs(first.compliance - second.compliance)
    known = np.isfinite(away)
    assert np.all(away[known] <= (first.error_compliance + second.error_compliance)[known] + 1e-12)
    size = np.sqrt(np.outer(*[np.abs(np.diag(second.compliance))] * 2))
    assert np.nanmax(away / size) < 0.02 and np.isfinite(first.compliance[0, 2])


# NGSolve 6.2, displacements of order 4 to 6 on triangles graded geometrically to the edges of target and cover (orders
# differ by less than 1e-3): a Mooney-Rivlin pad of 14 x 2 mm, c10 7 kPa, c01 3 kPa, K 1 MPa, under a neo-Hooke cover,
# mu 80 kPa, K 4 MPa, 1 mm over a target of 8 x 0.4 mm and 1.5 mm beyond it; the load 0.4 mm above its lower face.
PRESSED = [(0.4, 0.045852), (1.5, 0.160264), (-1.0, -0.12725)]  # N, mm
LOADED = [  # N/m, N/m, N; d_h, sink [mm], alpha [rad]
    ((0.0, 200.0, 0.0), (0.0, 0.098262, 0.0)), ((60.0, 100.0, 0.0), (0.47733, 0.049071, -0.0031056)),
    ((40.0, 200.0, 0.15), (0.30153, 0.097816, 0.018451)),
]


@pytest.mark.parametrize(("load", "expected"), LOADED)
def test_a_covered_strip_is_within_a_percent_of_another_code(load, expected):
    found = planar_layer(scene(STRIP), 1e-2).equilibrium(Wrench(F_x=load[0], F_z=load[1], M=load[2]))
    moved = np.array([1e3 * found.pose.d_h, 2.0 - 1e3 * found.pose.d_v, 4.0 * found.pose.alpha])
    known = np.array(expected) * (1.0, 1.0, 4.0)
    assert np.max(np.abs(moved - known)) < 0.01 * np.max(np.abs(known))
    assert found.report.estimated_error < 0.01 and found.report.notes == ()


@pytest.mark.parametrize("make", [axisymmetric_pad, pytest.param(block_pad, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("force", "expected"), PRESSED)
def test_a_covered_disc_is_within_a_percent_of_another_code(make, force, expected):
    found = make(scene(DISC), 1e-2).equilibrium(Wrench(F_z=force))
    sink = 2.0 - 1e3 * found.pose.d_v
    assert sink == pytest.approx(expected, rel=0.01)
    assert abs(sink - expected) <= 1e3 * found.error.d_v + 1e-3 * abs(expected)


@pytest.mark.slow
def test_a_covered_box_answers_its_mirror_images_and_out_of_plane_loads():
    model = block_pad(scene(), 0.1)
    loads = [Wrench(F_x=f, F_y=g, F_z=0.1) for f, g in ((1e-2, 0.0), (-1e-2, 0.0), (0.0, 1e-2))]
    one, other, across = (model.equilibrium(load).pose for load in loads)
    assert other.d_h == pytest.approx(-one.d_h, rel=1e-9) and other.d_v == pytest.approx(one.d_v, rel=1e-12)
    assert across.d_y > 0.0 and abs(across.d_h) < 1e-6 * across.d_y


def test_a_cover_that_relaxes_lets_the_target_creep():
    relaxing = '{law="neo-hookean", shear_modulus=80e3, bulk_modulus=4e6, prony=[{weight=0.5, time="0.1 s"}]}'
    loads = np.array([[0.0] * 6, *[[60.0, 100.0, 0.0, 0.0, 0.0, 0.0]] * 2])
    history = LoadHistory(np.array([0.0, 0.0, 10.0]), loads)
    moved = []
    for made in (relaxing, FIRM):
        motion = planar_layer(scene(STRIP, made), 0.05).in_time(history)
        d_h = motion.pose.d_h[motion.given]
        moved.append(float(d_h[-1] - d_h[-2]))
    assert moved[0] > 1e-7 and moved[1] == pytest.approx(0.0, abs=1e-3 * moved[0])


def test_ends_of_a_covered_pad_have_a_size_and_one_compliance_has_no_bound():
    assert strain_bound(scene(), [Wrench(F_z=0.01)]) == np.inf
    factor = ends_of_pad(scene(BOX))
    assert factor.compression > 1.5 and factor.shear > 1.0 and factor.error < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("shape", [BOX, DISC])
def test_derivatives_by_numbers_of_a_cover_are_those_of_solves(shape):
    sensor, load = scene(shape), Wrench(F_x=0.05, F_z=0.2)
    model = block_pad(sensor, 0.1)
    each = [parameter(sensor, f"cover.{name}") for name in ("thickness", "overhang", "material.shear_modulus")]
    found = model.slopes(model.equilibrium(load), each)
    for column, one in enumerate(each):
        step = 1e-3 * one.value
        up, down = (block_pad(one.changed(way * step), 0.1).equilibrium(load).pose.components for way in (1, -1))
        assert found.pose[:3, column] == pytest.approx((up - down)[:3] / (2.0 * step), rel=1e-3, abs=1e-9)


def area_at_rest(section):
    """Of the quads of a deformed section before the load [mm^2]."""
    x, z = 1e3 * np.moveaxis(section.rest[section.quads], -1, 0)
    return float(np.abs(0.5 * (x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z).sum(axis=1)).sum())


def test_pictures_show_pad_and_cover_without_the_target():
    model = axisymmetric_pad(scene(DISC), 0.1)
    section = deformed_mesh(model, model.equilibrium(Wrench(F_z=0.1)))
    assert area_at_rest(section) == pytest.approx(14 * 2 + 11 * 1.4 - 8 * 0.4, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "angle"), [(Wrench(F_z=0.1), 0.0), (Wrench(F_x=0.05, F_y=0.05), np.pi / 4)])
def test_pictures_in_space_show_pad_and_cover_without_the_target(load, angle):
    model = block_pad(scene(DISC), 0.1)
    section = deformed_section(model, model.equilibrium(load), angle)
    assert area_at_rest(section) == pytest.approx(14 * 2 + 11 * 1.4 - 8 * 0.4, rel=0.06 if angle else 1e-9)


@pytest.mark.slow
def test_a_pressed_pad_that_folds_onto_the_ground_is_held_there_on_the_meridian_and_in_space():
    sensor, load = scene(('diameter="9 mm"', DISC[1]), beyond=0.5), Wrench(F_z=5.0)
    own, solid = axisymmetric_pad(sensor, 1e-2).equilibrium(load), block_pad(sensor, 0.1).equilibrium(load)
    for found in (own, solid):
        assert [note.kind for note in found.report.notes] == [NoteKind.FACE_TOUCHES]
    assert abs(own.pose.d_v - solid.pose.d_v) <= own.error.d_v + solid.error.d_v
