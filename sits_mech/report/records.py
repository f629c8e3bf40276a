"""Make one flat record for each kind of answer, SI throughout, ready for JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.analysis.spectrum import Terminals
from sits_mech.chain.simulate import Simulation
from sits_mech.description import sized
from sits_mech.notes import Omission
from sits_mech.quantities import Array, Equilibrium, Impedance, Pose, SolveFailed, SolveReport, as_jsonable, report_of
from sits_mech.report.left_out import entry
from sits_mech.report.notes import sentences

if TYPE_CHECKING:
    import xarray as xr

Record = dict[str, Any]


def report_record(
    report: SolveReport, left_out: Sequence[Omission] = (), more: Sequence[str] = (), half: str | None = None
) -> Record:
    """Return how a number came about; ``min_J`` and ``stretch`` only where a layer was solved.

    ``left_out_error`` is the part of ``estimated_error`` that what is left out has, ``not_estimated`` names what has no
    size; `more` are further sentences.
    """
    others = (item for item in left_out if half in (None, item.half))
    every = {(item.kind, item.known.get("name")): item for item in (*others, *report.left_out)}
    listed = [*map(entry, every.values()), *({"what": "terminals", "reason": text} for text in more)]
    found = replace(report, left_out=()).written | {"notes": sentences(report.notes), "left_out": listed}
    found |= {"left_out_error": sized(report.left_out)}
    found |= {"not_estimated": [str(item.kind) for item in report.left_out if item.unbounded]}
    return {name: item for name, item in found.items() if item is not None}


def named(names: Sequence[str], values: Array) -> Record:
    """Return values by their names."""
    return dict(zip(names, values.tolist(), strict=True))


def status_record(flags: Sequence[str]) -> Record:
    """Return the flags of an answer, worst first, and the worst as its status."""
    return {"status": flags[0], "flags": list(flags)}


def equilibrium_record(found: Equilibrium, left_out: Sequence[Omission], half: str | None = None) -> Record:
    """Return where the target rests under a load: pose, its error, wrench, report; of a touch what it is, too."""
    return {
        "pose": asdict(found.pose),
        "error": asdict(found.error),
        "wrench": asdict(found.wrench),
        **({} if found.acting is None else {"acting": asdict(found.acting)}),
        **({} if found.sunk is None else dict(zip(("sunk", "error_sunk"), found.sunk, strict=True))),
        **({} if found.error_F_z is None else {"error_F_z": found.error_F_z}),
        "report": report_record(found.report, left_out, half=half),
    }


def impedance_record(
    pose: Pose, found: Impedance, left_out: Sequence[Omission], seen: Terminals | None = None, *,
    more: Sequence[str] = (), half: str | None = None,
) -> Record:
    """Return L and R at one pose; ``relative`` is each coil's L over its L0, ``terminals`` is `seen`.

    ``L_coil`` is of each coil alone, the others open; ``L_terminal`` at its terminals, idle coils as the scene says.
    """
    own, free = np.diagonal(found.L), np.diagonal(found.L0)
    matrices = {name: getattr(found, name) for name in ("L", "R", "L0", "error_L", "error_R", "R_dc")}
    if found.error_L0 is not None:
        matrices["error_L0"] = found.error_L0
    return {
        "pose": asdict(pose),
        "frequency": found.frequency,
        **found.convention,
        **matrices,
        "relative": own / free,
        "L_coil": own,
        **({} if seen is None else {"L_terminal": seen.L}),
        **({} if seen is None else {"terminals": _terminals(vars(seen))}),
        "report": report_record(found.report, left_out, more, half),
    }


def spectrum_record(pose: Pose, data: xr.Dataset, left_out: Sequence[Omission]) -> Record:
    """Return L and R at one pose over a range of frequencies: lists along the frequency."""
    names = ("frequency", "L", "R", "Q", "error_L", "error_R", "error_L0", "R_track", "L0", "R_dc")
    found = {"pose": asdict(pose), "unit_L": data.attrs["unit_L"]}
    found |= {name: data[name].to_numpy() for name in names}
    if "shift" in data:
        inner = {"L": "terminal_L", "R": "terminal_R", "R_ac": "R_track", "Q": "terminal_Q"}
        outer = ("shift", "apparent_L", "apparent_R", "apparent_Q", "tank_frequency")
        keys = inner | {name: name for name in (*outer, "own_capacitance", "self_resonance")}
        found["terminals"] = _terminals({key: data[name].to_numpy() for key, name in keys.items()})
    return found | {"report": report_record(report_of(data.attrs["report"]), left_out)}


def _terminals(seen: Mapping[str, Array]) -> Record:
    """Return impedances at the terminals; ``apparent`` includes the readout's capacitance.

    ``own_capacitance`` is an estimate in none of them; ``R_ac`` and ``delta_L_ac``, of uneven current, are in air.
    """
    found: Record = {name: seen[name] for name in ("L", "R", "R_ac", "Q")} | {"delta_L_ac": seen["shift"]}
    found["apparent"] = {name: seen[f"apparent_{name}"] for name in ("L", "R", "Q")}
    return found | {name: seen[name] for name in ("tank_frequency", "own_capacitance", "self_resonance")}


def simulation_record(
    found: Simulation, left_out: Sequence[Omission] = (), seen: Terminals | None = None
) -> Record:
    """Return the whole chain at one load; ``report`` has one part for each physics, with what was left out of it."""
    layer = equilibrium_record(found.equilibrium, left_out, "mechanics")
    coils = impedance_record(found.equilibrium.pose, found.impedance, left_out, seen, half="magnetics")
    reports = {"mechanics": layer["report"], "magnetics": coils["report"]}
    kept = None if found.promise is None else found.promise.record
    own = status_record(found.flags) | {"signals": found.signals.known, "report": reports, "promise": kept}
    return layer | coils | own


def failure_record(error: SolveFailed, whole: bool = False) -> Record:
    """Return the last state, the reason and the report of a failed solve.

    Of a `whole` chain the report has one part for each physics, as on success; the half that was not begun is null.
    """
    last, report = error.last, report_record(error.report)
    begun = None if last is None or error.half == "mechanics" else report_record(last.report)
    halves = {"mechanics": begun, "magnetics": None}
    carried, unsure = (None, None) if error.carried is None else map(asdict, error.carried)
    return {
        "status": error.status,
        "message": str(error),
        **{name: None if last is None else asdict(getattr(last, name)) for name in ("pose", "error", "wrench")},
        "carried": carried,
        "error_carried": unsure,
        "report": halves | {error.half: report} if whole else report,
    }


def json_text(record: Record, **form: Any) -> str:
    """Return a record as one JSON object; what is not a number becomes null."""
    return json.dumps(_finite(as_jsonable(record)), allow_nan=False, **{"indent": 1} | form)


def _finite(value: Any) -> Any:
    """Replace NaN and infinities, which JSON lacks."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
