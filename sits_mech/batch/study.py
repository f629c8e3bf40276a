"""Read a study file: a scene, a request, what varies and what is fixed.

    scene = "biorob2018"              # a scene file beside the study, or a name of the catalogue
    request = "inductance"            # or pose, simulate, calibrate, quality
    combine = "product"               # or "zip"
    [vary]                            # keys of the scene in quotes, arguments of the request bare
    "target.width" = ["8 mm", "15 mm", "22 mm"]
    dv = { from = "1 mm", to = "5 mm", count = 41 }
    [fixed]
    frequency = "5 MHz"
    model = "planar"
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.batch.requests import REQUESTS, Request, Variant
from sits_mech.cases import Combine, grid_points
from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS
from sits_mech.scene.files import check_keys, literal, read_as
from sits_mech.scene.materials import unknown
from sits_mech.scene.sensor import SceneError, load_beside, scene_text
from sits_mech.store import Row
from sits_mech.units import shown, split_quantity

COMPONENTS = {name: argument for argument, name in (LOAD_ARGUMENTS | POSE_ARGUMENTS).items()}
"""Arguments by the names that their components have in Python, which study files may use as well."""
KEYS = ("scene", "request", "combine", "vary", "fixed")
TOP = ("frequency", "substrate_radius")  # keys of a scene that stand in no table
_NOT_OF_COILS = ("elastomer", "readout", "tolerances", "mechanics")
_NOT_OF_PAD = ("coils", "conductors", "frequency", "substrate_radius", "readout", "tolerances", "magnetics")
_MOST = 1_000_000  # cases of a study
_LOOKS = 3_000  # scenes that are looked at before a run whether a value is possible, a second
_RANGE = '{ from = "1 mm", to = "5 mm", count = 41 } with different ends in one unit and a count of two or more'


@dataclass(frozen=True)
class Study:
    """A study as its file says; made by `read_study`."""

    scene: str  # of `scene_text`, the fixed keys of the scene applied
    name: str  # a key of `REQUESTS`
    vary: dict[str, list[Any]]  # values of each varied key or argument as written, ranges written out
    fixed: Row  # arguments that are the same in all cases
    combine: Combine = "product"

    @property
    def request(self) -> Request:
        """Return the request."""
        return REQUESTS[self.name]

    @property
    def identity(self) -> str:
        """Return the study's identity as JSON: scene, request, names of what varies, whose values may grow."""
        return json.dumps([self.scene, self.name, sorted(self.vary), self.fixed, self.combine], indent=1)

    @property
    def count(self) -> int:
        """Return how many cases it has."""
        sizes = [len(values) for values in self.vary.values()]
        return math.prod(sizes) if self.combine == "product" else max(sizes)

    def shared(self, point: Row) -> tuple[Hashable, Hashable]:
        """Return what a case prepares: coils with their plates, pad with its meshes, by all that varies of each."""
        still = {name: str(item) for name, item in point.items() if name not in (*LOAD_ARGUMENTS, *POSE_ARGUMENTS)}
        coils, pad = (
            tuple(item for item in still.items() if item[0].partition(".")[0] not in other)
            for other in (_NOT_OF_COILS, _NOT_OF_PAD)
        )
        return () if self.name == "pose" else coils, pad if self.request.layer else ()

    def case(self, point: Row) -> tuple[Variant, Row]:
        """Return scene and arguments of a point."""
        return Variant(self.scene, _overrides(point, self.request)), self.fixed | _arguments(point, self.request)


def read_study(path: Path) -> Study:
    """Read and check a study file (TOML); every value has one possible scene at least.

    Raise SceneError in one line: the file, the key, what it must be, what came.
    """
    return read_as(path, _study)


def _study(table: Mapping[str, Any], folder: Path) -> Study:
    """Return the study of a file's tables."""
    check_keys(table, KEYS, ("scene", "request", "vary"))
    combine: Combine = table.get("combine", "product")
    for key, value, known in (("request", table["request"], tuple(REQUESTS)), ("combine", combine, ("product", "zip"))):
        if value not in known:
            raise SceneError(f"{key} {unknown(str(value), known)}")
    request = REQUESTS[table["request"]]
    varied, fixed = _table(table, "vary"), _table(table, "fixed")
    _check_names(table["request"], request, varied, fixed)
    scene = load_beside(folder, str(table["scene"]), _overrides(fixed, request))
    if not request.layer and not any(key.startswith("elastomer.") for key in varied):
        scene = scene.model_copy(update={"elastomer": None})
    vary = {name: _values(name, item) for name, item in varied.items()}
    study = Study(scene_text(scene), table["request"], vary, _arguments(fixed, request), combine)
    _check_cases(study)
    return study


