"""What passes between the rooms: wrench, pose, equilibrium, impedance, and the report that every solve carries.

Conventions (the whole project)
-------------------------------
SI and radians. x is shear, y points out of the plane, z up; ``z = 0`` is the top face of the uppermost track layer.
``alpha > 0`` is clockwise in the x-z picture: the target's left edge rises, its right edge sinks.
Phasors go as ``exp(+j omega t)``: an impedance is ``R + j omega L`` and an inductance is flux linkage per ampere.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Wrench:
    """Dead load on the target.

    Attributes
    ----------
    F_x : float
        Shear force along +x [N].
    F_z : float
        Normal force, positive when it presses down [N].
    M : float
        Moment, positive towards ``alpha > 0`` [N m].
    """

    F_x: float = 0.0
    F_z: float = 0.0
    M: float = 0.0


@dataclass(frozen=True)
class Pose:
    """Where the target is: one pose, or many when the fields are arrays of one shape.

    Attributes
    ----------
    d_h, d_v : float or ndarray
        Coordinates x and z of the centre of the target's bottom face [m].
    alpha : float or ndarray
        Rotation, clockwise in the x-z picture [rad].
    """

    d_h: float | Array
    d_v: float | Array
    alpha: float | Array = 0.0


@dataclass(frozen=True)
class SolveReport:
    """How a number came about: the model, its size, its error and its price.

    Attributes
    ----------
    model : str
        Name of the model, as on the command line.
    unknowns, iterations : int
        Size of the discrete problem; linear solves it took.
    residual : float
        Norm of what is left of the discrete equations, relative to the load.
    estimated_error : float
        Relative error of the answer; the model's documentation says of which quantity.
    seconds : float
        Wall time of this solve.
    status : str
        "converged", or a short name of what stopped the solve.
    notes : tuple of str
        Plain sentences: regime used, warnings, reasons.
    left_out : tuple of str
        What the scene did not need, with the reason.
    min_J : float or None
        Smallest volume ratio in the deformed layer; None where no layer was solved.
    """

    model: str
    unknowns: int
    iterations: int
    residual: float
    estimated_error: float
    seconds: float
    status: str = "converged"
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    min_J: float | None = None


@dataclass(frozen=True)
class Equilibrium:
    """A layer at rest under a wrench.

    Attributes
    ----------
    wrench : Wrench
        The load [N, N m].
    pose : Pose
        The target's pose [m, rad].
    error : Pose
        Estimated absolute error of each component of the pose [m, rad].
    state : ndarray
        The discrete solution, to start a neighbouring load from; its layout belongs to the model that made it.
    report : SolveReport
        ``estimated_error`` is the largest error of a component over the size of the displacement.
    """

    wrench: Wrench
    pose: Pose
    error: Pose
    state: Array = field(repr=False)
    report: SolveReport


@dataclass(frozen=True)
class Impedance:
    """What the coils show at a frequency, as coil-by-coil matrices, each coil alone driven.

    Attributes
    ----------
    frequency : float
        [Hz].
    L, R : ndarray, shape (..., n, n)
        Inductance and resistance; leading axes are those of the pose. R is without the coils' own direct-current
        resistance [unit_L, unit_R].
    L0 : ndarray, shape (n, n)
        Inductance without target [unit_L].
    R_dc : ndarray, shape (n,)
        Direct-current resistance of the tracks [unit_R].
    error_L, error_R : ndarray, shape (..., n, n)
        Estimated absolute errors of L and R.
    unit_L : str
        "H" or "H/m" (planar models are per metre of depth); the unit of resistance follows.
    report : SolveReport
        ``estimated_error`` is relative to the largest change of inductance.
    """

    frequency: float
    L: Array
    R: Array
    L0: Array
    R_dc: Array
    error_L: Array
    error_R: Array
    unit_L: str
    report: SolveReport


class SolveFailed(Exception):
    """A solve that did not reach its answer; it carries what was reached.

    Attributes
    ----------
    report : SolveReport
        Its ``status`` names the reason.
    last : Equilibrium or None
        The last converged state on the way, if there is one.
    """

    def __init__(self, message: str, report: SolveReport, last: Equilibrium | None = None) -> None:
        super().__init__(message)
        self.report = report
        self.last = last


class MechanicalModel(Protocol):
    """Wrench in, pose out."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench`, reached from `start`; raise SolveFailed if there is none."""
        ...


class MagneticModel(Protocol):
    """Pose in, impedance out."""

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return the impedance matrices for one pose or many at `frequency` [Hz]."""
        ...


def as_jsonable(value: Any) -> Any:
    """Turn arrays, tuples and numpy scalars into lists and numbers that `json` can write."""
    if isinstance(value, dict):
        return {key: as_jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [as_jsonable(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
