"""Answer poses and a frequency with an impedance: what all magnetic models have in common.

    L = L0 + Im Delta Z / omega,    R = Re Delta Z,    exp(+j omega t),

where Delta Z is what target and other metal do to the coils; a model finds that for a batch of poses in a row, and
nothing else. Without metal it is not asked.

A plate is prepared for all clearances g from some c on, and for all frequencies f up to some top. So that one pose has
one answer whatever else is asked, and curves over pose and frequency have no steps, the preparations form two ladders,

    c_k = c_0 2^k,    f_m = f_0 10^m,

and a pose with c_k <= g < c_(k+1) and f_(m-1) < f <= f_m is answered by

    Z = sum of w(x) Z_(k, .) + (1 - w(x)) Z_(k-1, .),    x = log2(g / c_k) / `_NEAR`,
        and of w(y) Z_(., m) + (1 - w(y)) Z_(., m+1),    y = log10(f_m / f) / `_UP`,

with w(s) = s^3 (10 - 15 s + 6 s^2) below s = 1 and 1 beyond: most poses and frequencies need one preparation only, and
where the next one takes over, with two continuous derivatives, both hold.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.tracks import check_frequency
from sits_mech.notes import Note
from sits_mech.quantities import (
    POSE,
    Array,
    Complex,
    Impedance,
    Integers,
    Pose,
    SolveFailed,
    SolveReport,
    refuse_out_of_plane,
)
from sits_mech.scene.sensor import Sensor

_NEAR = 0.25  # octaves of clearance over which two preparations share
_UP = 0.15  # decades of frequency over which two share
_FREQUENCY = 2.5e7  # a top, f_0 [Hz]


def clearances(gap: Array, anchor: float) -> list[tuple[Integers, Array]]:
    """Return the two steps k of the ladder that serve each gap (p,) [m], and their shares.

    From the gap `anchor` [m] on step 0 serves alone; see `clearance_of`.
    """
    x = np.log2(gap / anchor) + _NEAR
    step = np.floor(x).astype(np.int64)
    share = _rise((x - step) / _NEAR)
    return [(step, share), (step - 1, 1.0 - share)]


def clearance_of(step: int, anchor: float) -> float:
    """Return the clearance that a step of the ladder is prepared for [m]."""
    return float(anchor * 2.0 ** (step - _NEAR))


def served(clearance: float) -> tuple[float, float]:
    """Return the smallest and the largest gap of which a preparation for a clearance has a share [m]."""
    return clearance, float(clearance * 2.0 ** (1.0 + _NEAR))


def lowest_served(top: float) -> float:
    """Return the lowest frequency of which what is prepared up to `top` has a share [Hz]."""
    return float(top * 10.0 ** (-1.0 - _UP))


def tops(frequency: float, *, least_step: float = -math.inf) -> list[tuple[float, float]]:
    """Return the frequencies that are prepared for [Hz], and their shares; those of no share are left out.

    `least_step` is the least m of those that a model prepares: the preparation for that frequency answers all below it.
    """
    y = math.log10(frequency / _FREQUENCY)
    step = int(max(math.ceil(y), least_step))
    share = float(_rise(np.array((step - y) / _UP)))
    found = ((_FREQUENCY * 10.0**step, share), (_FREQUENCY * 10.0 ** (step + 1), 1.0 - share))
    return [(top, own) for top, own in found if own > 0.0]


def together(parts: Sequence[list[tuple[Integers, Array]]]) -> Iterator[tuple[tuple[int, ...], Integers, Array]]:
    """Yield the steps of several plates that serve some poses together, which poses, and their shares.

    `parts` are as of `clearances`, for the same poses.
    """
    for choice in product(*parts):
        steps, share = np.stack([step for step, _ in choice], axis=1), choice[0][1]
        for _, own in choice[1:]:
            share = share * own
        left = share > 0.0
        while left.any():
            kind = steps[np.argmax(left)]
            some = np.flatnonzero(left & (steps == kind).all(axis=1))
            left[some] = False
            yield tuple(kind.tolist()), some, share[some]


def serving(
    gaps: Sequence[tuple[Array, float]], frequency: float, *, least_step: float = -math.inf
) -> Iterator[tuple[list[float], float, Integers, Array]]:
    """Yield preparations that serve some poses: clearance of each plate [m], top [Hz]; which poses, and their shares.

    `gaps` are of each plate, (p,) and its anchor [m], as of `clearances`; `least_step` as of `tops`.
    """
    for steps, some, share in together([clearances(*gap) for gap in gaps]):
        clear = [clearance_of(step, anchor) for step, (_, anchor) in zip(steps, gaps, strict=True)]
        for top, own in tops(frequency, least_step=least_step):
            yield clear, top, some, own * share


def _rise(s: Array) -> Array:
    """Return w of the module docstring."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


