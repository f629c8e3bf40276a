"""Correct all poses of a grid of loads by finer meshes at one or two of them.

All loads of a grid are solved on the same two meshes. Extrapolation adds a_k, with its sign, to a component k, and
E_k >= |a_k| is its estimated error; both are large where a mesh is too coarse, so that finer meshes are compared with
these and not with the load. With D_k = finer - first and e_k the finer answer's own error at loads m that are compared,
and w_m weights of how alike a load moves the target (inverse squares of the distance of its displacements, each over
the largest; one in all),

    pose_k += c_k a_k,       c_k = sum_m w_m D_k a_k / sum_m w_m E_k^2,
    error_k = r_k E_k,       r_k = sum_m w_m (|D_k - c_k a_k| + s_k e_k)/E_k,       s = 0.7 of d_v, else 0.9:

of what three meshes own to, a fourth showed 0.21 to 0.65 of d_v and 0.08 to 0.90 of d_h and alpha, under eight loads of
three pads (edges' and cells' terms cancel along z, and the latter was spurious). r_k a_k is shared by all loads with
one sign for each component, and the rest is each load's own. What small strains are off by is in E_k, in proportion to
the load; what is left goes by the squares of displacements, so that beyond those of a load that was compared what that
one tells grows by their squares, and where E_k grows more than in proportion by as much again, at most to one: there
the first meshes' error stands (`biorob2018-w15`, shear alone: D_k/E_k of d_h 0.11 at 0.35 N, 0.37 at 0.7 N). Components
that no load showed take the largest r.

The first meshes overestimate the stretch at bonded edges: less one, the larger share of it that finer ones show at
those loads is taken everywhere.

The loads are the one that moves all components most, so that none of their kind lies beyond, and the one that moves
them in the most different proportion, of those that move it between a half and three quarters as much, where finer
answers are cheaper; next ones where a finer mesh does not get there. Where all go in one proportion one load does. In
space none in contact, guarded or creased: third meshes rest late there and own to more (13 um for 11 under 1 N, 4 N).
Where these move the target so much farther than others that none would lessen the largest error, poses stand, and a
quarter of the farthest load tells the stretch.

Source: D. Shepard, Proc. 23rd ACM Nat. Conf. (1968) 517, the weights; multi-fidelity correction, A. I. J.
Forrester, A. Keane, Prog. Aerosp. Sci. 45 (2009) 50, section 2.3; effectivity of error estimates, M. Ainsworth, J. T.
Oden, Comput. Methods Appl. Mech. Eng. 142 (1997) 1, section 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from sits_mech.chain.plans.prices import OF_ALL
from sits_mech.chain.propagation import poses_of
from sits_mech.mechanics.levels.family import PARTS
from sits_mech.mechanics.loads import Settled
from sits_mech.quantities import POSE, Array, Equilibrium, Pose, Wrench

_NEAR = 0.75  # of the farthest load's displacement, what others move at most: beyond, finer meshes are dear
_LEFT = np.array([0.9, 0.7, 0.9, 0.9, 0.9, 0.9])  # s
_TENTH = 0.1  # of the largest displacement of a component: one that a compared load shows
_MOVES = np.array([True, True, False, True, False, False])  # an angle is what moments leave of each other
_REACH = OF_ALL**-0.5  # times a displacement, how far errors are less than before: what is left goes by its square
_MILD = 0.25  # of the farthest load
_STILL = 1e-3  # of the farthest, a displacement that counts


def corrected_loads(
    settled: Mapping[Wrench, Settled], finer: Callable[[Wrench], Settled], levers: Array, at_rest: Array,
    only: Wrench | None = None,
) -> dict[Wrench, Settled]:
    """Return what comes of loads with poses and errors corrected by finer meshes.

    `finer` solves a load on them, without what its symmetry forbids; `levers`, shape (6,), turn the components of a
    pose into displacements [1, m]; `at_rest`, shape (6,), is the undeformed pose; `only` is a load that is compared for
    the stretch alone. Failed loads, and all where no finer mesh converges, come back unchanged.
    """
    good = {load: one.rest for load, one in settled.items() if one.rest is not None}
    rests = list(good.values())
    poses, errors, added = _numbers(rests)
    apart = [rest.shared[PARTS:] for rest in rests]  # no matter of meshes
    way = (poses - at_rest) * levers
    size = np.max(np.abs(way), axis=1, initial=0.0)
    moved = size > _STILL * np.max(size, initial=0.0)
    asked = [k for k, load in enumerate(good) if moved[k] and only in (None, load)]
    open_to = [k for k in asked if errors[k].any() and comparable(rests[k])]
    chosen, wanted = _telling(way, open_to)
    fine: dict[int, Equilibrium] = {}
    for k in chosen[: 2 * wanted]:
        rest = finer(rests[k].wrench).rest
        if rest is not None and not np.array_equal(rest.pose.components, poses[k]):
            fine[k] = rest
        if len(fine) == wanted:
            break
    if not fine:
        return dict(settled)
    finer_poses, finer_errors, _ = _numbers(list(fine.values()))
    own = list(fine)
    D, E, a = finer_poses - poses[own], errors[own], added[own]
    seen = np.abs(way[own]) > _TENTH * np.abs(way).max(axis=0)
    part = np.abs(way) / np.maximum(np.abs(way).max(axis=0), 1e-300)
    near = 1.0 / np.maximum(np.sum((part[:, None] - part[own]) ** 2, axis=2), _STILL**2)  # how alike they move, (n, m)
    near /= near.sum(axis=1, keepdims=True)
    alike = near[..., None] * (E > 0.0) * (seen | ~seen.any(axis=0))  # (n, m, 6)
    share = np.sum(alike * D * a, axis=1) / np.maximum(np.sum(alike * E**2, axis=1), 1e-300)
    left = np.abs(D - share[:, None] * a) + _LEFT * finer_errors
    each = left / np.maximum(E, 1e-300) * (E > 0.0)
    each = np.maximum(each, np.minimum(1.0, each * _beyond_compared(errors, way, own)))
    ratio = np.sum(alike * each, axis=1) / np.maximum(np.sum(alike, axis=1), 1e-300)
    ratio = np.where(np.any(E > 0.0, axis=0), ratio, np.max(ratio, axis=1, keepdims=True))
    if only is not None:
        share, ratio = 0.0 * share, np.ones_like(ratio)
    strain = _beyond(rests)
    there = strain[own]
    above = min(1.0, float(np.max(np.divide(_beyond(fine.values()), there, out=there * 0.0 + 1.0, where=there > 0.0))))
    moved_to, errors, parts = poses + share * added, ratio * errors, ratio * added
    return dict(settled) | {
        load: replace(settled[load], rest=replace(
            rest, pose=Pose.of(moved_to[k]), error=Pose.of(errors[k] + np.abs(apart[k]).sum(axis=0)),
            shared=np.vstack([np.diag(parts[k]), apart[k]]) if only is None else rest.shared,
            report=replace(rest.report, stretch=float(1.0 + above * strain[k])),
        ))
        for k, (load, rest) in enumerate(good.items())
    }


def mild_load(settled: Mapping[Wrench, Settled], levers: Array, at_rest: Array) -> Wrench | None:
    """Return a part of the farthest load where none to be compared reaches near it, else None; as `corrected_loads`."""
    rests = [one.rest for one in settled.values() if one.rest is not None and one.rest.state.size]
    way = np.abs(poses_of(rests).value - at_rest) * levers
    size, open_to = way.max(axis=1, initial=0.0), [comparable(rest) for rest in rests]
    if _REACH * size[open_to].max(initial=0.0) >= size.max(initial=0.0):
        return None
    far = rests[int(np.argmax((way / np.maximum(way.max(axis=0), 1e-300)).sum(axis=1)))]
    return Wrench(*(_MILD * far.wrench.components).tolist())


def _beyond_compared(errors: Array, way: Array, fine: list[int]) -> Array:
    """Return how many times more of their errors (n, 6) meshes own to than at compared loads, shape (n, m, 6).

    `way` (n, 6) are displacements.
    """
    size, there = np.abs(way).max(axis=1), errors[fine]
    farther = np.maximum(1.0, size[:, None] / size[fine])[..., None]
    seen = (np.abs(way[fine]) > _TENTH * np.abs(way).max(axis=0)) & _MOVES
    along = np.divide(np.abs(way[:, None]), np.abs(way[fine]), out=farther.repeat(len(POSE), axis=2), where=seen)
    proportion = errors[:, None] / np.maximum(there, 1e-300) / np.maximum(farther, along)
    return np.asarray(np.maximum(1.0, proportion) * np.maximum(1.0, along) ** 2)


def _beyond(rests: Iterable[Equilibrium]) -> Array:
    """Return the stretches of layers at rest less 1, NaN where they are not known."""
    return np.array([rest.report.stretch for rest in rests], dtype=float) - 1.0


def comparable(rest: Equilibrium) -> bool:
    """Whether finer meshes rest in time and show more: in space those of the free family, unless rims crease."""
    return rest.state.size > 0 and (rest.report.model != "block" or not (rest.report.creased or rest.state[0]))


def _numbers(rests: list[Equilibrium]) -> tuple[Array, Array, Array]:
    """Return poses of n rests, their errors by meshes, and what extrapolation adds, shape (n, 6) each."""
    whole = [rest.error.components - np.abs(rest.shared[PARTS:]).sum(axis=0) for rest in rests]
    poses, errors = poses_of(rests), np.array(whole).reshape(-1, len(POSE))
    return poses.value, errors, poses.shared[:PARTS].sum(axis=0)


def _telling(way: Array, loads: list[int]) -> tuple[list[int], int]:
    """Return loads to compare, and how many: the one that moves all components most, each over its own largest, of
    nearer ones that move these too the one in the most different proportion, if there is one, then the others.
    """
    largest = np.abs(way[loads]).max(axis=0, initial=0.0)
    own = np.abs(way) / np.maximum(largest, 1e-300) * (largest > _STILL * largest.max())
    size = np.abs(way).max(axis=1, initial=0.0)
    order = sorted(loads, key=lambda k: -float(own[k].sum()))
    first = own[order[0]] if order else own[:0]
    near = [k for k in order if size[k] <= _NEAR * size[order[0]]]
    alike = [k for k in near if own[k].max() >= 0.5 and np.all(own[k][first > 0.0] > 0.0)]
    off = {k: float(np.linalg.norm(own[k] - own[k] @ first / (first @ first) * first)) for k in alike}
    other = [k for k in alike if off[k] == max(off.values()) > _TENTH][:1]
    return list(dict.fromkeys([*order[:1], *other, *near])), 1 + len(other)
