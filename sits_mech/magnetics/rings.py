"""Axisymmetric model: one coil as rings under a coaxial disc, absolute L and R in henry and ohm.

    (R + j omega L) i = -j omega g(d_v),    Delta Z = omega^2 g^T (R + j omega L)^-1 g,

with the disc's rings, modes and field functions of `axis.disc`, and L0 from `coils.loops`. The disc is divided finer
until two successive extrapolations in the cell size (of two divisions: the extrapolation and the finer one) agree to
the tolerance, or their steps fall so fast that what is left does, at the poses and the frequency asked for.

Range: non-magnetic disc, coaxial and parallel to the one coil; any frequency and thickness. The coil's tracks carry
uniform current. Neglected: displacement current.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sits_mech.magnetics.answer import Kind, Reaction, answer, sizes
from sits_mech.magnetics.axis.disc import Disc, DiscProblem, count_rings, prepare_disc
from sits_mech.magnetics.coils.alone import free_inductances, track_resistances
from sits_mech.magnetics.skin import skin_depth
from sits_mech.quantities import Array, Complex, Impedance, Pose, SolveFailed, SolveReport
from sits_mech.scene.sensor import Coil, Sensor
from sits_mech.threads import one_thread
from sits_mech.units import checked_tolerance

_KIND = Kind("axisymmetric", "H")  # what leaves the axis `_check_coaxial` refuses
_MOST = 4200  # rings in half the disc: half a minute and a gigabyte
_APART = 1e-9  # off the axis by less than this is coaxial [m]


@dataclass(frozen=True)
class Axisymmetric:
    """The axisymmetric model of one sensor; make it with `axisymmetric`.

    Attributes
    ----------
    sensor : Sensor
    tolerance : float
        Asked relative error of the change of inductance; the resistance is good to ten times that.
    """

    sensor: Sensor
    tolerance: float

    @one_thread
    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L [H] and R [ohm] for one pose or many at `frequency` [Hz].

        The disc is divided on first use for the poses' gaps (to a factor of 1.4) and the frequency (to a decade), and
        kept for later calls.

        Raises
        ------
        Collision, ValueError
            As `check_asked`; also if a pose leaves the coil's axis.
        SolveFailed
            If the tolerance asks for more rings than fit.
        """
        def alone() -> tuple[Array, Array]:
            return free_inductances(self.sensor.coils), track_resistances(self.sensor.coils)

        return answer(_KIND, self.sensor, pose, frequency, alone, self._reaction)

    def _reaction(self, pose: Pose, frequency: float) -> Reaction:
        """What the disc does to the coil."""
        _check_coaxial(self.sensor.coils[0], pose)
        change, error, rings, levels = self._change(np.asarray(pose.d_v), frequency)
        worst = float((error.imag / np.abs(change.imag)).max())
        note = f"disc as {rings} rings, extrapolated from {levels} levels of division"
        notes = (note, "spiral windings taken as rings") if self.sensor.coils[0].winding == "spiral" else (note,)
        return Reaction(change[:, None, None], error[:, None, None], worst, rings, levels, notes=notes)

    def _change(self, d_v: Array, frequency: float) -> tuple[Complex, Complex, int, int]:
        """Divide finer until Delta Z [ohm] holds; with its errors, the rings and the levels."""
        problem = _problem(self.sensor, (float(d_v.min()), float(d_v.max())), frequency)
        asked = np.array([10 * self.tolerance, self.tolerance])
        values: list[Complex] = []
        limit: list[Complex] = []
        for level in range(12):
            if count_rings(problem, level) > _MOST:
                break
            disc = _prepared(problem, level)
            values.append(disc.reaction(d_v, 2 * np.pi * frequency))
            limit.append((4 * values[-1] - values[-2]) / 3 if level else values[-1])
            if level == 0:
                continue
            error = _error(limit) if level > 1 else sizes(limit[-1] - values[-1])
            if np.all(error <= asked[:, None] * sizes(limit[-1])):
                return limit[-1], error[0] + 1j * error[1], disc.rings, level + 1
        rings = 2 * count_rings(problem, len(values) - 1) if values else 0
        reached = float((sizes(limit[-1] - limit[-2]) / sizes(limit[-1])).max()) if len(limit) > 1 else 1.0
        report = SolveReport("axisymmetric", rings, len(values), 0.0, reached, 0.0, "too many rings")
        raise SolveFailed(
            f"axisymmetric: tolerance {self.tolerance:g} asks for more than the {2 * _MOST} rings that fit; reached "
            f"{reached:.1e} with {rings}; ask for a larger tolerance, or for 'sheets'",
            report,
        )


