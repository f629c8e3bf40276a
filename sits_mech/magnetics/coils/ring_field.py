"""Vector potential of a coil at points in space, as concentric rings or as the true spiral.

Ring of radius a at height z_k, 1 A, at distance rho from its axis (M of coaxial loops, `loops`, over 2 pi rho; nothing
cancels on the axis):

    A = (-y, x, 0) P,   P = mu0 a^2 (8 / 3 pi) R_D(0, 4 r1 r2 / (r1 + r2)^2, 1) / (r1 + r2)^3,
    r1^2 = (a + rho)^2 + (z - z_k)^2,   r2^2 = (a - rho)^2 + (z - z_k)^2.

P of all the coil's rings together is a smooth function of rho and z: for many points it is tabulated once and
interpolated (bicubic splines on a grid in asinh(rho / radius), with its mirror image, and in ln z).

Straight piece of a spiral along t, from s1 to s2 as seen from the foot of the perpendicular of length p:

    A = t mu0 / (4 pi) [asinh(s2 / p) - asinh(s1 / p)].

The spiral's own inductance takes p^2 + g^2 instead of p^2 along the same stretch of track, g its section's geometric
mean distance from itself, ``ln g = ln(w + h) - 1.5`` (to 0.1 %). Units: V s / (A m), H. The return lead is left out.

Source: Carlson, Numer. Algorithms 10 (1995) 13; Grover, Inductance Calculations (1946).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from scipy.constants import mu_0
from scipy.ndimage import map_coordinates, spline_filter
from scipy.special import elliprd

from sits_mech.geometry.windings import coil_sections, kinds_of, rounded, spiral_path
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil

Potential = Callable[[Array], Array]
_STEP = 0.05  # of the table, in distances to the coil
_PAD = 24  # cells of the table beyond the region, where the spline is not moved by its end


def ring_potential(coil: Coil, points: Array, *, across: int = 1) -> Array:
    """Return A of a coil's rings per ampere.

    Parameters
    ----------
    coil : Coil
    points : ndarray, shape (n, 3)
        [m].
    across : int
        Gauss filaments across each track.

    Returns
    -------
    ndarray, shape (n, 3)
        [V s / (A m)]
    """
    x, y = points[:, 0] - coil.centre[0], points[:, 1] - coil.centre[1]
    profile = _profile(coil, np.hypot(x, y), points[:, 2], across)
    return np.column_stack([-y * profile, x * profile, np.zeros(x.size)])


def _profile(coil: Coil, rho: Array, z: Array, across: int) -> Array:
    """P of the module docstring, all rings in series."""
    rings = coil_sections(coil)
    nodes, weights = np.polynomial.legendre.leggauss(across)
    total = np.zeros(np.broadcast(rho, z).shape)
    for radius, height, width in zip(rings.radius, rings.z, rings.width, strict=True):
        for node, weight in zip(nodes, weights, strict=True):
            a = radius + width / 2 * node
            far, near = np.hypot(a + rho, z - height), np.hypot(a - rho, z - height)
            both = far + near
            total += weight / 2 * a * a / both**3 * elliprd(0.0, 4.0 * far * near / both**2, 1.0)
    return np.asarray(8.0 * mu_0 / (3.0 * np.pi) * total)


def winding_potential(winding: Coil, windings: str, region: tuple[float, float, float]) -> Potential:
    """Return a function that gives A of a coil about z anywhere in a region, (p, 3, q) to (p, c, q); c = 2 without A_z.

    Parameters
    ----------
    winding : Coil
        Its centre plays no part.
    windings : str
        "rings" or "spiral".
    region : tuple of float
        Height from which on the potential is tabulated, greatest height and distance from the axis [m]. What is found
        at a point does not depend on the last two.
    """
    winding = winding.model_copy(update={"centre": (0.0, 0.0)})
    if windings == "spiral":
        path = spiral_path(winding)
        return lambda points: _in_rows(path_potential(path, _in_columns(points)), points)
    if region[1] <= region[0]:
        return lambda points: _in_rows(ring_potential(winding, _in_columns(points), across=2), points)[:, :2]
    return _table(winding, region[0], *(math.ceil(math.log2(size)) for size in region[1:])).potential


@dataclass(frozen=True, eq=False)
class _Table:
    """Spline coefficients of P, even in asinh(rho / scale) and in ln z from `start` on, at steps; P itself below."""

    winding: Coil
    values: Array
    scale: float
    steps: tuple[float, float]
    start: float

    def potential(self, points: Array) -> Array:
        """A_x and A_y at points (p, 3, q), shape (p, 2, q)."""
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        below = z < math.exp(self.start + 0.5 * _PAD * self.steps[1])
        u = np.arcsinh(np.hypot(x, y) * (1.0 / self.scale)) * (1.0 / self.steps[0])
        height = np.log(np.where(below, 1.0, z) if below.any() else z)
        place = np.stack([u, (height - self.start) * (1.0 / self.steps[1])])
        P = map_coordinates(self.values, place, order=3, mode="mirror", prefilter=False)
        if below.any():
            P[below] = _profile(self.winding, np.hypot(x[below], y[below]), z[below], 2)
        return np.stack([-y * P, x * P], axis=1)


def _in_columns(points: Array) -> Array:
    """Points (p, 3, q) as (p q, 3)."""
    return np.swapaxes(points, 1, 2).reshape(-1, 3)


def _in_rows(A: Array, points: Array) -> Array:
    """Vectors (p q, 3) at points (p, 3, q) in their shape."""
    return np.swapaxes(A.reshape(len(points), -1, 3), 1, 2)


@lru_cache(maxsize=16)
def _table(winding: Coil, lowest: float, high: int, reach: int) -> _Table:
    """P of a winding's rings for heights from `lowest` to 2^high and distances up to 2^reach [m].

    Its nodes do not depend on `high` and `reach`, only their number does.
    """
    scale = winding.outer_diameter / 2
    steps = _STEP * min(1.0, lowest / scale), _STEP
    start = math.log(lowest) - _PAD * _STEP
    u = steps[0] * np.arange(math.ceil(math.asinh(2.0**reach / scale) / steps[0]) + _PAD)
    z = np.exp(start + _STEP * np.arange(math.ceil((high * math.log(2.0) - start) / _STEP) + _PAD))
    across = 1 if lowest > 3 * winding.track_width else 2
    profile = _profile(winding, scale * np.sinh(u)[:, None], z, across)
    return _Table(winding, spline_filter(profile, order=3, mode="mirror"), scale, steps, start)


def path_potential(path: Array, points: Array, *, offset: Array | float = 0.0) -> Array:
    """Return A of 1 A along straight pieces between the vertices of `path` (m, 3) at points (n, 3); shape (n, 3).

    `offset` (n or broadcast to (n, m - 1)) is added to the perpendicular distances in square [m].
    """
    start, end = path[:-1], path[1:]
    length = np.linalg.norm(end - start, axis=1)
    t = (end - start) / length[:, None]
    result = np.empty((points.shape[0], 3))
    for first in range(0, points.shape[0], 256):
        some = slice(first, first + 256)
        from_start = points[some, None, :] - start
        along = np.einsum("nmi,mi->nm", from_start, t)
        square = np.einsum("nmi,nmi->nm", from_start, from_start) - along**2
        extra = offset[some] if isinstance(offset, np.ndarray) else offset
        p = np.sqrt(np.maximum(square, 1e-24) + extra**2)
        result[some] = (np.arcsinh((length - along) / p) + np.arcsinh(along / p)) @ t
    return mu_0 / (4 * np.pi) * result


def spiral_inductances(coils: Sequence[Coil], *, points_per_turn: int = 60) -> Array:
    """Return the free-space inductance matrix of coils as spirals [H], shape (n, n); equal pairs computed once."""
    kinds, which = kinds_of(coils)
    paths = [spiral_path(kind, points_per_turn=points_per_turn) for kind in kinds]
    gaps = [np.exp(-1.5) * (kind.track_width + kind.track_thickness) for kind in kinds]
    own = [_linkage(path, path, g, points_per_turn // 4) for path, g in zip(paths, gaps, strict=True)]
    L, known = np.diag([own[k] for k in which]), dict[tuple[int, int, float, float], float]()
    for i, j in combinations(range(len(coils)), 2):
        (one, at), (other, there) = sorted((which[k], coils[k].centre) for k in (i, j))
        pair = one, other, rounded(there[0] - at[0]), rounded(there[1] - at[1])
        if pair not in known:
            first, second = paths[one], paths[other] + (*pair[2:], 0.0)
            known[pair] = (_linkage(first, second) + _linkage(second, first)) / 2
        L[i, j] = L[j, i] = known[pair]
    return L


def _linkage(first: Array, second: Array, g: float = 0.0, near: int = 0) -> float:
    """Flux of the first path's 1 A through the second; pieces within `near` of each other are g apart."""
    step = np.diff(second, axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(2)
    pieces = np.arange(step.shape[0])
    offset = np.where(np.abs(pieces[:, None] - np.arange(first.shape[0] - 1)) <= near, g, 0.0)
    total = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        A = path_potential(first, second[:-1] + (1 + node) / 2 * step, offset=offset)
        total += weight / 2 * float((A * step).sum())
    return total
