"""Turn the pose and frequency asked into an impedance: what all magnetic models have in common.

    L = L0 + Im Delta Z / omega,    R = Re Delta Z,    exp(+j omega t),

where Delta Z is what target and other metal do to the coils; a model finds that for a batch of poses in a row, and
nothing else. Without metal it is not asked.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.waves import check_frequency
from sits_mech.quantities import POSE, Array, Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.refusals import refuse_beside
from sits_mech.scene.sensor import Sensor


@dataclass(frozen=True)
class Kind:
    """A kind of model."""

    name: str  # as on the command line
    unit_L: str  # "H", or "H/m" per metre of depth
    beyond: str | None = None  # the model for poses that leave the plane y = 0; None where this one takes them


@dataclass(frozen=True)
class Reaction:
    """What metal does to the impedance of n coils at p poses."""

    change: Complex  # (p, n, n) Delta Z [ohm or ohm/m]
    error: Complex  # (p, n, n) estimated absolute errors of its real and its imaginary part
    relative: float = 0.0  # largest error of L, over the largest change of inductance
    unknowns: int = 0  # size of the discrete problem
    solves: int = 0  # linear solves it took
    residual: float = 0.0  # of these, relative
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    shared: Complex | None = None  # (m, p, n, n) signed parts of the error, common to poses up to a factor


def check_asked(kind: Kind, sensor: Sensor, pose: Pose, frequency: float) -> None:
    """Refuse what a kind of model cannot answer.

    Collision if a pose brings the target to the coil plane or a fixed plate; ValueError if the frequency is not
    positive or beyond the coils' (`check_frequency`), or the pose leaves the plane y = 0 and the model cannot.
    """
    check_frequency(sensor.coils, frequency)
    if kind.beyond is not None:
        refuse_beside(kind.name, pose, kind.beyond)
    check_clearance(sensor, pose)


def answer(
    kind: Kind, sensor: Sensor, pose: Pose, frequency: float, alone: Callable[[], tuple[Array, Array]],
    react: Callable[[Pose, float], Reaction],
) -> Impedance:
    """Return L and R for poses of any shape at `frequency` [Hz].

    `alone` returns L0 and R_dc of the coils; `react` is the model: poses, with fields of shape (p,), and frequency to
    their reaction. Raises as `check_asked`, and SolveFailed if the model's matrices cannot be factored or give no
    numbers.
    """
    began = time.perf_counter()
    check_asked(kind, sensor, pose, frequency)
    places, n = pose.components, len(sensor.coils)
    shape, rows = (*places.shape[:-1], n, n), places.reshape(-1, len(POSE))
    if rows.size and (sensor.target is not None or sensor.conductors):
        found = _finite(kind, react, Pose.of(rows), frequency)
    else:
        none, why = np.zeros((len(rows), n, n), dtype=complex), ("eddy currents: the scene has no target",)
        found = Reaction(none, none, left_out=() if sensor.target is not None or sensor.conductors else why)
    change, error = (np.broadcast_to(Z, (len(rows), n, n)).reshape(shape) for Z in (found.change, found.error))
    omega = 2 * np.pi * frequency
    L0, R_dc = alone()
    report = SolveReport(
        kind.name, found.unknowns, found.solves, found.residual, found.relative, time.perf_counter() - began,
        notes=found.notes, left_out=found.left_out,
    )
    values = (L0 + change.imag / omega, change.real.copy(), L0, R_dc, error.imag / omega, error.real.copy())
    shared = None
    if found.shared is not None:
        parts = np.broadcast_to(found.shared.imag / omega, (len(found.shared), len(rows), n, n))
        shared = parts.reshape(-1, *shape)
    return Impedance(frequency, *values, kind.unit_L, report, shared)


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


def sizes(Z: Complex) -> Array:
    """Return the magnitudes of the real and the imaginary parts, along a new first axis."""
    return np.abs(np.stack([Z.real, Z.imag]))


def largest(matrices: Array) -> Array:
    """Return the largest entry of each matrix in size, for all its entries."""
    return np.broadcast_to(np.abs(matrices).max(axis=(-2, -1), keepdims=True), matrices.shape)
