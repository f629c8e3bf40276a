"""Read a study file: a scene, a request, what varies and what is fixed.

    scene = "biorob2018"              # a scene file beside the study, or a name of the catalogue
    request = "inductance"            # or pose, simulate, calibrate, quality
    combine = "product"               # or "zip", "adaptive", or samples: "sobol", "latin", "saltelli"
    [vary]                            # keys of the scene in quotes, arguments of the request bare
    "target.width" = ["8 mm", "15 mm", "22 mm"]
    dv = { from = "1 mm", to = "5 mm", count = 41 }
    [fixed]
    frequency = "5 MHz"
    model = "planar"

Beside these: `scene` may be a list, which varies as a key of [vary] called `scene` would. Samples take `samples` and
`seed`, and in [vary] ranges without a count; of a list they draw evenly. [derive] gives keys of the scene or arguments
from others, each by a text (samples.py); `where` is a list of conditions, and a case that breaks one is left out.
Samples, derived keys and conditions make cases stand side by side, as those of "zip", along the dimension `case`.

    scene = ["biorob2018", "biorob2018-w15"]
    combine = "sobol"
    samples = 64                      # the first 64: with 128 later these are kept
    seed = 0
    where = ["target.width <= elastomer.width", "dv > 0.5 * target.thickness + 0.2 mm"]
    [vary]
    "target.width" = { from = "8 mm", to = "22 mm" }
    [derive]
    "target.length" = "0.5 * target.width"

"adaptive" solves as few cases of the product as predict variables of the table at the others (adaptive.py): within a
share of their range or, with a limit, until each is known to be on one side of it.

    combine = "adaptive"
    [adaptive]
    of = "relative"                   # or several
    within = 1e-3
    limit = 0.7                       # or a quantity; may be left out

[[then]] is a stage on the best cases of the stage before, of which there may be more (stages.py).

    [[then]]
    where = ["largest_stretch < 2"]   # conditions on the table of the stage before
    least = "resolution"              # or largest: what is put in order
    count = 3                         # so many go on
    request = "quality"               # or export = ["c", "page"], in the last one
    fixed.tolerance = 1e-3
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.batch.adaptive import ADAPTIVE, adaptive_of
from sits_mech.batch.requests import REQUESTS
from sits_mech.batch.studies.asked import SCENE, Study, arguments_of, overrides_of
from sits_mech.batch.studies.possible import check_cases, check_names, named
from sits_mech.batch.studies.samples import (
    MOST,
    SAMPLED,
    checked_count,
    cube,
    derived,
    ends,
    expression,
    is_whole,
    names_of,
    sampled,
    written,
)
from sits_mech.batch.studies.stages import stages_of, texts_of
from sits_mech.cases import Combine, grid_points
from sits_mech.scene.files import check_keys, read_as
from sits_mech.scene.materials import unknown
from sits_mech.scene.sensor import SceneError, load_beside, scene_table
from sits_mech.store import Row
from sits_mech.units import shown, si_label

KEYS = ("scene", "request", "combine", "samples", "seed", "where", "vary", "derive", "fixed", "adaptive", "then")
_TABLES = ("vary", "derive", "fixed")
COMBINE = ("product", "zip", *SAMPLED, ADAPTIVE)
_STEPS: Mapping[str, Combine] = {"zip": "zip"}  # all others of lists are products
_RANGE = '{ from = "1 mm", to = "5 mm", count = 41 } with different ends in one unit and a count of two or more'


def read_study(path: Path) -> Study:
    """Read and check a study file (TOML); every value has one possible scene at least.

    Raise SceneError in one line: the file, the key, what it must be, what came.
    """
    return read_as(path, _study)


def _study(table: Mapping[str, Any], folder: Path) -> Study:
    """Return the study of a file's tables."""
    check_keys(table, KEYS, ("scene", "request", "vary"))
    _check_choice("request", table["request"], tuple(REQUESTS))
    _check_choice("combine", table.get("combine", "product"), COMBINE)
    request = REQUESTS[table["request"]]
    varied, derive, fixed = tables = [named(table, name) for name in _TABLES]
    _check_once(tables)
    check_names(table["request"], varied | derive, fixed)
    scenes = {name: load_beside(folder, name, overrides_of(fixed, request)) for name in _scenes(table["scene"])}
    then = stages_of(table.get("then", []), table["request"], (varied | derive, fixed), scenes)
    varied = {SCENE: list(scenes)} | varied if len(scenes) > 1 else varied
    whole = _combined(table, varied, Study({}, table["request"], {}, arguments_of(fixed, request)))
    study = _derived(table, derive, whole, {name: names_of(scene_table(scene)) for name, scene in scenes.items()})
    study = replace(study, scenes=texts_of(scenes, request, study.vary), then=then)
    check_cases(study)
    return study


