"""Calculate L(f), R(f), Q(f) of one pose, and what is seen at the terminals.

    Q_i = omega L_ii / (R_ii + R_track,i),

R_track the direct-current resistance: R_ii has skin and proximity effect of models in henry and ohm, not of planar
ones, which are per metre. At the terminals a coil shows, with the tracks and the leads in series and the idle coils
open or shorted,

    Z_i = R_i + j omega L_i  (`coils.terminals`),    Q_i = omega L_i / R_i,

and with the readout's capacitance across them the apparent ``Z_i / (1 + j omega C Z_i)``, which grows towards the
tank's own resonance and is capacitive above.

What skin and proximity effect add to the tracks' resistance and take from L in free space, both in these, are shown
beside them (`R_ac`, `shift`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from sits_mech.analysis.readings.terminals import own_capacitance, pulling, terminal_impedance, with_capacitance
from sits_mech.arguments import checked_arguments
from sits_mech.geometry.tracks import wave_notes
from sits_mech.geometry.windings import unnamed
from sits_mech.magnetics.coils.resistance import track_resistance
from sits_mech.magnetics.coils.tracks import Tracks, with_tracks
from sits_mech.notes import Note, Omission, OmissionKind
from sits_mech.quantities import Array, Impedance, MagneticModel, Pose, SolveReport, kept_report
from sits_mech.readout.converter import CONVERTERS, tank_frequency
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.scene.thermal import at_temperature

if TYPE_CHECKING:
    import xarray as xr

_AT_TERMINALS = (
    "terminal_L", "terminal_R", "terminal_Q", "apparent_L", "apparent_R", "apparent_Q", "tank_frequency",
    "own_capacitance", "self_resonance",
)
_PER_METRE = "terminals: the model is per metre of depth, leads and idle coils are in henry and ohm"


@dataclass(frozen=True)
class Terminals:
    """What each coil shows at the end of its leads; all of shape (..., n).

    The apparent ones are with the readout's capacitance across the terminals: negative L above the tank's resonance.
    """

    L: Array  # before the capacitance [H]
    R: Array  # likewise [ohm]
    R_ac: Array  # of the tracks in free space [ohm]
    Q: Array  # omega L / R
    shift: Array  # what skin and proximity effect take from L in free space, contained in L [H]
    apparent_L: Array  # [H]
    apparent_R: Array  # [ohm]
    apparent_Q: Array
    tank_frequency: Array  # resonance with L and R of this frequency; NaN if damped too much [Hz]
    own_capacitance: Array  # estimate, of the tracks, not contained in any of these; 0 of a single turn [F]
    self_resonance: Array  # estimate, of L with it alone; NaN of a single turn [Hz]


def at_terminals(sensor: Sensor, found: Impedance) -> tuple[Terminals | None, tuple[str, ...]]:
    """Return what each coil shows at its terminals, or None per metre, and what was left out, with the reason."""
    sensor = at_temperature(sensor)
    missing = wave_notes(sensor.coils, found.frequency)
    if found.unit_L != "H":
        return None, (_PER_METRE, *missing)
    missing = (*_rings(sensor), *_idle_words(sensor, found), *missing)
    return _terminals(sensor, _uneven(sensor, found)), missing


@checked_arguments
def spectrum(sensor: Sensor, model: MagneticModel, pose: Pose, frequencies: Sequence[float]) -> xr.Dataset:
    """Return what the coils show at one pose over a range of frequencies.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    model : MagneticModel
        Of the sensor.
    pose : Pose of float
    frequencies : sequence of float
        Different positive numbers [Hz].

    Returns
    -------
    Dataset, dims (frequency, coil, coil_2)
        ``L, R, error_L, error_R, error_L0, Q, R_track, L0, R_dc``, in the model's unit; in henry and ohm also
        ``terminal_L, terminal_R, terminal_Q, shift``, the apparent ones and ``tank_frequency`` (`Terminals`).
        Attributes: ``unit_L`` and ``report``, as JSON.

    Raises
    ------
    SceneError
        When the frequencies are none, not positive or not different.

    Examples
    --------
    >>> sensor = sm.load_sensor("biorob2018")
    >>> model, _ = sm.magnetic_model(sensor, "planar")
    >>> result = sm.spectrum(sensor, model, sm.Pose(0.0, 2e-3), [1e4, 1e6])
    >>> result["R"].sel(coil="C1", coil_2="C1").values.round(2).tolist()  # ohm/m
    [0.29, 9.34]
    """
    import xarray as xr

    sensor, hertz = at_temperature(sensor), np.array(sorted(frequencies), dtype=float)
    if not (hertz.size and np.all(np.diff(hertz, prepend=0.0) > 0.0)):
        raise SceneError(f"frequencies must be one or more different positive numbers [Hz]; got {list(frequencies)}")
    order = sorted(hertz.tolist(), key=lambda f: (f == sensor.frequency, -f))  # what is prepared first serves all
    each = sorted(map(partial(model.impedance, pose), order), key=lambda found: found.frequency)
    per_metre = each[0].unit_L != "H"
    missing = ((_PER_METRE,) if per_metre else _rings(sensor)) + wave_notes(sensor.coils, float(hertz[-1]))
    each = [_uneven(sensor, found) for found in each]
    names = sensor.coil_names
    pair = ("frequency", "coil", "coil_2")
    data = xr.Dataset(coords={"frequency": hertz, "coil": names, "coil_2": names})
    for name in ("L", "R", "error_L", "error_R"):
        data[name] = (pair, np.array([getattr(found, name) for found in each]))
    data["error_L0"] = pair, np.array([0.0 * f.L0 if f.error_L0 is None else f.error_L0 for f in each])
    data["L0"], data["R_dc"] = (pair[1:], each[-1].L0), (pair[1:2], each[0].R_dc)
    own_L, own_R = np.diagonal(data["L"], axis1=1, axis2=2), np.diagonal(data["R"], axis1=1, axis2=2)
    data["Q"] = (pair[:2], 2.0 * np.pi * hertz[:, None] * own_L / (own_R + each[0].R_dc))
    if per_metre:
        data["R_track"] = (pair[:2], np.tile(each[0].R_dc, (hertz.size, 1)))
    else:
        seen = [_terminals(sensor, found) for found in each]
        for name in (*_AT_TERMINALS, "shift"):
            data[name] = (pair[:2], np.array([getattr(item, name.removeprefix("terminal_")) for item in seen]))
        data["R_track"] = (pair[:2], np.array([item.R_ac for item in seen]))
    stated = (Omission(OmissionKind.STATED, counts=False, numbers=(("text", text),)) for text in missing)
    report = replace(_joined(each, hertz), left_out=(*_largest(each), *stated))
    return data.assign_attrs(unit_L=each[0].unit_L, name=sensor.name, report=kept_report(report))


def _idle_words(sensor: Sensor, found: Impedance) -> tuple[str, ...]:
    """Say where tanks swing at the same time, and what they do to each other."""
    n, readout = len(sensor.coils), sensor.readout
    if readout.idle_coil == "live":
        omega = 2.0 * np.pi * found.frequency
        return pulling(found.R + 1j * omega * found.L, sensor.coil_names, omega)
    channels = 0 if readout.converter == "none" else CONVERTERS[readout.converter].channels
    if 0 < channels < n:
        return (f'idle coils: {n} coils take {-(-n // channels)} of {readout.converter}, whose tanks swing at the same '
                'time: readout.idle_coil = "live" holds that',)
    return ()


def _uneven(sensor: Sensor, found: Impedance) -> Impedance:
    """Return an impedance with uneven current in the tracks."""
    return with_tracks(Tracks(sensor.coils, found.frequency, sensor.frequency), found)


def _terminals(sensor: Sensor, found: Impedance) -> Terminals:
    """Return the network of coils, tracks, leads and idle coils at one frequency."""
    omega = 2.0 * np.pi * found.frequency
    windings = unnamed(sensor.coils)
    R_dc = np.array([*map(track_resistance, windings)])
    Z = terminal_impedance(found.R + 1j * omega * found.L, R_dc, sensor.readout, omega)
    shape, capacitance = Z.real.shape, sensor.readout.parallel_capacitance
    tank = with_capacitance(Z, capacitance, omega)
    own = np.broadcast_to([own_capacitance(coil) for coil in windings], shape)
    alone = [own.alone for own in Tracks(sensor.coils, found.frequency, sensor.frequency).responses]
    R_ac, shift = R_dc + np.real(alone), np.imag(alone) / omega
    return Terminals(
        Z.imag / omega, Z.real, np.broadcast_to(R_ac, shape), Z.imag / Z.real, np.broadcast_to(shift, shape),
        tank.imag / omega, tank.real, tank.imag / tank.real, tank_frequency(Z.imag / omega, capacitance, Z.real), own,
        1.0 / (2.0 * np.pi * np.sqrt(Z.imag / omega * np.where(own > 0.0, own, np.nan))),
    )


def _rings(sensor: Sensor) -> tuple[str, ...]:
    """Say of which coils uneven current is that of rings that stand for them."""
    straight = ", ".join(coil.name for coil in sensor.coils if not coil.is_round)
    return (f"uneven current along straight tracks: {straight} as rings of its turns and length",) if straight else ()


def _joined(found: Sequence[Impedance], hertz: Array) -> SolveReport:
    """Join the reports of all solves: the worst of each; notes of the lowest and the highest frequency."""
    notes, reports = list[Note](), [each.report for each in found]
    for k in sorted({0, len(reports) - 1}):
        notes += [note.with_numbers(at_frequency=float(hertz[k])) for note in reports[k].notes]
    return SolveReport(
        reports[0].model,
        max(report.unknowns for report in reports),
        sum(report.iterations for report in reports),
        max(report.residual for report in reports),
        max(report.estimated_error for report in reports),
        sum(report.seconds for report in reports),
        notes=tuple(notes),
    )


def _largest(found: Sequence[Impedance]) -> tuple[Omission, ...]:
    """Return what is left out at any frequency, each where it has no size or the largest."""
    worst = dict[OmissionKind, Omission]()
    for item in chain.from_iterable(each.report.left_out for each in found):
        before = worst.get(item.kind)
        if before is None or not item.size <= before.size:
            worst[item.kind] = item
    return tuple(worst.values())
