"""The 3D pad: independent codes, invariants, work and energy, honest refusal."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad, solved_body
from sits_mech.mechanics.element.kernel import deformation, element_forces
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.levels.answer import layer_stretch
from sits_mech.mechanics.pad.solid import bonded_block, pad_parts
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.report.pictures.pad import deformed_section
from sits_mech.scene.sensor import SceneError, load_sensor

MU, MM = 3e4, 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def box(*more, size=15):
    """A pad of 20 x 20 x 2 mm under a square target; the force acts at the bonded face."""
    sides = [f'target.{side}="{size} mm"' for side in ("width", "length")]
    return load_sensor("biorob2018", ["target.load_height=0", *sides, NEO_HOOKEAN, *more])


# NGSolve 6.2 (graded hexahedra Q2/Q1 and Q3/Q2, tetrahedra P3/P2) and FElupe 11.3: kz, kx [N/mm], ka [N mm/rad], all
# to 0.15 % or better; then for F_z = 13 N the sink, for F_x = 1.8 N d_h [mm] and alpha.
KZ, KX, KA = 120.67, 4.482, 1069.5
SINK, D_H, ALPHA = 0.09766, 0.40669, -0.0026803


@pytest.mark.parametrize(
    ("cells", "grading", "allowed"), [(2, 2.5, 0.01), pytest.param(3, 3.0, 0.003, marks=pytest.mark.slow)]
)
def test_small_strain_stiffness(cells, grading, allowed):
    body = bonded_block(box(), cells, grading, 0.0).body
    k = 2.0 * np.linalg.inv(small_strain_compliance(body)[0]) * MU * 2e-3  # both halves [N/m]
    assert k[1, 1] * MM == pytest.approx(KZ, rel=allowed)
    assert k[0, 0] * MM == pytest.approx(KX, rel=allowed)
    assert k[2, 2] * 2e-3**2 / MM == pytest.approx(KA, rel=allowed)


@pytest.fixture(scope="module")
def pad():
    return block_pad(box())


def test_pressed_pose_and_its_error(pad):
    found = pad.equilibrium(Wrench(F_z=13.0))
    sink = (2.0 * MM - found.pose.d_v) / MM
    assert sink == pytest.approx(SINK, abs=5.9e-4)  # the reference's own bar
    assert abs(sink - SINK) * MM < found.error.d_v < 0.05 * SINK * MM
    assert abs(found.pose.d_h) < 1e-10 and abs(found.pose.alpha) < 1e-8
    assert found.report.status == "converged" and 0.0 < found.report.min_J < 1.0
    assert not any(note.kind is NoteKind.TOLERANCE_MISSED for note in found.report.notes)
    strict = block_pad(box(), 1e-4).equilibrium(Wrench(F_z=13.0), start=found)  # on the same meshes
    missed = Note.of(NoteKind.TOLERANCE_MISSED, error=strict.report.estimated_error, tolerance=1e-4)
    assert strict.report.notes[-1] == missed


@pytest.mark.slow
def test_sheared_pose_and_its_error():
    found = block_pad(box(), 3e-3).equilibrium(Wrench(F_x=1.8))
    assert found.pose.d_h / MM == pytest.approx(D_H, abs=1.22e-3)  # the references' own bars
    assert (2.0 * MM - found.pose.d_v) / MM == pytest.approx(-6.65e-4, abs=3.2e-4)
    assert abs(found.pose.d_h / MM - D_H) < found.error.d_h / MM + 1.22e-3 and found.error.d_h / MM < 3e-3 * D_H
    assert abs(found.pose.alpha - ALPHA) < found.error.alpha + 4.6e-5


@pytest.mark.slow
def test_meshes_follow_what_a_goal_takes_of_them(pad):
    """The first two where nothing is seen of the pose; more for d_h alone; from the first two's rest, the same."""
    load = Wrench(F_x=1.8)
    first = pad.rough.equilibrium(load)
    blind = pad.towards(np.zeros((1, 6)), 1e-2).equilibrium(load)
    assert blind.report.unknowns == first.report.unknowns and blind.pose == first.pose
    sees = np.array([[1.0 / first.pose.d_h, 0, 0, 0, 0, 0]])
    asked = 0.5 * first.error.d_h / first.pose.d_h
    from_rest, going_on = (pad.towards(sees, asked).equilibrium(load, start=start) for start in (None, first))
    assert from_rest.report.unknowns > first.report.unknowns and from_rest.error.d_h < first.error.d_h
    np.testing.assert_allclose(going_on.pose.components, from_rest.pose.components, rtol=1e-9, atol=1e-14)
    assert going_on.report.iterations < from_rest.report.iterations


