"""Model an inductance-to-digital converter: frequency, code, resistance, drive, noise of a coil, and back.

A coil L with R in series and C across it swings at w = 2 pi f where its impedance is real, which then is R_p:

    w^2 = 1 / (L C) - (R / L)^2,    L = (1 + sqrt(1 - (2 w C R)^2)) / (2 w^2 C),    Q = w L / R,    R_p = L / (R C)
    amplitude = (4 / pi) R_p I_drive
    code = g 2^bits (f / d_in / f_ref - OFFSET / 2^16),    f_ref = f_clock / d_ref

d_in and d_ref the part's dividers, g its output gain: of its 16 bits a part of 12 shows those from the gain on, a
window of 1/g of the reference frequency that OFFSET moves. Beyond the window bits are lost.

Noise: the part counts for T = 16 RCOUNT / f_ref and places the N = f T edges it sees to within a period of the
reference; a line through them has the relative error of its slope

    sigma_f / f = 1.5 / (f_ref T sqrt(N)),    and rounding the code adds  1 / (sqrt(12) code);

1.5 is set by the one figure that the makers' note SNOA944 is quoted with: 8e-7 at f / f_ref = 0.1 and RCOUNT = 2048.
It is a default, not a measurement of your board. Then sigma_L / L = 2 sigma_f / f.

Neglected: delay of the part's driver; phase noise of the reference. Sources: data sheets SNOSCY9A (LDC1612, LDC1614),
SNOSCZ0A (LDC1312, LDC1314: gain and offset) and SNOSD01D (LDC1101), their pages on the web read for the limits, the
registers and 16 RCOUNT + 4; as quoted by published drivers of the parts: the drive's 32 currents, 692 ns +
5 / f_ref, 35 MHz for one coil alone, and of the LDC1101 16 RCOUNT + 55, MIN_FREQ and R_p_min.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import Array

_NEAR = 0.2  # of the solved frequency: nearer, skins are the same to some percent
Registers = tuple[tuple[int, str, int], ...]
_DEGLITCH = ((1e6, 0b001), (3.3e6, 0b100), (10e6, 0b101), (33e6, 0b111))  # bandwidth [Hz] and its code


_CONFIG, _EXTERNAL = 0x1401, 0x0200  # awake, own drive current; REF_CLK_SRC


def no_registers(found: FrontEnd) -> Registers:
    """Return none: those of the part are not known."""
    return ()


def registers_161x(found: FrontEnd) -> Registers:
    """Return the registers of the LDC1612 and LDC1614, each channel its own, the sequence of channels."""
    n = min(len(found.settlecount), found.part.channels)
    rows = [(0x08 + k, f"RCOUNT{k}", found.rcount) for k in range(n)]
    rows += [(0x10 + k, f"SETTLECOUNT{k}", int(found.settlecount[k])) for k in range(n)]
    dividers = (found.input_divider << 12) | found.reference_divider
    rows += [(0x14 + k, f"CLOCK_DIVIDERS{k}", dividers) for k in range(n)]
    rows += [(0x1E + k, f"DRIVE_CURRENT{k}", int(found.drive[k]) << 11) for k in range(n)]
    if found.gain > 1:
        rows += [(0x0C + k, f"OFFSET{k}", int(found.offset[k])) for k in range(n)]
        rows.append((0x1C, "RESET_DEV", found.part.gains.index(found.gain) << 9))
    highest = float(found.frequency.max())
    deglitch = next((code for width, code in _DEGLITCH if highest < width), _DEGLITCH[-1][1])
    sequence = (1 << 15) | (max(n - 2, 0) << 13) if n > 1 else 0
    rows.append((0x1B, "MUX_CONFIG", sequence | 0x0208 | deglitch))
    config = _CONFIG if found.is_internal else _CONFIG | _EXTERNAL
    return (*rows, (0x1A, "CONFIG", config))


def registers_1101(found: FrontEnd) -> Registers:
    """Return the registers of the LDC1101 in its high-resolution L mode; RP_MAX is off."""
    slowest = int(np.clip(np.floor(16.0 - 8e6 / found.frequency.min()), 0, 15))
    return (
        (0x01, "RP_SET", 0x80 | int(found.drive[0])),
        (0x04, "DIG_CONFIG", (slowest << 4) | 0x07),
        (0x05, "ALT_CONFIG", 0x01),
        (0x0C, "D_CONFIG", 0x01),
        (0x30, "LHR_RCOUNT_LSB", found.rcount & 0xFF),
        (0x31, "LHR_RCOUNT_MSB", found.rcount >> 8),
        (0x34, "LHR_CONFIG", int(np.log2(found.input_divider))),
        (0x0B, "START_CONFIG", 0x00),
    )


_NOISE = 1.5  # over the error of a line through ideal edges: see above


@dataclass(frozen=True)
class Converter:
    """What a part can do, from its data sheet; pairs are least and greatest."""

    name: str
    source: str  # of the numbers
    channels: int  # coils it reads one after the other
    bits: int  # of the code
    frequency: tuple[float, float]  # of the coil [Hz]
    R_p: tuple[float, float]  # parallel resistance it can drive [ohm]
    clock: tuple[float, float]  # external [Hz]
    reference: tuple[float, float]  # greatest reference frequency, reading several coils and one alone [Hz]
    ratio: float  # the coil's frequency, divided, stays below the reference frequency over this
    amplitude: tuple[float, float]  # recommended, peak [V]
    drive: tuple[float, ...]  # currents of the drive's settings, in the order of the codes [A]
    rcount: tuple[int, int]  # reference count
    overhead: float  # periods of the reference that a conversion takes besides 16 RCOUNT
    switch: tuple[float, float]  # time to go to the next channel: fixed [s], and in periods of the reference
    R_p_min: tuple[float, ...] = ()  # settings, descending, of a part that regulates its amplitude [ohm]
    dividers: tuple[int, ...] = (1,)  # of the coil's frequency
    divide_from: float = np.inf  # frequency of the coil from which on it must be divided [Hz]
    stops_below: float = 0.0  # amplitude below which the oscillation may stop, peak [V]
    register_bits: int = 16
    gains: tuple[int, ...] = (1,)  # of the output, ascending, of all channels
    flags: tuple[tuple[int, str], ...] = ()  # bits above a code that tell of a conversion that failed
    internal: tuple[float, float, float] | None = None  # its own oscillator: least, typical, greatest [Hz]
    registers: Callable[[FrontEnd], Registers] = no_registers  # what it is set up with


@dataclass(frozen=True)
class FrontEnd:
    """A converter set for a sensor; arrays are of shape (n,) or (n, 2), least and greatest, one entry a coil."""

    part: Converter
    reference: float  # frequency after its divider [Hz]
    rcount: int
    input_divider: int
    reference_divider: int
    settlecount: Array  # (n,) integers
    drive: Array  # (n,) codes
    frequency: Array  # (n, 2) [Hz]
    code: Array  # (n, 2)
    R_p: Array  # (n, 2) [ohm]
    Q: Array  # (n, 2)
    amplitude: Array  # (n, 2) [V]
    channel_time: Array  # (n,) settling and switching included [s]
    rate: float  # readings of all coils per second [1/s]
    noise: Array  # (n,) of each inductance, one standard deviation [H]
    warnings: tuple[str, ...]  # what the part cannot follow
    registers: tuple[tuple[int, str, int], ...]  # address, name and value of each
    gain: int  # of the output
    offset: Array  # (n,) integers, OFFSETx

    @property
    def clock(self) -> float:
        """Frequency before the divider [Hz]."""
        return self.reference * self.reference_divider

    @property
    def is_internal(self) -> bool:
        """Whether the part's own oscillator is the clock: a frequency that none from outside may have."""
        return self.part.internal is not None and self.clock > self.part.clock[1] * (1.0 + 1e-9)

    @property
    def below(self) -> Array:
        """Codes that the offset takes away, (n,): a code and these are in proportion to the frequency."""
        return self.gain * 2.0 ** (self.part.bits - 16) * self.offset

    @property
    def window(self) -> Array:
        """Frequencies of the least and the greatest code, (n, 2) [Hz]; beyond them a code says something else."""
        ends = np.array([0.0, 2.0**self.part.bits])
        return frequency_of(ends, self.part, self.reference, self.input_divider, gain=self.gain,
                            offset=self.offset[:, None])

    @property
    def period(self) -> float:
        """Time of a scan of all coils [s]."""
        return 1.0 / self.rate

    def off(self, solved: float) -> str:
        """Say where the tanks swing far from the frequency that was solved [Hz]; empty where they are near it."""
        middle = float(np.exp(np.log(self.frequency).mean()))
        if abs(math.log(middle / solved)) < math.log(1.0 + _NEAR):
            return ""
        return f", and L too, where the tanks swing at some {middle:.3g} Hz: set frequency to that and calibrate anew"


