"""Read a study file, whose keys stand in `written.py`: its cases, each of which must be possible, and its stages.

The scene and all that is fixed of a stage are those of the one before, changed by its own; what the next request does
not know is left out.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from sits_mech.batch.adaptive import axes_of
from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.studies.asked import Stage, Study, arguments_of, of_scene, overrides_of
from sits_mech.batch.studies.samples import MOST, SAMPLED, Expression, cube, derived, expression, names_of, sampled
from sits_mech.batch.studies.written import SCENE, StudyTable
from sits_mech.batch.tables import SWEPT
from sits_mech.cases import grid_points
from sits_mech.inputs import checked, unknown
from sits_mech.scene.files import read_as
from sits_mech.scene.sensor import Sensor, changed, load_from, scene_table, scene_text
from sits_mech.store import Row
from sits_mech.units import SceneError, shown, si_label

EXPORT = "export"
"""What the last stage may be, in place of a request."""


def stages_of(table: StudyTable, scenes: Mapping[str, Sensor]) -> tuple[Stage, ...]:
    """Return the stages of a file after its first, of the scenes that it names."""
    found, request, fixed = list[Stage](), table.request, table.fixed
    for number, stage in enumerate(table.then, 1):
        place, study = f"then.{number}", None
        try:
            if request == EXPORT:
                raise SceneError("must not follow an export, which is the last stage")
            if stage.request is not None:
                study = _asked(stage.request, table.vary | table.derive, (fixed, stage.fixed), scenes)
            elif request not in SWEPT:
                raise SceneError(f"export: must follow {' or '.join(SWEPT)}; it follows {request}")
        except SceneError as error:
            raise SceneError(f"{place}: {error}") from None
        tests = tuple(_of_columns(f"{place}.where", text, condition=True) for text in stage.where)
        end = next((end for end in ("least", "largest") if end in stage.model_fields_set), None)
        order = None if end is None else _of_columns(f"{place}.{end}", getattr(stage, end))
        found.append(Stage(tests, order, end == "largest", stage.count, study, tuple(stage.export)))
        request, fixed = found[-1].name, fixed | stage.fixed
    return tuple(found)


def texts_of(scenes: Mapping[str, Sensor], request: Request, varied: Iterable[str]) -> dict[str, str]:
    """Return scenes as texts, without the elastomer where neither the request nor what varies is of it."""
    layer = request.layer or any(key.startswith("elastomer.") for key in varied)
    changes = {} if layer else {"elastomer": None}
    return {name: scene_text(scene.model_copy(update=changes)) for name, scene in scenes.items()}


def _asked(name: str, varied: Row, fixed: tuple[Row, Row], scenes: Mapping[str, Sensor]) -> Study:
    """Return what a stage asks, without cases, by what was fixed before and what it fixes itself."""
    request, (before, own) = REQUESTS[name], fixed
    for key in own:
        if key in varied:
            raise SceneError(f"fixed.{key}: must be no key that the study varies; got {shown(own[key])}")
    known = {key: item for key, item in before.items() if of_scene(key, request) or key in request.arguments} | own
    check_names(name, varied, known)
    overrides, arguments = overrides_of(known, request), arguments_of(known, request)
    request.in_si(arguments)
    own_scenes = {key: changed(scene, overrides) for key, scene in scenes.items()}
    return Study(texts_of(own_scenes, request, varied), name, {}, arguments)


def _of_columns(where: str, text: object, *, condition: bool = False) -> Expression:
    """Return an expression of columns; refuse one of numbers alone."""
    found = expression(where, text, condition=condition)
    if not found.names:
        raise SceneError(f"{where}: must name a column of the table; got {shown(text)}")
    return found


_LOOKS = 3_000  # scenes that are looked at before a run whether a value is possible, a second


def check_cases(study: Study) -> None:
    """Refuse a study whose arguments are none, or with values that no possible scene has."""
    study.request.in_si(study.fixed)
    for name in arguments_of(study.vary, study.request):
        for value in study.vary[name]:
            study.request.in_si({name: value})
    if study.combine == "zip":
        _check_side_by_side(study)
        return
    for name, values in study.vary.items():
        for value in values if of_scene(name, study.request) else ():
            refusal = _refusal_of_all(study, name, value)
            if refusal is not None:
                raise _impossible(f"{name} = {shown(value)}", refusal)


def _check_side_by_side(study: Study) -> None:
    """Refuse values that no possible scene has; of what is drawn from ranges or derived one must be possible."""
    columns, possible, first = _looked_at(study), set[tuple[str, str]](), dict[tuple[str, str], SceneError]()
    for number, point in enumerate(grid_points(study.vary, "zip")):
        values = [(name, texts[number]) for name, texts in columns.items()]
        if possible.issuperset(values):
            continue
        refusal = _refusal(study, point)
        if refusal is None:
            possible.update(values)
            continue
        for value in values:
            first.setdefault(value, refusal)
        if len(first) > _LOOKS:
            return
    for (name, text), refusal in first.items():
        if (name, text) not in possible:
            raise _impossible(f"{name} = {text}" if text else "some case", refusal)


def _looked_at(study: Study) -> dict[str, list[str]]:
    """Return the values of the scene's keys in each case as texts; "" where any value of many will do."""
    whole, found = study.combined == "zip" and not study.asked.get("derive"), {}
    for name, values in study.vary.items():
        if of_scene(name, study.request):
            texts = [json.dumps(value) for value in values]
            found[name] = [""] * len(texts) if not whole and 2 * len(set(texts)) > study.count else texts
    return found


def _impossible(what: str, error: SceneError) -> SceneError:
    """Return the refusal of what varies by the first scene with it."""
    return SceneError(f"vary: {what} must leave a possible scene; the first one: {error}")


def _refusal(study: Study, point: Row) -> SceneError | None:
    """Return why the scene of a point is impossible; None where it is possible."""
    try:
        study.case(point)[0].sensor  # noqa: B018  the look at it is the check
    except SceneError as error:
        return error
    return None


def _refusal_of_all(study: Study, name: str, value: Any) -> SceneError | None:
    """Return why no scene of a product with a value is possible; one that only some others rule out is left to them."""
    keys = {key: values for key, values in study.vary.items() if key == SCENE or of_scene(key, study.request)}
    keys |= {name: [value]}
    first = None
    for count, values in enumerate(itertools.product(*keys.values())):
        refusal = _refusal(study, dict(zip(keys, values, strict=True)))
        if refusal is None or count == _LOOKS:
            return None
        first = first or refusal
    return first


def check_names(name: str, varied: Row, fixed: Row) -> None:
    """Refuse arguments that a request does not know, lacks, or cannot vary."""
    request = REQUESTS[name]
    for key in varied | fixed:
        if not of_scene(key, request) and key not in request.arguments:
            raise SceneError(f"argument of {name} {unknown(key, request.arguments)}, or a dotted key of the scene")
    for key in request.needed:
        if key not in varied and key not in fixed:
            raise SceneError(f"{key}: must be given under vary or fixed for {name}; it is missing")
    for key in request.ranges:
        if key in varied:
            form = 'such as "0 N:4 N:9"'
            raise SceneError(f"{key}: must be a range under fixed for {name}, {form}; it stands under vary")


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
    scenes = {name: load_from(folder, name, overrides_of(fixed, request)) for name in given.scene}
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