@pytest.mark.slow
def test_mirrored_load_from_a_neighbour_mirrors_the_pose(pad):
    here = pad.equilibrium(Wrench(1.2, 6.0, 2e-3))
    there = pad.equilibrium(Wrench(-1.2, 6.0, -2e-3), start=here)
    assert there.pose.d_h == pytest.approx(-here.pose.d_h, rel=1e-7)
    assert there.pose.d_v == pytest.approx(here.pose.d_v, rel=1e-9)
    assert there.pose.alpha == pytest.approx(-here.pose.alpha, rel=1e-5)


def test_work_is_the_energy_stored():
    body, load = bonded_block(box(), 1, 2.0, 0.0).body, np.array([3.0, 20.0, 1.0])
    factor, weight = np.polynomial.legendre.leggauss(8)
    state, before, work = rest(body), 0.0, 0.0
    for s, w in zip((factor + 1) / 2, weight / 2, strict=True):
        state, before = advance(body, state, Path((before * load, s * load))).state, s
        work -= w * (load @ (state.q * [1, -1, 1]))  # int F du = F u - int u dF
    end = advance(body, state, Path((before * load, load))).state
    work += load @ (end.q * [1, -1, 1])
    found = element_forces(body.mesh, body.laws, end.u)
    assert found.energy == pytest.approx(work, rel=1e-6)


@pytest.mark.slow
def test_length_scales_out():
    small, large = box(size=8), box(
        'elastomer.width="40 mm"', 'elastomer.length="40 mm"', 'elastomer.thickness="4 mm"', size=16
    )
    one = block_pad(small, 0.5).equilibrium(Wrench(0.2, 1.0, 1e-4))
    two = block_pad(large, 0.5).equilibrium(Wrench(0.8, 4.0, 8e-4))
    assert two.pose.d_h == pytest.approx(2.0 * one.pose.d_h, rel=1e-7)
    assert two.pose.alpha == pytest.approx(one.pose.alpha, rel=1e-6)


@pytest.mark.slow
def test_every_law_starts_alike():
    """At small strain only the initial shear modulus counts."""
    laws = ('law="mooney-rivlin", c10=1e4, c01=5e3', 'law="yeoh", c10=1.5e4, c20=300.0, c30=10.0',
            'law="ogden", mu=[2e4, 1e4], alpha=[1.7, -2.6]')
    wrench = Wrench(1e-3, 1e-2)
    first = block_pad(box(), 0.5).equilibrium(wrench)
    for law in laws:
        other = block_pad(box(f"elastomer.material={{{law}, bulk_modulus=3e7}}"), 0.5).equilibrium(wrench)
        assert other.pose.d_h == pytest.approx(first.pose.d_h, rel=1e-4)
        assert 2.0 * MM - other.pose.d_v == pytest.approx(2.0 * MM - first.pose.d_v, rel=1e-3)


def test_zero_load_is_rest(pad):
    found = pad.equilibrium(Wrench())
    assert (found.pose.d_h, found.pose.d_v, found.pose.alpha) == (0.0, 2.0 * MM, 0.0)


