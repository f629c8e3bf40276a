"""Quantities that pass between the rooms: wrench, pose, equilibrium, impedance, and the report of every solve.

Conventions (the whole project)
-------------------------------
SI and radians. x is shear, y points out of the plane, z up; ``z = 0`` is the top face of the uppermost track layer.
``alpha > 0`` is clockwise in the x-z picture: the target's left edge rises. Phasors go as ``exp(+j omega t)``: an
impedance is ``R + j omega L`` and an inductance is flux linkage per ampere.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from numbers import Real
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sits_mech.notes import Note, NoteKind, Omission, packed, packed_omissions, unpacked, unpacked_omissions
from sits_mech.status import FAILED, NOT_CARRIED
from sits_mech.units import SceneError, shown

SURE = 1.645
"""Deviations within which 90 % of the values of a normal distribution lie."""
Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]


def tensor_grid(*axes: ArrayLike) -> NDArray[Any]:
    """Return the nodes of a grid with some axes, the last one fastest, shape (..., d)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def integrals(density: Array, x: Array) -> Array:
    """Return the integral of a density from the first of some places to each, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(x))])


@dataclass(frozen=True)
class Wrench:
    """Dead load on the target; the last three components are zero in the plane y = 0.

    Attributes
    ----------
    F_x : float
        Shear force along +x [N].
    F_z : float
        Normal force, positive when it presses down [N].
    M : float
        Moment about y, positive towards ``alpha > 0`` [N m].
    F_y : float
        Shear force along +y [N].
    M_x, M_z : float
        Moments about x and z, by the right hand [N m].

    Examples
    --------
    >>> sm.Wrench(F_x=0.5, F_z=2.0).components.tolist()
    [0.5, 2.0, 0.0, 0.0, 0.0, 0.0]
    """

    F_x: float = 0.0
    F_z: float = 0.0
    M: float = 0.0
    F_y: float = 0.0
    M_x: float = 0.0
    M_z: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no number, such as "1 N"; raise SceneError with the component."""
        _check_numbers(self, WRENCH, scalar=True)

    @property
    def components(self) -> Array:
        """All six, in the order of `WRENCH`, shape (6,) [N, N m]."""
        return np.array([getattr(self, name) for name in WRENCH], dtype=np.float64)

    @property
    def out_of_plane(self) -> tuple[str, ...]:
        """Names of the components that leave the plane y = 0 and are not zero."""
        return tuple(name for name in WRENCH[3:] if getattr(self, name) != 0.0)


@dataclass(frozen=True)
class Pose:
    """Where the target is: one pose, or many when the fields are arrays that broadcast.

    The rotation vector is (alpha_x, alpha, alpha_z): the axis that the target has turned about by the right hand, as
    long as the angle. The last three fields are zero in the plane y = 0.

    Attributes
    ----------
    d_h, d_v : float or ndarray
        Coordinates x and z of the centre of the target's bottom face [m].
    alpha : float or ndarray
        Rotation about y, clockwise in the x-z picture [rad].
    d_y : float or ndarray
        Coordinate y of that centre [m].
    alpha_x, alpha_z : float or ndarray
        Rotation about x and z [rad].

    Examples
    --------
    >>> sm.Pose(0.0, np.array([1e-3, 2e-3, 3e-3])).centre.shape  # three poses
    (3, 3)
    """

    d_h: float | Array
    d_v: float | Array
    alpha: float | Array = 0.0
    d_y: float | Array = 0.0
    alpha_x: float | Array = 0.0
    alpha_z: float | Array = 0.0

    def __post_init__(self) -> None:
        """Refuse what holds no numbers, as a wrench does."""
        _check_numbers(self, POSE, scalar=False)

    @classmethod
    def of(cls, components: Array) -> Pose:
        """Return the pose, or poses, of components in the order of `POSE`, shape (..., 3) or (..., 6) [m, rad]."""
        each = np.moveaxis(np.asarray(components, dtype=np.float64), -1, 0)
        return cls(*(float(part) if part.ndim == 0 else part for part in each))

    @property
    def components(self) -> Array:
        """All six, in the order of `POSE`, shape (..., 6) [m, rad]."""
        return self._stacked.copy()

    @cached_property
    def _stacked(self) -> Array:
        """The same, found once: a pose is asked for them several times."""
        each = np.broadcast_arrays(*(np.asarray(getattr(self, name), dtype=np.float64) for name in POSE))
        return np.stack(each, axis=-1)

    @property
    def centre(self) -> Array:
        """Coordinates x, y, z of the centre of the target's bottom face, shape (..., 3) [m]."""
        return self.components[..., [0, 3, 1]]

    @property
    def rotation(self) -> Array:
        """Rotation vector, shape (..., 3) [rad]."""
        return self.components[..., [4, 2, 5]]

    @property
    def out_of_plane(self) -> tuple[str, ...]:
        """Names of the components that leave the plane y = 0 and are not zero."""
        return tuple(name for name in POSE[3:] if np.any(np.asarray(getattr(self, name)) != 0.0))


