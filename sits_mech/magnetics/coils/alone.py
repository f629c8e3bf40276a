"""Inductances in free space and direct-current resistances of the coils, without any other metal.

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


def track_conductivity(coil: Coil) -> float:
    """Return the conductivity of a coil's tracks, copper's unless the scene gives another [S/m]."""
    return coil.conductivity or metals()["copper"].conductivity


def track_resistance(coil: Coil) -> float:
    """Return the direct-current resistance of a coil's tracks, uniform current density [ohm]."""
    return track_squares(coil) / (track_conductivity(coil) * coil.track_thickness)


def track_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return the direct-current resistance of each coil, shape (n,) [ohm]."""
    return np.array([track_resistance(coil) for coil in coils])


def section_resistances(coils: tuple[Coil, ...]) -> Array:
    """Return the direct-current resistance of each coil's tracks in the section, shape (n,) [ohm/m]."""
    bars = [coil_bars(coil) for coil in coils]
    sections = [track_conductivity(coil) * own.width * own.thickness for coil, own in zip(coils, bars, strict=True)]
    return np.array([own.x.size / section for own, section in zip(bars, sections, strict=True)])
