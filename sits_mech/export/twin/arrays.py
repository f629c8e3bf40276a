"""Collect the numbers of a twin: arrays alone, each with a line that says what it is, in SI.

Maps over wrenches and poses (`maps`), the pad's compliance at rest, its relaxation and creep (`silicone.history`),
noise, converter and sampling (`readout.front_end`), temperature where the table tells it, where all of it came from.
What is not known is an array without entries, or NaN where a number of each coil or component would stand.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sits_mech.analysis.histories.scan import windows
from sits_mech.analysis.readings.bench import model_errors, self_inductances, sensor_calibration, sensor_front_end
from sits_mech.chain.models import mechanical_model
from sits_mech.export.source import Source
from sits_mech.export.twin.maps import guess_of, over_poses, over_wrenches
from sits_mech.mechanics.touch import check_untouched
from sits_mech.quantities import Array, SolveFailed, Wrench, tensor_grid
from sits_mech.readout.calibration import OK, Calibration, check_resolved
from sits_mech.readout.converter import FrontEnd, conversion_time
from sits_mech.readout.inversion import INCONSISTENT, MARGIN
from sits_mech.readout.loads import answered, load_words, several, varied
from sits_mech.readout.quality import reading_errors
from sits_mech.scene.sensor import SceneError, silicone_of
from sits_mech.silicone.history import retardation
from sits_mech.version import __version__

_EXACT = 1e-3  # residual of as many coils as forces, of the range: what single precision leaves
ABOUT = {
    "about": "this list: a name and what it is",
    "coils": "names, in the order of readings and of the converter's channels",
    "MAP_powers": "degrees of each product of Chebyshev's polynomials, (terms, d)",
    "MAP_coefficients": "(outputs, terms): inductances [H], then codes; of wrench, pose and the two guesses",
    "MAP_coefficients_float32": "the same in single precision",
    "MAP_base": "(outputs,): what is added to the sum",
    "MAP_low, MAP_high": "domain of the d components that vary [N, N m, m, rad]",
    "MAP_columns, MAP_fixed": "which of the six components these are; what the others are",
    "MAP_error": "(outputs,): largest error of the map where it predicts what it was not fitted to [H, codes]",
    "model_error": "(coils,): largest estimated error of the solved inductances themselves [H]",
    "force_error": "(d,): half width that holds 90 % of the true forces, median over the loads [N, N m]",
    "scale_L, scale_codes": "(coils,): range of each output over the table [H, codes]",
    "directions_L, directions_codes": "(d, coils + 1): what the guesses take of readings over their scale",
    "residual, margin": "of an estimate: largest misfit over the range; how far beyond the domain it counts [-]",
    "valid": "over a grid of the domain: 1 where no other wrench shows the same",
    "no_inverse": "why no wrench can be estimated; empty where it can",
    "codes": "1 with a converter, 0 without",
    "compliance": "(6, 6): of the target at rest [m, rad per N, N m], pose by wrench; NaN where the model has none",
    "rest_pose": "(6,): of the target without load [m, rad]",
    "load_height": "where the force acts above the target's bottom face [m]",
    "prony": "(branches, 2): shares of the instantaneous stiffness and times [s]; without rows: unknown",
    "relaxation_weights, relaxation_times": "of G(t) = 1 + sum w exp(-t/tau), stiffness over that at rest [-, s]",
    "creep_weights, creep_times": "of C(t) = 1 - sum c exp(-t/lambda), which undoes it [-, s]",
    "mullins": "(3,): r [-], m [Pa], beta [-] of the softening after the largest load; NaN: unknown. Not evaluated",
    "sigma_L": "(coils,): standard deviation of a reading over L, at rcount [-]; NaN without converter",
    "reference, bits, input_divider, reference_divider, rcount": "2^bits f/(input_divider reference) is the code",
    "gain, below": "of parts that show a window of it: gain times that less below, (coils,)",
    "capacitance": "across each coil [F]",
    "opened, conversion, channel_time": "(coils,): begin of counting in a scan, its length, all of a turn [s]",
    "slope_T_*": "by temperature over the table's loads: of inductances (..., coils) [H/K], poses [m/K, rad/K]",
    "slope_T_over_*, thermal_causes": "these loads [N, N m], an array for each force; parts of slope_T_L_by",
    "temperature_known": "1 where there are such slopes, 0 where the table tells none",
    "frequency": "that was solved for [Hz]",
    "scene, scene_hash, request, version": "where the numbers are from",
}
"""What each array is; MAP stands for ``wrench``, ``pose``, ``guess_L``, ``guess_codes``."""


def twin_arrays(source: Source) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return a twin's arrays and lines of notes; raise SceneError for an incomplete box or too few loads."""
    notes = list[str]()
    found, front = readout_arrays(source, "twin", notes)
    by_pose, note = over_poses(source, front)
    notes.append(note)
    found |= ({} if by_pose is None else by_pose.arrays("pose")) | _pad(source, notes) | _temperature(source)
    attrs = source.data.attrs
    origin = {name: np.array(attrs[name]) for name in ("scene", "scene_hash", "request") if name in attrs}
    about = np.array(list(ABOUT.items()))
    return {"about": about, **found, **origin, "version": np.array(__version__)}, tuple(notes)


