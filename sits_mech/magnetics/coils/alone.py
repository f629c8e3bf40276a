"""What are the coils without any other metal? Inductances in free space and direct-current resistances.

In space: the coils' rings, spirals or straight tracks, in henry and ohm. In the section y = 0: there and back, per
metre of depth.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sits_mech.geometry.tracks import coil_bars, track_squares
from sits_mech.magnetics.coils.loops import coil_inductances
from sits_mech.quantities import Array
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Coil


@lru_cache(maxsize=32)
def free_inductances(coils: tuple[Coil, ...], windings: str = "rings") -> Array:
    """Return the coils' inductance matrix, round ones as "rings" or as a "spiral", shape (n, n) [H]; kept for later."""
    return coil_inductances(coils, windings=windings)


def track_resistance(coil: Coil) -> float:
    """Return the direct-current resistance of a coil's copper tracks, uniform current density [ohm]."""
    return track_squares(coil) / (metals()["copper"].conductivity * coil.track_thickness)


def track_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return that of each coil, shape (n,) [ohm]."""
    return np.array([track_resistance(coil) for coil in coils])


def section_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return the direct-current resistance of each coil's tracks in the section, shape (n,) [ohm/m]."""
    copper = metals()["copper"].conductivity
    return np.array([(bars := coil_bars(c)).x.size / (copper * bars.width * bars.thickness) for c in coils])
