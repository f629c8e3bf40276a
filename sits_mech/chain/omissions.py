"""List what a request leaves out of the solution, with upper bounds of the effects.

Sizes are of the answer's relative change: of the target's displacement for what the mechanics leave out, of the change
of inductance for the magnetics, of L0 for idle coils; zero where nothing changes at all. Those that the answer's errors
do not hold add up to what stands beside them (`beside_errors`); what has no size is named there.

Small strain. A bonded pad of sides w and L, the target's or the layer's, whichever is narrower, of thickness t and area
A under the load

    sink/t = F_z/(E_c A),   shear = F_x/(mu A),   edge = alpha w/(2 t) = 6 M_o/(E_b A w),

with E_c and E_b of `mechanics.closed_form.pad_moduli`, M_o the moment about the layer's middle. One linear
compliance then misses the displacement by less than

    3 sink/t + (shear + edge)/2,

where finite elements show 1.6 to 2.8 times sink/t under pure compression, and up to 0.4 times the larger of shear and
edge under combined loads (w/t from 1.3 to 7.5); slender layers, which buckle, are excluded.

Skin. Of a plate of n = t/skin depth much is current in two skins; what passes from face to face is exp(-n).

Ends along y, pitch of spirals: ends.py, by the answer itself where it is there.

Idle coils. Shorted ones reduce the inductance of a driven one: with Z = R + j omega L of the model, each coil alone
driven, and J the shorted coils,

    Z_i - Z_ii = -Z_iJ (Z_JJ)^-1 Z_Ji,                                                                     (1)

which is M^2/L_J of L_ii for one of them without losses. Where no pose is known it has a bound for all poses at rest's
distance and beyond, from free space (0) and rest: with D = L0 - L, d_ij = |D_ij|/sqrt(L0_ii L0_jj), which falls with
the distance of the target, k_ij the same of L0, and r_ij of R/omega,

    |Z_ij|^2 <= omega^2 L0_ii L0_jj [(k_ij + d_ij)^2 + r_ij^2],    |Z_JJ| >= omega L0_JJ (1 - max d_jj) (1 - lambda),

lambda the largest sum of (k + d)_jl/(1 - max d_jj) over the other shorted coils l (Gershgorin): (1) is at most

    omega L0_ii sum_j [(k_ij + d_ij)^2 + r_ij^2] / ((1 - max d_jj) (1 - lambda)).                           (2)

Leads and the tracks' own resistance, which make it less, are left out. Closer than at rest the answer's own (1) counts.

Rate and history. A sudden load meets 1/(1 - sum w) times the stiffness that a Prony series with the weights w has under
a slow one, so that it moves the target by sum w less; below a larger load of the past Mullins' softening leaves at
least 1 - erf(1/beta)/r of it. Neither is an error of the answer to a slow first load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.chain.ends import ends_of_pad, ends_of_plates, in_plane_strain, pitch_of_spirals, whole_factors
from sits_mech.magnetics.modes import skin_depth
from sits_mech.mechanics.closed_form import pad_moduli, plain_pad, small_strain_bound
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Array, Impedance, Pose, Wrench
from sits_mech.scene.sensor import Sensor, silicone_of
from sits_mech.silicone.material import Silicone

ENDS = "ends "
"""How the names of what sections leave out begin."""
_SLENDER = 0.5  # shape factor below which no layer counts as one of small strain
_THICK = 3.0  # skin depths from which on the inside of a plate is at rest


@dataclass(frozen=True)
class Omission:
    """Something that a request leaves out."""

    what: str
    reason: str
    size: float = 0.0  # largest relative change of the answer; 0 where exact, NaN where not estimated
    of_change: bool = True  # size is of the change of inductance, to which errors are stated; else of L0
    half: str = "magnetics"  # "mechanics" or "magnetics": whose work is spared
    in_error: bool = False  # the answer's errors hold it
    asked: bool = True  # False for what another request would change: no error of this one

    @property
    def counts(self) -> bool:
        """Whether it is an error of the change of inductance that was asked for."""
        return self.of_change and self.asked

    @property
    def text(self) -> str:
        """The omission as one line."""
        of = "" if self.of_change else " of L0"
        size = "" if self.size == 0.0 else f" (at most {self.size:.1g}{of})"
        return f"{self.what}: {self.reason}" + (" (not estimated)" if math.isnan(self.size) else size)


def strain_bound(sensor: Sensor, loads: Sequence[Wrench]) -> float:
    """Return an upper bound of the relative error of one linear compliance under any of the loads [-].

    Infinite for slender layers, and where the scene has no layer that a strip stands for.
    """
    plain = plain_pad(sensor)
    if plain is None:
        return math.inf
    target, elastomer = plain
    (w, length), t = map(min, target.extent, elastomer.extent), elastomer.thickness
    if min(w, length) < 2.0 * t * _SLENDER:
        return math.inf
    silicone, (area, E_c, E_b) = elastomer.silicone, pad_moduli(target, elastomer)
    free = 3.0 * abs(elastomer.free_stretch - 1.0)  # of the thickness, by which the pad moves without load, at most
    strains, lever = [(free, 0.0, 0.0)], target.load_height + 0.5 * t
    for load in loads:
        sink, shear = abs(load.F_z) / (E_c * area), math.hypot(load.F_x, load.F_y) / (silicone.shear_modulus * area)
        along, across = (abs(M) + abs(F) * lever for M, F in ((load.M, load.F_x), (load.M_x, load.F_y)))
        edge = 6.0 * math.hypot(along / w, across / length) / (E_b * area)
        strains.append((sink + free, shear, edge))
    return max(small_strain_bound(silicone, (E_c, E_b), *each) for each in strains)


def skin_depths(sensor: Sensor) -> float:
    """Return the target's thickness in skin depths at the scene's frequency; 0 without a target."""
    target = sensor.target
    if target is None:
        return 0.0
    conductivity = target.metal.conductivity * target.metal.relative_permeability
    return target.thickness / skin_depth(sensor.frequency, conductivity)


@dataclass(frozen=True)
class Answered:
    """What the coils show: the answer at its poses, or a coarse one with the target at rest where none is known."""

    pose: Pose
    found: Impedance
    answered: bool = True  # whether it is the answer; else sizes hold at rest


def beside_errors(items: Sequence[Omission], half: str | None = None) -> tuple[float, tuple[str, ...]]:
    """Return the sum of omissions that an answer's errors do not hold, and the names of those without a size.

    `half` is "mechanics" or "magnetics", or both by default.
    """
    some = [item for item in items if item.counts and not item.in_error and half in (None, item.half)]
    missing = tuple(item.what for item in some if math.isnan(item.size))
    return sum(item.size for item in some if not math.isnan(item.size)), missing


def omissions(
    sensor: Sensor, loads: Sequence[Wrench], mechanics: str | None, magnetics: str | None,
    shown: Answered | None = None, auto: bool = False,
) -> tuple[Omission, ...]:
    """Return what a request leaves out, with sizes.

    `loads` are empty where the pose is given; `mechanics`, `magnetics` are the chosen models, None where that half is
    not asked for; without `shown` sizes that depend on the pose are not estimated; `auto` tells that the magnetic model
    was not asked for by name, so that the errors of a section hold the ends.
    """
    found = []
    if mechanics is None:
        found.append(Omission("mechanics", "the pose is given", half="mechanics"))
    elif mechanics == "linear":
        bound = strain_bound(sensor, loads)
        reason = "strains are so small that one constant compliance is enough"
        found.append(Omission("finite strain", reason, bound, half="mechanics", in_error=True))
    found += _ends(sensor, mechanics)
    silicone = silicone_of(sensor)
    if loads and silicone is not None and silicone.has_history:
        reason = "slow load on virgin material; ask for simulate --history, or cycle"
        size = history_share(silicone)
        found.append(Omission("rate and history of the silicone", reason, size, half="mechanics", asked=False))
    found += _mirrored(sensor, loads)
    return tuple(found) if magnetics is None else (*found, *_magnetic(sensor, magnetics, shown, auto))


def _mirrored(sensor: Sensor, loads: Sequence[Wrench]) -> list[Omission]:
    """Return what symmetry of scene and loads spares."""
    symmetry, different = symmetry_of(sensor), len(set(loads))
    if loads and symmetry.mirrored and not any(load.F_x or load.M or load.out_of_plane for load in loads):
        return [Omission("out-of-plane displacement and rotation", "scene and load are symmetric")]
    own = len(symmetry.without_images(loads))
    reason = f"pad and target are symmetric: {own} of {different} loads are solved, the others mirrored"
    return [Omission("mirrored loads", reason, half="mechanics")] if own < different else []


def history_share(silicone: Silicone) -> float:
    """Return the relative change of displacement under a sudden load, or below a larger load of the past [-]."""
    quick = sum(weight for weight, _ in silicone.prony)
    mullins = silicone.mullins
    deepest = 0.0 if mullins is None else math.erf(1.0 / mullins.beta) if mullins.beta else 1.0
    left = 1.0 if mullins is None else 1.0 - deepest / mullins.r
    return max(quick, 1.0 / left - 1.0)


def _ends(sensor: Sensor, mechanics: str | None) -> list[Omission]:
    """Return what plane strain leaves out of a pad, or a target on it, that has ends along y."""
    target, elastomer = sensor.target, sensor.elastomer
    if mechanics is None or target is None or elastomer is None or not in_plane_strain(sensor, mechanics):
        return []
    pad, plate, factor = elastomer.extent[1], target.extent[1], ends_of_pad(sensor)
    size = math.nan if factor is None else float(np.max(whole_factors(factor)))
    reason = f"plane strain spreads the force over {pad:g} m of pad, the target covers {plate:g} m: ask for block"
    return [Omission("ends of pad and target along y", reason, size, half="mechanics")]


def _magnetic(sensor: Sensor, model: str, shown: Answered | None, auto: bool) -> tuple[Omission, ...]:
    """Return what the magnetic half leaves out."""
    found, depths = [], skin_depths(sensor)
    if sensor.target is None:
        found.append(Omission("eddy currents", "no target: the coils in free space"))
    elif depths >= _THICK and model in ("planar-fem", "sheets"):
        reason = f"{depths:.2g} skin depths thick: modelled by its surface"
        found.append(Omission("interior of the target", reason, math.exp(-depths), in_error=model == "sheets"))
    if model in ("planar", "planar-fem") and sensor.target is not None:
        found.append(_of_section(sensor, shown, auto))
    if model != "planar-fem":
        found.append(Omission("mesh of the air", "no permeable parts: integral model"))
    if model == "axisymmetric" and sensor.coils[0].winding == "spiral":
        pitch = math.nan if shown is None else pitch_of_spirals(sensor, shown.found, shown.pose)
        found.append(Omission("pitch of the spiral windings", "this model replaces them by rings", pitch))
    return (*found, *_idle(sensor, shown))


def _of_section(sensor: Sensor, shown: Answered | None, auto: bool) -> Omission:
    """Return the ends that a section leaves out of coils and plates."""
    disc = sensor.target is not None and sensor.target.shape == "disc"
    spiral = any(coil.is_round and coil.winding == "spiral" for coil in sensor.coils)
    also = ", a disc as a strip of its diameter" * disc + ", spirals as straight tracks" * spiral
    reason = f"coils and plates are taken as endless along y{also}: ask for sheets"
    ends = None if shown is None else ends_of_plates(sensor, shown.found, shown.pose)
    size, known = (math.nan, False) if ends is None else (ends.size, auto)
    return Omission("ends along y", reason, size, in_error=known)


def _idle(sensor: Sensor, shown: Answered | None) -> list[Omission]:
    """Return what idle coils would change of the answer, each coil alone driven."""
    if len(sensor.coils) < 2:
        return []
    if sensor.readout.idle_coil != "shorted":
        return [Omission("current in the idle coil", "it is open")]
    reason, size = "each coil is driven alone; mutual inductances in L allow adding it", math.nan
    if shown is not None:
        size = idle_share(shown.found) if shown.answered else idle_bound(shown.found)
    return [Omission("current in the idle coil", reason, size, of_change=False)]


def idle_share(found: Impedance) -> float:
    """Return the largest part of a coil's free-space inductance that shorted coils take, by (1) [-]."""
    omega, n = 2.0 * np.pi * found.frequency, len(found.L0)
    if n < 2:
        return 0.0
    Z = (found.R + 1j * omega * found.L).reshape(-1, n, n)
    left = 1.0 / np.diagonal(np.linalg.inv(Z), axis1=1, axis2=2)  # the Schur complement of all other coils, for each
    taken = np.abs(np.diagonal(Z, axis1=1, axis2=2) - left)
    return float((taken / (omega * np.diagonal(found.L0))).max(initial=0.0))


