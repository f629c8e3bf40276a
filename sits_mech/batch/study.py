"""Read a study file: a scene, a request, what varies and what is fixed.

    scene = "biorob2018"              # a scene file beside the study, or a name of the catalogue
    request = "inductance"            # or pose, simulate, calibrate, quality
    combine = "product"               # or "zip", or samples: "sobol", "latin", "saltelli"
    [vary]                            # keys of the scene in quotes, arguments of the request bare
    "target.width" = ["8 mm", "15 mm", "22 mm"]
    dv = { from = "1 mm", to = "5 mm", count = 41 }
    [fixed]
    frequency = "5 MHz"
    model = "planar"

Beside these: `scene` may be a list, which varies as a key of [vary] called `scene` would. Samples take `samples` and
`seed`, and in [vary] ranges without a count; of a list they draw evenly. [derive] gives keys of the scene or arguments
from others, each by a text (expressions.py); `where` is a list of conditions, and a case that breaks one is left out.
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
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sits_mech.batch.expressions import expression, names_of
from sits_mech.batch.requests import REQUESTS, Request, Variant
from sits_mech.batch.samples import MOST, SAMPLED, checked_count, cube, derived, ends, is_whole, sampled, written
from sits_mech.cases import Combine, grid_points
from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS
from sits_mech.scene.files import check_keys, literal, read_as
from sits_mech.scene.materials import unknown
from sits_mech.scene.sensor import SceneError, load_beside, scene_table, scene_text
from sits_mech.store import Row
from sits_mech.units import shown, si_label

COMPONENTS = {name: argument for argument, name in (LOAD_ARGUMENTS | POSE_ARGUMENTS).items()}
"""Arguments by the names that their components have in Python, which study files may use as well."""
KEYS = ("scene", "request", "combine", "samples", "seed", "where", "vary", "derive", "fixed")
_TABLES = ("vary", "derive", "fixed")
Item = tuple[str, str]
COMBINE = ("product", "zip", *SAMPLED)
SCENE = "scene"
"""What varies with a list of scenes."""
TOP = ("frequency", "substrate_radius")  # keys of a scene that stand in no table
_NOT_OF_COILS = ("elastomer", "readout", "tolerances", "mechanics")
_NOT_OF_PAD = ("coils", "conductors", "frequency", "substrate_radius", "readout", "tolerances", "magnetics")
_SILICONE = "elastomer.material"
_LOOKS = 3_000  # scenes that are looked at before a run whether a value is possible, a second
_RANGE = '{ from = "1 mm", to = "5 mm", count = 41 } with different ends in one unit and a count of two or more'


class Shared(NamedTuple):
    """What a case prepares: coils with their plates, pad with its meshes, and the load that brings this to rest."""

    coils: tuple[Item, ...]
    pad: tuple[Item, ...]
    load: tuple[Item, ...]

    @property
    def order(self) -> tuple[Hashable, ...]:
        """What cases are ordered by: what both have, the pad, its silicone, the load; by coils where there is no pad.

        Cases that differ in coils alone take the rest of the one before; pads of two silicones have one mesh.
        """
        both = tuple(item for item in self.coils if item in self.pad)
        own = tuple(item for item in self.pad if item not in both)
        sizes = tuple(item for item in own if not item[0].startswith(_SILICONE))
        return (both, sizes, own, self.load) if self.pad or self.load else (self.coils,)


@dataclass(frozen=True)
class Study:
    """A study as its file says; made by `read_study`."""

    scenes: dict[str, str]  # of `scene_text`, the fixed keys of the scene applied, by their names in the file
    name: str  # a key of `REQUESTS`
    vary: dict[str, list[Any]]  # values of each varied key or argument as written, ranges written out
    fixed: Row  # arguments that are the same in all cases
    combine: Combine = "product"
    asked: Row = field(default_factory=dict)  # as written: combine, samples, seed, where, derive
    left_out: int = 0  # cases that break a condition

    @property
    def scene(self) -> str:
        """Return the text of the scene; of several a JSON table by their names."""
        return json.dumps(self.scenes) if len(self.scenes) > 1 else next(iter(self.scenes.values()))

    @property
    def request(self) -> Request:
        """Return the request."""
        return REQUESTS[self.name]

    @property
    def identity(self) -> str:
        """Return the study's identity as JSON: scene, request, names of what varies, whose values may grow."""
        return json.dumps([self.scene, self.name, sorted(self.vary), self.fixed, self.combined], indent=1)

    @property
    def combined(self) -> str:
        """Return how cases are combined, as it is written."""
        return str(self.asked.get("combine", "product"))

    @property
    def count(self) -> int:
        """Return how many cases it has."""
        sizes = [len(values) for values in self.vary.values()]
        return math.prod(sizes) if self.combine == "product" else max(sizes)

    def shared(self, point: Row) -> Shared:
        """Return what a case prepares, by what varies of it."""
        coils, pad, load = list[Item](), list[Item](), list[Item]()
        for name, value in point.items():
            item, part = (name, str(value)), name.partition(".")[0]
            if name in LOAD_ARGUMENTS:
                load.append(item)
            elif name not in POSE_ARGUMENTS:
                coils += [item] if self.name != "pose" and part not in _NOT_OF_COILS else []
                pad += [item] if self.request.layer and part not in _NOT_OF_PAD else []
        return Shared(tuple(coils), tuple(pad), tuple(load))

    def case(self, point: Row) -> tuple[Variant, Row]:
        """Return scene and arguments of a point."""
        scene = self.scenes[point[SCENE]] if SCENE in point else next(iter(self.scenes.values()))
        return Variant(scene, _overrides(point, self.request)), self.fixed | _arguments(point, self.request)


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
    varied, derive, fixed = tables = [_table(table, name) for name in _TABLES]
    _check_once(tables)
    _check_names(table["request"], varied | derive, fixed)
    scenes = {name: load_beside(folder, name, _overrides(fixed, request)) for name in _scenes(table["scene"])}
    varied = {SCENE: list(scenes)} | varied if len(scenes) > 1 else varied
    whole = _combined(table, varied, Study({}, table["request"], {}, _arguments(fixed, request)))
    study = _derived(table, derive, whole, {name: names_of(scene_table(scene)) for name, scene in scenes.items()})
    layer = request.layer or any(key.startswith("elastomer.") for key in study.vary)
    changes = {} if layer else {"elastomer": None}
    texts = {name: scene_text(scene.model_copy(update=changes)) for name, scene in scenes.items()}
    study = replace(study, scenes=texts)
    _check_cases(study)
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
    study = replace(study, vary=vary, combine=combine, asked={} if combine == "product" else {"combine": combine})
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
    return where