_ERRORS = (  # of DATAx_MSB, from its bit 12 on: SNOSCY9A, registers DATAx
    (0, "the amplitude"), (1, "the watchdog: no conversion"), (2, "over-range"), (3, "under-range"),
)
_DRIVE_161X = (
    16, 18, 20, 23, 28, 32, 40, 46, 52, 59, 72, 82, 95, 110, 127, 146, 169, 195, 212, 244, 297, 342, 424, 489, 551, 635,
    763, 880, 1017, 1173, 1355, 1563,
)
_R_P_MIN_1101 = (96e3, 48e3, 24e3, 12e3, 6e3, 3e3, 1.5e3, 0.75e3)  # [ohm] SNOSD01D, register RP_SET
_DIVIDE_FROM = 8.75e6  # [Hz] SNOSCY9A, registers CLOCK_DIVIDERSx: at least 2 from here on
_DRIVE_1101 = (4.7, 9.4, 18.7, 37.5, 75.0, 150.0, 300.0, 600.0)  # [uA] of these settings


def _ldc161x(name: str, channels: int) -> Converter:
    """Return the 28-bit parts, which differ by their channels."""
    return Converter(
        name=name, source="SNOSCY9A", channels=channels, bits=28, frequency=(1e3, 10e6), R_p=(1e3, 100e3),
        clock=(2e6, 40e6), reference=(40e6, 35e6), ratio=4.0, amplitude=(1.2, 1.8),
        drive=tuple(1e-6 * current for current in _DRIVE_161X), rcount=(9, 0xFFFF), overhead=4.0, switch=(692e-9, 5.0),
        dividers=(1, 2), divide_from=_DIVIDE_FROM, stops_below=0.5, registers=registers_161x, flags=_ERRORS,
        internal=(35e6, 43.4e6, 55e6),
    )