def test_largest_stretch_of_a_uniform_strain():
    """Stretched by 1.2, 1 and 0.7 along turned axes: the reciprocal of the last is the largest."""
    body = bonded_block(box(), 1, 2.0, 0.0).body
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    F = turn @ np.diag([1.2, 1.0, 0.7]) @ turn.T
    assert layer_stretch(body, (body.mesh.nodes @ (F - np.eye(3)).T).ravel()).value == pytest.approx(1 / 0.7, rel=1e-9)
    assert layer_stretch(body, np.zeros(body.mesh.nodes.size)).value == pytest.approx(1.0, rel=1e-9)


@pytest.mark.slow
def test_a_law_beyond_its_stability_or_its_data_is_named():
    """Mooney-Rivlin of c10 = 30, c01 = -20 kPa: planar tension loses Drucker's condition at 1.193 (stability.py)."""
    soft = box('elastomer.material={law="mooney-rivlin", c10=3e4, c01=-2e4, bulk_modulus=2e7}', size=8)
    notes = block_pad(soft).equilibrium(Wrench(F_z=1.0)).report.notes
    assert any(note.kind is NoteKind.LAW_END and abs(note.known["stretch"] - 1.193) < 6e-4 for note in notes)
    assert not any(note.kind is NoteKind.LAW_END for note in block_pad(soft).equilibrium(Wrench(F_z=0.01)).report.notes)


def test_a_rest_beyond_the_locking_stretch_is_none():
    """Gent's law has no state from I1 = 3 + j_m on; Newton's method, which goes on beyond, may come to rest there."""
    gent = box('elastomer.material={law="gent", shear_modulus=3e4, j_m=2.0, bulk_modulus=3e7}', size=8)
    body = bonded_block(gent, 1, 2.0, 0.0).body
    for load in (8.0, 30.0):  # the second in one step: beyond
        found = advance(body, rest(body), Path((np.zeros(3), np.array([load, 0.0, 0.0]))), smallest=1e-2)
        assert np.isfinite(element_forces(body.mesh, body.laws, found.state.u).energy)
        F, J = deformation(body.mesh, found.state.u)
        assert float(np.max(J ** (-2 / 3) * (F**2).sum(axis=-1))) < 5.0


@pytest.mark.slow
def test_a_tower_that_buckles_is_refused_by_name():
    square = [f'elastomer.{side}="8 mm"' for side in ("width", "length")]
    tower = block_pad(box('elastomer.thickness="20 mm"', *square, size=8))
    with pytest.raises(SolveFailed, match="F_z = 1 N, M = 0 N m; smallest volume ratio .*; .* buckles") as caught:
        tower.equilibrium(Wrench(F_z=1.0))
    assert any(note.known.get("end") in ("buckled", "sideways") for note in caught.value.report.notes)
    # Haringx's column, clamped and free: GA (sqrt(1 + 4 P_E/GA) - 1)/2, P_E = pi^2 EI/(2 h)^2; bonded ends stiffen it.
    GA, P_E = MU * (8 * MM) ** 2, np.pi**2 * 3 * MU * (8 * MM) ** 4 / 12 / (40 * MM) ** 2
    assert 0.95 < caught.value.last.wrench.F_z / (0.5 * GA * (np.sqrt(1 + 4 * P_E / GA) - 1)) < 1.3


@pytest.mark.slow
def test_too_much_load_is_refused_with_what_was_reached():
    with pytest.raises(SolveFailed, match="could be followed to") as caught:
        block_pad(box(size=8)).equilibrium(Wrench(F_z=300.0))
    assert caught.value.report.status == "load path ended"
    assert 0.0 < caught.value.last.wrench.F_z < 300.0
    assert caught.value.last.report.min_J > 0.0


def test_refusals(pad):
    with pytest.raises(ValueError, match="elastomer"):
        block_pad(box().model_copy(update={"elastomer": None}))
    with pytest.raises(ValueError, match="tolerance"):
        block_pad(box(), 1.0)
    with pytest.raises(ValueError, match="finite"):
        pad.equilibrium(Wrench(np.nan, 1.0))
    points = ((-4e-3, -3e-3), (4e-3, -3e-3), (0.0, 4e-3))
    triangle = box().target.model_copy(update={"shape": "outline", "points": points, "width": None, "length": None})
    with pytest.raises(ValueError, match="disc.*outline"):
        block_pad(box().model_copy(update={"target": triangle}))