@dataclass(frozen=True)
class Bounded:
    """Numbers within errors, shape (..., k), of which signed parts are shared: affine arithmetic for linear maps.

    A number x stands for x + sum_j t_j m_j + u, |t_j| <= 1, |u| <= a. The factors t_j are common to all, so that in
    differences shared parts m_j cancel as far as they are alike; an own part a is of each number for itself. Source:
    L. H. de Figueiredo, J. Stolfi, Numer. Algorithms 37 (2004) 147, section 2.
    """

    value: Array
    shared: Array  # (m, ..., k), parts of the errors with their signs
    own: Array  # (..., k)

    @classmethod
    def of(cls, value: Array, error: Array, shared: Array | None = None) -> Bounded:
        """Return numbers by their errors in all, and what of these is known to be shared."""
        shared = np.zeros((0, *value.shape)) if shared is None else shared
        return cls(value, shared, np.maximum(error - np.abs(shared).sum(axis=0), 0.0))

    @property
    def error(self) -> Array:
        """The errors in all."""
        return np.asarray(np.abs(self.shared).sum(axis=0) + self.own)

    def __getitem__(self, place: Any) -> Bounded:
        """Return some of the numbers."""
        return Bounded(self.value[place], self.shared[:, place], self.own[place])

    def __sub__(self, other: Bounded) -> Bounded:
        """Return differences from numbers with the same shared parts."""
        return Bounded(self.value - other.value, self.shared - other.shared, self.own + other.own)

    def mapped(self, matrix: Array) -> Bounded:
        """Return the numbers by a linear map (l, k), shape (..., l)."""
        return Bounded(self.value @ matrix.T, self.shared @ matrix.T, self.own @ np.abs(matrix).T)


