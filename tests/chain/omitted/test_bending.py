"""What bending leaves out of an answer: what coils see of a plate, which loads bend it, and what is said of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.models import MECHANICS, choose_mechanics, magnetic_model, mechanical_model, model_of
from sits_mech.chain.omitted.bending import bending, seen_shapes
from sits_mech.chain.omitted.mechanical import mechanical_omissions, with_omissions
from sits_mech.chain.plans.goal import rest_flags
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.magnetics.pose_slopes import lift_slopes
from sits_mech.mechanics.closed_form import HAIR
from sits_mech.mechanics.foil.bending import bonded_plate
from sits_mech.notes import NoteKind, OmissionKind, Relative
from sits_mech.quantities import Array, Pose, Wrench
from sits_mech.report.left_out import line
from sits_mech.report.notes import sentence
from sits_mech.scene.sensor import Coil, SceneError, Sensor, Target, load_sensor

POINT, PRESSED = 'touch={shape="sphere", radius="5 mm"}', Wrench(F_z=1.0)
FOIL, SPOT = 'target.thickness="0.1 mm"', 'touch={shape="pressure", diameter="2 mm"}'
RUBBER = (
    'target={material="copper", shape="rectangle", width="20 mm", length="20 mm", thickness="0.2 mm"}',
    'elastomer={width="20 mm", length="20 mm", thickness="2 mm", material={law="neo-hookean", '
    'shear_modulus="466.8 kPa", bulk_modulus="466.7 MPa"}}',
)
STEEL = ('target.backing_thickness="8 mm"', 'target.backing_modulus="200 GPa"')
BACKED = ('target.backing_thickness="0.8 mm"', 'target.backing_modulus="22 GPa"')


def permeable(sensor: Sensor) -> Sensor:
    """The scene with a target of permeable metal."""
    own = sensor.target.model_dump(exclude_unset=True, exclude={"material", "conductivity"})
    metal = own | {"conductivity": 5.8e7, "relative_permeability": 2.0, "youngs_modulus": 130e9}
    return sensor.model_copy(update={"target": Target.model_validate(metal)})


def test_coils_see_a_permeable_plate_as_one_of_copper() -> None:
    """With more of an error; and where no plate could be divided as its mean, with all of it."""
    sensor = load_sensor("biorob2018-w15")
    plate, pose = bonded_plate(sensor), unloaded_pose(sensor)
    asked = (sensor, pose), (permeable(sensor), pose), (sensor, Pose(0.0, 0.0))
    copper, steel, none = (seen_shapes(scene, plate, there) for scene, there in asked)
    np.testing.assert_array_equal(copper.parts, steel.parts)
    assert 10.0 * copper.off < steel.off < none.off == 1.0
    np.testing.assert_allclose(none.parts[:2], [[0.0, 0.0], [1.0, 1.0]])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "within"), [("biorob2018", 0.01), ("biorob2018-w15", 0.01), ("triaxial-4", 0.01)])
def test_coils_see_a_tilted_plate_by_the_mean_of_its_height(name: str, within: float) -> None:
    """By the lifts of its points as by its motion: dL/dalpha over dL/dd_v of `sheets`."""
    sensor = load_sensor(name)
    plate, (model, _) = bonded_plate(sensor), magnetic_model(sensor, "sheets", 1e-2)
    d, turn = 2e-5, 2e-3
    poses = Pose(np.zeros(4), 2e-3 + d * np.array([1.0, -1.0, 0.0, 0.0]), turn * np.array([0.0, 0.0, 1.0, -1.0]))
    L = np.diagonal(model.impedance(poses, sensor.frequency).L, axis1=1, axis2=2)
    by_height, by_turn = (L[0] - L[1]) / (2.0 * d), (L[2] - L[3]) / (2.0 * turn)
    seen = seen_shapes(sensor, plate, unloaded_pose(sensor)).parts[2]
    np.testing.assert_allclose(seen, by_turn / by_height, rtol=within)


def test_coils_see_a_bowl_by_its_mean_height() -> None:
    """A disc of 8 mm that stands off by 1 mm and by 1 mm + w (r/R)^2: of w coils see 0.453, by NGSolve.

    studies/common/ngsolve_turns.py, bow 0.1 mm and -0.1 mm, over gaps of 1.02 and 0.98 mm, at 5 MHz.
    """
    size = {"inner_diameter": 2.2e-3, "track_width": 1e-4, "track_gap": 1e-4}
    coil = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=12, track_thickness=35e-6, layer_pitch=85e-6, **size)
    disc = Target(conductivity=5.8e7, shape="disc", diameter=8e-3, thickness=2e-4)
    sensor, own = Sensor(name="bowl", frequency=5e6, coils=(coil,), target=disc), load_sensor("triaxial-3")
    plate, pose = bonded_plate(own.model_copy(update={"target": disc})), Pose(0.0, 1e-3)
    bowl = np.linalg.lstsq(plate.upwards, (plate.places**2).sum(axis=1) / 16e-6, rcond=None)[0]
    mean = plate.areas @ np.abs(plate.upwards[:, 6:] @ bowl[6:]) / plate.areas.sum()

    def upwards(places: Array) -> Array:
        """Rise as a whole, and as the bowl of that mesh, whose points do not go in as its slope would take them."""
        found = np.zeros((6, len(places), 2))
        found[0] = np.stack([np.ones(len(places)), (places**2).sum(axis=1) / 16e-6], axis=1)
        return found

    by_lift = seen_shapes(sensor, plate, pose)
    found = lift_slopes(sensor, pose, upwards, np.zeros(2), np.ones(2))[1, 0]
    assert found == pytest.approx(0.453, abs=by_lift.off * mean)
    assert float(bowl @ by_lift.parts[:, 0]) == pytest.approx(0.453, rel=0.03)


@pytest.mark.parametrize(("name", "keys", "load", "model"), [
    ("biorob2018-w22", [], Wrench(F_x=0.1, F_z=0.4), "block"),
    ("biorob2018-w22", [], Wrench(F_x=-0.1, F_z=0.4), "block"),
    ("biorob2018-w22", [], Wrench(F_z=0.4, F_y=0.1), "block"),
    ("triaxial-3", [FOIL, SPOT], PRESSED, "axisymmetric"), ("triaxial-3", [FOIL, SPOT], PRESSED, "block"),
])
def test_what_takes_half_of_the_tolerance_bends(name: str, keys: list[str], load: Wrench, model: str) -> None:
    """The pose goes by what the omission says, as of a rigid target within its error, with less of an error."""
    sensor = load_sensor(name, keys)
    layer, choice = mechanical_model(sensor, model, 1e-2, [load])
    assert choice.bent and not mechanical_model(sensor, model, 0.9, [load])[1].bent
    rigid = model_of(sensor, replace(choice, bent=False), 1e-2)
    bent, left_out = (with_omissions(sensor, [each.equilibrium(load)], model)[0] for each in (layer, rigid))
    (note,) = (note for note in bent.report.notes if note.kind is NoteKind.BENT)
    assert 1e-7 < note.known["deflection"] < 1e-4 and "bends by up to" in sentence(note)
    assert all(item.kind is not OmissionKind.BENDING for item in bent.report.left_out)
    moved, off = (bent.pose.components - left_out.pose.components, bent.error.components + left_out.error.components)
    assert np.all(np.abs(moved[:3]) <= off[:3] + 1e-12) and abs(moved[1]) > 0.01 * (2e-3 - left_out.pose.d_v)


@pytest.mark.parametrize("down", [1.0, 10.0, 20.0, 30.0])
@pytest.mark.parametrize(("backing", "bent"), [((), True), (STEEL, False)])
def test_a_foil_that_bends_by_more_than_it_sinks_bends_under_every_load(
    down: float, backing: tuple[str, ...], bent: bool
) -> None:
    """20 x 20 x 2 mm of rubber, flush under bare copper of 0.2 mm, or with 8 mm of steel glued on it."""
    sensor = load_sensor("biorob2018", [*RUBBER, *backing])
    assert choose_mechanics(sensor, "auto", [Wrench(F_z=down)], 1e-2).bent == bent


def test_a_bent_target_has_the_symmetry_of_its_load_and_less_of_an_error() -> None:
    sensor, load = load_sensor("biorob2018-w22"), Wrench(F_x=0.1, F_z=0.4)
    layer, choice = mechanical_model(sensor, "block", 1e-2, [load])
    right, left = (layer.equilibrium(replace(load, F_x=side * 0.1)) for side in (1.0, -1.0))
    np.testing.assert_allclose(left.pose.components, right.pose.components * (-1, 1, -1, 1, 1, 1), atol=1e-9)
    rigid = model_of(sensor, replace(choice, bent=False), 1e-2).equilibrium(load)
    (whole,) = with_omissions(sensor, [rigid], "block")
    more, before = (each.error.components - rigid.error.components for each in (right, whole))
    assert more[1] < before[1] / 5.0 and more[2] < before[2]


def test_what_is_pressed_at_a_point_bends_more_and_wider_plates_too() -> None:
    """D of a plate goes with the third power of its thickness, what the pad drags with the first: 4 mm are rigid."""
    sizes = {}
    for name in ("biorob2018", "biorob2018-w15", "biorob2018-w22"):
        for keys in ((), (POINT,), (POINT, *BACKED), (POINT, 'target.thickness="4 mm"')):
            (item,) = bending(load_sensor(name, keys), [PRESSED])
            assert (item.kind, item.relative_to) == (OmissionKind.BENDING, Relative.DISPLACEMENT)
            assert item.parts[1] == item.size and not item.included and not item.unbounded and not any(item.parts[2:])
            sizes[name, len(keys) + any("4 mm" in key for key in keys) * 9] = item.size
    narrow, middle, wide = ([sizes[name, k] for k in (0, 1, 3, 11)] for name in dict.fromkeys(key[0] for key in sizes))
    for found in (narrow, middle, wide):
        even, point, backed, thick = found
        assert even < point and thick < 0.05 * backed < 5e-3 * point
    assert narrow[1] < 0.1 * middle[1] < 0.1 * wide[1] and 0.2 < wide[1] < 0.3


def test_each_part_of_a_load_bends_what_it_moves() -> None:
    """Shear tilts and bends oddly, pressing alone evenly; a table holds the largest; a touch aside does both."""
    sensor = load_sensor("biorob2018-w15")
    loads = [PRESSED, Wrench(F_x=0.5), Wrench(F_x=-0.1, F_z=2.0)]
    ((press,), (shear,), (both,)) = (bending(sensor, some) for some in (loads[:1], loads[1:2], loads))
    assert press.parts[1] > 0.0 == press.parts[2] and shear.parts[2] > 0.0 == shear.parts[1]
    np.testing.assert_allclose(both.parts, np.add(press.parts, shear.parts), rtol=1e-9)
    (aside,) = bending(load_sensor("biorob2018-w15", [POINT, 'touch.x="3 mm"']), [PRESSED])
    assert aside.parts[1] > press.parts[1] and aside.parts[2] > shear.parts[2]
    assert bending(sensor, []) == bending(sensor, [Wrench()]) == ()


def test_an_error_holds_it_and_its_line_says_what_bends() -> None:
    sensor = load_sensor("biorob2018-w15", [POINT])
    layer, choice = mechanical_model(sensor, "linear", 1e-2)
    rest = layer.equilibrium(Wrench(F_z=0.1))
    (found,) = with_omissions(sensor, [rest], "linear")
    (item,) = (each for each in found.report.left_out if each.kind == OmissionKind.BENDING)
    sink = 2e-3 - rest.pose.d_v
    assert choice.name == "linear" and found.error.d_v - rest.error.d_v == pytest.approx(item.size * sink, rel=1e-9)
    assert rest_flags(sensor, found, 1e-2) == ("above tolerance",) and found.pose == rest.pose
    assert line(item) == (
        "bending of the target: it is solved as rigid; with a bending stiffness of 0.098 N m it bends by up to "
        "1.7 um; bare: give target.backing_thickness of what it is glued on "
        "(about 0.045 of the displacement, by component)"
    )


def test_what_is_less_than_the_least_error_of_a_model_is_not_listed() -> None:
    """A foil of 8 mm under an even pressure: 1e-5 of what it moves, where meshes reach 5e-4."""
    sensor, loads = load_sensor("biorob2018"), [PRESSED]
    assert 0.0 < bending(sensor, loads)[0].size < MECHANICS["block"].least
    (none,) = (item for item in mechanical_omissions(sensor, "block", loads) if item.kind == OmissionKind.BENDING)
    assert none.size == 0.0 and not any(none.parts) and not none.weighs
    (item,) = (each for each in mechanical_omissions(load_sensor("biorob2018", [POINT]), "block", loads) if each.weighs)
    assert item.kind == OmissionKind.BENDING and item.size > MECHANICS["block"].least


def test_without_a_modulus_a_metal_is_as_soft_as_lead() -> None:
    """What conducts less is not bounded, nor a pad without a mesh; until the scene gives one, by key or by name."""
    own = ('target.conductivity="2e7 S/m"', "target.relative_permeability=1.0")
    bare = {"shape": "rectangle", "width": 8e-3, "length": 8e-3, "thickness": 2e-4, "conductivity": 2e7}
    sensor = load_sensor("biorob2018")
    unknown = sensor.model_copy(update={"target": type(sensor.target).model_validate(bare)})
    (item,) = bending(unknown, [PRESSED])
    lead = sensor.model_copy(update={"target": type(sensor.target).model_validate(bare | {"youngs_modulus": "16 GPa"})})
    assert item.size == bending(lead, [PRESSED])[0].size > bending(sensor, [PRESSED])[0].size
    assert "as soft as lead: give target.youngs_modulus" in line(item)
    ink = type(sensor.target).model_validate(bare | {"conductivity": 1e5})
    (item,) = bending(sensor.model_copy(update={"target": ink}), [PRESSED])
    assert math.isnan(item.size) and item.unbounded
    assert line(item).startswith("bending of the target: what is no metal has no modulus here: give target.youngs")
    (item,) = bending(load_sensor("biorob2018", [f"elastomer.thickness={1.01 * 0.02 * HAIR}"]), [PRESSED])
    assert math.isnan(item.size) and "its pad has no mesh on which it could bend" in line(item)
    known = type(sensor.target).model_validate(bare | {"youngs_modulus": "130 GPa", "poissons_ratio": 0.343})
    sizes = [
        bending(each, [PRESSED])[0].size
        for each in (sensor, sensor.model_copy(update={"target": known}), load_sensor("biorob2018", own))
    ]
    assert sizes[1] == pytest.approx(sizes[2], rel=1e-12) == pytest.approx(sizes[0], rel=0.05)  # coils see more of it


def test_the_stiffness_of_a_backed_target() -> None:
    """Twice the thickness of one metal is eight times as stiff, glued of two; and what a backing lacks is refused."""
    one = load_sensor("biorob2018").target
    assert one.bending_stiffness == pytest.approx(130e9 * 0.2e-3**3 / 12.0 / (1.0 - 0.343**2))
    two = load_sensor("biorob2018", ['target.backing_thickness="0.2 mm"', 'target.backing_modulus="130 GPa"']).target
    assert two.bending_stiffness == pytest.approx(8.0 * one.bending_stiffness)
    for key, missing in (("thickness", "modulus"), ("modulus", "thickness")):
        value = '"1 mm"' if key == "thickness" else '"1 GPa"'
        with pytest.raises(SceneError, match=f"backing_{missing} must be given for a backing; it is missing"):
            load_sensor("biorob2018", [f"target.backing_{key}={value}"])
    with pytest.raises(SceneError, match='target.youngs_modulus: must be a modulus from 1 kPa .*; got "0 GPa"'):
        load_sensor("biorob2018", ['target.youngs_modulus="0 GPa"'])
