"""What does a request not need solved, and how large at most is what that leaves out?

Sizes are of the answer's relative change: of the target's displacement for what the mechanics leave out, of the change
of inductance for the magnetics, of L0 for idle coils; zero where nothing changes at all.

Small strain. A bonded strip of width w, the target's or the layer's, whichever is narrower, of thickness t, depth L and
shape factor S = w/(2 t) under the load

    sink/t = F_z/(E_c w L),   shear = F_x/(mu w L),   edge = alpha w/(2 t),   alpha = M_o t/(E_b w^3 L/12)

with 1/E_c = 1/(4 mu (1 + S^2)) + 1/K, E_b = mu (4 + 0.8 S^2), M_o the moment about the layer's middle (within 4 % of
finite elements from S = 2 on). One linear compliance then misses the displacement by less than

    3 sink/t + (shear + edge)/2,

where finite elements show 1.6 to 2.8 times sink/t under pure compression, and up to 0.4 times the larger of shear and
edge under combined loads (w/t from 1.3 to 7.5); slender layers, which buckle, are excluded.

Skin. Of a plate of n = t/skin depth much is current in two skins; what passes from face to face is exp(-n).

Idle coils. A shorted coil beside the driven one takes M^2/L_2 from its inductance: M^2/(L_1 L_2) of L0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.magnetics.coils.loops import coil_inductances
from sits_mech.magnetics.skin import skin_depth
from sits_mech.mechanics.closed_form import LONG, small_strain_bound
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor

_COVERED = 0.95  # share of a long pad under the target that plane strain stands for
_SLENDER = 0.5  # shape factor below which no layer counts as one of small strain
_THICK = 3.0  # skin depths from which on the inside of a plate is at rest


@dataclass(frozen=True)
class Omission:
    """Something that a request does not need solved.

    Attributes
    ----------
    what, reason : str
        A few words each.
    size : float
        Largest relative change of the answer, see above; 0 where it is exact, NaN where it is not estimated.
    of_change : bool
        Whether the size is of the change of inductance, to which errors are stated, or of L0.
    half : str
        "mechanics" or "magnetics": whose work is spared.
    """

    what: str
    reason: str
    size: float = 0.0
    of_change: bool = True
    half: str = "magnetics"

    @property
    def text(self) -> str:
        """Return it as one line."""
        of = "" if self.of_change else " of L0"
        size = "" if self.size == 0.0 else f" (at most {self.size:.1g}{of})"
        return f"{self.what}: {self.reason}" + (" (not estimated)" if math.isnan(self.size) else size)


def strain_bound(sensor: Sensor, loads: Sequence[Wrench]) -> float:
    """Return how far at most one linear compliance misses the displacement under any of the loads [-].

    Infinite for slender layers, and where the scene has no layer that a strip stands for.
    """
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or elastomer.mesh is not None or target.shape == "outline":
        return math.inf
    if elastomer.kind == "pillars":
        return math.inf
    (w, length), t = map(min, target.extent, elastomer.extent), elastomer.thickness
    shape, mu = w / (2.0 * t), elastomer.silicone.shear_modulus
    if shape < _SLENDER:
        return math.inf
    E_c = 1.0 / (1.0 / (4.0 * mu * (1.0 + shape**2)) + 1.0 / elastomer.silicone.bulk_modulus)
    E_b = mu * (4.0 + 0.8 * shape**2)
    bounds, lever = [0.0], target.load_height + 0.5 * t
    for load in loads:
        sink, shear = abs(load.F_z) / (E_c * w * length), math.hypot(load.F_x, load.F_y) / (mu * w * length)
        along, across = (abs(M) + abs(F) * lever for M, F in ((load.M, load.F_x), (load.M_x, load.F_y)))
        edge = math.hypot(along / (w**2 * length), across / (w * length**2)) / (E_b / 6.0)
        bounds.append(small_strain_bound(sink, shear, edge))
    return max(bounds)


def skin_depths(sensor: Sensor) -> float:
    """Return the target's thickness in skin depths at the scene's frequency; 0 without a target."""
    target = sensor.target
    if target is None:
        return 0.0
    conductivity = target.metal.conductivity * target.metal.relative_permeability
    return target.thickness / skin_depth(sensor.frequency, conductivity)


def idle_coupling(sensor: Sensor) -> float:
    """Return what the shorted idle coils take at most of a coil's inductance, over L0."""
    if len(sensor.coils) < 2:
        return 0.0
    L = coil_inductances(sensor.coils, tolerance=1e-6)
    own = np.diagonal(L)
    share = L**2 / np.outer(own, own)
    np.fill_diagonal(share, 0.0)
    return float(np.max(share.sum(axis=1)))


