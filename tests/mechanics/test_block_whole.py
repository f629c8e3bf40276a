"""All six components: the half model as a special case, turned loads, the linear limit, refusal."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.control import under
from sits_mech.mechanics.levels import settle
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import Elastomer, Target, load_sensor

MM = 1e-3
MESHES = Path(__file__).parents[2] / "meshes"
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def whole_equilibrium(sensor, wrench):
    """The rest of both halves, under a load in the plane y = 0, too."""
    found, part = settle.last_equilibrium(block_pad(sensor, 1e-2).whole, None, [under(wrench)])[:2]
    assert part == 1.0
    return found


@pytest.fixture(scope="module")
def sensor():
    """A pad of 20 x 20 x 2 mm under 15 x 15 mm; the force acts at the target's upper face."""
    return load_sensor("biorob2018", ['target.width="15 mm"', 'target.length="15 mm"', NEO_HOOKEAN])


@pytest.fixture(scope="module")
def combined(sensor):
    return whole_equilibrium(sensor, Wrench(F_x=1.2, F_z=6.0, M=2e-3))


@pytest.mark.slow
def test_a_load_in_the_plane_is_that_of_the_half_model(sensor, combined):
    half = block_pad(sensor).equilibrium(Wrench(1.2, 6.0, 2e-3))
    assert abs(combined.pose.centre[0] - half.pose.d_h) < combined.error.centre[0] + half.error.d_h
    assert abs(combined.pose.centre[2] - half.pose.d_v) < combined.error.centre[2] + half.error.d_v
    assert abs(combined.pose.rotation[1] - half.pose.alpha) < combined.error.rotation[1] + half.error.alpha
    np.testing.assert_allclose(combined.pose.centre[1], 0.0, atol=1e-10)
    np.testing.assert_allclose(combined.pose.rotation[[0, 2]], 0.0, atol=1e-8)


TURNED = Wrench(F_y=1.2, F_z=6.0, M_x=-2e-3)


@pytest.mark.slow
def test_a_turned_load_turns_the_pose():
    """A square pad and its mesh that are their own image under a quarter turn about z: x to y, y to -x.

    Steps on the third mesh end when the target stays, so that a hundred thousandth of its way is left.
    """
    square = load_sensor("biorob2018", ['target.width="12 mm"', 'target.length="12 mm"', NEO_HOOKEAN])
    along, turned = whole_equilibrium(square, Wrench(F_x=1.2, F_z=6.0, M=2e-3)), whole_equilibrium(square, TURNED)
    np.testing.assert_allclose(turned.pose.centre[[1, 0, 2]], along.pose.centre * [1, -1, 1], rtol=1e-5, atol=4e-9)
    back = turned.pose.rotation[[1, 0, 2]]
    np.testing.assert_allclose(back, along.pose.rotation * [1, -1, 1], rtol=1e-5, atol=1e-6)


@pytest.mark.slow
def test_a_turned_load_turns_the_pose_within_the_error_of_any_mesh(sensor, combined):
    """Under a target that is nearly as wide as its pad the third mesh corrects from a state that is far from rest."""
    turned = whole_equilibrium(sensor, TURNED)
    away = np.abs(turned.pose.centre[[1, 0, 2]] - combined.pose.centre * [1, -1, 1])
    assert np.all(away < turned.error.centre[[1, 0, 2]])
    away = np.abs(turned.pose.rotation[[1, 0, 2]] - combined.pose.rotation * [1, -1, 1])
    assert np.all(away < turned.error.rotation[[1, 0, 2]])