def idle_bound(rest: Impedance) -> float:
    """Return an upper bound of what shorted coils take of a coil's free-space inductance, by (2) [-].

    `rest` has the target at rest, or none; infinite where the coils are coupled too closely for the bound.
    """
    L0, n = rest.L0, len(rest.L0)
    if n < 2:
        return 0.0
    scale = np.sqrt(np.outer(np.diag(L0), np.diag(L0)))
    taken = np.abs(L0 - rest.L).reshape(-1, n, n).max(axis=0) / scale
    mutual = _without_own(np.abs(L0) / scale + taken)
    lost = _without_own(np.abs(rest.R).reshape(-1, n, n).max(axis=0) / (2.0 * np.pi * rest.frequency * scale))
    left = 1.0 - float(np.diag(taken).max())
    driven = np.where(np.eye(n, dtype=bool), np.inf, mutual).min(axis=1)
    among = float((mutual.sum(axis=1) - driven).max()) / left if left > 0.0 else 0.0
    if left <= 0.0 or among >= 1.0:
        return float("inf")
    return float((mutual**2 + lost**2).sum(axis=1).max() / (left * (1.0 - among)))


def _without_own(matrix: Array) -> Array:
    """Return a matrix without its diagonal."""
    return np.where(np.eye(len(matrix), dtype=bool), 0.0, matrix)


def keeps_axis(load: Wrench) -> bool:
    """Return whether a load neither shifts nor tilts a target in a scene with two planes of symmetry."""
    return load.F_x == load.M == load.F_y == load.M_x == 0.0
