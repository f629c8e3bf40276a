"""Hold what a study asks: scenes, a request, what varies, what is fixed; its cases, and what they share."""

from __future__ import annotations

import json
import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from sits_mech.batch.requests import REQUESTS, Request, Variant
from sits_mech.batch.studies.samples import Expression
from sits_mech.batch.studies.written import SCENE, Adaptive
from sits_mech.cases import Combine
from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS
from sits_mech.scene.files import literal
from sits_mech.store import Row

TOP = ("frequency", "substrate_radius")  # keys of a scene that stand in no table
Item = tuple[str, str]
_SILICONE = ("elastomer.material", "cover.material")
_NOT_OF_COILS = ("elastomer", "cover", "readout", "tolerances", "mechanics")
_NOT_OF_PAD = ("coils", "conductors", "frequency", "substrate_radius", "readout", "tolerances", "magnetics")


class Shared(NamedTuple):
    """What a case prepares: coils with their plates, pad with its meshes, and the load that brings this to rest."""

    coils: tuple[Hashable, ...]
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
class Stage:
    """What is done with the best cases of the stage before."""

    where: tuple[Expression, ...]  # conditions on its table
    order: Expression | None  # of what is best
    largest: bool  # whether that is the largest
    count: int | None  # how many are taken; None for all
    study: Study | None  # asked of them, without their values; None for an export
    export: tuple[str, ...] = ()  # formats

    @property
    def name(self) -> str:
        """Return what it is, in words."""
        return "export" if self.study is None else self.study.name


@dataclass(frozen=True)
class Study:
    """A study as its file says; made by `study.read_study`."""

    scenes: dict[str, str]  # of `scene_text`, the fixed keys of the scene applied, by their names in the file
    name: str  # a key of `REQUESTS`
    vary: dict[str, list[Any]]  # values of each varied key or argument as written, ranges written out
    fixed: Row  # arguments that are the same in all cases
    combine: Combine = "product"
    asked: Row = field(default_factory=dict)  # as written: combine, samples, seed, where, derive, adaptive
    left_out: int = 0  # cases that break a condition
    adaptive: Adaptive | None = None  # of a product
    then: tuple[Stage, ...] = ()

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
        combined = self.combine if self.adaptive else self.combined
        return json.dumps([self.scene, self.name, sorted(self.vary), self.fixed, combined], indent=1)

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
        coils, pad, load = [], [], []
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
        return Variant(scene, overrides_of(point, self.request)), self.fixed | arguments_of(point, self.request)


def of_scene(name: str, request: Request) -> bool:
    """Tell whether a name is a key of the scene, not an argument of the request."""
    return name not in request.arguments and ("." in name or name in TOP)


def arguments_of(names: Row, request: Request) -> Row:
    """Return the arguments of the request."""
    return {name: item for name, item in names.items() if name != SCENE and not of_scene(name, request)}


def overrides_of(names: Row, request: Request) -> tuple[str, ...]:
    """Return the keys of the scene as overrides of the command line."""
    return tuple(f"{name}={literal(item)}" for name, item in names.items() if of_scene(name, request))