def _table(table: Mapping[str, Any], name: str) -> Row:
    """Return a table of the file, loads and poses by the names of arguments; [vary] must have keys."""
    part: Row = table.get(name, {})
    if not isinstance(part, dict) or (name == "vary" and not part):
        raise SceneError(f"{name}: must be a table of keys and their values; got {shown(part)}")
    for key in part:
        if key in COMPONENTS and COMPONENTS[key] in part and COMPONENTS[key] != key:
            raise SceneError(f"{name}.{COMPONENTS[key]}: must be given once; got {key} beside it")
    return {COMPONENTS.get(key, key): item for key, item in part.items()}


def _check_names(name: str, request: Request, varied: Row, fixed: Row) -> None:
    """Refuse arguments that a request does not know, lacks, or cannot vary."""
    for key in (*varied, *fixed):
        if not _of_scene(key, request) and key not in request.arguments:
            raise SceneError(f"argument of {name} {unknown(key, request.arguments)}, or a dotted key of the scene")
        if key in varied and key in fixed:
            raise SceneError(f"{key}: must stand under vary or under fixed; it stands under both")
    for key in request.needed:
        if key not in varied and key not in fixed:
            raise SceneError(f"{key}: must be given under vary or fixed for {name}; it is missing")
    for key in request.ranges:
        if key in varied:
            form = 'such as "0 N:4 N:9"'
            raise SceneError(f"{key}: must be a range under fixed for {name}, {form}; it stands under vary")


def _check_cases(study: Study) -> None:
    """Refuse a study that is too large, whose arguments are none, or with values that no possible scene has."""
    if study.count > _MOST:
        raise SceneError(f"vary: must give at most {_MOST} cases; got {study.count}")
    study.request.in_si(study.fixed)
    for name, values in study.vary.items():
        for value in values:
            study.request.in_si(_arguments({name: value}, study.request))
    if study.combine == "zip":
        grid_points(study.vary, "zip")  # refuses what is not equally many
    for name, values in study.vary.items():
        for value in values if _of_scene(name, study.request) else ():
            refusal = _refusal(study, name, value)
            if refusal is not None:
                raise SceneError(f"vary: {name} = {shown(value)} must leave a possible scene; the first one: {refusal}")


def _refusal(study: Study, name: str, value: Any) -> SceneError | None:
    """Return why no scene of a study with a value is possible; one that only some others rule out is left to them."""
    varied = {key: values for key, values in study.vary.items() if _of_scene(key, study.request)}
    keys = varied | {name: [value]}
    if study.combine == "zip":
        points = (point for point in grid_points(study.vary, "zip") if point[name] == value)
    else:
        points = (dict(zip(keys, values, strict=True)) for values in itertools.product(*keys.values()))
    first = None
    for count, point in enumerate(points):
        try:
            study.case(point)[0].sensor  # noqa: B018  the look at it is the check
            return None
        except SceneError as error:
            first = first or error
        if count == _LOOKS:
            return None
    return first


def _values(name: str, item: Any) -> list[Any]:
    """Return the values of a varied key: a list as it is, a range written out."""
    if isinstance(item, list) and item:
        if len({json.dumps(value, default=str) for value in item}) == len(item):
            return item
        raise SceneError(f"{name}: must be a list of different values; got {shown(item)}")
    if isinstance(item, dict) and set(item) == {"from", "to", "count"}:
        count = item["count"]
        if isinstance(count, int) and not isinstance(count, bool) and 2 <= count <= _MOST:
            (first, unit), (last, other) = (split_quantity(item[end], f"{name}.{end}") for end in ("from", "to"))
            if unit == other and first != last:
                numbers = [float(f"{number:.15g}") for number in np.linspace(first, last, count)]
                return [f"{number!r} {unit}" if unit else number for number in numbers]
    raise SceneError(f"{name}: must be a list of values that is not empty, or a range {_RANGE}; got {shown(item)}")


def _of_scene(name: str, request: Request) -> bool:
    """Tell whether a name is a key of the scene, not an argument of the request."""
    return name not in request.arguments and ("." in name or name in TOP)


def _arguments(names: Row, request: Request) -> Row:
    """Return the arguments of the request."""
    return {name: item for name, item in names.items() if not _of_scene(name, request)}


def _overrides(names: Row, request: Request) -> tuple[str, ...]:
    """Return the keys of the scene as overrides of the command line."""
    return tuple(
        f"{name}={literal(item)}" for name, item in names.items() if _of_scene(name, request)
    )