def readout_arrays(source: Source, kind: str, notes: list[str]) -> tuple[dict[str, Any], FrontEnd | None]:
    """Return what wrenches show and what readings tell of them, for which nothing is solved, and the converter.

    `kind` is the format that refuses what has none; what is not known goes to `notes`.
    """
    check_box(source, kind)
    sensor = source.sensor
    cal = sensor_calibration(sensor, source.data)
    front: FrontEnd | None = None
    codes: Calibration | None = None
    try:
        front, codes = sensor_front_end(sensor, source.data)[0], cal.code_calibration
    except ValueError as error:
        notes.append(f"no codes: {error}")
    over = over_wrenches(source, cal, codes)
    share = float((over.error / np.concatenate([cal.full_scale, *([] if codes is None else [codes.full_scale])])).max())
    notes.append(f"wrenches: {len(over.powers)} terms over {', '.join(cal.forces)}, within {share:.1e} of the range")
    found = {"coils": np.array(cal.coils), "codes": np.array(int(codes is not None))}
    found |= over.arrays("wrench") | inverse_arrays(cal, codes, over.base, notes)
    found |= {"model_error": model_errors(sensor, source.data), "frequency": np.array(sensor.frequency)}
    return found | _sampling(source, front, cal), front


def check_box(source: Source, kind: str) -> None:
    """Refuse a table whose converged loads do not reach all corners of its box, or that has one load alone."""
    names = several(source.data)
    if not names:
        raise SceneError(f"--to {kind}: must be of a table with at least two values of a force; got one load")
    failed = ~answered(source.data)
    corners = failed.isel({name: [0, -1] for name in names})
    if bool(corners.any()):
        at = zip(corners.dims, np.argwhere(corners.to_numpy())[0], strict=True)
        first = load_words({str(name): float(corners[name][k]) for name, k in at})
        raise SceneError(
            f"--to {kind}: must be of a table whose corners have results, so that its domain is a box; "
            f"{int(failed.sum())} of {failed.size} loads failed, among them {first}: calibrate over less"
        )


def inverse_arrays(cal: Calibration, codes: Calibration | None, base: Array, notes: list[str]) -> dict[str, Any]:
    """Return what estimates wrenches, or append to `notes` why nothing does.

    `cal` is in henry, `codes` in codes where there are some; `base` (outputs,) is that of the map over wrenches.
    """
    n, d = len(cal.coils), len(cal.forces)
    try:
        check_resolved(cal)
    except ValueError as error:
        notes.append(f"no estimate of wrenches: {error}")
        return {"no_inverse": np.array(str(error))}
    found = {"no_inverse": np.array(""), "margin": np.array(MARGIN)}
    found["force_error"] = reading_errors(cal)[:, 1]
    found["residual"] = np.array(INCONSISTENT if n > d else _EXACT)
    axes = [np.linspace(-1.0, 1.0, count) for count in cal.domain.labels.shape]
    nodes = tensor_grid(*axes)
    found["valid"] = (cal.inverse(cal.forward(cal.map.unscaled(nodes))).status == OK).astype(np.uint8)
    for name, each, own in (("L", cal, base[:n]), ("codes", codes, base[n:])):
        if each is not None:
            scale = 1.0 / each.weights * (each.weights * each.full_scale).max()
            guess, directions = guess_of(each, own, scale)
            found |= guess.arrays(f"guess_{name}") | {f"scale_{name}": scale, f"directions_{name}": directions}
    if not found["valid"].all():
        share, where = 1.0 - found["valid"].mean(), "; ".join(cal.domain.regions)
        notes.append(f"{share:.1%} of the wrenches have no estimate: {where}")
    return found