def _check_choice(key: str, value: object, known: tuple[str, ...]) -> None:
    """Refuse a value that is none of those known."""
    if value not in known:
        raise SceneError(f"{key} {unknown(str(value), known)}")


def _scenes(asked: Any) -> list[str]:
    """Return the names of scenes; refuse what is none, or stands twice."""
    names = asked if isinstance(asked, list) else [str(asked)]
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise SceneError(f"scene: must be a scene, or a list of different ones; got {shown(names)}")
    return names


def _combined(table: Mapping[str, Any], varied: Row, study: Study) -> Study:
    """Return a study with the values of what varies, before what is derived; refuse one that is too large."""
    combine = table.get("combine", "product")
    if combine in SAMPLED:
        for name, item in varied.items():
            if isinstance(item, list):
                _values(name, item)
        count, seed = checked_count(combine, table.get("samples"), table.get("seed", 0), len(varied))
        vary = sampled(varied, cube(combine, count, seed, len(varied)))
        return replace(study, vary=vary, combine="zip", asked={"combine": combine, "samples": count, "seed": seed})
    for key in ("samples", "seed"):
        if key in table:
            raise SceneError(f"{key}: must stand beside combine = {', '.join(SAMPLED)}; got {combine}")
    vary = {name: _values(name, item) for name, item in varied.items()}
    adaptive, asked = adaptive_of(table, vary), {key: table[key] for key in ("combine", "adaptive") if key in table}
    study = replace(study, vary=vary, combine=_STEPS.get(combine, "product"), asked=asked, adaptive=adaptive)
    if study.count > MOST:
        raise SceneError(f"vary: must give at most {MOST} cases; got {study.count}")
    if combine == "zip":
        grid_points(vary, "zip")  # refuses what is not equally many
    return study


def _derived(table: Mapping[str, Any], derive: Row, study: Study, scenes: Mapping[str, Row]) -> Study:
    """Return a study with its derived keys, without the cases that break a condition; scenes' keys by their names."""
    where = _conditions(table, study.combined)
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


def _conditions(table: Mapping[str, Any], combined: str) -> list[Any]:
    """Return the conditions of a file; refuse what is no list, and any on Saltelli's design."""
    where = table.get("where", [])
    if not isinstance(where, list):
        raise SceneError(f"where: must be a list of conditions; got {shown(where)}")
    if where and combined == "saltelli":
        raise SceneError("where: must not stand beside saltelli, whose indices need all cases")
    for key in ("where", "derive"):
        if table.get(key) and combined == ADAPTIVE:
            raise SceneError(f"{key}: must not stand beside {ADAPTIVE}, which refines a whole grid")
    return where


def _check_once(tables: list[Row]) -> None:
    """Refuse a key that stands in two of the tables."""
    for (one, own), (other, others) in itertools.combinations(zip(_TABLES, tables, strict=True), 2):
        for key in own:
            if key in others:
                raise SceneError(f"{key}: must stand under {one} or under {other}; it stands under both")


def _values(name: str, item: Any) -> list[Any]:
    """Return the values of a varied key: a list as it is, a range written out."""
    if isinstance(item, list) and item:
        if len({json.dumps(value, default=str) for value in item}) == len(item):
            return item
        raise SceneError(f"{name}: must be a list of different values; got {shown(item)}")
    if isinstance(item, dict) and set(item) == {"from", "to", "count"} and is_whole(item["count"], 2, MOST):
        span = ends(name, item)
        if span is not None:
            return written(np.linspace(*span[:2], item["count"]), span[2])
    raise SceneError(f"{name}: must be a list of values that is not empty, or a range {_RANGE}; got {shown(item)}")