def _ldc131x(name: str, channels: int) -> Converter:
    """Return the 12-bit parts, whose window the output gain narrows, otherwise as those of 28 bits."""
    return replace(_ldc161x(name, channels), bits=12, source="SNOSCZ0A", gains=(1, 4, 8, 16))


CONVERTERS: Mapping[str, Converter] = {
    "LDC1614": _ldc161x("LDC1614", 4),
    "LDC1612": _ldc161x("LDC1612", 2),
    "LDC1314": _ldc131x("LDC1314", 4),
    "LDC1312": _ldc131x("LDC1312", 2),
    "LDC1101": Converter(
        name="LDC1101", source="SNOSD01D, high-resolution L mode", channels=1, bits=24, frequency=(500e3, 10e6),
        R_p=(1.25e3, 90e3), clock=(1e6, 16e6), reference=(16e6, 16e6), ratio=4.0, amplitude=(1.2, 1.2),
        drive=tuple(1e-6 * current for current in _DRIVE_1101), rcount=(2, 0xFFFF), overhead=55.0, switch=(0.0, 0.0),
        R_p_min=_R_P_MIN_1101, dividers=(1, 2, 4, 8), divide_from=_DIVIDE_FROM, register_bits=8,
        registers=registers_1101,
    ),
}
"""The parts by name."""


def converter(name: str) -> Converter:
    """Return a part by its name; raise ValueError when there is none."""
    if name not in CONVERTERS:
        raise ValueError(f"converter: must be one of {', '.join(CONVERTERS)}; got {name}")
    return CONVERTERS[name]


