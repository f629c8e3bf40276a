"""References of one material point with a history: the stored file, closed forms, limits of slow and of sudden."""

import json
from pathlib import Path as File

import numpy as np
import pytest
from common import history_points
from common.history_points import Path, Point, stresses
from scipy.integrate import solve_ivp
from scipy.special import erf

STORED = json.loads((File(history_points.__file__).parent / "reference_points.json").read_text("utf-8"))["rows"]
MU, K = 30e3, 3e6
SHEAR = (("1", "0", "s"), ("0", "1", "0"), ("0", "0", "1"))


def shear(time, gamma):
    """Simple shear along x of planes that face z, linear between corners."""
    return Path(tuple(time), {"s": tuple(gamma)}, SHEAR)


def neo(**more):
    return Point("neo-hookean", {"shear_modulus": MU}, K, **more)


@pytest.mark.slow
def test_stored_rows_are_those_of_the_code():
    """Every fifth row again, coarser: path, material and stresses; the quadrature is converged in all."""
    assert len(STORED) == 36 and all(one["error"] < 1e-12 for one in STORED)
    for one in STORED[::5]:
        path = Path(tuple(one["corners"]), {k: tuple(v) for k, v in one["signals"].items()}, tuple(one["F"]))
        branches = tuple((branch["weight"], branch["time"]) for branch in one["prony"])
        point = Point(one["law"], one["constants"], one["bulk_modulus"], branches, one["mullins"])
        found, largest = stresses(point, path, one["time"][:6], parts=2.0)
        stored = np.array(one["P"][:6]).reshape(-1, 3, 3)
        assert found == pytest.approx(stored, abs=1e-9 * np.abs(one["P"]).max())
        assert largest == pytest.approx(one["W_max"][:6], rel=1e-9)


def test_shear_of_neo_hooke_at_even_rate():
    """``S'_e,xz = mu (gamma + gamma^3/3)``, ``S'_e,zz = -mu gamma^2/3``: closed convolutions.

    P_xz = S_xz + gamma S_zz, after DEV at the present shear.
    """
    g, tau, T, end = 0.25, 0.5, 0.8, 0.4
    a = end / T
    (P,), _ = stresses(neo(prony=((0.2, tau),)), shear((0.0, T), (0.0, end)), [T])

    def past(n):
        """``int_0^T exp(-(T - s)/tau) d(a s)^n``."""
        moments = [-tau * np.expm1(-T / tau)]
        for k in range(1, n):
            moments.append(tau * (T**k - k * moments[-1]))
        return a**n * n * moments[n - 1]

    xz = MU * ((end + end**3 / 3.0) + g * (past(1) + past(3) / 3.0))
    zz = MU * (-(end**2) / 3.0 + g * (-past(2) / 3.0))
    xx = MU * (-4.0 * end**2 / 3.0 - end**4 / 3.0 + g * (-4.0 * past(2) / 3.0 - past(4) / 3.0))
    yy = MU * (-(end**2) / 3.0 - g * past(2) / 3.0)
    rest = (xx + 2.0 * end * xz + (1.0 + end**2) * zz + yy) / 3.0  # S' : C over three
    S_xz, S_zz = xz + rest * end, zz - rest
    assert P[0, 2] == pytest.approx(S_xz + end * S_zz, rel=1e-12)
    assert P[2, 2] == pytest.approx(S_zz, rel=1e-12)


@pytest.mark.slow
def test_slow_and_sudden_loads_are_elastic():
    """After a very long time the law, at once 1/(1 - sum w) times its deviator."""
    (rest,), _ = stresses(neo(), shear((0.0, 1.0), (0.0, 0.3)), [1.0])
    viscous = neo(prony=((0.2, 0.5), (0.1, 1.0)))
    (slow,), _ = stresses(viscous, shear((0.0, 1.0, 30.0), (0.0, 0.3, 0.3)), [30.0])
    (fast,), _ = stresses(viscous, shear((0.0, 1e-7), (0.0, 0.3)), [1e-7])
    assert slow == pytest.approx(rest, abs=1e-8 * MU)
    assert fast == pytest.approx(rest / 0.7, abs=1e-6 * MU)


def test_a_point_below_its_peak_is_softer():
    """Half way back ``W = W_max/4`` in shear of neo-Hooke: eta = 1 - erf(3/4)/r; beyond the peak it is virgin again."""
    soft = neo(mullins={"r": 2.5, "m": 0.0, "beta": 1.0})
    path = shear((0.0, 1.0, 2.0, 4.0), (0.0, 0.3, 0.0, 0.6))
    found, largest = stresses(soft, path, [0.5, 1.5, 2.5, 3.5])
    assert largest == pytest.approx(0.5 * MU * np.array([0.15, 0.3, 0.3, 0.45]) ** 2)
    eta = 1.0 - erf(0.75) / 2.5
    assert found[1] == pytest.approx(eta * found[0], abs=1e-9 * MU) and found[2] == pytest.approx(found[1])
    virgin, _ = stresses(neo(), path, [3.5])
    assert found[3] == pytest.approx(virgin[0])


@pytest.mark.slow
def test_branches_follow_their_equation():
    """``Q' = g dS'_0/dt - Q/tau`` by Runge-Kutta, stress as the file has it: pulled, back, with softening."""
    one = next(row for row in STORED if row["name"].startswith("yeoh, softened, viscous: space, pulled twice"))
    path = Path(tuple(one["corners"]), {k: tuple(v) for k, v in one["signals"].items()}, tuple(one["F"]))
    point = Point("yeoh", one["constants"], one["bulk_modulus"])

    def lambda_of(t):
        return float(path.at(t)[2, 2])

    def softened(t):
        """S'_0,zz: stress along the pull; W_max is at 1 s, until the second pull passes it at 3 s."""
        S, W = history_points.elastic(point, path.at(t))
        largest = history_points.elastic(point, path.at(min(t, 1.0) if t <= 3.0 else t if t <= 3.5 else 3.5))[1]
        return S[2, 2] * (1.0 - float(erf((largest - W) / max(largest, 1e-30))) / 2.5)

    w, tau = (np.array([branch[key] for branch in one["prony"]]) for key in ("weight", "time"))
    g, z = w / (1.0 - w.sum()), np.zeros(2)  # z: exp-weighted mean of S'_0, Q = g (S'_0 - z)
    for a, b in ((0.0, 1.0), (1.0, 2.0), (2.0, 3.0)):
        z = solve_ivp(lambda t, z: (softened(t) - z) / tau, (a, b), z, rtol=1e-9, atol=1e-6, method="DOP853").y[:, -1]
    at = one["time"].index(3.0)
    S_zz = softened(3.0) + float(g @ (softened(3.0) - z))
    stretch, x = lambda_of(3.0), np.zeros(2)  # S'_0 : C = 0, so that S'_0,xx = -lambda^3 S'_0,zz/2 at each time
    for a, b in ((0.0, 1.0), (1.0, 2.0), (2.0, 3.0)):
        x = solve_ivp(lambda t, x: (-0.5 * lambda_of(t) ** 3 * softened(t) - x) / tau, (a, b), x, rtol=1e-9, atol=1e-6,
                      method="DOP853").y[:, -1]
    S_xx = -0.5 * stretch**3 * softened(3.0)
    S_xx += float(g @ (S_xx - x))
    rest = (2.0 * S_xx / stretch + S_zz * stretch**2) / 3.0
    P_zz = stretch * (S_zz - rest / stretch**2)
    assert np.array(one["P"][at]).reshape(3, 3)[2, 2] == pytest.approx(P_zz, rel=1e-6)
