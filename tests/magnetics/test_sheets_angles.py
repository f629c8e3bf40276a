"""Fixed plates at an angle: as a target in that pose, in a scene that is turned, beside a coil as its mirror image."""

from typing import Any

import numpy as np
import pytest

from sits_mech.geometry.collision import Collision, check_clearance, placed_plates
from sits_mech.magnetics.axis_fem import axisymmetric_fem
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.omitted.remote import remote_bounds
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Impedance, Pose
from sits_mech.rotations import rotation_matrix, rotation_vector
from sits_mech.scene.sensor import SceneError, Sensor, scene_text, sensor_from

MM = 1e-3
COIL = {
    "name": "C", "centre": [0, 0], "layers": 2, "turns": 6, "inner_diameter": 2.2 * MM, "track_width": 0.1 * MM,
    "track_gap": 0.1 * MM, "track_thickness": 35e-6, "layer_pitch": 85e-6,
}
PLATE = {"conductivity": 5.8e7, "shape": "rectangle", "width": 6 * MM, "length": 4 * MM, "thickness": 0.2 * MM}
REST = Pose(0.0, 1 * MM)


def scene(*fixed: dict[str, Any], coils: tuple[dict[str, Any], ...] = (COIL,), **more: Any) -> Sensor:
    """Coils among fixed plates."""
    return sensor_from({"name": "angles", "frequency": 1e6, "coils": list(coils), "conductors": list(fixed)} | more)


def fixed(place: Any, turned: tuple[float, float, float] = (0.0, 0.0, 0.0), **more: Any) -> dict[str, Any]:
    """A plate about its middle [m], turned by (alpha_x, alpha, alpha_z)."""
    angles = dict(zip(("alpha_x", "alpha", "alpha_z"), turned, strict=True))
    return PLATE | angles | {"name": "P", "centre": [float(x) for x in place]} | more


def change(found: Impedance) -> complex:
    """Return Delta L - j R / omega of the first pose [H]."""
    L, R = (np.ravel(each)[0] for each in (found.L - found.L0, found.R))
    return complex(L, -R / (2 * np.pi * found.frequency))


@pytest.mark.parametrize(
    "mu_r, sigma, rel", [(1.0, 5.8e7, 1e-3), pytest.param(100.0, 5e6, 1e-2, marks=pytest.mark.slow)]
)
def test_a_fixed_plate_is_a_target_in_its_pose(mu_r: float, sigma: float, rel: float) -> None:
    """Sheets at rest are found on other ways than in poses, also of steel."""
    metal = {"relative_permeability": mu_r, "conductivity": sigma}
    turned, middle = (-0.15, 0.25, 0.4), np.array([1.0, -0.5, 2.0]) * MM
    x, y, z = middle - rotation_matrix(np.array(turned))[:, 2] * 0.1 * MM
    pose = Pose(x, z, turned[1], y, turned[0], turned[2])
    still = change(sheets(scene(fixed(middle, turned, **metal)), 1e-2).impedance(REST, 1e6))
    moved = change(sheets(scene(target=PLATE | metal), 1e-2).impedance(pose, 1e6))
    assert still.real == pytest.approx(moved.real, rel=rel) and still.imag == pytest.approx(moved.imag, rel=2 * rel)


@pytest.mark.slow
def test_a_scene_may_be_turned_as_a_whole() -> None:
    """A tilted plate over a D, about z."""
    drawn = {key: item for key, item in COIL.items() if key != "inner_diameter"}
    drawn |= {"shape": "D", "inner_width": 2 * MM, "inner_length": 3 * MM, "turns": 3}
    found = []
    for angle in (0.0, 0.6):
        G = rotation_matrix(np.array([0.0, 0.0, angle]))
        turned = rotation_vector(G @ rotation_matrix(np.array([0.3, 0.0, 0.0])))
        plate = fixed(G @ [2 * MM, 1 * MM, 1.5 * MM], tuple(turned.tolist()))
        found.append(change(sheets(scene(plate, coils=(drawn | {"alpha_z": angle},)), 1e-2).impedance(REST, 1e6)))
    assert found[0] == pytest.approx(found[1], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["alpha", "alpha_x"])
def test_a_wall_beside_a_coil_mirrors_it(key: str) -> None:
    """Upright, seven skin depths thick: towards a coil that turns alike, mirrored half a skin depth behind its face.

    What walls of 12, 18 and 27 mm lack is 16, 6 and 2 % of it.
    """
    away, sizes = 3 * MM, {"width": 18 * MM, "length": 18 * MM}
    along = 0 if key == "alpha" else 1
    place = np.zeros(3)
    place[along], place[2] = away + 0.1 * MM, -60e-6
    behind = 2 * away + skin_depth(5e6, 5.8e7)
    wall = fixed(place, (0.0, np.pi / 2, 0.0) if along == 0 else (np.pi / 2, 0.0, 0.0), **sizes)
    found = sheets(scene(wall), 1e-2).impedance(REST, 5e6)
    other = COIL | {"name": "D", "centre": [behind * (along == 0), behind * (along == 1)]}
    image = float(free_inductances(scene(coils=(COIL, other)).coils)[0, 1])
    assert image < 0.0 and change(found).real == pytest.approx(0.94 * image, rel=2e-2)


@pytest.mark.parametrize("thin, turned", [("width", (0.0, np.pi / 2, 0.0)), ("length", (np.pi / 2, 0.0, 0.0))])
def test_a_tall_block_is_a_plate_that_stands(thin: str, turned: tuple[float, float, float]) -> None:
    """Whichever side is written as its thickness: the same division, to rounding the same answer."""
    place, t, high = (4.0 * MM, -3.5 * MM, 0.5 * MM), PLATE["thickness"], PLATE[thin]
    block = fixed(place, **{thin: t, "thickness": high})
    one, other = (sheets(scene(part), 1e-1).impedance(REST, 1e6) for part in (block, fixed(place, turned)))
    assert change(one) == pytest.approx(change(other), rel=1e-5) and one.report.unknowns == other.report.unknowns


