"""The guard: the lowest point of the tilted plate, and the fixed plates around it."""

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision, check_clearance, clearance, ground_notes, room
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.sheets import sheets
from sits_mech.notes import NoteKind
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Conductor, load_sensor

MM = 1e-3


@pytest.mark.parametrize(("name", "hits"), [("biorob2018", False), ("biorob2018-w15", True), ("biorob2018-w22", True)])
def test_wide_plates_hit_the_coils_at_20_degrees(name, hits):
    sensor, pose = load_sensor(name), Pose(0.0, 2e-3, np.radians(20.0))
    assert (clearance(sensor, pose) <= 0.0) == hits
    if hits:
        with pytest.raises(Collision, match="alpha = 20 deg"):
            check_clearance(sensor, pose)


def test_clearance_is_the_lowest_corner():
    sensor = load_sensor("biorob2018")
    alpha = np.linspace(-3.0, 3.0, 25)
    corners = np.array([[xi, eta] for xi in (-4e-3, 4e-3) for eta in (0.0, 2e-4)])
    z = 5e-3 - corners[:, :1] * np.sin(alpha) + corners[:, 1:] * np.cos(alpha)
    np.testing.assert_allclose(clearance(sensor, Pose(0.0, 5e-3, alpha)), z.min(axis=0), rtol=1e-12)


def test_a_pose_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match=r"^pose: must be finite numbers; got d_h = nan mm, d_v = 2 mm,"):
        check_clearance(load_sensor("biorob2018"), Pose([0.0, np.nan], 2 * MM, 0.0))


def plate(x, z, *, y=0.0, size=(2.0, 0.2), shape="rectangle"):
    """A fixed plate in millimetres: side or diameter, and thickness."""
    sizes = {"diameter": size[0] * MM} if shape == "disc" else {"width": size[0] * MM, "length": size[0] * MM}
    return Conductor(
        name="nut", material="copper", shape=shape, centre=(x * MM, y * MM, z * MM), thickness=size[1] * MM, **sizes
    )


def with_plate(part, **changes):
    return load_sensor("biorob2018").model_copy(update={"conductors": (part,), "elastomer": None, **changes})


def test_every_model_refuses_a_pose_in_a_fixed_plate_alike():
    """Beside, above and below it, touching or not, the same line with both parts and the place."""
    for part, how in ((plate(4.5, 2.65), "overlaps it by 0.15 mm"), (plate(0.0, 2.8), "touches it"),
                      (plate(5.0, 2.6), "touches it"), (plate(0.0, 2.4), "touches it")):
        said = set()
        for model in (planar_bars, planar_fem, sheets):
            with pytest.raises(Collision) as caught:
                model(with_plate(part), 1e-2).impedance(Pose(0.0, 2.5 * MM), 5e6)
            said.add(str(caught.value))
        (line,) = said
        assert "target must stay clear of conductors.nut, which reaches from z = " in line and how in line
        assert line.endswith("for d_h = 0 mm, d_v = 2.5 mm, alpha = 0 deg")


def test_a_plate_out_of_the_section_counts_too():
    """What the section y = 0 does not cut is in the target's way all the same."""
    with pytest.raises(Collision, match="conductors.nut"):
        planar_bars(with_plate(plate(0.0, 2.6, y=3.0)), 1e-2).impedance(Pose(0.0, 2.5 * MM), 5e6)


@pytest.mark.parametrize(("off", "hits"), [(4.5, True), (4.9, True), (5.1, False)])
def test_round_plates_are_round(off, hits):
    """Discs of 8 and 2 mm touch at 5 mm, wherever around; the boxes around them overlap at 45 degrees up to 7 mm."""
    disc = load_sensor("biorob2018", ['target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}'])
    place = off / np.sqrt(2.0)
    sensor = with_plate(plate(place, 2.6, y=place, shape="disc"), target=disc.target)
    if hits:
        with pytest.raises(Collision, match=r"overlaps it by 0\.\d+ mm"):
            check_clearance(sensor, Pose(0.0, 2.5 * MM))
    else:
        check_clearance(sensor, Pose(0.0, 2.5 * MM))


def test_room_is_the_nearest_of_all():
    """Below the coil plane, beside a plate; one a pose."""
    sensor = with_plate(plate(6.0, 2.6))
    poses = Pose(np.array([0.0, 0.5 * MM, -9.0 * MM]), np.array([2.5, 2.5, 0.3]) * MM)
    np.testing.assert_allclose(room(sensor, poses), [1.0 * MM, 0.5 * MM, 0.3 * MM], rtol=1e-9)


def test_a_wide_target_that_tilts_onto_the_substrate_is_told():
    """30 mm wide, 2.1 mm up on a film of 0.1 mm: the rim reaches the ground at sin(alpha) = 2/15, the coils later."""
    sensor = load_sensor("biorob2018", ['target.width="30 mm"', 'elastomer.standoff="0.1 mm"'])
    slope = np.array([0.99, 1.01]) * 2.0 / 15.0
    above, below = (ground_notes(sensor, Pose(0.0, 2.1 * MM, float(np.arcsin(each)))) for each in slope)
    assert above == () and [(note.kind, note.known) for note in below] == [
        (NoteKind.BELOW_GROUND, {"depth": pytest.approx(0.02 * MM, rel=1e-6)})
    ]
    assert ground_notes(sensor.model_copy(update={"elastomer": None}), Pose(0.0, 0.1 * MM, 1.0)) == ()


def test_outlines_of_fixed_plates_count_with_their_notches_filled():
    """An L beside the target, clear of it by its box, and one whose notch the target would stand in."""
    ell = tuple((x * MM, y * MM) for x, y in ((0, -6), (6, -6), (6, 6), (5, 6), (5, -5), (0, -5)))
    sensor = load_sensor("biorob2018")
    for x, clear in ((10.0, True), (2.0, False)):
        part = Conductor(name="GND", material="copper", shape="outline", centre=(x * MM, 0.0, 3.1 * MM), points=ell,
                         thickness=0.2 * MM)
        among = sensor.model_copy(update={"conductors": (part,)})
        if clear:
            check_clearance(among, Pose(0.0, 3e-3))
            continue
        with pytest.raises(Collision, match="clear of conductors.GND"):
            check_clearance(among, Pose(0.0, 3e-3))
