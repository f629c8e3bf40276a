"""Run a whole study: its cases anywhere, kept as they end, joined to one labelled table that grows with them.

A case is named by a hash of its resolved scene, the request with its arguments in SI, and the version: what is there is
not computed again, whatever wrote it.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sits_mech.arguments import checked_arguments
from sits_mech.batch.adaptive import adaptively
from sits_mech.batch.requests import Variant, with_quality
from sits_mech.batch.studies.asked import Study
from sits_mech.batch.tables import SWEPT, case_calibration
from sits_mech.cases import Progress, attempt, grid_points, no_progress, solve_cases
from sits_mech.labels import labelled
from sits_mech.quantities import LOAD_ARGUMENTS
from sits_mech.readout.loads import point
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError, key_unit, scene_hash
from sits_mech.status import ANSWERED
from sits_mech.store import DAMAGED, Row, case_name, no_table, opened, save_table
from sits_mech.units import shown, si_label, si_unit
from sits_mech.version import __version__

if TYPE_CHECKING:
    import xarray as xr

TABLE = "result.nc"


@dataclass(frozen=True)
class Case:
    """The function of a study's sweep: a point in, a row out; workers need none of the values that vary."""

    study: Study

    def __call__(self, **point: Any) -> Row:
        """Return the answer at a point."""
        variant, arguments = self.study.case(point)
        return self.study.request.answer(variant, self.study.request.in_si(arguments))


def keys(study: Study) -> Callable[[Row], str]:
    """Return a function that gives what the answer at a point depends on; it looks at each scene once."""
    scenes = {}

    def key(point: Row) -> str:
        variant, arguments = study.case(point)
        if variant not in scenes:
            try:
                scenes[variant] = scene_hash(variant.sensor)
            except SceneError as error:  # a case of its own: the row that says so
                scenes[variant] = str(error)
        return json.dumps([__version__, scenes[variant], study.name, study.request.in_si(arguments)], sort_keys=True)

    return key


def run_study(
    study: Study, folder: Path, *, executor: Executor | None = None, progress: Progress = no_progress
) -> xr.Dataset:
    """Run what a study has not yet run, keep cases in ``cases.sqlite`` of the folder, write its table ``result.nc``.

    Return the answers along what varies, in SI, with ``status`` and ``reason`` of each case; attributes hold the study.
    While it runs, ``result.nc`` is the table so far. `progress` gets the numbers of cases done and of all. Raise
    SceneError when the folder is another study's or another run's, or cannot be written.
    """
    claim(folder, study)
    data = solve_cases(
        Case(replace(study, vary={})), study.vary, combine=study.combine, executor=executor, folder=folder,
        chunk=1 if study.adaptive else study.request.chunk,  # else one process has a round of few cases
        key=keys(study), group=lambda point: study.shared(point).order, progress=progress, choose=adaptively(study),
        snapshot=lambda table: save_table(_labelled(table, study), folder / TABLE),
    )
    data = _labelled(data, study)
    save_table(data, folder / TABLE)
    return data


def keep_known(study: Study, folder: Path, before: tuple[Study, xr.Dataset], numbers: Sequence[int]) -> None:
    """Keep for a study what follows from some cases of a study before and its table: quality from calibrations.

    Only of cases with the same scene, arguments and version, which then are not calibrated again, and only answers.
    """
    first, data = before
    if (first.name, study.name) != SWEPT:
        return
    claim(folder, study)
    key, needed, had = keys(study), keys(replace(study, name=first.name)), keys(first)
    with opened(folder) as cases:
        known = cases.names
        for number, own in zip(numbers, grid_points(study.vary, study.combine), strict=True):
            name = case_name(key(own), {})
            if name not in known and needed(own) == had(own):
                row = point(data, number)
                found = attempt(lambda row=row: with_quality(*case_calibration(row)), {})
                cases.put([(name, found)] if found["status"] in ANSWERED else [])


@checked_arguments
def open_sweep(folder: str | Path) -> xr.Dataset:
    """Open the table of a sweep's folder, also while the sweep runs; numbers are read when they are asked for.

    Parameters
    ----------
    folder : str or Path
        That of `sits-mech sweep -o`.

    Returns
    -------
    Dataset
        The answers along what varies, in SI with ``units``; ``status`` is "unfinished" where a case was still to come
        when the table was written. A running sweep writes it again now and then: open it anew for what has come since.

    Raises
    ------
    SceneError
        When there is no table of a sweep.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from sits_mech.batch.run import run_study
    >>> from sits_mech.batch.studies.study import read_study
    >>> lines = 'scene = "biorob2018"', 'request = "pose"', 'vary.fz = ["0 N", "1 N"]', 'fixed.model = "linear"'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "study.toml"
    ...     _ = path.write_text("\\n".join(lines))
    ...     _ = run_study(read_study(path), Path(folder) / "out")
    ...     with sm.open_sweep(Path(folder) / "out") as data:
    ...         dict(data.sizes), data["d_v"].units
    ({'fz': 2}, 'm')
    """
    import xarray as xr

    try:
        found = xr.open_dataset(Path(folder) / TABLE, engine="netcdf4")
    except DAMAGED as error:
        raise no_table(Path(folder) / TABLE, error) from None
    return found