def omissions(
    sensor: Sensor, loads: Sequence[Wrench], mechanics: str | None, magnetics: str | None
) -> tuple[Omission, ...]:
    """Return what a request leaves out.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    loads : sequence of Wrench
        The loads asked for; none where the pose is given.
    mechanics, magnetics : str
        The models that were chosen; None where no load, or no inductance, is asked for.

    Returns
    -------
    tuple of Omission
        With sizes.
    """
    found = []
    if mechanics is None:
        found.append(Omission("mechanics", "the pose is given", half="mechanics"))
    elif mechanics == "linear":
        bound = strain_bound(sensor, loads)
        reason = "the load strains the layer so little that one compliance will do"
        found.append(Omission("finite strain", reason, bound, half="mechanics"))
    found += _ends(sensor, mechanics)
    silicone = None if sensor.elastomer is None else sensor.elastomer.silicone
    if loads and silicone is not None and (silicone.prony or silicone.mullins):
        reason = "slow load on virgin material; ask for cycle"
        found.append(Omission("rate and history of the silicone", reason, math.nan, half="mechanics"))
    if loads and symmetry_of(sensor).mirrored and not any(load.F_x or load.M or load.beside for load in loads):
        found.append(Omission("poses beside and turned", "scene and load are symmetric"))
    elif (own := len(symmetry_of(sensor).without_images(loads))) < len(set(loads)):
        reason = f"pad and target are their own image: {own} of {len(set(loads))} loads stand for all"
        found.append(Omission("images of loads", reason, half="mechanics"))
    return tuple(found) if magnetics is None else tuple(found) + _magnetic(sensor, magnetics)


def _ends(sensor: Sensor, mechanics: str | None) -> list[Omission]:
    """Return what plane strain leaves out of a pad, or a target on it, that has ends along y."""
    target, elastomer = sensor.target, sensor.elastomer
    if mechanics in (None, "block") or target is None or elastomer is None:
        return []
    pad, plate = elastomer.extent[1], target.extent[1]
    if pad >= LONG * elastomer.extent[0] and plate >= _COVERED * pad:
        return []
    reason = f"plane strain spreads the force over {pad:g} m of pad, the target covers {plate:g} m: ask for block"
    return [Omission("ends of pad and target along y", reason, math.nan, half="mechanics")]


def _magnetic(sensor: Sensor, model: str) -> tuple[Omission, ...]:
    """Return what the magnetic half leaves out."""
    found, depths = [], skin_depths(sensor)
    if sensor.target is None:
        found.append(Omission("eddy currents", "no target: the coils in free space"))
    elif depths >= _THICK and model in ("planar-fem", "sheets"):
        reason = f"{depths:.2g} skin depths thick: its surface stands for it"
        found.append(Omission("inside of the target", reason, math.exp(-depths)))
    if model in ("planar", "planar-fem") and sensor.target is not None:
        reason = "a plane section stands for coils and plates: ask for sheets for what their ends are worth"
        found.append(Omission("ends along y", reason, math.nan))
        if sensor.target.shape == "disc":
            found.append(Omission("roundness of the target", "a strip as wide as its diameter stands for it", math.nan))
    if model != "planar-fem":
        found.append(Omission("mesh of the air", "nothing permeable: integral model"))
    if sensor.coils[0].winding == "spiral" and model != "sheets":
        found.append(Omission("pitch of the spiral windings", "rings stand for them in this model"))
    if len(sensor.coils) > 1 and sensor.readout.idle_coil == "shorted":
        reason = "each coil is driven alone; L holds the mutual inductances to add it"
        found.append(Omission("current in the idle coil", reason, idle_coupling(sensor), False))
    elif len(sensor.coils) > 1:
        found.append(Omission("current in the idle coil", "it is open"))
    return tuple(found)


def keeps_axis(load: Wrench) -> bool:
    """Tell whether a load neither shifts nor tilts a target in a scene with two planes of symmetry."""
    return load.F_x == load.M == load.F_y == load.M_x == 0.0