@dataclass(frozen=True)
class Kind:
    """A kind of model."""

    name: str  # as on the command line
    unit_L: str  # "H", or "H/m" per metre of depth
    plane: bool = False  # whether poses must stay in the plane y = 0

    def of(self, absolute: bool) -> Kind:
        """Return the kind whose answers are per metre, or those of whole coils."""
        return replace(self, unit_L="H") if absolute else self


@dataclass(frozen=True)
class Reaction:
    """What metal does to the impedance of n coils at p poses."""

    change: Complex  # (p, n, n) Delta Z [ohm or ohm/m]
    error: Complex  # (p, n, n) estimated absolute errors of its real and its imaginary part
    relative: float = 0.0  # largest error of L, over the largest change of inductance
    unknowns: int = 0  # size of the discrete problem
    solves: int = 0  # linear solves it took
    residual: float = 0.0  # of these, relative
    notes: tuple[Note, ...] = ()
    shared: Complex | None = None  # (m, p, n, n) signed parts of the error, common to poses up to a factor
    tracks: Complex | None = None  # (2, p, n, n) what its field does in the tracks, where asked for, and the error


def check_asked(kind: Kind, sensor: Sensor, pose: Pose, frequency: float) -> None:
    """Refuse what a kind of model cannot answer.

    Collision if a pose brings the target to the coil plane or a fixed plate; ValueError if the frequency is not
    positive or beyond the coils' (`check_frequency`), or the pose leaves the plane y = 0 and the model cannot.
    """
    check_frequency(sensor.coils, frequency)
    if kind.plane:
        refuse_out_of_plane(kind.name, pose)
    check_clearance(sensor, pose)


def answer(
    kind: Kind, sensor: Sensor, pose: Pose, frequency: float, alone: Callable[[], tuple[Array, ArrayLike]],
    react: Callable[[Pose, float], Reaction],
) -> tuple[Impedance, Complex | None]:
    """Return L and R for poses of any shape at `frequency` [Hz], and a reaction's `tracks`.

    `alone` returns L0 and R_dc of the coils; `react` is the model: poses, with fields of shape (p,), and frequency to
    their reaction. Raises as `check_asked`, and SolveFailed where matrices have no factors or give no numbers.
    """
    began = time.process_time()
    check_asked(kind, sensor, pose, frequency)
    places, n = pose.components, len(sensor.coils)
    shape, rows = (*places.shape[:-1], n, n), places.reshape(-1, len(POSE))
    empty = sensor.target is None and not sensor.conductors
    if rows.size and not empty:
        found = _finite(kind, react, Pose.of(rows), frequency)
    else:
        none = np.zeros((len(rows), n, n), dtype=complex)
        found = Reaction(none, none)
    change, error = (np.broadcast_to(Z, (len(rows), n, n)).reshape(shape) for Z in (found.change, found.error))
    omega = 2 * np.pi * frequency
    L0, R_dc = map(np.asarray, alone())
    report = SolveReport(
        kind.name, found.unknowns, found.solves, found.residual, found.relative, time.process_time() - began,
        notes=found.notes,
    )
    values = (L0 + change.imag / omega, change.real.copy(), L0, R_dc, error.imag / omega, error.real.copy())
    shared = None
    if found.shared is not None:
        parts = np.broadcast_to(found.shared.imag / omega, (len(found.shared), len(rows), n, n))
        shared = parts.reshape(-1, *shape)
    return Impedance(frequency, *values, kind.unit_L, report, shared), found.tracks


def _finite(kind: Kind, react: Callable[[Pose, float], Reaction], pose: Pose, frequency: float) -> Reaction:
    """Return what a model answers, or refuse what rounding has lost."""
    try:
        found = react(pose, frequency)
        if np.all(np.isfinite(found.change)) and np.all(np.isfinite(found.error)) and np.isfinite(found.relative):
            return found
        why = "the answer is no number"
    except np.linalg.LinAlgError as error:
        why = str(error)
    raise SolveFailed(
        f"{kind.name}: sizes, gaps and skin depth of this scene are too far apart to be resolved ({why}); ask for "
        "another model or a larger tolerance",
        SolveReport(kind.name, 0, 0, 0.0, 1.0, 0.0, "not resolved"),
        half="magnetics",
    )


def magnitudes(Z: Complex) -> Array:
    """Return the magnitudes of the real and the imaginary parts, along a new first axis."""
    return np.abs(np.stack([Z.real, Z.imag]))


def largest(matrices: Array) -> Array:
    """Return the largest entry of each matrix in size, for all its entries."""
    return np.broadcast_to(np.abs(matrices).max(axis=(-2, -1), keepdims=True), matrices.shape)
