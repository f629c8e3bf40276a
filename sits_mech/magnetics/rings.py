"""Axisymmetric model: one coil as rings under a coaxial disc, absolute L and R in henry and ohm.

    (R + j omega L) i = -j omega g(d_v),    Delta Z = omega^2 g^T (R + j omega L)^-1 g,

with the disc's rings, modes and field functions of `disc`, and L0 from `loops`. The disc is divided finer until two
successive extrapolations in the cell size (of two divisions: the extrapolation and the finer one) agree to the
tolerance, or their steps fall so fast that what is left does, at the poses and the frequency asked for.

Range: non-magnetic disc, coaxial and parallel to the one coil; any frequency and thickness. The coil's tracks carry
uniform current. An infinite plate or layers: `dodd_deeds`. Neglected: displacement current.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0

from sits_mech.geometry.collision import check_clearance
from sits_mech.geometry.windings import check_frequency
from sits_mech.magnetics.disc import Disc, DiscProblem, count_rings, prepare_disc
from sits_mech.magnetics.loops import coil_inductances
from sits_mech.magnetics.losses import track_resistance
from sits_mech.quantities import Array, Impedance, Pose, SolveFailed, SolveReport, refuse_beside
from sits_mech.sensor import Coil, Sensor, Target
from sits_mech.threads import one_thread

Complex = NDArray[np.complex128]
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
        Collision
            If a pose brings the disc to the coil plane.
        ValueError
            If a pose leaves the coil's axis, or the frequency is not positive or beyond the coil's
            (`check_frequency`).
        SolveFailed
            If the tolerance asks for more rings than fit.
        """
        began = time.perf_counter()
        check_frequency(self.sensor.coils, frequency)
        shape = np.broadcast(pose.d_h, pose.d_v, pose.alpha).shape
        L0 = _free_inductance(self.sensor.coils)
        R_dc = np.array([track_resistance(coil) for coil in self.sensor.coils])
        if self.sensor.target is None:
            zero = np.zeros((*shape, *L0.shape))
            left_out = ("eddy currents: the scene has no target",)
            report = SolveReport("axisymmetric", 0, 0, 0.0, 0.0, time.perf_counter() - began, left_out=left_out)
            return Impedance(frequency, L0 + zero, zero, L0, R_dc, zero, zero, "H", report)
        refuse_beside("axisymmetric", pose, "sheets")
        check_clearance(self.sensor, pose)
        _check_coaxial(self.sensor.coils[0], pose)
        d_v = np.broadcast_to(np.asarray(pose.d_v, dtype=float), shape).ravel()
        change, error, rings, levels = self._change(self.sensor.target, d_v, frequency)
        seconds = time.perf_counter() - began
        worst = float((error.imag / np.abs(change.imag)).max())
        note = f"disc as {rings} rings, extrapolated from {levels} levels of division"
        notes = (note, "spiral windings taken as rings") if self.sensor.coils[0].winding == "spiral" else (note,)
        report = SolveReport("axisymmetric", rings, levels, 0.0, worst, seconds, notes=notes)
        omega = 2 * np.pi * frequency
        parts = (change.imag / omega, change.real, error.imag / omega, error.real)
        delta_L, R, error_L, error_R = (part.reshape(*shape, 1, 1) for part in parts)
        return Impedance(frequency, L0 + delta_L, R, L0, R_dc, error_L, error_R, "H", report)

    def _change(self, target: Target, d_v: Array, frequency: float) -> tuple[Complex, Complex, int, int]:
        """Divide finer until Delta Z [ohm] holds; with its errors, the rings and the levels."""
        coil = self.sensor.coils[0]
        problem = _problem(coil, target, (float(d_v.min()), float(d_v.max())), frequency)
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
            error = _error(limit) if level > 1 else _parts(limit[-1] - values[-1])
            if np.all(error <= asked[:, None] * _parts(limit[-1])):
                return limit[-1], error[0] + 1j * error[1], disc.rings, level + 1
        rings = 2 * count_rings(problem, len(values) - 1) if values else 0
        reached = float((_parts(limit[-1] - limit[-2]) / _parts(limit[-1])).max()) if len(limit) > 1 else 1.0
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
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: must be between 0 and 1; got {tolerance}")
    reason = _reason_against(sensor)
    if reason:
        raise ValueError(f"axisymmetric: {reason}")
    return Axisymmetric(sensor, tolerance)


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
    if target.shape != "disc":
        return f"the target must be a disc, it is of shape '{target.shape}'; use 'sheets'"
    return ""


def _check_coaxial(coil: Coil, pose: Pose) -> None:
    """Refuse poses off the coil's axis."""
    off = np.hypot(np.asarray(pose.d_h) - coil.centre[0], coil.centre[1])
    if np.any(off > _APART):
        raise ValueError(
            f"pose: the disc must be on the axis of coil {coil.name} for 'axisymmetric', it is {off.max() * 1e3:.4g} mm"
            " off; use 'sheets'"
        )
    if np.any(np.asarray(pose.alpha) != 0.0):
        tilt = np.degrees(np.abs(pose.alpha).max())
        raise ValueError(f"pose: alpha must be 0 for 'axisymmetric', got {tilt:.4g} deg; use 'sheets'")


def _problem(coil: Coil, target: Target, gaps: tuple[float, float], frequency: float) -> DiscProblem:
    """What to divide the disc for: gaps rounded to half powers of two, the frequency up to a power of ten."""
    sigma = target.metal.conductivity
    top = 10.0 ** np.ceil(np.log10(frequency) - 1e-9)
    low, high = 2.0 ** (np.floor(2 * np.log2(gaps[0])) / 2), 2.0 ** ((np.floor(2 * np.log2(gaps[1])) + 1) / 2)
    radius = (target.diameter or 0.0) / 2
    depth = float(1.0 / np.sqrt(np.pi * top * mu_0 * sigma))
    alike = coil.model_copy(update={"name": "C", "centre": (0.0, 0.0)})
    return DiscProblem(radius, target.thickness, sigma, alike, (float(low), float(high)), depth)


@lru_cache(maxsize=6)
def _prepared(problem: DiscProblem, level: int) -> Disc:
    """Divided discs, kept."""
    return prepare_disc(problem, level)


@lru_cache(maxsize=16)
def _free_inductance(coils: tuple[Coil, ...]) -> Array:
    """Free-space inductances, kept [H]."""
    return coil_inductances(coils)


def _error(limit: list[Complex]) -> Array:
    """Error of the last of three or more limits: their last step, or what a geometric series leaves after it."""
    step = _parts(limit[-1] - limit[-2])
    if len(limit) < 4:
        return step
    before = _parts(limit[-2] - limit[-3])
    ratio = np.clip(step / np.where(before > 0.0, before, 1.0), 0.3, 0.5)  # 1/16 for smooth, more at rims
    return np.asarray(step * ratio / (1.0 - ratio))


def _parts(value: Complex) -> Array:
    """Magnitudes of real and imaginary part, shape (2, p)."""
    return np.abs(np.stack([value.real, value.imag]))