def fault(code: float, part: Converter) -> str:
    """Return what is wrong with a code as read, in words; "" where it may be of a coil.

    Error flags stand above the code's bits; no frequency and one beyond the reference give zero and full scale.
    """
    whole, full = int(code), 2**part.bits - 1
    flagged = [words for bit, words in part.flags if whole >> part.bits >> bit & 1]
    if flagged or whole > full:
        return f"the {part.name} flags {', '.join(flagged) or 'an error'}"
    beyond = ", or its frequency is out of range" + " of the window of gain and offset" * (len(part.gains) > 1)
    if whole == full:
        return f"full scale: the coil is open or does not swing{beyond}"
    return f"zero: the coil is shorted or does not swing{beyond * (len(part.gains) > 1)}" if whole == 0 else ""


def tank_frequency(L: ArrayLike, capacitance: float, R: ArrayLike = 0.0) -> Array:
    """Return where inductances [H] with R [ohm] in series resonate with a capacitance [F] across them [Hz].

    NaN of one that is damped too much to resonate; L and capacitance must be positive (ValueError).
    """
    L, R = np.asarray(L, dtype=float), np.asarray(R, dtype=float)
    if not (capacitance > 0.0 and np.all(L > 0.0)):
        raise ValueError(f"L and capacitance: must be positive; got at least {np.min(L):g} H and {capacitance:g} F")
    square = 1.0 / (L * capacitance) - (R / L) ** 2
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)) / (2.0 * np.pi))


def tank_inductance(frequency: ArrayLike, capacitance: float, R: ArrayLike = 0.0) -> Array:
    """Return the inductance [H] that resonates at a frequency [Hz]; `tank_frequency` backwards, NaN where none does."""
    omega = 2.0 * np.pi * np.asarray(frequency, dtype=float)
    square = 1.0 - (2.0 * omega * capacitance * np.asarray(R, dtype=float)) ** 2
    return np.asarray((1.0 + np.sqrt(np.where(square >= 0.0, square, np.nan))) / (2.0 * omega**2 * capacitance))


def parallel_resistance(L: ArrayLike, R: ArrayLike, capacitance: float) -> Array:
    """Return R_p [ohm] of inductances [H] with series resistances [ohm] at resonance with a capacitance [F]."""
    return np.asarray(L, dtype=float) / (np.asarray(R, dtype=float) * capacitance)


def code_of(
    frequency: ArrayLike, part: Converter, reference: float, divider: int = 1, *, gain: int = 1, offset: ArrayLike = 0
) -> Array:
    """Return the code [-], not rounded, of coil frequencies [Hz] with a reference frequency [Hz] and input divider.

    `gain` is that of the output, `offset` the register OFFSETx of each coil.
    """
    share = np.asarray(frequency, dtype=float) / (divider * reference)
    return np.asarray(gain * 2.0**part.bits * (share - np.asarray(offset) / 2.0**16))


def frequency_of(
    code: ArrayLike, part: Converter, reference: float, divider: int = 1, *, gain: int = 1, offset: ArrayLike = 0
) -> Array:
    """Return the coil's frequency [Hz] of codes; `code_of` backwards."""
    share = np.asarray(code, dtype=float) / (gain * 2.0**part.bits) + np.asarray(offset) / 2.0**16
    return np.asarray(share * divider * reference)


def conversion_time(rcount: int, part: Converter, reference: float) -> float:
    """Return how long one conversion takes [s]: (16 RCOUNT + overhead) / f_ref."""
    return (16.0 * rcount + part.overhead) / reference


def relative_noise(
    frequency: ArrayLike, part: Converter, reference: float, rcount: int, divider: int = 1, *, gain: int = 1
) -> Array:
    """Return the default relative noise of the frequency, one standard deviation: counting and rounding [-]."""
    f = np.asarray(frequency, dtype=float) / divider
    duration = 16.0 * rcount / reference
    counting = _NOISE / (reference * duration * np.sqrt(f * duration))
    rounding = 1.0 / (np.sqrt(12.0) * code_of(f, part, reference, gain=gain))
    return np.asarray(np.hypot(counting, rounding))


def inductance_noise(L: ArrayLike, relative: ArrayLike) -> Array:
    """Return the noise of inductances [H] from the relative noise of the frequency: twice as much, relative to L."""
    return np.asarray(2.0 * np.asarray(L, dtype=float) * np.asarray(relative, dtype=float))
