"""Convert a load history to codes and their times: the converter reads coil after coil while the inductances change.

What each coil shows at the end of its leads (analysis/spectrum.py) is interpolated from solved times to all others
between the corners of the load (response.py, `between`).

The channels go round in their order; channel k of scan s takes ``channel_time[k]`` (readout/front_end.py):

    | settling 16 SETTLECOUNT/f_ref | counting T = 16 RCOUNT/f_ref | overhead/f_ref | switch |

and a coil alone neither settles nor switches. Its code is the mean of the coil's frequency while it is counted,

    code = round(the code of (1/T) int_(t - T/2)^(t + T/2) f dt + noise),    f of L(t) and R(t) (readout/converter.py),

with t the middle of its own window: a load that moves is smeared over T, as ``sin(pi nu T)/(pi nu T)`` at the frequency
nu, and coils are read at different times. *Assumed*: a count of periods over the window, each of one weight; how the
parts weigh edges inside the window is not published. (A line fitted through all edges would weigh f by 6 u (1 - u), u
from 0 to 1 over the window: the same middle, a blur 0.77 as wide.)

Noise is white from sample to sample, with the converter's deviation less that of rounding, which is done here. Noise of
lower frequency (1/f, drift of the reference) is unknown for these parts, and none is added.

Between samples of the history the frequency is a piecewise cubic that overshoots nowhere (F. N. Fritsch, R. E. Carlson,
SIAM J. Numer. Anal. 17 (1980) 238), integrated exactly. Neglected: how the tank settles after the switch to its
channel; a resonance that lags its L. Source: data sheets SNOSCY9A, SNOSD01D.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from sits_mech.analysis.histories.interpolant import Interpolant
from sits_mech.analysis.readings.bench import absolute, table_impedance
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.labels import labelled
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.notes import Note, NoteKind, packed, unpacked
from sits_mech.quantities import WRENCH, Array
from sits_mech.readout.converter import FrontEnd, code_of, converter, frequency_of, tank_frequency, tank_inductance
from sits_mech.readout.front_end import front_end
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.scene.thermal import at_temperature, clock_factor

_MOST = 10_000_000  # samples of all coils


@dataclass(frozen=True)
class Samples:
    """What a converter gives over time; one row a scan, one column a coil."""

    time: Array  # (m, n) middle of the window in which each code was counted [s]
    ready: Array  # (m, n) when it can be read [s]
    code: NDArray[np.int64]  # (m, n)
    L: Array  # (m, n) inductances that the codes stand for, at the coils' terminals [H]
    window: float  # how long a code is counted [s]
    period: float  # how long a scan of all coils takes [s]


def scan(
    front: FrontEnd, capacitance: float, time: ArrayLike, L: ArrayLike, R: ArrayLike = 0.0, *,
    seed: int | np.random.Generator | None = 0,
) -> Samples:
    """Return the codes of a converter, all scans that end within the history, while inductances change.

    `time` (k,) rises [s], `L` (k, n) is at the terminals [H], and `R`, alike or one [ohm]; `front` is set for these
    coils over their range; `seed` is of the noise, None for none. The first channel begins to settle with the history.
    ValueError when time does not rise, L is not one positive number for each time and coil, or there is no scan, or too
    many.
    """
    time, L = np.asarray(time, dtype=float), np.asarray(L, dtype=float)
    _check(front, time, L)
    R = np.broadcast_to(np.asarray(R, dtype=float), L.shape)
    first = float(time[0])
    begin, window = windows(front)
    scans = int(np.floor((float(time[-1]) - first) / front.period * (1.0 + 1e-12)))
    if scans <= 0:
        raise ValueError(f"time: must last one scan of {front.period:.4g} s; got {time[-1] - first:.4g} s")
    if scans * L.shape[1] > _MOST:
        raise ValueError(f"time: must hold at most {_MOST} samples; got {scans} scans of {front.period:.4g} s")
    opened = first + front.period * np.arange(scans)[:, None] + begin
    frequency = tank_frequency(L, capacitance, R)
    mean, lossy = (
        np.stack([_mean(time, part[:, k], opened[:, k], window) for k in range(L.shape[1])], axis=1)
        for part in (frequency, R)
    )
    if seed is not None:
        noise = np.random.default_rng(seed).standard_normal(mean.shape)
        mean = mean * (1.0 + _deviation(front, capacitance) * noise)
    exact = code_of(mean, front.part, front.reference, front.input_divider, gain=front.gain, offset=front.offset)
    code = np.clip(np.rint(exact), 1, 2**front.part.bits - 1).astype(np.int64)
    shown = frequency_of(
        code, front.part, front.reference, front.input_divider, gain=front.gain, offset=front.offset
    )
    ready = opened + window + front.part.overhead / front.reference
    return Samples(opened + 0.5 * window, ready, code, tank_inductance(shown, capacitance, lossy), window, front.period)


def windows(front: FrontEnd) -> tuple[Array, float]:
    """Return when each channel begins to be counted after a scan begins, shape (n,), and for how long [s]."""
    window = 16.0 * front.rcount / front.reference
    several = len(front.channel_time) > 1 and front.part.channels > 1
    settling = several * 16.0 * np.asarray(front.settlecount, dtype=float) / front.reference
    return np.cumsum(np.r_[0.0, front.channel_time[:-1]]) + settling, window


def _mean(time: Array, frequency: Array, opened: Array, window: float) -> Array:
    """Return the mean frequency over windows; of a constant one it is that, to the last digit."""
    piece = PchipInterpolator(time, frequency - frequency[0]).antiderivative()
    closed = np.minimum(opened + window, time[-1])
    return np.asarray(frequency[0] + (piece(closed) - piece(opened)) / window)


def _deviation(front: FrontEnd, capacitance: float) -> Array:
    """Return the relative deviation of each coil's frequency without that of rounding, shape (n,)."""
    lossless = tank_inductance(front.frequency[:, 0], capacitance)  # where L is largest, of which the noise is
    whole = front.noise * (1.0 + front.Q[:, 0] ** -2) / (2.0 * lossless)
    rounding = 1.0 / (np.sqrt(12.0) * (front.code[:, 0] + front.below))
    return np.asarray(np.sqrt(np.maximum(whole**2 - rounding**2, 0.0)))


