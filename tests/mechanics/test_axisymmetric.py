"""A cylinder under a coaxial disc: closed forms, another code, the pad in space, orders, refusals."""

import numpy as np
import pytest
from scipy.special import iv

from sits_mech.chain.models import choose_mechanics
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.layer import axisymmetric_pad, deformed_mesh
from sits_mech.mechanics.pad.planar import layer_family
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.notes import NoteKind
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, load_sensor

ECOFLEX = '"ecoflex-00-30"'
NEO_HOOKEAN = '{law="neo-hookean", shear_modulus="20 kPa", bulk_modulus="%s"}'
AXIAL = [1]  # the component of a pose and a load that such pads have
TILTED = [0, 2, 3, 4]


def cylinder(pad, disc, thickness, material=ECOFLEX, more=""):
    """A scene of diameters and thickness [mm]."""
    return load_sensor("biorob2018", [
        f'elastomer={{material={material}, diameter="{pad} mm", thickness="{thickness} mm"{more}}}',
        f'target={{material="copper", shape="disc", diameter="{disc} mm", thickness="0.2 mm"}}',
    ])


@pytest.mark.parametrize(("across", "off"), [(40, 1e-3), (80, 2.5e-4)])
def test_a_thin_flush_pad_is_as_stiff_as_its_pressure(across, off):
    """``K (1 - 2 I_1(y)/(y I_0(y)))``, y = R sqrt(12 mu/K)/t: the pressure's own equation, but for the rim, t/R."""
    sensor = cylinder(across, across, 1, NEO_HOOKEAN % "25 MPa")
    levels = layer_family(sensor, axial=True)
    compliance = levels.limit([small_strain_compliance(levels.maker(k))[0][1:2, 1] for k in range(3)]).value[0]
    R, K = 0.5 * across, sensor.elastomer.silicone.bulk_modulus / 2e4
    y = R * np.sqrt(12.0 / K)
    assert K * (1.0 - 2.0 * iv(1, y) / (y * iv(0, y))) * np.pi * R**2 * compliance == pytest.approx(1.0, abs=off)


@pytest.mark.parametrize(("disc", "order"), [(8, 2.0), (10, 2.38)])
def test_compliances_converge_with_the_exponent_of_the_rim(disc, order):
    """Twice 2 k: 0.5 within a face, 0.5946 where the pad ends with its target; lines graded with 2."""
    bodies = (
        bonded_body(cylinder(10, disc, 2), SectionFineness(cells, 2.0, True, axial=True)) for cells in (8, 16, 32)
    )
    coarse, middle, fine = (small_strain_compliance(body)[0][1, 1] for body in bodies)
    assert np.log2((middle - coarse) / (fine - middle)) == pytest.approx(order, abs=0.15)


# NGSolve 6.2, (r, z), order 4 with discontinuous pressures of order 2 on lines with two geometric layers of a quarter
# at each edge, 5,442 unknowns, and how far it moved from fewer cells: press in mm, force in N
NGSOLVE = [(0.04, 0.194900, 5e-5), (0.1, 0.514404, 1e-4)]


@pytest.mark.parametrize(("sink", "force", "off"), NGSOLVE)
def test_force_against_another_code(sink, force, off):
    found = axisymmetric_pad(cylinder(10, 8, 2), 1e-3).controlled(Control(sink=1e-3 * sink))
    assert found.wrench.F_z == pytest.approx(force, rel=found.report.estimated_error + off)
    assert found.report.estimated_error < 1e-3


