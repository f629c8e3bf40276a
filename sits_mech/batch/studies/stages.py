"""Read the stages of a study after its first: what goes on (funnel.py), and what is asked of it, or how it is exported.

The scene and all that is fixed are those of the stage before, changed by the stage's own; what the next request does
not know is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.studies.asked import Stage, Study, arguments_of, of_scene, overrides_of
from sits_mech.batch.studies.possible import check_names, named
from sits_mech.batch.studies.samples import Expression, expression, is_whole
from sits_mech.batch.tables import SWEPT
from sits_mech.scene.files import check_keys
from sits_mech.scene.materials import unknown
from sits_mech.scene.sensor import Sensor, changed, scene_text
from sits_mech.store import Row
from sits_mech.units import SceneError, shown

EXPORT = "export"
"""What the last stage may be, in place of a request."""
_ENDS = ("least", "largest")
STAGE_KEYS = ("where", "least", "largest", "count", "request", "fixed", "export")


def stages_of(tables: Any, request: str, names: tuple[Row, Row], scenes: Mapping[str, Sensor]) -> tuple[Stage, ...]:
    """Return the stages of a file after its first, of which request, names (varied, fixed) and scenes are given."""
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise SceneError(f"then: must be tables under [[then]]; got {shown(tables)}")
    found, (varied, fixed) = [], names
    for number, table in enumerate(tables, 1):
        place = f"then.{number}"
        try:
            _check_kind(table, request)
            own = named(table, "fixed")
            study = _study(table["request"], varied, (fixed, own), scenes) if "request" in table else None
        except SceneError as error:
            raise SceneError(f"{place}: {error}") from None
        found.append(_stage(place, table, study))
        request, fixed = found[-1].name, fixed | own
    return tuple(found)


def texts_of(scenes: Mapping[str, Sensor], request: Request, varied: Iterable[str]) -> dict[str, str]:
    """Return scenes as texts, without the elastomer where neither the request nor what varies is of it."""
    layer = request.layer or any(key.startswith("elastomer.") for key in varied)
    changes = {} if layer else {"elastomer": None}
    return {name: scene_text(scene.model_copy(update=changes)) for name, scene in scenes.items()}


def _check_kind(table: Mapping[str, Any], request: str) -> None:
    """Refuse a stage that has no request of those known, and is no export that may follow the request before."""
    check_keys(table, STAGE_KEYS)
    if request == EXPORT:
        raise SceneError("must not follow an export, which is the last stage")
    kinds = [key for key in ("request", EXPORT) if key in table]
    if len(kinds) != 1:
        raise SceneError(f"must have a request or an export; got {', '.join(table) or 'nothing'}")
    if kinds == [EXPORT]:
        _check_export(table, request)
    elif table["request"] not in REQUESTS:
        raise SceneError(f"request {unknown(str(table['request']), tuple(REQUESTS))}")


def _check_export(table: Mapping[str, Any], request: str) -> None:
    """Refuse an export that fixes something, or of no calibrations."""
    if "fixed" in table:
        raise SceneError("fixed: must stand beside a request; got an export")
    if request not in SWEPT:
        raise SceneError(f"export: must follow {' or '.join(SWEPT)}; it follows {request}")


def _study(name: str, varied: Row, fixed: tuple[Row, Row], scenes: Mapping[str, Sensor]) -> Study:
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


def _stage(place: str, table: Mapping[str, Any], study: Study | None) -> Stage:
    """Return a stage that asks for a study, or exports, from its table."""
    where, kinds = (_texts(place, key, table) for key in ("where", EXPORT))
    ends, count = [key for key in _ENDS if key in table], table.get("count")
    if len(ends) > 1 or (count is not None and not ends):
        raise SceneError(f"{place}: must have least or largest, beside a count; got {', '.join(table)}")
    if count is not None and not is_whole(count, 1):
        raise SceneError(f"{place}.count: must be a whole number, one or more; got {shown(count)}")
    tests = tuple(_of_columns(f"{place}.where", text, condition=True) for text in where)
    order = _of_columns(f"{place}.{ends[0]}", table[ends[0]]) if ends else None
    return Stage(tests, order, ends == ["largest"], count, study, tuple(kinds))


def _of_columns(where: str, text: object, *, condition: bool = False) -> Expression:
    """Return an expression of columns; refuse one of numbers alone."""
    found = expression(where, text, condition=condition)
    if not found.names:
        raise SceneError(f"{where}: must name a column of the table; got {shown(text)}")
    return found


def _texts(place: str, key: str, table: Mapping[str, Any]) -> list[str]:
    """Return a list of texts of a stage's table; refuse what is none."""
    texts = table.get(key, [])
    if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts) or (key in table and not texts):
        raise SceneError(f"{place}.{key}: must be a list of texts; got {shown(texts)}")
    return texts