def means(pad, found):
    """Mean volume ratio of each cell."""
    body = solved_body(pad, found)
    J = deformation(body.mesh, found.state[1 : 1 + body.mesh.nodes.size])[1]
    return np.average(J, axis=1, weights=body.mesh.inside.weights)


def test_section_for_pictures(pad):
    """At rest it fills the section; under a load it hangs on ground and target."""
    for wrench in (Wrench(), Wrench(0.9, 6.0)):
        found = pad.equilibrium(wrench)
        points, quads, J, *_ = deformed_section(pad, found)
        x, z = np.moveaxis(points[quads], -1, 0)
        area = 0.5 * np.abs(np.sum(x * np.roll(z, -1, axis=1) - z * np.roll(x, -1, axis=1), axis=1))
        assert J.shape == (len(quads),) and J.min() >= found.report.min_J
        mean = means(pad, found)
        assert wrench == Wrench() or J.min() < mean.min() - 0.02  # at a point, beside the target's edge
        assert z.min() == pytest.approx(0.0, abs=1e-12) and np.ptp(x) > 19.9 * MM
        if wrench == Wrench():
            assert area.sum() == pytest.approx(20 * MM * 2 * MM) and np.all(J == pytest.approx(1.0))
        assert np.min(np.hypot(*(points - [found.pose.d_h, found.pose.d_v]).T)) < 0.01 * MM


@pytest.mark.slow
def test_a_slanted_section_fills_the_pad(pad):
    """Of a whole pad at 30 degrees: as long as the pad is there, hanging on the ground; along x as the faces there."""
    found = pad.equilibrium(Wrench(0.2, 1.0, F_y=1e-6))
    points, quads, J, *_ = deformed_section(pad, found, np.pi / 6)
    across = np.ptp(points[np.abs(points[:, 1]) < 1e-9][:, 0])
    assert across == pytest.approx(20 * MM / np.cos(np.pi / 6), rel=2e-3) and J.min() >= found.report.min_J
    straight, near = (deformed_section(pad, found, angle) for angle in (0.0, 1e-6))
    for low in (np.min, np.max):
        assert low(near[0][near[1]], axis=(0, 1)) == pytest.approx(low(straight[0], axis=0), abs=0.02 * MM)
    assert near[2].min() == pytest.approx(straight[2].min(), abs=1e-6)


def test_a_mesh_that_memory_does_not_hold_is_refused_before_it_is_made(monkeypatch):
    """A pillar a thousand times as high as it is wide under a plate ten thousand times as long: 40 GiB."""
    monkeypatch.setattr("sits_mech.mechanics.pad.solid.half_bricks", lambda *_: pytest.fail("meshed"))
    sizes = 'shape="pillars", diameter="50 nm", pitch="0.1 um", thickness="40 um"'
    pillars = f'elastomer={{{sizes}, material="ecoflex-00-30"}}'
    long = 'target={shape="rectangle", width="0.2 um", length="1 mm", thickness="1 mm", material="copper"}'
    with pytest.raises(ValueError, match="^memory: a mesh of .* more than the limit"):
        block_pad(load_sensor("biorob2018", [long, pillars]))


def test_a_hair_is_refused_by_name():
    """2001 mm high and 2 mm thin; 1999 mm is a pad of this model."""
    for thickness in ("2001 mm", "1999 mm"):
        sizes = [f'elastomer.thickness="{thickness}"', 'elastomer.width="2 mm"']
        if thickness == "2001 mm":
            with pytest.raises(SceneError, match="elastomer.thickness: must be at most 1000 times"):
                pad_parts(load_sensor("biorob2018", sizes))
        else:
            assert pad_parts(load_sensor("biorob2018", sizes))
