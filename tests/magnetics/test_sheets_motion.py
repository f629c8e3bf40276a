"""A target that leaves the plane y = 0: dipole by Biot and Savart, scene and target turned together, mirror images."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.constants import mu_0

from sits_mech.geometry.collision import Collision
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Pose
from sits_mech.rotations import rotation_vector
from sits_mech.scene.sensor import Sensor, load_sensor

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def turn(axis: int, angle: float) -> np.ndarray:
    """Rotation about x, y or z by the right hand."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = np.cos(angle)
    R[i, j], R[j, i] = -np.sin(angle), np.sin(angle)
    return R


def posed(R: np.ndarray, c: np.ndarray) -> Pose:
    """Pose of a rotation matrix and a place."""
    (alpha_x, alpha, alpha_z), (d_h, d_y, d_v) = rotation_vector(R), c
    return Pose(d_h, d_v, alpha, d_y, alpha_x, alpha_z)


def two_loops(target: str) -> Sensor:
    """Two single turns of 20 mm radius side by side, under a small target."""
    coils = ", ".join(
        f'{{name="C{k}", centre=[{x}, 0.0], layers=1, turns=1, inner_diameter="39.9 mm", track_width="0.1 mm", '
        'track_thickness="35 um"}' for k, x in ((1, -0.025), (2, 0.025))
    )
    return load_sensor("biorob2018", [f"coils=[{coils}]", f"target={{{target}}}"])


def flux_density(sensor: Sensor, coil: int, point: np.ndarray) -> np.ndarray:
    """B per ampere of a single turn by Biot and Savart's law, the integral around it by the trapezoidal rule [T]."""
    one = sensor.coils[coil]
    a, phi = (one.inner_diameter + one.track_width) / 2, 2 * np.pi * np.arange(400) / 400
    loop = np.column_stack([a * np.cos(phi), a * np.sin(phi), 0.0 * phi - one.track_thickness / 2])
    along = np.column_stack([-np.sin(phi), np.cos(phi), 0.0 * phi]) * 2 * np.pi * a / phi.size
    away = point - loop - [*one.centre, 0.0]
    return mu_0 / (4 * np.pi) * (np.cross(along, away) / np.linalg.norm(away, axis=1)[:, None] ** 3).sum(axis=0)


def test_small_perfect_disc_anywhere_in_space() -> None:
    """Its moment is -8 a^3 H_n / 3 along its normal (Bethe's small hole, by duality), what two coils feel of it

        Delta L_cd = -8 a^3 B_c B_d / (3 mu0),    B the flux density along the normal, per ampere.

    Fields change over some 15 mm: (a / 15 mm)^2 = 1e-3 is left out.
    """
    a, t = 0.5e-3, 1e-8
    sensor = two_loops(f'conductivity=1e12, relative_permeability=1, shape="disc", diameter={2 * a}, thickness={t}')
    R, c = turn(2, 0.7) @ turn(0, 0.6) @ turn(1, 0.4), np.array([-12e-3, 9e-3, 11e-3])
    z = sheets(sensor).impedance(posed(R, c), 1e8)
    normal = [flux_density(sensor, k, c + R[:, 2] * t / 2) @ R[:, 2] for k in (0, 1)]
    expected = -8 * a**3 / 3 / mu_0 * np.outer(normal, normal)
    np.testing.assert_allclose(z.L - z.L0, expected, rtol=3e-3)


@pytest.mark.slow
def test_scene_and_target_turned_together() -> None:
    """A quarter turn of everything about z is nothing; the rectangle, not square, is turned in its own axes."""
    along_x = load_sensor("biorob2018", ['target.length="6 mm"'])
    beside = ["coils.C1.centre=[0, -0.004]", "coils.C2.centre=[0, 0.004]"]
    along_y = load_sensor("biorob2018", ['target.length="6 mm"', *beside])
    R, c = turn(0, 0.05) @ turn(1, -0.03) @ turn(2, 0.1), np.array([0.4e-3, -0.7e-3, 2.2e-3])
    one = sheets(along_x, 1e-2).impedance(posed(R, c), 5e6)
    two = sheets(along_y, 1e-2).impedance(posed(QUARTER @ R, QUARTER @ c), 5e6)
    scale = np.abs(one.L - one.L0).max()
    np.testing.assert_allclose(two.L, one.L, rtol=0, atol=1e-4 * scale)
    np.testing.assert_allclose(two.R, one.R, rtol=0, atol=1e-3 * one.R.max())


def test_mirror_image_in_y_and_the_plane_motion() -> None:
    sensor = load_sensor("biorob2018")
    model, flip = sheets(sensor, 1e-2), np.diag([1.0, -1.0, 1.0])
    R, c = turn(0, 0.05) @ turn(1, -0.03) @ turn(2, 0.1), np.array([0.4e-3, -0.7e-3, 2.2e-3])
    both = np.stack([posed(R, c).components, posed(flip @ R @ flip, flip @ c).components])
    z = model.impedance(Pose.of(both), 5e6)
    np.testing.assert_allclose(z.L[1], z.L[0], rtol=1e-9)
    np.testing.assert_allclose(z.R[1], z.R[0], rtol=1e-7)
    plane = model.impedance(posed(turn(1, 0.03), np.array([0.4e-3, 0.0, 2.2e-3])), 5e6)
    np.testing.assert_allclose(plane.L, model.impedance(Pose(0.4e-3, 2.2e-3, 0.03), 5e6).L, rtol=1e-12)


def test_a_corner_below_the_coil_plane_is_refused() -> None:
    """8 x 8 mm turned about x by 30 degrees at 2 mm: the edge is 4 mm sin(30 deg) = 2 mm deep."""
    model = sheets(load_sensor("biorob2018"), 1e-2)
    with pytest.raises(Collision, match="above the coil plane"):
        model.impedance(Pose(0.0, 2e-3, alpha_x=np.pi / 6 + 1e-3), 5e6)
