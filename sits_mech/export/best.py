"""Write a case of a sweep of calibrations as a calibration of its own, with its exports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sits_mech.export.formats import export, export_path, format_of
from sits_mech.export.source import Source
from sits_mech.readout.loads import check_enough, varied
from sits_mech.report.folder import prepare_folder, read_calibration
from sits_mech.report.written import write_calibration


def export_case(folder: Path, case: int, kinds: Sequence[str], place: Path) -> list[str]:
    """Write a case, from 1 on, to a folder of its own; return one line for each thing to know about it.

    Raise SceneError for a case without a table, a sensor that does not fit, a failed write; SolveFailed.
    """
    sensor, data = read_calibration(folder, case)
    for kind in kinds:
        if format_of(kind).inverts:
            check_enough(sensor.coils, varied(data))
    notes = write_calibration(sensor, data, prepare_folder(place, cases=False), layer=False)
    for kind in kinds:
        notes += export(Source(sensor, data), kind, place / export_path(sensor, kind, None))[1]
    return notes
