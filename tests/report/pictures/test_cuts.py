"""What a plane cuts: chords of circles and outlines in closed form; turning plane and part together changes nothing."""

import numpy as np
import pytest

from sits_mech.quantities import Pose
from sits_mech.report.pictures.cuts import Plane, chords, coil_cut, conductor_cut, names_cut, target_cut
from sits_mech.scene.sensor import Conductor, load_sensor

SQUARE = ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
HOLE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


def test_a_coil_beside_the_plane() -> None:
    """Rings of radius r at a distance d are cut at sqrt(r^2 - d^2), the smaller ones not at all."""
    coil = load_sensor("biorob2018").coils[0]
    for d in (0.0, 2e-3):
        corners, sign = coil_cut(coil, Plane(0.0, d))
        assert corners[..., 0].max() == pytest.approx(coil.centre[0] + np.sqrt((coil.outer_diameter / 2) ** 2 - d**2))
        radii = coil.inner_diameter / 2 + (coil.track_width + coil.track_gap) * np.arange(coil.turns) + coil.track_width
        assert len(corners) == 2 * coil.layers * np.sum(radii > d) and np.sum(sign) == 0
        assert np.all(sign * (corners[..., 0].mean(axis=1) - coil.centre[0]) > 0.0)
        assert (corners[..., 1].min(), corners[..., 1].max()) == pytest.approx((-coil.height, 0.0))
    assert names_cut(load_sensor("biorob2018"), Plane(0.0, 5e-3)) == ([], ["C1", "C2"])


def test_straight_tracks() -> None:
    """Of a square, two bars a turn and layer at y = 0, as wide as the track; a plane at an angle cuts them wider."""
    coil = load_sensor("square-4").coils[0]
    corners, sign = coil_cut(coil)
    assert len(corners) == 2 * 4 * 8 and sign.sum() == 0.0
    assert np.ptp(corners[..., 0], axis=1) == pytest.approx(np.full(64, 0.15e-3), rel=1e-9)
    assert np.all(sign * corners[..., 0].mean(axis=1) > 0.0)
    assert (corners[..., 1].min(), corners[..., 1].max()) == pytest.approx((-coil.height, 0.0), abs=1e-12)
    corners, sign = coil_cut(coil, Plane(np.pi / 5, 0.0))
    assert np.ptp(corners[..., 0], axis=1) == pytest.approx(np.full(64, 0.15e-3 / np.cos(np.pi / 5)), rel=1e-9)


def test_a_turned_plane_cuts_a_turned_coil_alike() -> None:
    coil = load_sensor("biorob2018").coils[0]
    c, s = np.cos(0.7), np.sin(0.7)
    x, y = coil.centre
    turned = coil.model_copy(update={"centre": (c * x - s * y, s * x + c * y)})
    for one, other in zip(coil_cut(coil, Plane(0.0, 1e-3)), coil_cut(turned, Plane(0.7, 1e-3)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-15)


def test_on_a_cylinder_tracks_keep_their_distance_from_its_axis() -> None:
    coil = load_sensor("biorob2018").coils[0]
    flat, bent = coil_cut(coil)[0], coil_cut(coil, Plane(), 12e-3)[0]
    np.testing.assert_allclose(np.hypot(bent[..., 0], bent[..., 1] + 12e-3), 12e-3 + flat[..., 1], rtol=1e-12)


def test_chords() -> None:
    """A square with a hole along x and along its diagonal; beside it nothing."""
    np.testing.assert_allclose(chords((SQUARE,), Plane(0.0, 1.5)), [[-2.0, 2.0]])
    np.testing.assert_allclose(chords((SQUARE, HOLE), Plane(0.0, 0.5)), [[-2.0, -1.0], [1.0, 2.0]])
    root = np.sqrt(2.0)
    np.testing.assert_allclose(chords((SQUARE, HOLE), Plane(np.pi / 4)), [[-2 * root, -root], [root, 2 * root]])
    assert chords((SQUARE,), Plane(0.0, 2.5)).shape == (0, 2)


def test_a_fixed_disc() -> None:
    """A disc of 5 mm, cut 1.5 mm from its middle: a chord of 4 mm, but for the corners of its outline."""
    size = {"diameter": 5e-3, "thickness": 1e-3}
    nut = Conductor(name="nut", material="copper", shape="disc", centre=(3e-3, 2e-3, -1e-3), **size)
    (piece,) = conductor_cut(nut, Plane(0.0, 0.5e-3))
    np.testing.assert_allclose(piece, np.array([[1, -1.5], [5, -1.5], [5, -0.5], [1, -0.5]]) * 1e-3, atol=2e-6)


def test_the_target_turns_clockwise() -> None:
    """alpha > 0: the left edge rises, the right one sinks; the bottom's centre stays. alpha_x > 0: +y rises."""
    target = load_sensor("biorob2018").target
    (corners,) = target_cut(target, Pose(1e-3, 2e-3, 0.1))
    np.testing.assert_allclose(corners[:2].mean(axis=0), [1e-3, 2e-3], atol=1e-18)
    assert corners[0, 1] > 2e-3 > corners[1, 1] and corners[3, 1] > corners[0, 1]
    np.testing.assert_allclose(np.linalg.norm(corners[1] - corners[0]), 8e-3)
    (corners,) = target_cut(target, Pose(0.0, 2e-3, alpha_x=0.1), Plane(np.pi / 2))
    assert corners[0, 1] < 2e-3 < corners[1, 1]
