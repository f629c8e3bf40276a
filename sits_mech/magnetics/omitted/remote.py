"""Bound the change of the coils' inductance by a distant conductor, in closed form.

A conductor K without net current in the coils' field H [1/m, for 1 A] changes their impedance by j omega Delta L with

    |Delta L_cd|^2 <= q_c q_d,    q_c = mu0 <H_c, Q H_c>,

where q_c is what K takes of L_cc as a perfect conductor (B = 0 within) or, permeable, adds with unbounded permeability,
whichever is more. Both grow with the body, so that any body around K bounds K:

    ellipsoid of volume V in a uniform field h:   q = mu0 sum_i alpha_i h_i^2,  alpha_i = V/(1 - N_i), permeable V/N_i,
    ball of volume V, part of H of degree n:      q = mu0 V mean H^2 3/(n + 1),  permeable 3/n, the mean on its surface,

with depolarisation factors N_i = (abc/3) R_D(b^2, c^2, a^2). (A thin disc across the field has the moment 8/3 a^3 h, a
ball 3/2 V h.) What ferrite adds is found by few boxes (`space.ferrite`), and a little more is taken. Elsewhere H is its
value h at the middle and a rest of degrees n >= 2:

    a_c = sqrt(q_c) <= sqrt(mu0 sum_i alpha_i h_i^2) + sqrt(k mu0 V mean (H - h)^2),   k = 1, permeable 3/2.   (1)

The target, or a ball T around it and the plates that are solved, answers to the coils as well. The currents of metal
oppose the field that reaches it, and K sees no more than the coils' own; permeable parts on one side of the coils
double it at most, by their image, g = 2. And T answers to K's currents. Those of unit energy have a moment of at most
sqrt(alpha_i/mu0), whose field on T goes into (1), and a rest, whose field at a distance R is at most

    H^2 = rho^3 [(1 - rho^2/R^2)^-3 - 1] / (2 pi mu0 R^6),   permeable 3/2 of it;   q = mu0 V_T mean H^2 3/2, 3.   (2)

(2) is the sum over n of the second line above for a unit moment at R. Both roots together are kappa. Several far
conductors i, with kappa_ij = (rho_i rho_j)^(3/2) ((R_ij - rho_j)^2 - rho_i^2)^(-3/2) between their balls (permeable
sqrt 2 of it each), change L by at most

    sum_i (g a_i)^2 / (1 - lambda),   lambda = max_i sum_j (kappa_i kappa_j + kappa_ij).

In the section y = 0 [H/m] a circle stands for K: a_c^2 = 2 mu0 pi rho^2 mean H^2, kappa = a rho/(R - rho)^2.
All is infinite where balls meet each other or a coil: near conductors have to be solved.

Of what is so far that less will do, all bodies are balls and a_c^2 = mu0 V (3/2, permeable 3) max H^2, by
the closed forms of `coils.far_field`: where that is below what is `enough`, nothing is integrated.

Range: isolated conductors beside flat coils, any frequency; the resistance changes by omega times the same at most.
Neglected: a spiral's pitch, uneven current in the tracks. That metal does not add to the field on K is no theorem: at
24 places, true changes were 0.5 to 0.8 of these bounds for ferrite, 0.04 to 0.2 for metal, with a target and without.
Sources: Osborn, Phys. Rev. 67 (1945) 351 (N_i); Landau & Lifshitz, Electrodynamics of Continuous Media, art. 4, 54;
Carlson, Numer. Algorithms 10 (1995) 13. The energy grows with the body by Thomson's and Dirichlet's principles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.plates import cut_width
from sits_mech.geometry.tracks import coil_bars
from sits_mech.geometry.windings import kinds_of
from sits_mech.magnetics.coils.far_field import (
    ROUND,
    Body,
    ball_of,
    body_around,
    coil_field,
    dipole_field,
    field_bound,
    sphere,
)
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.permeable.shell_plans import added_inductance
from sits_mech.magnetics.section.coils import free_space_inductance
from sits_mech.quantities import POSE, Array, Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import Coil, Conductor, Sensor

_NEAR = 1.5  # radii of a conductor from its middle to a coil: a nearer one is not bounded
_MOST = 0.5  # of lambda
_FEWER = 1.3  # of what few boxes of ferrite add, and a few percent that they lack


@dataclass(frozen=True)
class _Solved:
    """What is solved: body or None, its middle (p, 3) and rotation (p, 3, 3)."""

    body: Body | None
    middle: Array
    turn: Array


@dataclass(frozen=True)
class _Far:
    """Far conductors: a_c over sqrt(L), (m, n); kappa with what is solved, (p, m), and with each other, (m, m)."""

    own: Array
    to_solved: Array
    to_others: Array


def remote_bounds(
    sensor: Sensor, far: Sequence[Conductor], pose: Pose, *, section: bool = False, enough: float = 0.0
) -> Array:
    """Return how much m far conductors change any entry of L at most, over the largest self-inductance; shape (p, m).

    Infinite where this bound does not hold. `sensor` has flat coils, the target, and as conductors those that are
    solved; `far` are left out together. `section`: what the section y = 0 cuts of them counts as endless along y as
    well. `enough` is a sum over the conductors below which a pose needs no better bound.
    """
    solved = _solved(sensor, pose)
    if not far:
        return np.zeros((len(solved.middle), 0))
    gain, L = _gain(sensor), max(float(free_inductances((coil,))[0, 0]) for coil in kinds_of(sensor.coils)[0])
    found = (
        _together(_by_balls(sensor.coils, far, solved, L), gain) if enough > 0.0
        else np.full((len(solved.middle), len(far)), np.inf)
    )
    if (close := ~(found.sum(axis=1) <= enough)).any():
        found[close] = _together(_in_space(sensor.coils, far, solved, L), gain)[close]
    cut = np.array([cut_width(part) > 0.0 for part in far], dtype=bool)
    if section and cut.any():
        endless = _in_section(sensor, [part for part, is_cut in zip(far, cut, strict=True) if is_cut], solved)
        found[:, cut] = np.maximum(found[:, cut], _together(endless, gain))
    return found


def _together(far: _Far, gain: float) -> Array:
    """Return each part's share of the last formula in space of the module docstring, shape (p, m)."""
    kappa = far.to_solved
    with np.errstate(invalid="ignore"):
        q = np.where(np.isfinite(kappa), (gain * far.own.max(axis=-1)) ** 2, np.inf)
        each = (kappa[:, :, None] * kappa[:, None] + far.to_others).sum(axis=-1).max(axis=-1, initial=0.0)
    holds = (each < _MOST)[:, None] & np.isfinite(q)
    return np.where(holds, q / (1.0 - np.where(each < _MOST, each, 0.0))[:, None], np.inf)


