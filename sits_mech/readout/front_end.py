"""Set the converter for given coils, and tell how fast and how quiet it is then, and what it cannot follow.

For every coil over all loads, L from L_low to L_high with R_p from R_p_low to R_p_high:

    input divider      the part's least that keeps f below f_ref / 4 and is no 1 from 8.75 MHz on
    SETTLECOUNT        at least Q f_ref / (16 f), for the amplitude to settle after the switch to a channel
    gain, OFFSET       the largest gain of the output that keeps the codes of each coil in the middle half of its window
    drive              the largest current whose amplitude (4/pi) R_p I stays below the greatest allowed at R_p_high
                       (parts that regulate it, as the LDC1101: the largest R_p_min below 0.8 R_p_low)
    time of a coil     settling 16 SETTLECOUNT / f_ref + conversion (16 RCOUNT + 4) / f_ref + switch 692 ns + 5 / f_ref

The channels go one after the other; an idle coil is grounded by the part. A single coil neither settles nor switches
between conversions. Sources: data sheets SNOSCY9A, SNOSCZ0A and SNOSD01D.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import Array
from sits_mech.readout.converter import (
    Converter,
    FrontEnd,
    code_of,
    conversion_time,
    inductance_noise,
    parallel_resistance,
    relative_noise,
    tank_frequency,
)


def front_end(
    part: Converter, L: ArrayLike, R: ArrayLike, capacitance: float, *, clock: float | None = None,
    rcount: int = 0xFFFF,
) -> FrontEnd:
    """Return a converter's settings for n coils over m loads, L and R (m, n) at the terminals, leads included [H, ohm].

    `capacitance` is across each coil, of pins and cable too [F]; `clock` external, the part's greatest by default [Hz];
    `rcount` the reference count: longer conversions are quieter. ValueError when one of these is none the part can
    have.
    """
    L, R = np.atleast_2d(np.asarray(L, dtype=float)), np.atleast_2d(np.asarray(R, dtype=float))
    clock = check_settings(part, clock, rcount)
    if L.shape != R.shape or not L.size or not (np.all(np.isfinite(L)) and np.all(R > 0.0)):
        raise ValueError(f"L and R: must be finite, positive and of one shape; got {L.shape} and {R.shape}")
    f, R_p = tank_frequency(L, capacitance, R), parallel_resistance(L, R, capacitance)
    if np.isnan(f).any():
        raise ValueError(f"R: must let every coil swing, below sqrt(L / C); got up to {R.max():.4g} ohm")
    divider, reference_divider = _dividers(part, float(f.max()), clock, L.shape[1])
    reference = clock / reference_divider
    Q = 2.0 * np.pi * f * L / R
    settle = np.maximum(4, np.ceil((Q / f).max(axis=0) * reference / 16.0)).astype(int)
    drive = _drive(part, R_p)
    amplitude = 4.0 / np.pi * R_p * np.asarray(part.drive)[drive]
    if part.R_p_min:
        amplitude = np.full_like(R_p, part.amplitude[1])
    several = min(L.shape[1], part.channels) > 1
    switching = 16.0 * settle / reference + part.switch[0] + part.switch[1] / reference
    times = conversion_time(rcount, part, reference) + several * switching
    gain, offset = _window(part, f / (divider * reference))
    own = relative_noise(f, part, reference, rcount, divider, gain=gain)
    found = FrontEnd(
        part, reference, rcount, divider, reference_divider, np.minimum(settle, 0xFFFF), drive, _ends(f),
        _ends(code_of(f, part, reference, divider, gain=gain, offset=offset)), _ends(R_p), _ends(Q), _ends(amplitude),
        times, float(1.0 / times.sum()), inductance_noise(L.max(axis=0), own.max(axis=0)), (), (), gain, offset,
    )
    return replace(found, warnings=_warnings(found, settle), registers=part.registers(found))


def register_text(found: FrontEnd) -> str:
    """Return the registers as text, one line each: address, value, name."""
    digits = found.part.register_bits // 4
    return "\n".join(f"0x{address:02X} = 0x{value:0{digits}X}  {name}" for address, name, value in found.registers)


def check_settings(part: Converter, clock: float | None, rcount: int) -> float:
    """Return the clock, the part's greatest by default [Hz]; refuse one, or a count, that the part cannot have.

    One beyond what may come from outside is the part's own oscillator.
    """
    clock = part.clock[1] if clock is None else clock
    low, high = part.clock
    highest = part.internal[2] if part.internal else high
    if not low <= clock <= highest:
        own = f", or its own, up to {highest:g} Hz" if part.internal else ""
        raise ValueError(f"clock: must be from {low:g} to {high:g} Hz{own} for the {part.name}; got {clock:g} Hz")
    if not part.rcount[0] <= rcount <= part.rcount[1] or rcount != int(rcount):
        low, high = part.rcount
        raise ValueError(f"rcount: must be from {low} to {high} for the {part.name}; got {rcount}")
    return clock


def _ends(values: Array) -> Array:
    """Return the least and the greatest of each coil, shape (n, 2)."""
    return np.stack([values.min(axis=0), values.max(axis=0)], -1)


def _dividers(part: Converter, highest: float, clock: float, coils: int) -> tuple[int, int]:
    """Return the divider of the coil's frequency and of the clock."""
    limit = part.reference[0 if min(coils, part.channels) > 1 else 1]
    reference_divider = int(np.ceil(clock / limit - 1e-9))
    reference = clock / reference_divider
    fits = [d for d in part.dividers if highest / d < reference / part.ratio and (d > 1 or highest < part.divide_from)]
    return (fits[0] if fits else part.dividers[-1]), reference_divider


