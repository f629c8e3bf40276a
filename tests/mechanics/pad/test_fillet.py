"""Edge radius: exact area, orthonormal pressures, the mesh's rate restored, its effect on the pose, refusals."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element.kernel import deformation
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance
from sits_mech.mechanics.faces.surface import edge_points
from sits_mech.mechanics.layer import planar_layer
from sits_mech.mechanics.linear import linear_layer
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body, side_faces
from sits_mech.notes import NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def pad(W, w, t, *more):
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", NEO_HOOKEAN, *sizes, *more])


def radius(r):
    return f'elastomer.edge_radius="{r} mm"'


@pytest.mark.parametrize(("sizes", "arcs"), [((15, 15, 3), 4), ((20, 15, 3), 2)])
def test_mesh_has_the_area_and_the_sides_of_the_fillets(sizes, arcs):
    """An arc of radius r sweeps 60 degrees: its segment's area in closed form."""
    r, area = 0.9 / 3, sizes[0] / 3
    c, angle = r * np.sin(np.pi / 3), np.pi / 3
    flare = r * c - 0.5 * r**2 * (angle + np.sin(angle) * np.cos(angle))  # beyond the drawn-in face, of one arc
    mesh = bonded_body(pad(*sizes, radius(0.9)), SectionFineness(12, 1.5)).mesh
    assert mesh.inside.weights.sum() == pytest.approx(area - r + arcs * flare, rel=1e-6)
    straight = (2.0 if arcs == 4 else 1.0) * c
    length = 2.0 * (arcs / 2 * angle * r + 1.0 - straight)
    assert edge_points(mesh, side_faces(mesh)).weight.sum() == pytest.approx(length, rel=1e-5)
    ones = np.einsum("emq,enq,eq->emn", mesh.chi, mesh.chi, 1.0 / mesh.inside.weights)
    np.testing.assert_allclose(ones, np.broadcast_to(np.eye(3), ones.shape), atol=1e-9)
    gradient = np.array([[0.1, -0.3], [0.2, 0.4]])
    F, _ = deformation(mesh, (mesh.nodes @ gradient.T).ravel())
    np.testing.assert_allclose(F, np.broadcast_to((np.eye(2) + gradient).ravel(), F.shape), atol=1e-10)


def test_uniform_meshes_converge_as_at_a_smooth_edge():
    """Sharp corners give h**1.19; 30 degrees at the bond allow h**2.9 (exponent 1.47)."""
    stiffness = []
    for cells in (4, 8, 16):
        body = bonded_body(pad(4, 4, 2, radius(0.8)), SectionFineness(cells, 1.0))
        stiffness.append(1.0 / np.diag(small_strain_compliance(body)[0]))
    away = np.abs(np.diff(stiffness, axis=0))
    assert np.all(np.log2(away[0] / away[1])[1:] > 2.0)  # compression, tilt; in shear corners count for little


@pytest.mark.parametrize("r", [0.2, 0.9])
def test_pose_moves_as_the_note_says(r):
    """At 1 % of strain, as the note is of small strain."""
    wrench = Wrench(5.0, 30.0)
    sharp, rounded = (planar_layer(pad(15, 15, 3, *more), 1e-3).equilibrium(wrench) for more in ((), (radius(r),)))
    assert max(rounded.report.estimated_error, sharp.report.estimated_error) < 1e-3
    told = next(note for note in rounded.report.notes if note.kind is NoteKind.EDGE_RADIUS)
    d_h, sink = told.known["d_h"], -told.known["d_v"]
    assert d_h == pytest.approx(rounded.pose.d_h - sharp.pose.d_h, rel=0.1)
    assert sink == pytest.approx(sharp.pose.d_v - rounded.pose.d_v, rel=0.5)
    assert not any(note.kind is NoteKind.EDGE_RADIUS for note in sharp.report.notes)


@pytest.mark.slow
def test_edge_of_a_narrower_target_stays_sharp_and_other_models_leave_the_radius_out():
    scene = pad(20, 15, 3, radius(0.5))
    for layer in (planar_layer(scene, 2e-2), linear_layer(scene)):
        notes = layer.equilibrium(Wrench(10.0, 100.0)).report.notes
        assert any(note.kind is NoteKind.EDGE_SHARP for note in notes)
    found = block_pad(load_sensor("biorob2018", [radius(0.2)])).equilibrium(Wrench(0.1, 0.5))
    assert any(note.kind is NoteKind.EDGE_LEFT_OUT for note in found.report.notes)


TOO_LARGE_OR_SMALL = [((15, 15, 3), 1.6), ((15, 15, 3), 0.1), ((15.5, 15, 3), 0.6), ((20, 15, 3), 4.0)]


@pytest.mark.parametrize(("sizes", "r"), TOO_LARGE_OR_SMALL)
def test_radius_that_does_not_fit_is_refused(sizes, r):
    with pytest.raises(ValueError, match="edge_radius: must lie between"):
        planar_layer(pad(*sizes, radius(r)))