def _solved(sensor: Sensor, pose: Pose) -> _Solved:
    """Return the target in its poses, or the largest ball that holds it and the plates that are solved."""
    poses, target = Pose.of(pose.components.reshape(-1, len(POSE))), sensor.target
    turn, middle, body = rotation_matrix(poses.rotation), poses.centre, None
    if target is not None:
        middle, body = middle + turn[:, :, 2] * target.thickness / 2.0, body_around(target)
    if sensor.conductors:
        parts = [body_around(part) for part in sensor.conductors]
        away = [float(np.linalg.norm(middle - part.centre, axis=1).max()) for part in sensor.conductors]
        radius = max(gap + part.radius for gap, part in zip(away, parts, strict=True))
        parts += [] if body is None else [body]
        body = ball_of(max(radius, *(part.radius for part in parts)), any(part.permeable for part in parts))
    return _Solved(body, middle, turn)


def _gain(sensor: Sensor) -> float:
    """Return g: what the solved parts add to the field on far parts; infinite with permeable ones around the coils."""
    depth = max(coil.height for coil in sensor.coils)
    cores = [part for part in sensor.conductors if part.metal.relative_permeability != 1.0]
    above, below = [part.span[0] > 0.0 for part in cores], [part.span[1] < -depth for part in cores]
    if sensor.target is not None and sensor.target.metal.relative_permeability != 1.0:
        above, below = [*above, True], [*below, False]
    if not above:
        return 1.0
    return 2.0 if all(above) or all(below) else math.inf


def _by_balls(coils: Sequence[Coil], far: Sequence[Conductor], solved: _Solved, L: float) -> _Far:
    """Return far conductors as balls in the largest field that they can be in: the closed forms alone."""
    bodies, middle = [body_around(part) for part in far], np.array([part.centre for part in far])
    own = np.array([
        [field_bound(coil, math.dist(at, (*coil.centre, 0.0)) - body.radius) for coil in coils]
        for at, body in zip(middle, bodies, strict=True)
    ]) * np.sqrt([[mu_0 * (3.0 if body.permeable else 1.5) * body.volume / L] for body in bodies])
    kappa = np.zeros((len(solved.middle), len(far)))
    if solved.body is not None:
        kappa[:] = [_pairs([solved.body, *bodies], np.vstack([at, middle]))[0, 1:] for at in solved.middle]
    return _Far(own, kappa, _pairs(bodies, middle))


def _in_space(coils: Sequence[Coil], far: Sequence[Conductor], solved: _Solved, L: float) -> _Far:
    """Return far conductors as ellipsoids and balls."""
    bodies, middle = [body_around(part) for part in far], np.array([part.centre for part in far])
    own = [[_own_strength(coil, part) for coil in coils] for part in far]
    kappa = [_kappa(body, place, solved) for body, place in zip(bodies, middle, strict=True)]
    return _Far(np.array(own) / math.sqrt(L), np.stack(kappa, axis=-1), _pairs(bodies, middle))


