"""Potentials of charges and of dipoles on flat triangles: the boundary integrals of a plate's surface.

For triangles i with constant charges and j with constant ones, or with the linear functions l_a of their corners a,

    V_ij = 1/(4 pi) int_i int_j 1/|x - y|,    D_ija = 1/(4 pi) int_i int_j n_y.(x - y)/|x - y|^3 l_a(y).

The inner integrals at a point x, h = n.(x - y) above the triangle's plane, are sums over edges e: with the normals m_e
in the plane outwards, the distances d_e of x's foot inside them, lengths l_e and r, r' to their ends,

    L_e = 2 artanh(l_e / (r + r')),    Omega = int h/r^3,    int 1/r = sum d_e L_e - h Omega,
    int h/r^3 l_a = l_a(foot) Omega - h grad l_a . sum m_e L_e,

Omega the solid angle. Near triangles take Gauss points in the first and these, others Gauss points in both, far ones
in the second alone. Errors of the integrals are 1e-3; of far ones less, as these add to each other, which no finer
division shows: with a third of the distance small discs are 4e-4 to 5e-4 of Delta Z off. The second moments of the
first, 1/8 of its largest radius squared (1/6, if long), are missing, 1/(8 (2 n)^2) of 1/r at n sums of two such radii:
1.4e-4 from n = 15 on.

Source: A. van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125; D. R. Wilton et al., IEEE Trans. Antennas
Propag. 32 (1984) 276.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array

_NEAR, _FAR = 2.0, 15.0  # where triangles stop being near and start being far, in the sum of their largest radii
_HELD = 2_000_000  # pairs at once
_MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])  # of edges: of third order, equal weights
_A, _B = 0.101286507323456, 0.470142064105115  # a corner of the two triples of points of sixth order
_SEVEN = np.array([[1 / 3] * 3, *(np.roll([1 - 2 * c, c, c], k) for c in (_A, _B) for k in range(3))])  # of sixth order
_WEIGHTS = (0.225, *[0.125939180544827] * 3, *[0.132394152788506] * 3)  # of their middle and of the triples


def triangle_potentials(first: Array, second: Array) -> tuple[Array, Array]:
    """Return V (n, m) [m^3] and D (n, m, 3) [m^2] between triangles (n, 3, 3) and (m, 3, 3) [m].

    Corners go counter-clockwise about the normals.
    """
    step = max(1, _HELD // len(second))
    parts = [_potentials(first[k : k + step], second) for k in range(0, len(first), step)]
    V, D = (np.concatenate(each) / (4.0 * np.pi) for each in zip(*parts, strict=True))
    return V, D


def _potentials(X: Array, Y: Array) -> tuple[Array, Array]:
    """Return 4 pi V and 4 pi D of some triangles."""
    (x, size_x, area), (y, size_y, other) = _shape(X), _shape(Y)
    normal = _normals(Y) / (2.0 * other)[:, None]
    at = np.einsum("qa,mak->qmk", _MIDDLES, Y)
    V, D = np.zeros((len(X), len(Y))), np.zeros((len(X), len(Y), 3))
    for q in range(3):
        square = (x**2).sum(1)[:, None] - 2.0 * x @ at[q].T + (at[q] ** 2).sum(1)
        inverse = 1.0 / np.sqrt(np.maximum(square, np.finfo(float).tiny))
        V += inverse / 3.0
        dipole = (x @ normal.T - (at[q] * normal).sum(1)) * inverse**3 / 3.0
        D += dipole[..., None] * _MIDDLES[q]
    V, D = V * other, D * other[:, None]
    apart = np.linalg.norm(x[:, None] - y, axis=2) / (size_x[:, None] + size_y)
    near = np.nonzero(apart < _NEAR)
    V[near], D[near] = _outer(X[near[0]], Y[near[1]], True)
    middle = np.nonzero((apart >= _NEAR) & (apart < _FAR))
    V[middle], D[middle] = _outer(X[middle[0]], Y[middle[1]], False)
    return V * area[:, None], D * area[:, None, None]


def _shape(T: Array) -> tuple[Array, Array, Array]:
    """Return triangles' centres, largest radii about these, and areas."""
    centre = T.mean(axis=1)
    radius = np.linalg.norm(T - centre[:, None], axis=2).max(axis=1)
    return centre, radius, np.linalg.norm(_normals(T), axis=1) / 2.0


def _normals(T: Array) -> Array:
    """Return normals of triangles, twice their areas long."""
    return np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])


def _outer(X: Array, Y: Array, near: bool) -> tuple[Array, Array]:
    """Return means over triangles X of the inner integrals over Y, pair by pair: (p,) and (p, 3)."""
    V, D = np.zeros(len(X)), np.zeros((len(X), 3))
    for point, weight in zip(*((_SEVEN, _WEIGHTS) if near else (_MIDDLES, [1 / 3] * 3)), strict=True):
        v, d = (_inner if near else _sampled)(np.einsum("a,nak->nk", point, X), Y)
        V, D = V + weight * v, D + weight * d
    return V, D


def _sampled(x: Array, Y: Array) -> tuple[Array, Array]:
    """Return the inner integrals by Gauss points, pair by pair."""
    normal = _normals(Y) / 2.0
    r = x[:, None] - np.einsum("qa,nak->nqk", _MIDDLES, Y)
    inverse = 1.0 / np.sqrt((r**2).sum(2)) / 3.0
    dipole = np.einsum("nqk,nk->nq", r, normal) * inverse**3 * 9.0
    return inverse.sum(1) * np.linalg.norm(normal, axis=1), dipole @ _MIDDLES


def _inner(x: Array, Y: Array) -> tuple[Array, Array]:
    """Return the inner integrals in closed form, pair by pair."""
    edge, normal = np.roll(Y, -1, axis=1) - Y, _normals(Y)
    length, twice = np.linalg.norm(edge, axis=2), np.linalg.norm(normal, axis=1)
    r = Y - x[:, None]
    away = np.linalg.norm(r, axis=2)
    m = np.cross(edge / length[..., None], (normal / twice[:, None])[:, None])
    d = (m * r).sum(2)
    h = -(normal * r[:, 0]).sum(1) / twice
    L = 2.0 * np.arctanh(np.minimum(length / (away + np.roll(away, -1, axis=1)), 1.0 - 1e-15))
    volume = (r[:, 0] * np.cross(r[:, 1], r[:, 2])).sum(1)
    corner = away.prod(1) + sum((r[:, k] * r[:, k - 1]).sum(1) * away[:, k - 2] for k in range(3))
    omega = np.where(np.abs(h) > 1e-12 * np.sqrt(twice), -2.0 * np.arctan2(volume, corner), 0.0)
    opposite = np.roll(m * (length / twice[:, None])[..., None], -1, axis=1)  # -grad l_a, of the edge opposite a
    along = np.einsum("pek,pe->pk", m, L)
    linear = np.roll(d * length / twice[:, None], -1, axis=1) * omega[:, None]
    return (d * L).sum(1) - h * omega, linear + h[:, None] * np.einsum("pak,pk->pa", opposite, along)