WRENCH = ("F_x", "F_z", "M", "F_y", "M_x", "M_z")
"""Names of the components of a wrench; the first three are the plane's."""
POSE = ("d_h", "d_v", "alpha", "d_y", "alpha_x", "alpha_z")
"""Names of the components of a pose, each in the place of the component of the wrench that works on it."""
TOUCH = ("touch_x", "touch_y")
"""Names of the place of a touch on a target at rest."""
UNITS = {
    "F_x": "N", "F_z": "N", "M": "N*m", "F_y": "N", "M_x": "N*m", "M_z": "N*m",
    "d_h": "m", "d_v": "m", "alpha": "rad", "d_y": "m", "alpha_x": "rad", "alpha_z": "rad",
    "touch_x": "m", "touch_y": "m",
}
"""The SI unit of each component of a wrench and of a pose, and of a touch's place."""
LOAD_ARGUMENTS = {"fx": "F_x", "fz": "F_z", "moment": "M", "fy": "F_y", "mx": "M_x", "mz": "M_z"}
"""The components of a wrench by their names on the command line and in study files."""
POSE_ARGUMENTS = {"dh": "d_h", "dv": "d_v", "alpha": "alpha", "dy": "d_y", "alphax": "alpha_x", "alphaz": "alpha_z"}
"""The components of a pose by those names."""


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
    notes : tuple of Note
        Regime used, warnings, reasons, as kinds with numbers; `report.notes.sentence` words them.
    left_out : tuple of Omission
        What counts of what the answer leaves out; ``estimated_error`` holds it, but for what has no size.
    min_J : float or None
        Smallest volume ratio in the deformed layer; None where no layer was solved.
    stretch, error_stretch : float or None
        Largest principal stretch, or reciprocal, that all but 0.1 % of the layer stays below; the last mesh's change,
        or what half a cell more than that share makes.
    creased : bool
        Whether rims crease so that no finer mesh would rest.
    """

    model: str
    unknowns: int
    iterations: int
    residual: float
    estimated_error: float
    seconds: float
    status: str = "converged"
    notes: tuple[Note, ...] = ()
    left_out: tuple[Omission, ...] = ()
    min_J: float | None = None
    stretch: float | None = None
    error_stretch: float | None = None
    creased: bool = False

    def judged(self, tolerance: float) -> SolveReport:
        """Return it with a note where its error is above a tolerance, in place of one on a part of that error."""
        if not self.estimated_error > tolerance:
            return self
        others = (note for note in self.notes if note.kind is not NoteKind.TOLERANCE_MISSED)
        missed = Note.of(NoteKind.TOLERANCE_MISSED, error=self.estimated_error, tolerance=tolerance)
        return replace(self, notes=(*others, missed))

    @property
    def written(self) -> dict[str, Any]:
        """What files and answers hold of it by name: all but `creased`, which is for plans."""
        found = asdict(self)
        del found["creased"]
        return found


class Ended(StrEnum):
    """Statuses of reports on what was followed and ended before its goal."""

    PATH = "load path ended"
    HISTORY = "history ended"


def kept_report(report: SolveReport) -> str:
    """Return a report as one text for a file, which `report_of` reads."""
    texts = {"notes": packed(report.notes), "left_out": packed_omissions(report.left_out)}
    return json.dumps(as_jsonable(report.written | texts))


def report_of(text: str) -> SolveReport:
    """Return the report of a text that `kept_report` wrote."""
    row = json.loads(text)
    return SolveReport(**row | {"notes": unpacked(row["notes"]), "left_out": unpacked_omissions(row["left_out"])})


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
    shared : ndarray, shape (m, 6)
        Parts of the error with their signs, each of which neighbouring loads have in common up to one factor between -1
        and 1 [m, rad]; m is 0 where no such part is known.
    finer : tuple of ndarray
        Discrete solutions beyond `state` that the pose is extrapolated from; one that is not known is empty.
    slopes : ndarray, shape (n, 6)
        Derivatives of the pose by numbers of the scene, where they were asked for; n is 0 otherwise.
    acting : Wrench or None
        What a touch is at this pose, about the middle of the target's top face; None without touch, and on a cover
        [N, N m].
    sunk : tuple of float or None
        How deep the lowest point of a shape that presses on a cover is below its top at rest, and the error [m]; None
        without one.
    error_F_z : float or None
        What the force of a touch may be off by that leads to its depth, part of the pose's error; None of others [N].
    """

    wrench: Wrench
    pose: Pose
    error: Pose
    state: Array = field(repr=False)
    report: SolveReport
    shared: Array = field(default_factory=lambda: np.zeros((0, len(POSE))), repr=False)
    finer: tuple[Array, ...] = field(default=(), repr=False)
    slopes: Array = field(default_factory=lambda: np.zeros((0, len(POSE))), repr=False)
    acting: Wrench | None = None
    sunk: tuple[float, float] | None = None
    error_F_z: float | None = None


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
        Estimated absolute errors of L - L0 and R.
    unit_L : str
        "H" or "H/m" (planar models are per metre of depth); the unit of resistance follows.
    report : SolveReport
        ``estimated_error`` is relative to the largest change of inductance.
    shared_L : ndarray, shape (m, ..., n, n), or None
        Parts of the error of L with their signs, each of which poses have in common up to one factor between -1 and 1
        [unit_L]; None where no such part is known.
    uneven : bool
        Whether L, R and L0 hold skin and proximity effect in the coils' tracks.
    error_L0 : ndarray, shape (n, n), or None
        Estimated absolute error of L0, which L shares [unit_L]; None where it is far below that of L - L0.

    Examples
    --------
    >>> model, _ = sm.magnetic_model(sm.load_sensor("biorob2018"), "planar")
    >>> result = model.impedance(sm.Pose(0.0, 2e-3), 5e6)
    >>> result.unit_L, result.L.shape, round(float(result.L[0, 0] / result.L0[0, 0]), 3)
    ('H/m', (2, 2), 0.964)
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
    shared_L: Array | None = None
    uneven: bool = False
    error_L0: Array | None = None

    @property
    def convention(self) -> dict[str, str]:
        """Attributes of a table of L and R: their unit, and whether the current in tracks is even."""
        return {"unit_L": self.unit_L, "tracks": "uneven" if self.uneven else "even"}