def cases_aside(study: Study, folder: Path) -> int:
    """Return how many finished cases in a study's folder are of values outside it; `run_study` leaves them out."""
    with opened(folder) as cases:
        kept = cases.names
    key = keys(study)
    return len(kept.difference(case_name(key(point), {}) for point in grid_points(study.vary, study.combine)))


def claim(folder: Path, study: Study) -> None:
    """Claim a folder for a study; raise SceneError when it is another study's, or cannot be written to."""
    path, known = folder / "study.json", None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if path.exists():
            with suppress(ValueError):  # no JSON, no study
                known = json.loads(path.read_text(encoding="utf-8"))
            if known != (own := json.loads(study.identity)):
                what = "must be a new folder, or that of a study with the same scene, request, keys and fixed values"
                raise SceneError(f"{folder}: {what}; it is that of another study{_difference(known, own)}")
            return
    except OSError as error:
        raise SceneError(f"{folder}: must be a folder that can be written to; got: {error.strerror or error}") from None
    write_text(path, study.identity)


def _difference(known: Any, own: list[Any]) -> str:
    """Return the first key by which the identities of two studies differ, with both values; "" where one is damaged."""
    if not isinstance(known, list) or [*map(type, known)] != [*map(type, own)]:
        return ""
    names = "scene", "request", "vary", "fixed", "combine"
    there, here = (dict(_keys("", dict(zip(names, each, strict=True)))) for each in (known, own))
    key = next((key for key in {**there, **here} if there.get(key) != here.get(key)), None)
    return "" if key is None else f": {key} is {shown(there.get(key))} there, {shown(here.get(key))} here"


def _keys(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a value with their paths: of tables, of lists of tables, and of a scene's text."""
    if path == "scene" and isinstance(value, str):
        value = json.loads(value) if value.startswith("{") else tomllib.loads(value)
    if isinstance(value, list) and value and isinstance(value[0], dict):
        value = {str(each.get("name", k)): each for k, each in enumerate(value)}
    if not isinstance(value, dict):
        yield path, value
        return
    for step, each in value.items():
        yield from _keys(f"{path}.{step}".lstrip("."), each)


def _labelled(data: xr.Dataset, study: Study) -> xr.Dataset:
    """Return a table with SI labels, and the names of coils and forces where those are dimensions."""
    data = data.assign_coords({name: (data[name].dims, *_si_values(study, name)) for name in study.vary})
    fixed = study.request.in_si(study.fixed)
    names = {name: fixed.get(argument) for argument, name in LOAD_ARGUMENTS.items()}
    if "coil" in data.dims:
        names |= dict.fromkeys(("coil", "coil_2"), _coil_names(study))
    if "forces" in data:  # the same of all cases, but for those that have none
        names["force"] = max(data["forces"].to_numpy().reshape(-1, data.sizes["force"]).tolist())
        data = data.drop_vars("forces")
    data = data.assign_coords({name: values for name, values in names.items() if name in data.dims and values})
    written = {key: item if isinstance(item, int) else json.dumps(item) for key, item in study.asked.items()}
    asked = written | {"request": study.name, "fixed": json.dumps(study.fixed), "combine": study.combined}
    return labelled(data.assign_attrs(scene=study.scene, **asked, version=__version__))


def _si_values(study: Study, name: str) -> tuple[list[Any], dict[str, str]]:
    """Return the values of what varies in SI, and the attribute with their unit."""
    values = study.vary[name]
    unit = study.request.units.get(name) or si_unit(values[0]) or key_unit(name)
    return [*map(si_label, values)], {"units": unit} if unit else {}


def _coil_names(study: Study) -> list[str] | None:
    """Return the names of the coils of all scenes; None where a scene names the same places otherwise."""
    coils = sorted((Variant(scene).sensor.coil_names for scene in study.scenes.values()), key=len)
    return coils[-1] if all(own == coils[-1][: len(own)] for own in coils) else None