def test_turned_plates_keep_clear() -> None:
    """Of pad, coils and each other, by their boxes in place; level they would not all."""
    pad = {"elastomer": {"material": "ecoflex-00-30", "width": 6 * MM, "length": 6 * MM, "thickness": 2 * MM}}
    pad |= {"target": PLATE}
    scene(fixed([3.2 * MM, 0.0, 4 * MM], (0.0, np.pi / 2, 0.0)), **pad)
    with pytest.raises(SceneError, match=r"conductors.P must be clear of elastomer, .* overlaps it by 0.0"):
        scene(fixed([3.05 * MM, 0.0, 4 * MM], (0.0, np.pi / 2, 0.0)), **pad)
    with pytest.raises(SceneError, match=r"conductors.P must be clear of coils.C, .* z = -1.\d+ mm to"):
        scene(fixed([0.0, 0.0, 1 * MM], (0.0, 0.8, 0.0)))
    beside = fixed([0.0, 0.0, 3 * MM], name="Q")
    scene(fixed([3.2 * MM, 0.0, 3 * MM], (0.0, np.pi / 2, 0.0)), beside)
    with pytest.raises(SceneError, match="conductors.Q must be clear of conductors.P"):
        scene(fixed([3.2 * MM, 0.0, 3.5 * MM], (0.0, -1.2, 0.0)), beside)


def test_a_target_keeps_clear_of_a_slope() -> None:
    """By 45 degrees above its rim: seen as boxes, and as a disc that is none."""
    sensor = scene(fixed([0.0, 0.0, 8 * MM], (0.0, np.pi / 4, 0.0)), target=PLATE)
    check_clearance(sensor, Pose(0.0, 5 * MM))
    with pytest.raises(Collision, match=r"conductors.P, which reaches from z = 5.808 mm to 10.19 mm"):
        check_clearance(sensor, Pose(0.0, 6.5 * MM))
    disc = PLATE | {"shape": "disc", "diameter": 4 * MM}
    disc = {key: item for key, item in disc.items() if key not in ("width", "length")}
    check_clearance(scene(fixed([0.0, 0.0, 8 * MM], (0.0, np.pi / 4, 0.0)), target=disc), Pose(-1.0 * MM, 6 * MM))


def test_places_of_turned_plates() -> None:
    """The middle stays, the bottom face is below it along the plate's own axis."""
    sensor = scene(fixed([1 * MM, 0.0, 3.5 * MM], (0.0, np.pi / 2, 0.0)))
    (plate,) = placed_plates(sensor, np.zeros((0, 3, 3)), np.zeros((0, 3)))
    np.testing.assert_allclose(plate.places[0], [0.9 * MM, 0.0, 3.5 * MM], atol=1e-12)
    assert plate.windings == pytest.approx(0.5 * MM)


def test_angles_are_written_and_read() -> None:
    """With units, and not at all where they are zero."""
    sensor = scene(fixed([0.0, 0.0, 9 * MM]) | {"alpha": "90 deg"})
    assert sensor.conductors[0].alpha == pytest.approx(np.pi / 2) and "alpha_x" not in scene_text(sensor)
    assert sensor.conductors[0].span == pytest.approx((6 * MM, 12 * MM))
    assert "alpha" not in scene_text(scene(fixed([0.0, 0.0, 9 * MM])))


def test_models_of_a_plane_or_an_axis_say_what_they_do_not_hold() -> None:
    """One line each; a section holds a plate turned in it."""
    pose, turned = Pose(0.0, 1 * MM), {"alpha": 0.3}
    with pytest.raises(SceneError, match=r"conductors.P.alpha_x must be 0 for a section; got 17.19 deg$"):
        planar_bars(scene(fixed([0, 0, 5 * MM], (0.3, 0.0, 0.0)), target=PLATE))
    disc = {key: item for key, item in PLATE.items() if key not in ("width", "length")}
    disc |= {"shape": "disc", "diameter": 4 * MM, "name": "P", "centre": [0, 0, 5 * MM]}
    with pytest.raises(SceneError, match=r"conductors.P.alpha must be 0 for axisymmetric-fem; got 17.19 deg$"):
        axisymmetric_fem(scene(disc | turned))
    still = change(planar_bars(scene(fixed([0.2 * MM, 0.0, 3 * MM], (0.0, 0.3, 0.0)))).impedance(pose, 1e6))
    bottom = np.array([0.2, 3.0]) * MM - 0.1 * MM * np.array([np.sin(0.3), np.cos(0.3)])
    moved = change(planar_bars(scene(target=PLATE)).impedance(Pose(bottom[0], bottom[1], 0.3), 1e6))
    assert still.real == pytest.approx(moved.real, rel=2e-3)


def test_far_turned_plates_are_bounded_by_their_balls() -> None:
    """Above what they do, found by the sheets; and above the bound of their level sisters."""
    near = scene()
    turned = scene(fixed([0.0, 0.0, 20 * MM], (0.0, np.pi / 2, 0.0))).conductors
    level = scene(fixed([0.0, 0.0, 20 * MM])).conductors
    bounds = [float(remote_bounds(near, part, REST).max()) for part in (turned, level)]
    assert bounds[0] > bounds[1] > 0.0
    found = sheets(scene(fixed([0.0, 0.0, 20 * MM], (0.0, np.pi / 2, 0.0))), 1e-2).impedance(REST, 1e6)
    assert abs(change(found)) < bounds[0] * float(found.L0.ravel()[0])
