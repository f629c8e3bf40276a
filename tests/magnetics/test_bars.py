"""Planar integral model: against an independent FEM, exact solutions, invariants and its own error estimate."""

import numpy as np
import pytest
from common.strip import strip_reaction

from sits_mech.geometry.collision import Collision
from sits_mech.magnetics import bars
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.section.coils import bars_of_coils, free_space_inductance
from sits_mech.quantities import Pose, SolveFailed
from sits_mech.scene.sensor import load_sensor

MM = 1e-3

# NGSolve 6.2, p = 5, radius 20 m (self-convergence 1e-7), confirmed by GetDP 3.2 to 2e-5; per metre of depth.
L0, M12 = 0.00047480313357162, -4.7405988439865e-05
# d_v, d_h [mm], f [Hz], Delta L1, Delta L2, Delta M12 [H/m], R1, R2 [ohm/m]
ISOLATED = [
    (1, 0, 5e3, -1.2689598921607269e-06, -1.2689598921154072e-06, 6.392315755497909e-07, 0.18784622982, 0.18784622982),
    (1, 0, 5e6, -3.994483152940223e-05, -3.9944831526274576e-05, 1.3991454285199589e-05, 51.836221913, 51.836221917),
    (2, 0, 5e3, -6.000927442762491e-07, -6.000927443278571e-07, 3.442411899716089e-07, 0.0842147524, 0.0842147524),
    (2, 0, 5e6, -1.696012066246201e-05, -1.6960120662048495e-05, 7.643219439158008e-06, 21.111396592, 21.111396595),
    (5, 0, 5e3, -3.1700495058595204e-07, -3.1700495057267056e-07, -2.1331758309676936e-07, 0.0273720914, 0.0273720914),
    (5, 0, 5e6, -3.5703584183263714e-06, -3.570358418378847e-06, -9.270677255568654e-07, 3.0513129890, 3.0513129897),
    (2, 2, 5e3, -5.232550057347849e-07, -5.997367846259031e-06, 1.6667088439393363e-06, 0.03841497493, 0.49201650576),
    (2, 2, 5e6, -4.559785394394114e-06, -5.531686111106578e-05, 1.2581211484302178e-05, 6.7166619081, 33.251718933),
]
# R_b [mm], then as above, at d_v = 2 mm, d_h = 0, 5 MHz
RETURNING = [
    (25, -3.0211498005433372e-05, 2.207033815487948e-05, 16.818854984),
    (50, -2.7611887226104356e-05, 1.8605208946658057e-05, 17.773919865),
    (100, -2.578783286786787e-05, 1.6549498114230073e-05, 18.297042269),
    (1000, -2.2516436114938202e-05, 1.320032193911121e-05, 19.197114098),
]


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


def change(sensor, tolerance, pose, frequency):
    z = planar_bars(sensor, tolerance).impedance(pose, frequency)
    return z, z.L - z.L0


def test_free_space_inductance_is_the_closed_form(sensor):
    L = free_space_inductance(sensor)
    assert L[0, 0] == pytest.approx(L0, rel=1e-6)
    assert L[0, 1] == pytest.approx(M12, rel=1e-6)


@pytest.mark.parametrize(
    ("tolerance", "error_L", "error_R"),
    [(1e-2, 1e-2, 1e-1), (1e-3, 1e-3, 1e-2), pytest.param(1e-4, 1e-4, 1e-3, marks=pytest.mark.slow),
     pytest.param(1e-5, 1e-5, 1e-4, marks=pytest.mark.slow)],
)
def test_isolated_plate_against_independent_fem(sensor, tolerance, error_L, error_R):
    for d_v, d_h, f, L1, L2, M, R1, R2 in ISOLATED:
        z, dL = change(sensor, tolerance, Pose(d_h * MM, d_v * MM, 0.0), f)
        np.testing.assert_allclose([dL[0, 0], dL[1, 1], dL[0, 1]], [L1, L2, M], rtol=0, atol=error_L * max(-L1, -L2))
        np.testing.assert_allclose([z.R[0, 0], z.R[1, 1]], [R1, R2], rtol=error_R)


CLOSE = pytest.param(1e-4, 1e-4, 1e-3, marks=pytest.mark.slow)


