"""Read a study file, whose keys stand in `written.py`: its cases, each of which must be possible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from sits_mech.batch.adaptive import axes_of
from sits_mech.batch.requests import REQUESTS
from sits_mech.batch.studies.asked import Study, arguments_of, overrides_of
from sits_mech.batch.studies.possible import check_cases, check_names
from sits_mech.batch.studies.samples import MOST, SAMPLED, cube, derived, expression, names_of, sampled
from sits_mech.batch.studies.stages import stages_of, texts_of
from sits_mech.batch.studies.written import SCENE, StudyTable
from sits_mech.cases import grid_points
from sits_mech.inputs import checked
from sits_mech.scene.files import read_as
from sits_mech.scene.sensor import SceneError, load_beside, scene_table
from sits_mech.store import Row
from sits_mech.units import si_label


def read_study(path: Path) -> Study:
    """Read and check a study file (TOML); every value has one possible scene at least.

    Raise SceneError in one line: the file, the key, what it must be, what came.
    """
    return read_as(path, _study)


def _study(table: Mapping[str, Any], folder: Path) -> Study:
    """Return the study of a file's tables."""
    given = checked(StudyTable, table, "study", first=1)
    request, fixed = REQUESTS[given.request], given.fixed
    check_names(given.request, given.vary | given.derive, fixed)
    scenes = {name: load_beside(folder, name, overrides_of(fixed, request)) for name in given.scene}
    then = stages_of(given, scenes)
    asked = {key: table[key] for key in ("combine", "adaptive") if key in table}
    whole = _combined(given, Study({}, given.request, {}, arguments_of(fixed, request), asked=asked))
    study = _derived(given, whole, {name: names_of(scene_table(scene)) for name, scene in scenes.items()})
    study = replace(study, scenes=texts_of(scenes, request, study.vary), then=then)
    check_cases(study)
    return study


def _combined(given: StudyTable, study: Study) -> Study:
    """Return a study with the values of what varies, before what is derived; refuse one that is too large."""
    vary = given.varied
    if given.combine in SAMPLED and given.samples is not None:
        asked: Row = {"combine": given.combine, "samples": given.samples, "seed": given.seed}
        vary = sampled(vary, cube(given.combine, given.samples, given.seed, len(vary)))
        return replace(study, vary=vary, combine="zip", asked=asked)
    if given.adaptive is not None:
        axes_of(vary)  # refuses what has no numbers
    study = replace(study, vary=vary, combine="zip" if given.combine == "zip" else "product", adaptive=given.adaptive)
    if study.count > MOST:
        raise SceneError(f"vary: must give at most {MOST} cases; got {study.count}")
    if given.combine == "zip":
        grid_points(vary, "zip")  # refuses what is not equally many
    return study


def _derived(given: StudyTable, study: Study, scenes: Mapping[str, Row]) -> Study:
    """Return a study with its derived keys, without the cases that break a condition; scenes' keys by their names."""
    where, derive = given.where, given.derive
    if not where and not derive:
        return study
    texts = {name: expression(f"derive.{name}", text) for name, text in derive.items()}
    tests = [expression("where", text, condition=True) for text in where]
    fixed = {name: si_label(item) for name, item in study.fixed.items()}
    known = {name: keys | fixed for name, keys in scenes.items()}
    first, points = next(iter(known)), grid_points(study.vary, study.combine)
    found = derived(points, texts, tests, lambda point: known[point.get(SCENE, first)])
    asked = {key: item for key, item in (("where", where), ("derive", derive)) if item}
    return replace(
        study, vary={name: [point[name] for point in found] for name in found[0]}, combine="zip",
        asked=study.asked | asked, left_out=len(points) - len(found),
    )
