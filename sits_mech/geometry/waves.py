"""Find the frequency above which a coil is no longer short against a wave, and no model here holds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from scipy.constants import c

from sits_mech.geometry.tracks import track_length
from sits_mech.scene.sensor import Coil


def check_frequency(coils: Sequence[Coil], frequency: float) -> None:
    """Refuse a frequency that is not positive or at which a track is as long as a wave in free space (ValueError)."""
    if not 0.0 < frequency < math.inf:
        raise ValueError(f"frequency: must be a positive number of hertz, got {frequency}")
    coil = max(coils, key=track_length)
    length = track_length(coil)
    if frequency * length > c:
        raise ValueError(
            f"frequency: must be below {c / length:.3g} Hz, where a wave is as long as the track of coil {coil.name} "
            f"({length:.3g} m), got {frequency:g} Hz; no model here holds waves: it takes a full-wave solver"
        )


def wave_notes(coils: Sequence[Coil], frequency: float) -> tuple[str, ...]:
    """Say where a track is longer than a tenth of a wave: near its self-resonance, which no model here holds."""
    coil = max(coils, key=track_length)
    share = frequency * track_length(coil) / c
    if share < 0.1:
        return ()
    return (
        f"displacement current: the track of {coil.name} is {share:.2g} waves long at {frequency:.3g} Hz; what its "
        "turns' own capacitance adds is not held",
    )