def _pad(source: Source, notes: list[str]) -> dict[str, Any]:
    """Return compliance, pose at rest, relaxation and softening of the pad."""
    sensor, request = source.sensor, source.request
    check_untouched(sensor, "a twin, whose pad answers wrenches")
    model, _ = mechanical_model(sensor, request["mechanics"], request["tolerance"])
    compliance, rest = np.full((6, 6), np.nan), np.full(6, np.nan)
    try:
        found = model.equilibrium(Wrench())
        rest = found.pose.components
        if hasattr(model, "slopes"):
            compliance = model.slopes(found, (), sideways=True).compliance
    except SolveFailed as error:
        notes.append(f"compliance: not known: {error}")
    try:
        silicone = silicone_of(sensor)
    except SceneError as error:
        silicone = None
        notes.append(str(error))
    prony = np.array(() if silicone is None else silicone.prony, dtype=float).reshape(-1, 2)
    if not prony.size:
        notes.append("relaxation: unknown, the silicone has no prony: time steps show the slow response at once")
    weights, times = retardation([(w, tau) for w, tau in prony.tolist()])
    soft = None if silicone is None else silicone.mullins
    return {
        "compliance": compliance, "rest_pose": rest, "prony": prony,
        "load_height": np.array(np.nan if sensor.target is None else sensor.target.load_height),
        "relaxation_weights": prony[:, 0] / (1.0 - prony[:, 0].sum()), "relaxation_times": prony[:, 1],
        "creep_weights": weights, "creep_times": times[: len(weights)],
        "mullins": np.full(3, np.nan) if soft is None else np.array([soft.r, soft.m, soft.beta]),
    }


def _sampling(source: Source, front: FrontEnd | None, cal: Calibration) -> dict[str, Any]:
    """Return the converter's numbers, its noise and the conversion time of each coil."""
    unknown = np.full(len(cal.coils), np.nan)
    found = {"capacitance": np.array(source.sensor.readout.parallel_capacitance)}
    if front is None:
        return found | {"sigma_L": unknown, "opened": unknown, "conversion": unknown, "channel_time": unknown}
    L = cal.forward(cal.middle)
    counted = np.full(len(unknown), conversion_time(front.rcount, front.part, front.reference))
    return found | {
        "sigma_L": front.noise / L, "reference": np.array(front.reference), "bits": np.array(front.part.bits),
        "input_divider": np.array(front.input_divider), "reference_divider": np.array(front.reference_divider),
        "rcount": np.array(front.rcount), "gain": np.array(front.gain), "below": front.below, "conversion": counted,
        "opened": windows(front)[0], "channel_time": front.channel_time,
    }


def _temperature(source: Source) -> dict[str, Any]:
    """Return the slopes by temperature that the table has."""
    data, sensor = source.data, source.sensor
    slopes = {str(name): item for name, item in data.data_vars.items() if str(name).startswith("slope_T_")}
    if not slopes:
        return {"temperature_known": np.array(0)}
    scale = np.ones(len(sensor.coils))
    if data.attrs["unit_L"] != "H":  # per metre, of which the relative change holds
        scale = self_inductances(sensor) / np.diagonal(data["L0"].to_numpy())
    loads, found = varied(data), {"temperature_known": np.array(1)}
    for name, item in slopes.items():
        values = item.transpose(*(load for load in loads if load in item.dims), ...).to_numpy()
        found[name] = values * scale if "coil" in item.dims else values
    if "thermal_cause" in data.coords:
        found["thermal_causes"] = np.array([str(cause) for cause in data["thermal_cause"].to_numpy()])
    return found | {f"slope_T_over_{load}": data[load].to_numpy() for load in loads}