PADS = [
    pytest.param(10, 8, 2, 0.5, "", (), id="narrower", marks=pytest.mark.slow),
    pytest.param(6, 6, 6, 0.05, "", (), id="tall"),
    pytest.param(8, 12, 2, 1.5, "", NoteKind.FACE_TOUCHES, id="wider-in-contact", marks=pytest.mark.slow),
    pytest.param(10, 10, 2, 1.7, "", NoteKind.FACE_TOUCHES, id="flush-in-contact", marks=pytest.mark.slow),
    pytest.param(10, 8, 2, 1.0, ", free_stretch=1.01", (), id="grown", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("pad", "disc", "thickness", "force", "more", "note"), PADS)
def test_pose_and_derivatives_are_those_in_space(pad, disc, thickness, force, more, note):
    """Sink, what it changes by, and what shear and tilt would move, which are the first harmonic."""
    sensor = cylinder(pad, disc, thickness, more=more)
    load = Wrench(F_z=force)
    models = axisymmetric_pad(sensor, 1e-3), block_pad(sensor, 1e-2)
    own, solid = (model.equilibrium(load) for model in models)
    assert abs(own.pose.d_v - solid.pose.d_v) < own.error.d_v + solid.error.d_v
    assert own.error.d_v < 0.5 * solid.error.d_v
    assert (own.error.d_h, own.error.alpha) == (0.0, 0.0)
    assert not note or note in {each.kind for each in own.report.notes}
    slopes, others = (model.slopes(found, [], sideways=True) for model, found in zip(models, (own, solid), strict=True))
    away, bar = np.abs(slopes.compliance - others.compliance), slopes.error_compliance + others.error_compliance
    components = AXIAL if note else AXIAL + TILTED
    assert np.all(away[np.ix_(components, components)] <= bar[np.ix_(components, components)])
    assert np.all(np.isnan(slopes.compliance[5])) and bool(note) == bool(np.isnan(slopes.compliance[0, 0]))


def test_derivative_by_the_load_is_that_of_the_poses():
    model, h = axisymmetric_pad(cylinder(10, 8, 2), 1e-3), 0.01
    low, here, high = (model.equilibrium(Wrench(F_z=1.0 + step)) for step in (-h, 0.0, h))
    slope = model.slopes(here, []).compliance[1, 1]
    assert (high.pose.d_v - low.pose.d_v) / (2 * h) == pytest.approx(slope, rel=2e-3)


@pytest.mark.slow
def test_a_tall_pad_falls_sideways_where_it_does_in_space():
    load, sensor = Wrench(F_z=0.4), cylinder(6, 6, 6)
    carried = []
    for model in (axisymmetric_pad(sensor, 1e-2), block_pad(sensor, 1e-2)):
        with pytest.raises(SolveFailed, match="buckles") as failed:
            model.equilibrium(load)
        carried.append(failed.value.carried)
    (own, off), (solid, away) = carried
    assert abs(own.F_z - solid.F_z) < off.F_z + away.F_z < 0.15 * solid.F_z


def test_a_history_is_that_in_space():
    material = '{law="neo-hookean", shear_modulus="20 kPa", bulk_modulus="2 MPa", prony=[{weight=0.3, time="1 s"}]}'
    sensor, load = cylinder(10, 10, 3, material), Wrench(F_z=0.3).components
    history = LoadHistory(np.array([0.0, 0.1, 2.0]), np.array([0.0 * load, load, load]))
    own, solid = (model(sensor, 1e-2).in_time(history) for model in (axisymmetric_pad, block_pad))
    bar = own.error.d_v + solid.error.d_v
    assert np.all(np.abs(own.pose.d_v - solid.pose.d_v)[1:] < bar[1:])
    assert np.ptp(own.pose.d_v[1:]) > 5 * bar.max()


def test_it_is_taken_for_a_coaxial_press_alone():
    sensor = cylinder(10, 8, 2)
    assert choose_mechanics(sensor, loads=[Wrench(F_z=1.0), Wrench(F_z=2.0)]).name == "axisymmetric"
    assert choose_mechanics(sensor, loads=[Wrench(F_z=1.0), Wrench(F_x=0.5, F_z=2.0)]).name == "block"
    assert choose_mechanics(load_sensor("biorob2018"), loads=[Wrench(F_z=2.0)]).name == "block"


def test_other_scenes_and_loads_are_refused_in_one_line():
    with pytest.raises(SceneError, match="elastomer must be a cylinder under a disc for axisymmetric; got a box under"):
        axisymmetric_pad(load_sensor("biorob2018"))
    with pytest.raises(ValueError, match="wrench: F_x, M must be zero for the model axisymmetric, which takes F_z"):
        axisymmetric_pad(cylinder(10, 8, 2)).equilibrium(Wrench(F_x=0.1, F_z=1.0, M=1e-4))


def test_a_picture_shows_both_halves():
    model = axisymmetric_pad(cylinder(10, 8, 2))
    found = deformed_mesh(model, model.equilibrium(Wrench(F_z=1.0)))
    assert found.points[:, 0].min() == -found.points[:, 0].max() < -5e-3
    (a, b, c, d), way = np.moveaxis(found.points[found.quads], 1, 0), np.array([1.0, -1.0])
    area = 0.5 * ((c - a) * (d - b)[:, ::-1] @ way)
    assert np.all(area > 0.0) and found.J.shape == area.shape
