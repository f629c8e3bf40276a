"""What are the coils without any other metal? Inductances in free space and direct-current resistances.

In space: the coils' rings or spirals, in henry and ohm. In the section y = 0: there and back, per metre of depth.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sits_mech.geometry.windings import coil_bars, track_length
from sits_mech.magnetics.coils.loops import coil_inductances
from sits_mech.magnetics.coils.ring_field import spiral_inductances
from sits_mech.quantities import Array
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil


@lru_cache(maxsize=32)
def free_inductances(coils: tuple[Coil, ...], windings: str = "rings") -> Array:
    """Return the coils' inductance matrix as "rings" or as a "spiral", shape (n, n) [H]; kept for later."""
    return spiral_inductances(coils) if windings == "spiral" else coil_inductances(coils)


def track_resistance(coil: Coil) -> float:
    """Return the direct-current resistance of a coil's copper tracks, uniform current density [ohm]."""
    return track_length(coil) / (metals()["copper"].conductivity * coil.track_width * coil.track_thickness)


def track_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return that of each coil, shape (n,) [ohm]."""
    return np.array([track_resistance(coil) for coil in coils])


def section_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return the direct-current resistance of each coil's tracks in the section, shape (n,) [ohm/m]."""
    copper = metals()["copper"].conductivity
    return np.array([coil_bars(c).x.size / (copper * c.track_width * c.track_thickness) for c in coils])