def _pairs(bodies: Sequence[Body], middle: Array) -> Array:
    """Return kappa_ij of bodies' balls, the lower of both ways; infinite where they meet, 0 of one with itself."""
    rho = np.array([body.radius for body in bodies])
    factor = np.array([math.sqrt(2.0) if body.permeable else 1.0 for body in bodies]) * rho**1.5
    from_ball = np.linalg.norm(middle[:, None] - middle, axis=2) - rho
    square = np.where(from_ball > rho[:, None], from_ball**2 - rho[:, None] ** 2, 0.0)
    with np.errstate(divide="ignore"):
        pairs = np.outer(factor, factor) / square**1.5
    np.fill_diagonal(pairs, 0.0)
    return np.minimum(pairs, pairs.T)


@lru_cache(maxsize=256)
def _own_strength(coil: Coil, part: Conductor) -> float:
    """Return a_c of a conductor; infinite where it is near the coil [sqrt(H)]."""
    body, place = body_around(part), np.array(part.centre)
    across = math.dist(place[:2], coil.centre) - 0.5 * coil.outer_diameter
    if math.hypot(max(across, 0.0), max(place[2], -coil.height - place[2], 0.0)) <= _NEAR * body.radius:
        return math.inf
    if body.permeable:
        if part.is_turned:
            return math.inf
        return math.sqrt(_FEWER * float(added_inductance(part, (coil,), part.centre)[0]))
    points, weight = sphere()
    H = coil_field(coil, np.vstack([place, place + body.radius * points]), 1e-3 * body.radius)
    return math.sqrt(mu_0) * float(body.strength(H[0], H[1:], weight))


def _kappa(body: Body, place: Array, solved: _Solved) -> Array:
    """Return kappa of a far conductor and what is solved, shape (p,)."""
    if solved.body is None:
        return np.zeros(len(solved.middle))
    points, weight = sphere()
    from_it = np.swapaxes(solved.turn, 1, 2) @ (solved.middle - place)[:, :, None]  # in the target's own frame
    ball = from_it[:, None, :, 0] + solved.body.radius * points
    best = body.alpha[np.argmin(body.alpha.max(axis=1))]
    moments = np.swapaxes(solved.turn, 1, 2) * np.sqrt(best)  # columns; those of unit energy, times sqrt(mu0)
    square = np.zeros(len(ball))
    for k in range(3):
        m = moments[:, None, :, k]
        h = dipole_field(m, from_it[:, None, :, 0])[:, 0]
        square += solved.body.strength(h, dipole_field(m, ball), weight) ** 2
    R, rho = np.linalg.norm(ball, axis=2), body.radius
    apart = np.linalg.norm(from_it[:, :, 0], axis=1) > solved.body.radius + rho
    inside = np.minimum((rho / R) ** 2, 1.0 - 1e-9)
    rest = (rho**3 * ((1.0 - inside) ** -3.0 - 1.0) / (2.0 * np.pi * R**6)) @ weight * solved.body.volume
    factors = (1.5 if body.permeable else 1.0) * (3.0 if solved.body.permeable else 1.5)
    return np.where(apart, np.sqrt(square) + np.sqrt(factors * rest), np.inf)


def _in_section(sensor: Sensor, far: Sequence[Conductor], solved: _Solved) -> _Far:
    """Return far conductors as circles in the section y = 0."""
    middle = np.array([complex(part.centre[0], part.centre[2]) for part in far])
    rho = np.array([0.5 * math.hypot(cut_width(part), part.thickness) for part in far])
    points = middle + rho * np.exp(2j * np.pi * np.arange(ROUND) / ROUND)[:, None]
    own, L = [], float(np.diag(free_space_inductance(sensor)).max())
    for coil in sensor.coils:
        bars = coil_bars(coil)
        H = ((1.0 / (points[..., None] - (bars.x + 1j * bars.z))) @ bars.sign) / (2.0 * np.pi)
        across = np.maximum(np.abs(middle.real - coil.centre[0]) - 0.5 * coil.outer_diameter, 0.0)
        away = np.hypot(across, np.maximum(np.maximum(middle.imag, -coil.height - middle.imag), 0.0))
        q = 2.0 * mu_0 * np.pi * rho**2 * (np.abs(H) ** 2).mean(axis=0)
        own.append(np.where(away > _NEAR * rho, np.sqrt(q / L), np.inf))
    a = 0.0 if solved.body is None else solved.body.radius
    apart = np.abs((solved.middle[:, 0] + 1j * solved.middle[:, 2])[:, None] - middle) - a - rho
    gap = np.abs(middle[:, None] - middle) - rho - rho[:, None]
    with np.errstate(divide="ignore"):
        kappa = np.where(apart > 0.0, a * rho / apart**2, np.inf)
        pairs = np.where(gap > 0.0, np.outer(rho, rho) / gap**2, np.inf)
    np.fill_diagonal(pairs, 0.0)
    return _Far(np.array(own).T, kappa, pairs)