def _check(front: FrontEnd, time: Array, L: Array) -> None:
    """Refuse a history that is none."""
    coils = len(front.channel_time)
    if time.ndim != 1 or time.size < 2 or not np.all(np.diff(time) > 0.0):
        raise ValueError(f"time: must rise from one sample to the next, of at least two; got {_first_fault(time)}")
    if L.shape != (time.size, coils) or not np.all(np.isfinite(L) & (L > 0.0)):
        raise ValueError(f"L: must be positive, of shape {(time.size, coils)}; got {L.shape}, least {np.min(L):g} H")


def _first_fault(time: Array) -> str:
    """Say where time does not rise."""
    if time.ndim != 1 or time.size < 2:
        return f"shape {time.shape}"
    k = int(np.argmin(np.diff(time) > 0.0))
    return f"{time[k]:g} s and then {time[k + 1]:g} s"


_FINE = 8  # times between two solved ones, of what the converter is given


def checked_count(sensor: Sensor, rcount: int | None) -> int:
    """Return a reference count of the scene's converter, by default its greatest; raise SceneError for a bad one."""
    if sensor.readout.converter == "none":
        if rcount is None:
            return 0
        raise SceneError(f'rcount: must be left out with readout.converter = "none"; got {rcount}')
    low, high = converter(sensor.readout.converter).rcount
    if rcount is not None and not low <= rcount <= high:
        raise SceneError(f"rcount: must be from {low} to {high} for the {sensor.readout.converter}; got {rcount}")
    return high if rcount is None else rcount


def with_codes(sensor: Sensor, data: xr.Dataset, *, rcount: int = 0xFFFF, seed: int | None = 0) -> xr.Dataset:
    """Return a history from `in_time` with the codes of the converter.

    Adds, by ``scan`` and coil, ``code``, ``code_time`` (the middle of its window), ``code_ready`` [s] and ``code_L`` at
    the terminals [H]; attributes ``window`` and ``period`` [s], ``rcount`` (longer conversions are quieter, and smear
    more). `seed` None: no noise. Without a converter that can follow, the history with the reason in its ``notes``.
    """
    try:
        return _scanned(sensor, data, rcount, seed)
    except ValueError as reason:
        none = Note.of(NoteKind.NO_CODES, text=str(reason))
        return data.assign_attrs(notes=packed((*unpacked(data.attrs["notes"]), none)))


def _scanned(sensor: Sensor, data: xr.Dataset, rcount: int, seed: int | None) -> xr.Dataset:
    """Return the history with codes; raise ValueError where there are none."""
    if sensor.readout.converter == "none":
        raise ValueError("the scene has no converter")
    seen, reasons = at_terminals(sensor, absolute(sensor, table_impedance(data, ("time",)))[0])
    if seen is None:
        raise ValueError("; ".join(reasons))
    part, C = converter(sensor.readout.converter), at_temperature(sensor).readout.parallel_capacitance
    front = front_end(part, seen.L, seen.R, C, rcount=rcount)
    front = replace(front, reference=clock_factor(sensor) * front.reference)
    time, load = data["time"].to_numpy(), np.stack([data[name].to_numpy() for name in WRENCH], axis=1)
    every = np.interp(np.arange(_FINE * (len(time) - 1) + 1) / _FINE, np.arange(len(time)), time)
    corners = LoadHistory(time, load).corners
    L, R = (Interpolant(time, corners, part).at(every)[0] for part in (seen.L, seen.R))
    found = scan(front, C, every, L, R, seed=seed)
    dims = ("scan", "coil")
    columns = {"code": found.code, "code_time": found.time, "code_ready": found.ready, "code_L": found.L}
    data = data.assign({name: (dims, values) for name, values in columns.items()})
    data = data.set_coords(["code_time", "code_ready"])
    return labelled(data.assign_attrs(window=found.window, period=found.period, rcount=rcount))
