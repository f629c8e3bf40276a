"""What stress does a silicone with a rate and a softening answer to a history of its strain? One material point.

    S'_e = J^(2/3) S_e,  S_e = 2 dW/dC of W(Cbar),   Cbar = J^(-2/3) C            elastic, deviatoric  (S_e : C = 0)
    S'_0 = eta S'_e,     eta = 1 - (1/r) erf((W_max - W)/(m + beta W_max))         softened
    S' = S'_0 + sum_i g_i int_0^t exp(-(t - s)/tau_i) dS'_0(s),   g_i = w_i/(1 - sum w)
    S = J K (J - 1) C^-1 + J^(-2/3) DEV[S'(t)],   DEV[A] = A - (A : C) C^-1/3,    P = F S

with C = F^T F and W_max the largest W that the point has had. The deformation is given, so nothing is solved: elastic
stresses by complex steps of W (of a law of stretches along its axes), and each convolution, by parts, by Gauss' rule
of 12 points on pieces no longer than a fraction of the shortest time. Pieces end at the corners of the path and where W
turns or meets W_max, so that all under the integral is smooth. No law, kinematics or history of the package is used.

Sources: J. C. Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153; R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455
(1999) 2861. Range: any path that starts at rest, F = 1, and is smooth between its corners. Neglected: nothing of the
model. Stresses in Pa, times in s; x, y, z with y out of the plane.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar
from scipy.special import erf

Array = NDArray[np.float64]

_STEP = 1e-30  # of a complex step
_GAUSS = np.polynomial.legendre.leggauss(12)
_SEEN = 41  # samples of W between two corners, among which its turns are looked for


@dataclass(frozen=True)
class Point:
    """A material, in SI.

    Attributes
    ----------
    law : str
        "neo-hookean", "yeoh", "mooney-rivlin" or "ogden".
    constants : mapping
        Of the package's material table.
    bulk_modulus : float
        K [Pa].
    prony : tuple of (float, float)
        Share of the instantaneous stiffness [-] and time [s] of each branch.
    mullins : mapping
        r [-], m [Pa] and beta [-]; empty: none.
    """

    law: str
    constants: Mapping[str, Any]
    bulk_modulus: float
    prony: tuple[tuple[float, float], ...] = ()
    mullins: Mapping[str, float] | None = None


@dataclass(frozen=True)
class Path:
    """A history of the deformation gradient.

    Attributes
    ----------
    time : tuple of float
        Corners, from 0 on [s].
    signals : mapping
        Values at the corners by name, linear between them [-].
    F : tuple of tuple of str
        Rows of the gradient as Python expressions of the signals.
    """

    time: tuple[float, ...]
    signals: Mapping[str, tuple[float, ...]]
    F: tuple[tuple[str, str, str], ...]

    def at(self, t: float) -> Array:
        """Return the gradient at a time [s], shape (3, 3)."""
        now = {name: float(np.interp(t, self.time, values)) for name, values in self.signals.items()}
        return np.array([[float(eval(entry, {"__builtins__": {}}, now)) for entry in row] for row in self.F])


def energy(point: Point, C: Any) -> Any:
    """Return W(Cbar) [Pa] of a right Cauchy-Green tensor, complex ones included, shape (3, 3)."""
    Cbar = np.linalg.det(C) ** (-1.0 / 3.0) * C
    I1 = np.trace(Cbar)
    I2 = 0.5 * (I1 * I1 - np.trace(Cbar @ Cbar))
    c = point.constants
    if point.law == "neo-hookean":
        return 0.5 * c["shear_modulus"] * (I1 - 3.0)
    if point.law == "mooney-rivlin":
        return c["c10"] * (I1 - 3.0) + c["c01"] * (I2 - 3.0)
    if point.law == "yeoh":
        return sum(c[f"c{k}0"] * (I1 - 3.0) ** k for k in (1, 2, 3))
    squares = np.linalg.eigvalsh(Cbar)
    return sum(2 * mu / a**2 * (np.sum(squares ** (a / 2)) - 3.0) for mu, a in zip(c["mu"], c["alpha"], strict=True))


def elastic(point: Point, F: Array) -> tuple[Array, float]:
    """Return S'_e = J^(2/3) 2 dW/dC [Pa], shape (3, 3), and W [Pa]."""
    C = F.T @ F
    J = float(np.linalg.det(F))
    if point.law == "ogden":
        return _along_axes(point, C, J), float(energy(point, C))
    S = np.zeros((3, 3))
    for i in range(3):
        for j in range(i, 3):
            aside = C.astype(complex)
            aside[i, j] += 1j * _STEP  # a symmetric pair moves together: twice the derivative off the diagonal
            aside[j, i] = aside[i, j]
            slope = float(np.imag(energy(point, aside))) / _STEP
            S[i, j] = S[j, i] = (2.0 if i == j else 1.0) * slope
    return J ** (2.0 / 3.0) * S, float(energy(point, C))