@pytest.mark.parametrize(("tolerance", "error_L", "error_R"), [(1e-3, 1e-3, 1e-2), CLOSE])
def test_returning_current_against_independent_fem(tolerance, error_L, error_R):
    for radius, L1, M, R1 in RETURNING:
        changes = ['target.net_current="free"', f'target.planar_boundary_radius="{radius} mm"']
        z, dL = change(load_sensor("biorob2018", changes), tolerance, Pose(0.0, 2 * MM, 0.0), 5e6)
        np.testing.assert_allclose([dL[0, 0], dL[0, 1]], [L1, M], rtol=0, atol=error_L * -L1)
        assert z.R[0, 0] == pytest.approx(R1, rel=error_R)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, pytest.param(1e-4, marks=pytest.mark.slow)])
def test_estimated_error_brackets_the_true_one(sensor, tolerance):
    """Never less than half the true error; at most five times it, where it is not far below what was asked for."""
    for d_v, d_h, f, L1, L2, M, R1, R2 in ISOLATED:
        z, dL = change(sensor, tolerance, Pose(d_h * MM, d_v * MM, 0.0), f)
        true_L = np.max(np.abs([dL[0, 0] - L1, dL[1, 1] - L2, dL[0, 1] - M]))
        true_R = np.max(np.abs([z.R[0, 0] - R1, z.R[1, 1] - R2]))
        assert true_L / 2 < z.error_L.max() < max(5 * true_L, 0.2 * tolerance * max(-L1, -L2))
        assert true_R / 2 < z.error_R.max() < max(5 * true_R, 2 * tolerance * max(R1, R2))


@pytest.mark.slow
@pytest.mark.parametrize(
    "pose",
    [
        Pose(0.0, 1 * MM, 0.0), Pose(1.5 * MM, 2 * MM, 0.3),
        pytest.param(Pose(-2 * MM, 1 * MM, -0.15), marks=pytest.mark.slow),
    ],
)
def test_thin_perfect_conductor_is_the_exact_strip(pose):
    thin = load_sensor("biorob2018", ['target.thickness="0.2 um"', "target.conductivity=1.3e12"])  # skin depth 0.2 um
    _, dL = change(thin, 1e-4, pose, 5e6)
    bars = bars_of_coils(thin)
    places, current = zip(*(_filaments(b) for b in bars), strict=True)
    coils = list(zip(places, current, strict=True))
    exact = np.array([[i @ strip_reaction(p, q, pose, 8 * MM) @ j for q, j in coils] for p, i in coils])
    np.testing.assert_allclose(dL, exact, rtol=0, atol=1e-4 * np.abs(exact).max())


def _filaments(bars):
    """4 x 2 Gauss filaments a bar."""
    (gx, wx), (gz, wz) = np.polynomial.legendre.leggauss(4), np.polynomial.legendre.leggauss(2)
    p = bars.x[:, None, None] + bars.width / 2 * gx[:, None] + 1j * (bars.z[:, None, None] + bars.thickness / 2 * gz)
    return p.ravel(), (bars.sign[:, None, None] * wx[:, None] * wz / 4).ravel()