@pytest.mark.slow
def test_twist_of_a_layer_as_wide_as_its_target():
    """Sheared by w x r it resists with mu a^4/(6 t) at most: an edge sheared along itself loses nothing, one sheared
    across as much as 0.2308 t of the width (the closed form of k_x in plane strain)."""
    sides = [f'{part}.{side}="15 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    found = whole_equilibrium(load_sensor("biorob2018", [*sides, NEO_HOOKEAN]), Wrench(M_z=1e-4))
    mu, a, t = 3e4, 15 * MM, 2 * MM
    assert mu * (a - 0.2308 * t) ** 4 / 6 / t < 1e-4 / found.pose.rotation[2] < mu * a**4 / 6 / t
    np.testing.assert_allclose(found.pose.rotation[:2], 0.0, atol=1e-9)


@pytest.mark.slow
def test_all_six_at_once_with_quadratic_convergence(sensor):
    found = whole_equilibrium(sensor, Wrench(0.8, 5.0, 2e-3, -0.6, 1e-3, 3e-3))
    mirrored = whole_equilibrium(sensor, Wrench(0.8, 5.0, 2e-3, 0.6, -1e-3, -3e-3))
    assert found.report.iterations <= 14 and found.report.min_J > 0.0 and found.report.estimated_error < 0.03
    np.testing.assert_allclose(mirrored.pose.centre, found.pose.centre * [1, -1, 1], rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(mirrored.pose.rotation, found.pose.rotation * [-1, 1, -1], rtol=1e-5, atol=1e-9)


@pytest.fixture(scope="module")
def cylinder():
    """A cylinder 15 mm across and 2 mm high under a disc as wide."""
    base = load_sensor("biorob2018", [NEO_HOOKEAN])
    plate = {"shape": "disc", "material": "copper", "diameter": 15 * MM, "thickness": 0.2 * MM}
    pad = {"material": base.elastomer.material, "diameter": 15 * MM, "thickness": 2 * MM}
    parts = {"target": Target.model_validate(plate), "elastomer": Elastomer.model_validate(pad)}
    return base.model_copy(update=parts)


def test_twist_of_a_cylinder(cylinder):
    """Saint-Venant's twist is exact under a bonded disc: M = mu pi a^4 w / (2 t); the volume of the mesh as well."""
    found = whole_equilibrium(cylinder, Wrench(M_z=1e-3))
    assert 1e-3 / found.pose.rotation[2] == pytest.approx(3e4 * np.pi * (7.5 * MM) ** 4 / 2 / (2 * MM), rel=5e-4)
    mesh = bonded_block(cylinder, 2, 2.0, 0.0, whole=True).body.mesh
    assert mesh.inside.weights.sum() == pytest.approx(np.pi * 3.75**2, rel=1e-4)


@pytest.mark.slow
def test_a_round_pad_answers_alike_in_all_directions(cylinder):
    """Though its mesh does not; along x as the half model."""
    half = block_pad(cylinder, 1e-2).equilibrium(Wrench(0.5, 3.0))
    along, across = (whole_equilibrium(cylinder, Wrench(F_x, 3.0, F_y=F_y)) for F_x, F_y in ((0.5, 0.0), (0.3, 0.4)))
    assert along.pose.centre[0] == pytest.approx(half.pose.d_h, abs=half.error.d_h + along.error.centre[0])
    assert along.pose.rotation[1] == pytest.approx(half.pose.alpha, abs=half.error.alpha + along.error.rotation[1])
    shift, turn = along.pose.d_h * np.array([0.6, 0.8]), along.pose.alpha * np.array([-0.8, 0.6])
    np.testing.assert_allclose(across.pose.centre[:2], shift, atol=along.error.d_h)
    np.testing.assert_allclose(across.pose.rotation[:2], turn, atol=along.error.alpha)


def flush(*more):
    """A pad of 8 x 8 mm under a target as large."""
    sides = [f'{part}.{side}="8 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    return load_sensor("biorob2018", [*sides, NEO_HOOKEAN, *more])


@pytest.fixture(scope="module")
def pressed():
    """A flush pad in contact with the target's plane, by the half model."""
    return block_pad(flush(), 1e-2).equilibrium(Wrench(0.0, 8.0))


@pytest.mark.slow
@pytest.mark.parametrize("load", [Wrench(F_y=0.01, F_z=8.0), Wrench(F_z=8.0, M_z=1e-4)])
def test_contact_is_that_of_the_half_model(load, pressed):
    """The heights agree within both errors; without contact the answer says that it is missing."""
    found = whole_equilibrium(flush(), load)
    away = abs(found.pose.centre[2] - pressed.pose.d_v)
    assert away < found.error.centre[2] + pressed.error.d_v
    assert any(note.kind is NoteKind.FACE_TOUCHES and note.known["surface"] == "target" for note in found.report.notes)
    bare = whole_equilibrium(flush('elastomer.contact="never"'), load)
    assert any(note == Note.of(NoteKind.FACE_FOLDS, surface="target") for note in bare.report.notes)


@pytest.mark.slow
def test_contact_is_alike_in_all_directions():
    """A square pad does not know x from y; its moment about y goes with the force along x."""
    along = whole_equilibrium(flush(), Wrench(F_x=0.1, F_z=8.0, M=2e-4))
    across = whole_equilibrium(flush(), Wrench(F_y=0.1, F_z=8.0, M_x=-2e-4))
    assert any(note.known.get("friction") == 0.0 for note in along.report.notes)
    np.testing.assert_allclose(across.pose.centre[[1, 0, 2]], along.pose.centre, atol=1e-9)
    np.testing.assert_allclose(across.pose.rotation[[1, 0, 2]] * [-1.0, -1.0, 1.0], along.pose.rotation, atol=1e-6)


@pytest.mark.slow
def test_contact_that_cannot_be_followed_is_worth_the_whole_displacement(monkeypatch):
    on = settle._on

    def without(line, numbers, *more):
        """Contact that never gets there."""
        found = on(line, range(settle.PAIR), *more)
        return found if numbers[0] < settle.PAIR else found._replace(part=0.0)

    monkeypatch.setattr(settle, "_on", without)
    found = whole_equilibrium(flush(), Wrench(F_y=0.01, F_z=8.0))
    assert found.report.estimated_error == 1.0
    assert any(note.kind is NoteKind.CONTACT_LOST for note in found.report.notes)


@pytest.mark.slow
def test_a_law_beyond_its_stability_is_named():
    """As of the half pad, test_block.py."""
    soft = flush('elastomer.material={law="mooney-rivlin", c10=3e4, c01=-2e4, bulk_modulus=2e7}')
    notes = whole_equilibrium(soft, Wrench(F_y=0.05, F_z=1.0)).report.notes
    assert any(note.kind is NoteKind.LAW_END and abs(note.known["stretch"] - 1.193) < 6e-4 for note in notes)


@pytest.mark.slow
def test_refusals(sensor):
    with pytest.raises(ValueError, match="finite"):
        block_pad(sensor, 1e-2).equilibrium(Wrench(1.0, F_y=np.nan))


@pytest.mark.slow
def test_half_a_mesh_of_the_users_is_refused_beside_the_plane(sensor):
    with pytest.raises(ValueError, match="must be of the whole pad"):
        own = sensor.elastomer.model_copy(update={"mesh": str(MESHES / "box.msh")})
        block_pad(sensor.model_copy(update={"elastomer": own}), 1e-2).equilibrium(Wrench(F_y=1.0))


@pytest.mark.slow
def test_a_slender_pad_is_not_followed_beyond_its_critical_load():
    """Upright and symmetric, Newton's method rests at any load; the half model, which looks too, ends near by."""
    square = [f'{part}.{side}="4 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    slender = load_sensor("biorob2018", [*square, 'elastomer.thickness="8 mm"', NEO_HOOKEAN])
    assert whole_equilibrium(slender, Wrench(F_z=0.07)).report.status == "converged"
    pad = block_pad(slender, 1e-2)
    last, part, reason = settle.last_equilibrium(pad.whole, None, [under(Wrench(F_z=0.09))])[:3]
    assert part < 1.0 and reason == "buckled" and last.wrench.F_z == pytest.approx(part * 0.09)
    np.testing.assert_allclose(last.pose.centre[:2], 0.0, atol=5e-6 * MM)
    assert 0.3 * MM < 8.0 * MM - last.pose.d_v < 0.4 * MM
    for beside in (0.0, 1e-9):
        with pytest.raises(SolveFailed, match="not to F_x = 0 N, F_z = 0.09 N, M = 0 N m.*; .* buckles") as caught:
            pad.equilibrium(Wrench(F_z=0.09, F_y=beside))
        assert any(note.known.get("end") in ("buckled", "sideways") for note in caught.value.report.notes)
        assert caught.value.last.wrench.F_z == pytest.approx(last.wrench.F_z, rel=0.03)
