"""Refuse a study before it is run: arguments that are none, and values with which no scene is possible."""

from __future__ import annotations

import itertools
import json
from typing import Any

from sits_mech.batch.requests import REQUESTS
from sits_mech.batch.studies.asked import Study, arguments_of, of_scene
from sits_mech.batch.studies.written import SCENE
from sits_mech.cases import grid_points
from sits_mech.inputs import unknown
from sits_mech.scene.sensor import SceneError
from sits_mech.store import Row
from sits_mech.units import shown

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
            many = not whole and 2 * len(set(texts)) > study.count
            found[name] = [""] * len(texts) if many else texts
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