def _table(table: Mapping[str, Any], name: str) -> Row:
    """Return a table of the file, loads and poses by the names of arguments; [vary] must have keys."""
    part: Row = table.get(name, {})
    if not isinstance(part, dict) or (name == "vary" and not part):
        raise SceneError(f"{name}: must be a table of keys and their values; got {shown(part)}")
    for key in part:
        if key in COMPONENTS and COMPONENTS[key] in part and COMPONENTS[key] != key:
            raise SceneError(f"{name}.{COMPONENTS[key]}: must be given once; got {key} beside it")
    return {COMPONENTS.get(key, key): item for key, item in part.items()}


def _check_once(tables: list[Row]) -> None:
    """Refuse a key that stands in two of the tables."""
    for (one, own), (other, others) in itertools.combinations(zip(_TABLES, tables, strict=True), 2):
        for key in own:
            if key in others:
                raise SceneError(f"{key}: must stand under {one} or under {other}; it stands under both")


def _check_names(name: str, varied: Row, fixed: Row) -> None:
    """Refuse arguments that a request does not know, lacks, or cannot vary."""
    request = REQUESTS[name]
    for key in varied | fixed:
        if not _of_scene(key, request) and key not in request.arguments:
            raise SceneError(f"argument of {name} {unknown(key, request.arguments)}, or a dotted key of the scene")
    for key in request.needed:
        if key not in varied and key not in fixed:
            raise SceneError(f"{key}: must be given under vary or fixed for {name}; it is missing")
    for key in request.ranges:
        if key in varied:
            form = 'such as "0 N:4 N:9"'
            raise SceneError(f"{key}: must be a range under fixed for {name}, {form}; it stands under vary")


def _check_cases(study: Study) -> None:
    """Refuse a study whose arguments are none, or with values that no possible scene has."""
    study.request.in_si(study.fixed)
    for name, values in study.vary.items():
        for value in values:
            study.request.in_si(_arguments({name: value}, study.request))
    if study.combine == "zip":
        _check_side_by_side(study)
        return
    for name, values in study.vary.items():
        for value in values if _of_scene(name, study.request) else ():
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
    whole, found = study.combined == "zip" and not study.asked.get("derive"), dict[str, list[str]]()
    for name, values in study.vary.items():
        if _of_scene(name, study.request):
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
    keys = {key: values for key, values in study.vary.items() if key == SCENE or _of_scene(key, study.request)}
    keys |= {name: [value]}
    first = None
    for count, values in enumerate(itertools.product(*keys.values())):
        refusal = _refusal(study, dict(zip(keys, values, strict=True)))
        if refusal is None or count == _LOOKS:
            return None
        first = first or refusal
    return first


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


def _of_scene(name: str, request: Request) -> bool:
    """Tell whether a name is a key of the scene, not an argument of the request."""
    return name not in request.arguments and ("." in name or name in TOP)


def _arguments(names: Row, request: Request) -> Row:
    """Return the arguments of the request."""
    return {name: item for name, item in names.items() if name != SCENE and not _of_scene(name, request)}


def _overrides(names: Row, request: Request) -> tuple[str, ...]:
    """Return the keys of the scene as overrides of the command line."""
    return tuple(f"{name}={literal(item)}" for name, item in names.items() if _of_scene(name, request))