def _window(part: Converter, share: Array) -> tuple[int, Array]:
    """Return output gain and offsets (n,) of frequencies over the reference (m, n)."""
    low, high = share.min(axis=0), share.max(axis=0)
    gain = max((gain for gain in part.gains if np.max(high - low) <= 0.5 / gain), default=1)
    middle = np.rint(2.0**16 * (0.5 * (low + high) - 0.5 / gain))
    return gain, np.maximum(middle, 0.0) if gain > 1 else np.zeros(len(low))


def _drive(part: Converter, R_p: Array) -> Array:
    """Return the drive's code of each coil."""
    if part.R_p_min:
        fits = 0.8 * R_p.min(axis=0)[:, None] >= np.asarray(part.R_p_min)
        return np.where(fits.any(axis=1), fits.argmax(axis=1), len(part.R_p_min) - 1)
    peaks = 4.0 / np.pi * np.outer(R_p.max(axis=0), part.drive)
    return np.asarray(np.maximum(np.sum(peaks <= part.amplitude[1] * (1.0 + 1e-6), axis=1) - 1, 0))


def _warnings(found: FrontEnd, settle: Array) -> tuple[str, ...]:
    """Return what the part cannot follow."""
    part, lines = found.part, []
    n = len(found.settlecount)
    if found.is_internal and part.internal:
        least, typical, most = part.internal
        lines.append(
            f"the part's own oscillator is anywhere from {least:g} to {most:g} Hz, {typical:g} Hz as a rule: codes of "
            f"all coils are off alike by up to {100.0 * (found.clock / least - 1.0):.0f} %, and drift with it"
        )
    if n > part.channels:
        lines.append(f"{n} coils, but the {part.name} reads {part.channels}: take {-(-n // part.channels)} of them")
    for coil in range(n):
        lines += [f"coil {coil + 1} {text}" for text in (*_tank_warnings(found, coil), *_swing_warnings(found, coil))]
        if settle[coil] > 0xFFFF:
            lines.append(f"coil {coil + 1} needs SETTLECOUNT {settle[coil]}, more than {0xFFFF}: lower the clock")
    return tuple(lines)


def _tank_warnings(found: FrontEnd, coil: int) -> list[str]:
    """Return what is wrong with the frequency and the resistance of a coil."""
    part, (slow, fast), (R_low, R_high) = found.part, found.frequency[coil], found.R_p[coil]
    lines = []
    if slow < part.frequency[0] or fast > part.frequency[1]:
        cure = "lower" if slow < part.frequency[0] else "raise"
        reach = f"{part.frequency[0]:g} to {part.frequency[1]:g} Hz of the {part.name}"
        lines.append(f"resonates at {slow:.4g} to {fast:.4g} Hz, outside {reach}: {cure} the capacitance")
    elif fast / found.input_divider >= found.reference / part.ratio:
        lines.append(f"is too fast at {fast:.4g} Hz for a reference of {found.reference:.4g} Hz: raise the clock")
    if R_low < part.R_p[0] or R_high > part.R_p[1]:
        lossy = "too lossy: less resistance, more inductance or less capacitance"
        way = lossy if R_low < part.R_p[0] else "more than the part damps: raise the capacitance"
        reach = f"{part.R_p[0]:g} to {part.R_p[1]:g} ohm"
        lines.append(f"has R_p of {R_low:.4g} to {R_high:.4g} ohm, outside {reach}: {way}")
    return lines


def _swing_warnings(found: FrontEnd, coil: int) -> list[str]:
    """Return what is wrong with the amplitude of a coil; a part that regulates it has none."""
    (low, high), (least, most) = found.amplitude[coil], found.part.amplitude
    if found.part.R_p_min:
        return []
    lines = []
    if low < least * (1.0 - 1e-6):
        stop = "it may stop" if low < found.part.stops_below else "more noise"
        lines.append(f"swings {low:.3g} to {high:.3g} V, less than {least:g} V: {stop}")
    if high > most * (1.0 + 1e-6):
        lines.append(f"swings up to {high:.3g} V, more than {most:g} V: it is clipped")
    return lines
