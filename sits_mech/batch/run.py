"""Run a whole study: its cases anywhere, kept one by one, joined to one labelled table.

A case is named by a hash of its resolved scene, the request with its arguments in SI, and the version: what is there is
not computed again, whatever wrote it.
"""

from __future__ import annotations

import json
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from sits_mech.batch.requests import Variant
from sits_mech.batch.study import Study
from sits_mech.cases import Progress, Row, case_path, grid_points, save_table, sweep
from sits_mech.labels import labelled
from sits_mech.quantities import LOAD_ARGUMENTS
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError, scene_hash
from sits_mech.units import si_label, si_unit
from sits_mech.version import __version__


@dataclass(frozen=True)
class Case:
    """The function of a study's sweep: a point in, a row out."""

    study: Study

    def __call__(self, **point: Any) -> Row:
        """Return the answer at a point."""
        variant, arguments = self.study.case(point)
        return self.study.request.answer(variant, self.study.request.in_si(arguments))

    def key(self, point: Row) -> str:
        """Return what the answer at a point depends on."""
        variant, arguments = self.study.case(point)
        try:
            scene = scene_hash(variant.sensor)
        except SceneError as error:  # a case of its own: the row that says so
            scene = str(error)
        return json.dumps([__version__, scene, self.study.name, self.study.request.in_si(arguments)], sort_keys=True)


def run_study(
    study: Study, folder: Path, *, executor: Executor | None = None, progress: Progress | None = None
) -> xr.Dataset:
    """Run what a study has not yet run, keep cases under ``cases/`` of the folder and write its table ``result.nc``.

    Return the answers along what varies, in SI, with ``status`` and ``reason`` of each case; attributes hold the study.
    `progress` gets the numbers of cases done and of all. Raise SceneError when the folder is another study's or cannot
    be written.
    """
    claim(folder, study)
    case = Case(study)
    data = sweep(
        case, study.vary, combine=study.combine, executor=executor, chunk=study.request.chunk, folder=folder / "cases",
        key=case.key, progress=progress,
    )
    data = _labelled(data, study)
    save_table(data, folder / "result.nc")
    return data


def cases_aside(study: Study, folder: Path) -> int:
    """Return how many finished cases in a study's folder are of values outside it; `run_study` leaves them out."""
    kept = {path.name for path in (folder / "cases").glob("[!.]*.json")}
    if not kept:
        return 0
    case = Case(study)
    paths = (case_path(folder, case.key(point), {}) for point in grid_points(study.vary, study.combine))
    return len(kept - {path.name for path in paths if path is not None})


def claim(folder: Path, study: Study) -> None:
    """Claim a folder for a study; raise SceneError when it is another study's, or cannot be written to."""
    path = folder / "study.json"
    try:
        (folder / "cases").mkdir(parents=True, exist_ok=True)
        if path.exists():
            if path.read_text(encoding="utf-8") != study.identity:
                what = "must be a new folder, or that of a study with the same scene, request, keys and fixed values"
                raise SceneError(f"{folder}: {what}; it is that of another study")
            return
    except OSError as error:
        raise SceneError(f"{folder}: must be a folder that can be written to; got: {error.strerror or error}") from None
    write_text(path, study.identity)


def _labelled(data: xr.Dataset, study: Study) -> xr.Dataset:
    """Return a table with SI labels, and the names of coils and forces where those are dimensions."""
    units = {name: study.request.units.get(name) or si_unit(values[0]) for name, values in study.vary.items()}
    data = data.assign_coords(
        {
            name: (data[name].dims, [*map(si_label, values)], {"units": units[name]} if units[name] else {})
            for name, values in study.vary.items()
        }
    )
    fixed = study.request.in_si(study.fixed)
    names: dict[str, Any] = {name: fixed.get(argument) for argument, name in LOAD_ARGUMENTS.items()}
    if "coil" in data.dims:
        names |= dict.fromkeys(("coil", "coil_2"), [coil.name for coil in Variant(study.scene).sensor.coils])
    if "forces" in data:  # the same of all cases, but for those that have none
        names["force"] = max(data["forces"].to_numpy().reshape(-1, data.sizes["force"]).tolist())
        data = data.drop_vars("forces")
    data = data.assign_coords({name: values for name, values in names.items() if name in data.dims})
    asked = {"request": study.name, "fixed": json.dumps(study.fixed), "combine": study.combine}
    return labelled(data.assign_attrs(scene=study.scene, **asked, version=__version__))
