"""Read the stages of a study after its first: what goes on (funnel.py), and what is asked of it, or how it is exported.

The scene and all that is fixed are those of the stage before, changed by the stage's own; what the next request does
not know is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from sits_mech.batch.requests import REQUESTS, Request
from sits_mech.batch.studies.asked import Stage, Study, arguments_of, of_scene, overrides_of
from sits_mech.batch.studies.possible import check_names
from sits_mech.batch.studies.samples import Expression, expression
from sits_mech.batch.studies.written import StageTable, StudyTable
from sits_mech.batch.tables import SWEPT
from sits_mech.scene.sensor import Sensor, changed, scene_text
from sits_mech.store import Row
from sits_mech.units import SceneError, shown

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
                study = _study(stage.request, table.vary | table.derive, (fixed, stage.fixed), scenes)
            elif request not in SWEPT:
                raise SceneError(f"export: must follow {' or '.join(SWEPT)}; it follows {request}")
        except SceneError as error:
            raise SceneError(f"{place}: {error}") from None
        found.append(_stage(place, stage, study))
        request, fixed = found[-1].name, fixed | stage.fixed
    return tuple(found)


def texts_of(scenes: Mapping[str, Sensor], request: Request, varied: Iterable[str]) -> dict[str, str]:
    """Return scenes as texts, without the elastomer where neither the request nor what varies is of it."""
    layer = request.layer or any(key.startswith("elastomer.") for key in varied)
    changes = {} if layer else {"elastomer": None}
    return {name: scene_text(scene.model_copy(update=changes)) for name, scene in scenes.items()}


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


def _stage(place: str, table: StageTable, study: Study | None) -> Stage:
    """Return a stage that asks for a study, or exports, from its table."""
    tests = tuple(_of_columns(f"{place}.where", text, condition=True) for text in table.where)
    end = next((end for end in ("least", "largest") if end in table.model_fields_set), None)
    order = None if end is None else _of_columns(f"{place}.{end}", getattr(table, end))
    return Stage(tests, order, end == "largest", table.count, study, tuple(table.export))


def _of_columns(where: str, text: object, *, condition: bool = False) -> Expression:
    """Return an expression of columns; refuse one of numbers alone."""
    found = expression(where, text, condition=condition)
    if not found.names:
        raise SceneError(f"{where}: must name a column of the table; got {shown(text)}")
    return found