def axisymmetric(sensor: Sensor, tolerance: float = 1e-3) -> Axisymmetric:
    """Return the axisymmetric model of a sensor.

    Parameters
    ----------
    sensor : Sensor
        One coil and a disc, or no target (then any coils with parallel axes, free-space inductances only).
    tolerance : float
        Relative error of the change of inductance; the resistance is good to ten times that.

    Raises
    ------
    ValueError
        If the scene is not axisymmetric; the message names the model for it.
    """
    reason = _reason_against(sensor)
    if reason:
        raise ValueError(f"axisymmetric: {reason}")
    return Axisymmetric(sensor, checked_tolerance(tolerance))


def _reason_against(sensor: Sensor) -> str:
    """Why a scene is not axisymmetric, and which model takes it; empty when it is."""
    if sensor.substrate_radius is not None:
        return "the coils must lie in a plane, the scene has a substrate_radius; use 'planar-fem'"
    if sensor.conductors:
        return f"must have no other conductors, the scene has {len(sensor.conductors)}; use 'planar-fem' or 'sheets'"
    target = sensor.target
    if target is None:
        return ""
    if target.metal.relative_permeability != 1.0:
        return f"the target must not be magnetic, it has {target.metal.relative_permeability:g}; use 'planar-fem'"
    if len(sensor.coils) != 1:
        return f"must have one coil over a coaxial disc, the scene has {len(sensor.coils)} coils; use 'sheets'"
    if sensor.coils[0].shape != "circle":
        return f"the coil must be round, {sensor.coils[0].name} is of shape '{sensor.coils[0].shape}'; use 'sheets'"
    if target.shape != "disc":
        return f"the target must be a disc, it is of shape '{target.shape}'; use 'sheets'"
    return ""


def on_axis(coil: Coil, pose: Pose) -> bool:
    """Tell whether poses leave a disc on a coil's axis, turned about it at most."""
    tilted = np.any(pose.rotation[..., :2] != 0.0)
    return not tilted and bool(np.all(_off_axis(coil, pose) <= _APART))


def _off_axis(coil: Coil, pose: Pose) -> Array:
    """Distance of the disc's middle from the coil's axis [m]."""
    return np.asarray(np.linalg.norm(pose.centre[..., :2] - coil.centre, axis=-1))


def _check_coaxial(coil: Coil, pose: Pose) -> None:
    """Refuse poses off the coil's axis."""
    if on_axis(coil, pose):
        return
    off, tilt = float(_off_axis(coil, pose).max()), float(np.degrees(np.abs(pose.rotation[..., :2]).max()))
    if off > _APART:
        raise ValueError(
            f"pose: the disc must be on the axis of coil {coil.name} for 'axisymmetric', it is {off * 1e3:.4g} mm off; "
            "use 'sheets'"
        )
    raise ValueError(f"pose: alpha and alpha_x must be 0 for 'axisymmetric', got {tilt:.4g} deg; use 'sheets'")


def _problem(sensor: Sensor, gaps: tuple[float, float], frequency: float) -> DiscProblem:
    """What to divide the disc for: gaps rounded to half powers of two, the frequency up to a power of ten."""
    target, coil = sensor.target, sensor.coils[0]
    if target is None:
        raise ValueError("target: the scene has none to divide")
    sigma = target.metal.conductivity
    top = 10.0 ** np.ceil(np.log10(frequency) - 1e-9)
    low, high = 2.0 ** (np.floor(2 * np.log2(gaps[0])) / 2), 2.0 ** ((np.floor(2 * np.log2(gaps[1])) + 1) / 2)
    radius = (target.diameter or 0.0) / 2
    alike = coil.model_copy(update={"name": "C", "centre": (0.0, 0.0)})
    return DiscProblem(radius, target.thickness, sigma, alike, (float(low), float(high)), skin_depth(top, sigma))


@lru_cache(maxsize=6)
def _prepared(problem: DiscProblem, level: int) -> Disc:
    """Divided discs, kept."""
    return prepare_disc(problem, level)


def _error(limit: list[Complex]) -> Array:
    """Error of the last of three or more limits: their last step, or what a geometric series leaves after it."""
    step = sizes(limit[-1] - limit[-2])
    if len(limit) < 4:
        return step
    before = sizes(limit[-2] - limit[-3])
    ratio = np.clip(step / np.where(before > 0.0, before, 1.0), 0.3, 0.5)  # 1/16 for smooth, more at rims
    return np.asarray(step * ratio / (1.0 - ratio))