class SolveFailed(Exception):
    """A solve that did not reach its answer; it carries what was reached.

    Attributes
    ----------
    report : SolveReport
        Its ``status`` names the reason.
    last : Equilibrium or None
        The last converged state on the way, if there is one.
    half : str
        Of a whole chain, the physics that the report is of: "mechanics" or "magnetics".
    carried : (Wrench, Wrench) or None
        The largest load of the asked kind that a layer carries, or of one far beyond the data of its silicone the
        largest within them, and its error; None where none was found.

    Examples
    --------
    >>> model, _ = sm.mechanical_model(sm.load_sensor("biorob2018"), "planar", 0.1)
    >>> try:
    ...     model.equilibrium(sm.Wrench(F_z=-500.0))  # pulls the layer off
    ... except sm.SolveFailed as error:
    ...     print(error.report.status, error.carried[0].F_z > -20.0, error.last is None)
    load path ended True False
    """

    def __init__(
        self, message: str, report: SolveReport, last: Equilibrium | None = None, half: str = "mechanics",
        carried: tuple[Wrench, Wrench] | None = None,
    ) -> None:
        super().__init__(message)
        self.report = report
        self.last = last
        self.half = half
        self.carried = carried

    @property
    def status(self) -> str:
        """What it is to a script, a word of status.py."""
        return NOT_CARRIED if self.report.status in tuple(Ended) else FAILED


def _check_numbers(given: Wrench | Pose, names: Sequence[str], *, scalar: bool) -> None:
    """Raise SceneError for the first component that is no real number, or no array of them."""
    for name in names:
        value = getattr(given, name)
        if isinstance(value, float) or (scalar and isinstance(value, Real)):
            continue
        if scalar or np.asarray(value).dtype.kind not in "fiu":
            kind = "a number" if scalar else "numbers"
            raise SceneError(f"{name}: must be {kind} [{UNITS[name]}]; got {shown(value)}")


def shown_unit(name: str) -> str:
    """Return the SI unit of a component of a wrench or a pose, or of a touch's place, for a reader, such as "N m"."""
    return UNITS[name].replace("*", " ")


class MechanicalModel(Protocol):
    """Wrench in, pose out."""

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium under `wrench`, reached from `start`; raise SolveFailed if there is none."""
        ...


@runtime_checkable
class PathModel(Protocol):
    """A mechanical model whose answer may depend on the load path."""

    def along(self, loads: Sequence[Wrench]) -> Equilibrium:
        """Return the equilibrium under the last of `loads`, reached from rest straight from each to the next.

        `equilibrium` of one load goes there straight from rest. Raise SolveFailed as it does.
        """
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


def refuse_infinite(wrench: Wrench) -> None:
    """Raise ValueError for a load with a component that is not finite."""
    if not np.all(np.isfinite(wrench.components)):
        raise ValueError(f"wrench: must be finite numbers, got {wrench}")


def load_at(values: Mapping[str, float], place: Sequence[float] = (0.0, 0.0)) -> Wrench:
    """Return a load by its components, and by where it touches in place of moments: about the touched point `place`.

    Without "touch_x" and "touch_y" [m] it touches there.
    """
    x, y = (values.get(name, own) - own for name, own in zip(TOUCH, place, strict=True))
    forces = {name: value for name, value in values.items() if name not in TOUCH}
    if x or y:
        forces |= {"M": x * forces.get("F_z", 0.0), "M_x": 0.0 - y * forces.get("F_z", 0.0)}
    return Wrench(**forces)


class _Leaving(Protocol):
    """What names its components that leave the plane y = 0: a wrench, a pose, a mix of forces and places."""

    @property
    def out_of_plane(self) -> tuple[str, ...]: ...


def refuse_out_of_plane(model: str, given: _Leaving) -> None:
    """Raise ValueError for components that leave the plane y = 0 of a `model`."""
    if given.out_of_plane:
        kind, names = ("pose" if isinstance(given, Pose) else "wrench"), ", ".join(given.out_of_plane)
        raise ValueError(f"{kind}: {names} must be zero for the model {model}, which is plane")
