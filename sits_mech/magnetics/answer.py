"""From the pose and frequency asked to the impedance answered: what all magnetic models have in common.

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
    """A kind of model.

    Attributes
    ----------
    name : str
        As on the command line.
    unit_L : str
        "H", or "H/m" per metre of depth.
    beyond : str or None
        The model that takes poses which leave the plane y = 0; None where this one does.
    """

    name: str
    unit_L: str
    beyond: str | None = None


@dataclass(frozen=True)
class Reaction:
    """What metal does to the impedance of n coils at p poses.

    Attributes
    ----------
    change : ndarray of complex, shape (p, n, n)
        Delta Z [ohm or ohm/m].
    error : ndarray of complex, shape (p, n, n)
        Estimated absolute errors of its real and its imaginary part.
    relative : float
        The largest of L, over the largest change of inductance.
    unknowns, solves : int
        Size of the discrete problem; linear solves it took.
    residual : float
        Of these, relative.
    notes, left_out : tuple of str
    shared : ndarray of complex, shape (m, p, n, n), or None
        Parts of the error with their signs, each of which poses have in common up to one factor; None: none is known.
    """

    change: Complex
    error: Complex
    relative: float = 0.0
    unknowns: int = 0
    solves: int = 0
    residual: float = 0.0
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    shared: Complex | None = None


def check_asked(kind: Kind, sensor: Sensor, pose: Pose, frequency: float) -> None:
    """Refuse what a kind of model cannot answer.

    Raises
    ------
    Collision
        If a pose brings the target to the coil plane or a fixed plate.
    ValueError
        If the frequency is not positive, or beyond the coils' (`check_frequency`); if the pose leaves the plane y = 0
        and the model cannot.
    """
    check_frequency(sensor.coils, frequency)
    if kind.beyond is not None:
        refuse_beside(kind.name, pose, kind.beyond)
    check_clearance(sensor, pose)


def answer(
    kind: Kind, sensor: Sensor, pose: Pose, frequency: float, alone: Callable[[], tuple[Array, Array]],
    react: Callable[[Pose, float], Reaction],
) -> Impedance:  # fmt: skip
    """Return L and R for one pose or many at `frequency` [Hz].

    Parameters
    ----------
    kind : Kind
    sensor : Sensor
    pose : Pose
        Of any shape.
    frequency : float
    alone : callable
        Returns L0 and R_dc of the coils.
    react : callable
        The model: poses, their fields of shape (p,), and the frequency to their reaction.

    Raises
    ------
    Collision, ValueError
        As `check_asked`.
    SolveFailed
        If the model's matrices cannot be factored, or give no numbers.
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
    )  # fmt: skip
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
