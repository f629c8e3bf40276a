"""Choose the loads whose readings tell most about the forces that a built sensor will read.

A reading under a load F tells of the unknowns theta, its own load misread by u,

    M(F) = L_theta^T (sigma^2 + L_F U L_F^T)^-1 L_theta,     U = cov u,

and N of them leave Sigma = (Sigma_0^-1 + sum M)^-1. Chosen are the N that make the mean square error of the forces over
the loads to be read least, each force over its range (I-optimal: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum
Experimental Designs, 2007, section 10.6): one after the other, then each exchanged for a better one until none is. All
by the derivatives of the computed sensor, before any is built.

Rigs: `weights` lie on top (no shear); a `press` pushes down by a screw, with a scale below and a dial for its
way; a `stage` moves in all forces with a load cell. In `use` there is no bench, and what has drifted since is unknown:
a look at rest, a weight on top, a press to a stop, whose depth is known and whose load is not. Loads stay so far within
the table that a sensor which is softer by two deviations of its modulus can be read there as well: s F_max, ln s =
ln v - 2 sd/v. Named weights are the only loads then, and of a step its multiples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.analysis.bench.force_maps import lacking, moduli, needed
from sits_mech.analysis.bench.unknowns import PriorParameter
from sits_mech.analysis.built.prior import Prior, check_deviation, inverted, load_noise_of
from sits_mech.analysis.readings.bench import loads_over
from sits_mech.quantities import SURE, UNITS, Array
from sits_mech.scene.sensor import SceneError
from sits_mech.units import SLACK, quantity

RIGS = ("weights", "press", "stage", "use")
_ACROSS = 5  # values of each force that may be chosen, and that are read
_DEPTH = 1e-5  # deviation of a dial [m]
_ROUNDS = 20  # of exchanges, at most
_GRAVITY = 9.80665  # m/s^2
SOFTER = 1.4
"""Times softer than its table: what a plan tells of such a sensor (published moduli of a silicone differ as much)."""
_NOTHING = 1.0  # deviation of a way down that was not measured [m]: far more than any


@dataclass(frozen=True)
class LoadPlan:
    """Loads to be read, and what they bring.

    Errors are of each force over its range, 90 % of readings lie within.
    """

    rig: str
    forces: tuple[str, ...]  # components of the loads
    loads: Array  # in the order of their use, (N, d) [N, N m]
    kinds: tuple[str, ...]  # of each: load, rest, weight, stop (its load is the one that the computed sensor has there)
    read: Array  # loads that errors are taken over, the range to be read, (m, d)
    errors: Array  # after none of the loads but a tare at rest (in use without one), one, ..., (N + 1, d)
    more: Array  # the same after the loads and as many more of the best, (d,)
    known_after: Array  # what is known of the unknowns each time, as a matrix of information, (N + 1, p, p)
    least: float  # factor of the modulus of the softest sensor that can be read at these loads by this table
    grow: str = ""  # what a sensor that is `SOFTER` needs, where the table does not hold it
    too_much: tuple[str, ...] = ()  # weights that are too much, with why


@dataclass(frozen=True)
class Bench:
    """Which loads a bench has: weights on top [N], or multiples of a step of each force [N]; any without both."""

    weights: tuple[float, ...] = ()
    step: float | None = None

    @classmethod
    def written(cls, weights: str, step: str | None) -> Bench:
        """Read "50 g, 100 g, 2 N", and "0.5 N"; SceneError for what is neither a mass nor a force above zero."""
        own = tuple(_weight(part.strip()) for part in weights.split(",")) if weights.strip() else ()
        each = None if step is None else quantity(step, "N", "--step")
        if each is not None and (own or not each > 0.0):
            raise SceneError(f"--step: must be a force above 0, without --weights; got {step}")
        return cls(own, each)

    def loads(self, prior: Prior, read: Array) -> tuple[Array, tuple[str, ...]]:
        """Return loads that this bench has of those to be read (m, d), and what it has that is too much."""
        forces = np.array([UNITS[name] == "N" for name in prior.forces])
        if self.step is not None:
            whole = np.where(forces, self.step * np.trunc(read / self.step + np.sign(read) * SLACK), read) + 0.0
            inside = np.all((whole >= read.min(axis=0)) & (whole <= read.max(axis=0)), axis=1)
            return np.unique(whole[inside], axis=0), ()
        if not self.weights:
            return read, ()
        down, unit = _downwards(prior), UNITS["F_z"]
        most, rest = float(read[:, down].max()), np.clip(0.0, read.min(axis=0), read.max(axis=0))
        heavy = [weight for weight in self.weights if weight > most * (1.0 + SLACK)]
        fit = [weight for weight in self.weights if weight not in heavy and weight >= read[:, down].min()]
        left = tuple(
            f"{weight:.3g} N: above {most:.3g} N, where the table may end for a soft sensor; "
            f"{needed(weight, softest_of(prior), unit)} of F_z" for weight in heavy
        )
        if not fit:
            raise SceneError(f"--weights: must have one that the table holds; {(*left, 'all are below it')[0]}")
        loads = np.tile(rest, (len(fit), 1))
        loads[:, down] = sorted(fit)
        return loads, left


def _weight(text: str) -> float:
    """Return the load of a written weight [N]."""
    mass = text.rstrip("0123456789.").strip().endswith("g")
    found = _GRAVITY * quantity(text, "kg", "--weights") if mass else quantity(text, "N", "--weights")
    if not found > 0.0:
        raise SceneError(f'--weights: must be masses or forces above 0, such as "50 g, 100 g"; got {text!r}')
    return found


def softest_of(prior: Prior) -> float:
    """Return the modulus that is two deviations below what is known, over the calibrated one."""
    names = prior.setup.names
    return (prior.known[names.index("modulus")] if "modulus" in names else PriorParameter("modulus", 1.0, 0.0)).softest


def plan_loads(
    prior: Prior, count: int, rig: str = "stage", *, bench: Bench = Bench(), load_noise: float | None = None,
    depth_noise: float = _DEPTH,
) -> LoadPlan:
    """Return the `count` loads that tell most of a sensor, on a rig, of those that a bench has.

    `load_noise` [N] and `depth_noise` [m] as of `adapt`. Raises SceneError for an unknown rig, no load, or a rig that
    has none of the forces that the calibration varies, or weights that all are too much.
    """
    if rig not in RIGS:
        raise SceneError(f"rig: must be one of {', '.join(RIGS)}; got {rig}")
    if count < 1:
        raise SceneError(f"plan: must be one or more loads; got {count}")
    check_deviation("load_noise", load_noise, "N")
    check_deviation("depth_noise", depth_noise, "m")
    softer = softest_of(prior)  # by two deviations
    read = loads_over(softer * prior.table.map.low, softer * prior.table.map.high, _ACROSS)
    possible, too_much = bench.loads(prior, read)
    if rig != "stage":
        possible = possible[~np.any(np.delete(possible, _downwards(prior), axis=1), axis=1)]
    answers, by = prior.force_slopes(prior.start, read)
    each = answers @ by / np.ptp(read, axis=0)[:, None]
    goal = np.einsum("mdp,mdq->pq", each, each) / len(read)  # G: tr(G Sigma) is the forces' mean square over ranges
    kinds = ["load"] * len(possible)
    gain = prior.fisher(possible, load_noise, depth_noise if rig == "press" else None)
    start = prior.tared
    if rig == "use":
        start = inverted(prior.covariance)
        possible, kinds, gain = _in_use(prior, possible, load_noise, depth_noise)
    chosen, twice = (_chosen(start, gain, goal, number) for number in (count, 2 * count))
    known = start + np.concatenate([np.zeros((1, *start.shape)), np.cumsum(gain[chosen], axis=0)])
    errors = np.array([_errors(prior, each, read) for each in known])
    more = _errors(prior, start + gain[twice].sum(axis=0), read)
    loads, least = possible[chosen], moduli(possible[chosen], prior.table, prior.forces)[0][0]
    return LoadPlan(
        rig, prior.forces, loads, tuple(kinds[k] for k in chosen), read, errors, more, known, least,
        _grow(prior, loads), too_much,
    )


def _grow(prior: Prior, loads: Array) -> str:
    """Return what the table lacks for a sensor that is `SOFTER`, of each force; nothing where it holds it."""
    short = lacking(loads, prior.table, 1.0 / SOFTER)
    return ", ".join(
        f"calibrate to at least {most:.3g} {UNITS[name]} of {'-' if sign < 0.0 else ''}{name}"
        for (name, sign), most in short.items()
    )


def _in_use(
    prior: Prior, weights: Array, load_noise: float | None, depth_noise: float
) -> tuple[Array, list[str], Array]:
    """Return what can be read in use, loads (m, d), what each is, and what it tells (m, p, p)."""
    down = _downwards(prior)
    rest, stop = np.clip(np.zeros(weights.shape[1]), weights.min(axis=0), weights.max(axis=0)), weights.max(axis=0)
    some = weights[weights[:, down] > rest[down]]
    loads = np.concatenate([rest[None], some, stop[None]])
    noises = np.tile(load_noise_of(prior.table, load_noise), (len(loads), 1))
    noises[0], noises[-1, down] = 0.0, np.ptp(weights[:, down])
    depths = np.full(len(loads), _NOTHING)
    depths[-1] = depth_noise
    return loads, ["rest", *["weight"] * len(some), "stop"], prior.fisher(loads, noises, depths)


def _downwards(prior: Prior) -> int:
    """Return the place of F_z among the forces; SceneError where it is not varied."""
    if "F_z" not in prior.forces:
        raise SceneError(f"rig: must be stage where F_z is not varied; the calibration has {', '.join(prior.forces)}")
    return prior.forces.index("F_z")


def _chosen(start: Array, gain: Array, goal: Array, count: int) -> list[int]:
    """Return which readings to take: one after the other, then exchanged."""

    def left(chosen: list[int]) -> float:
        """Return the mean square error after some readings."""
        return float(np.sum(goal * inverted(start + gain[chosen].sum(axis=0))))

    found: list[int] = []
    for _ in range(count):
        found.append(min(range(len(gain)), key=lambda k: left([*found, k])))
    for _ in range(_ROUNDS):
        before = left(found)
        for place in range(count):
            others = [*found[:place], *found[place + 1 :]]
            best = min(range(len(gain)), key=lambda k: left([*others, k]))
            if left([*others, best]) < left(found):
                found = [*others, best]
        if not left(found) < 0.999 * before:
            break
    return found


def _errors(prior: Prior, information: Array, read: Array) -> Array:
    """Return within what 90 % of each force's readings lie, over its range, shape (d,)."""
    spread = prior.force_covariance(prior.start, inverted(information), read)
    each = SURE * np.sqrt(np.einsum("mdd->md", spread).mean(axis=0))
    return np.asarray(each / np.ptp(read, axis=0))