def _along_axes(point: Point, C: Array, J: float) -> Array:
    """S'_e of a law of stretches: along the axes of C, the deviator of lambda dW/dlambda over lambda^2."""
    squares, axes = np.linalg.eigh(C)
    isochoric = J ** (-1.0 / 3.0) * np.sqrt(squares)
    push = np.zeros(3)
    for mu, a in zip(point.constants["mu"], point.constants["alpha"], strict=True):
        push += 2.0 * mu / a * isochoric**a
    push -= push.mean()
    return J ** (2.0 / 3.0) * (axes * (push / squares)) @ axes.T


def stresses(point: Point, path: Path, times: Sequence[float], *, parts: float = 4.0) -> tuple[Array, Array]:
    """Return the first Piola stress [Pa] at some times, shape (n, 3, 3), and W_max [Pa] there, shape (n,).

    Parameters
    ----------
    times : sequence of float, length n
        Ascending, the last no later than the path's [s].
    parts : float
        Pieces of the rule in the shortest relaxation time; 20 in the path where there is none.
    """
    ends = _pieces(point, path, times, parts)
    branches = [(w / (1.0 - sum(v for v, _ in point.prony)), tau) for w, tau in point.prony]
    Q = [np.zeros((3, 3)) for _ in branches]
    found, peaks, largest = [], [], 0.0
    wanted = set(times)
    for before, now in zip([0.0, *ends[:-1]], ends, strict=True):
        length = now - before
        peak = max(largest, elastic(point, path.at(0.5 * (before + now)))[1])
        rising = peak > largest

        def softened(t: float, rising: bool = rising, most: float = largest) -> Array:
            S, W = elastic(point, path.at(t))
            return S if rising else _eta(point, W, most) * S

        first, last = softened(before), softened(now)
        at, weights = before + 0.5 * length * (_GAUSS[0] + 1.0), 0.5 * length * _GAUSS[1]
        inner = [softened(t) for t in at] if branches else []
        for k, (g, tau) in enumerate(branches):
            mean = sum(w * np.exp(-(now - t) / tau) * S for w, t, S in zip(weights, at, inner, strict=True)) / tau
            kept = np.exp(-length / tau)
            Q[k] = kept * Q[k] + g * (last - kept * first - mean)
        largest = max(largest, elastic(point, path.at(now))[1]) if rising else largest
        if now in wanted:
            found.append(_piola(point, path.at(now), last + sum(Q, np.zeros((3, 3)))))
            peaks.append(largest)
    if wanted and min(times) == 0.0:
        found, peaks = [np.zeros((3, 3)), *found], [0.0, *peaks]
    return np.array(found), np.array(peaks)


def _piola(point: Point, F: Array, S_own: Array) -> Array:
    """P of the deviatoric history S' [Pa]."""
    C, J = F.T @ F, float(np.linalg.det(F))
    inverse = np.linalg.inv(C)
    deviator = S_own - np.sum(S_own * C) / 3.0 * inverse
    return np.asarray(F @ (J * point.bulk_modulus * (J - 1.0) * inverse + J ** (-2.0 / 3.0) * deviator))


def _eta(point: Point, W: float, largest: float) -> float:
    """Softening below the largest energy."""
    table = point.mullins
    if not table or W >= largest:
        return 1.0
    return 1.0 - float(erf((largest - W) / (table.get("m", 0.0) + table.get("beta", 1.0) * largest))) / table["r"]


def _pieces(point: Point, path: Path, times: Sequence[float], parts: float) -> list[float]:
    """Ends of the pieces on which all is smooth: corners, wanted times, turns of W, W at W_max, and between them."""
    def W(t: float) -> float:
        return elastic(point, path.at(t))[1]

    ends = {*path.time, *times}
    for a, b in zip(path.time[:-1], path.time[1:], strict=True):
        ends |= _turns(W, a, b)
    largest = 0.0
    for a, b in zip(sorted(ends)[:-1], sorted(ends)[1:], strict=True):
        if W(a) < largest < W(b):
            ends.add(float(brentq(lambda t, most=largest: W(t) - most, a, b, xtol=1e-13 * path.time[-1], rtol=1e-14)))
        largest = max(largest, W(b))
    size = min([tau for _, tau in point.prony], default=path.time[-1] * parts / 20.0) / parts
    ordered = sorted(one for one in ends if one <= max(times))
    found: list[float] = []
    for a, b in zip(ordered[:-1], ordered[1:], strict=True):
        count = int(np.ceil((b - a) / size))
        found += [a + (b - a) * k / count for k in range(1, count)] + [b]
    return found


def _turns(W: Callable[[float], float], a: float, b: float) -> set[float]:
    """Times between two corners where W has an extremum."""
    grid = np.linspace(a, b, _SEEN)
    seen = np.array([W(t) for t in grid])
    found = set()
    for k in range(1, _SEEN - 1):
        way = np.sign(seen[k] - seen[k - 1])
        if way * (seen[k + 1] - seen[k]) < 0.0:
            best = minimize_scalar(lambda t, way=way: -way * W(t), bounds=(grid[k - 1], grid[k + 1]), method="bounded",
                                   options={"xatol": 1e-10 * (b - a)})
            found.add(float(best.x))
    return found