def test_mirrored_pose_swaps_the_coils(sensor):
    d_h, d_v, alpha = np.array([0.3, 1.0, 2.0]) * MM, np.array([1.5, 2.0, 2.5]) * MM, np.array([0.02, -0.1, 0.2])
    model = planar_bars(sensor, 1e-2)
    here, there = model.impedance(Pose(d_h, d_v, alpha), 5e6), model.impedance(Pose(-d_h, d_v, -alpha), 5e6)
    np.testing.assert_allclose(there.L[:, ::-1, ::-1], here.L, rtol=1e-11)
    np.testing.assert_allclose(there.R[:, ::-1, ::-1], here.R, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("free", [False, True])
def test_invariants_over_all_regimes(free):
    changes = ['target.net_current="free"', 'target.planar_boundary_radius="60 mm"'] if free else []
    sensor = load_sensor("biorob2018", changes)
    poses = Pose(np.array([0.0, 1.0, -3.0]) * MM, np.array([0.6, 2.0, 20.0]) * MM, np.array([0.0, 0.1, 0.4]))
    before = np.zeros((3, 2))
    for frequency in np.logspace(0, 8, 9):
        z = planar_bars(sensor, 1e-2).impedance(poses, frequency)
        assert np.all(np.isfinite(z.L)) and np.all(np.isfinite(z.R))
        np.testing.assert_allclose(z.L, np.swapaxes(z.L, -1, -2), rtol=1e-12)
        assert np.all(np.linalg.eigvalsh(z.R) >= -1e-12 * np.abs(z.R).max())
        dL = np.diagonal(z.L - z.L0, axis1=-2, axis2=-1)
        assert np.all(dL <= 0.0) and np.all(dL >= -z.L0[0, 0])
        assert np.all(np.linalg.eigvalsh(z.L) > 0.0)
        assert np.all(dL <= before + 1e-2 * np.abs(dL))  # the plate is divided anew each decade
        before = dL


def test_resistive_limit_goes_with_frequency_squared(sensor):
    pose = Pose(1 * MM, 2 * MM, 0.1)
    one, two = (planar_bars(sensor, 1e-3).impedance(pose, f) for f in (10.0, 20.0))
    np.testing.assert_allclose(two.R, 4 * one.R, rtol=1e-4)
    np.testing.assert_allclose(two.L - two.L0, 4 * (one.L - one.L0), rtol=1e-3)


def test_scaling_all_lengths_scales_nothing_at_equal_skin_ratio(sensor):
    """Planar L is per metre: lengths times s, frequency over s^2 leaves Delta L and R times s^2."""
    big = load_sensor("biorob2018", [
        "target.width=0.016", "target.thickness=0.0004", *(
            f"coils.{k}.{key}={value}" for k in (0, 1) for key, value in (
                ("inner_diameter", 0.0044), ("track_width", 0.0002), ("track_gap", 0.0002), ("track_thickness", 70e-6),
                ("layer_pitch", 170e-6), ("centre", [(-0.008, 0.008)[k], 0.0]),
            )
        ),
    ])
    small = planar_bars(sensor, 1e-2).impedance(Pose(0.5 * MM, 1.9 * MM, 0.05), 4e6)
    large = planar_bars(big, 1e-2).impedance(Pose(1.0 * MM, 3.8 * MM, 0.05), 1e6)
    np.testing.assert_allclose(large.L, small.L, rtol=1e-3)
    np.testing.assert_allclose(large.R, small.R / 4, rtol=1e-2)


def test_far_target_and_no_target_leave_free_space(sensor):
    far = planar_bars(sensor, 1e-2).impedance(Pose(0.0, 50 * MM, 0.0), 5e6)
    np.testing.assert_allclose(far.L, far.L0, rtol=1e-4)
    bare = planar_bars(sensor.model_copy(update={"target": None}), 1e-2).impedance(Pose(0.0, 2 * MM, 0.0), 5e6)
    np.testing.assert_array_equal(bare.L, bare.L0)


def test_batch_equals_single_poses(sensor):
    model = planar_bars(sensor, 1e-3)
    d_v = np.array([[1.2, 1.4], [1.6, 1.9]]) * MM
    batch = model.impedance(Pose(0.2 * MM, d_v, 0.01), 5e6)
    assert batch.L.shape == (2, 2, 2, 2)
    one = model.impedance(Pose(0.2 * MM, d_v[1, 0], 0.01), 5e6)
    np.testing.assert_allclose(batch.L[1, 0] - batch.L0, one.L - one.L0, rtol=2e-4)


def test_refusals(sensor):
    with pytest.raises(Collision, match="coil plane"):
        planar_bars(load_sensor("biorob2018-w15"), 1e-3).impedance(Pose(0.0, 2 * MM, np.radians(20.0)), 5e6)
    with pytest.raises(ValueError, match="frequency"):
        planar_bars(sensor, 1e-3).impedance(Pose(0.0, 2 * MM, 0.0), 0.0)
    with pytest.raises(ValueError, match="coils.C1.centre must be on y = 0 for a section; got y = 1 mm$"):
        planar_bars(load_sensor("biorob2018", ['coils.0.centre=["-4 mm", "1 mm"]']))
    with pytest.raises(ValueError, match="planar_boundary_radius"):
        small = load_sensor("biorob2018", ['target.net_current="free"', 'target.planar_boundary_radius="5 mm"'])
        planar_bars(small).impedance(Pose(0.0, 2 * MM, 0.0), 5e6)


def test_a_plate_too_fine_for_bars_is_refused_before_any_is_solved(monkeypatch):
    """0.2 m over 0.8 mm: the nearer of two preparations does not fit, the farther one would take seconds."""
    sizes = ['target.width="215 mm"', 'coils.C1.turns=3', 'coils.C2.turns=3', "frequency=1e6"]
    solved = []
    own = bars.prepare_plate
    monkeypatch.setattr(bars, "prepare_plate", lambda *given: solved.append(own(*given)))
    with pytest.raises(SolveFailed, match="too many bars|bars and"):
        planar_bars(load_sensor("biorob2018", sizes), 0.2).impedance(Pose(0.0, 0.8 * MM), 1e6)
    assert not solved
