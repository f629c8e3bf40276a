"""Define what a study file may hold: a model of each of its tables, whose schema is that of the files.

    scene = ["biorob2018", "biorob2018-w15"]   # or one: a scene file beside the study, or a name of the catalogue
    request = "inductance"            # or pose, simulate, calibrate, quality
    combine = "sobol"                 # or "latin", "saltelli"; of values, "product" (as without it), "zip", "adaptive"
    samples = 64                      # the first 64: with 128 later these are kept
    seed = 0
    where = ["target.width <= elastomer.width", "dv > 0.5 * target.thickness + 0.2 mm"]
    [vary]                            # keys of the scene in quotes, arguments of the request bare
    "target.width" = { from = "8 mm", to = "22 mm" }   # with a count where nothing is drawn; or a list
    [derive]
    "target.length" = "0.5 * target.width"
    [fixed]
    frequency = "5 MHz"
    [adaptive]                        # beside combine = "adaptive"
    of = "relative"                   # or several
    within = 1e-3
    limit = 0.7                       # or a quantity; may be left out
    [[then]]
    where = ["largest_stretch < 2"]   # conditions on the table of the stage before
    least = "resolution"              # or largest: what is put in order
    count = 3                         # so many go on
    request = "quality"               # or export = ["c", "page"], in the last one
    fixed.tolerance = 1e-3

Several scenes vary as a key of [vary] called `scene` would. Samples draw evenly from a list. [derive] gives keys of the
scene or arguments from others, each by a text (samples.py); a case that breaks a condition of `where` is left out.
Samples, derived keys and conditions make cases stand side by side, as those of "zip", along the dimension `case`.
"adaptive" solves as few cases of the product as predict variables of the table at the others (adaptive.py): within a
share of their range or, with a limit, until each is known to be on one side of it. [[then]] is a stage on the best
cases of the stage before, of which there may be more (study.py). Arguments are those of `requests.py`.
"""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, ValidationInfo, WithJsonSchema, model_validator

from sits_mech.batch.requests import REQUESTS, SHARE
from sits_mech.batch.studies.samples import LONGEST, MOST, SAMPLED, number_texts
from sits_mech.inputs import FORM, NUMBER_OR_TEXT, Reads, choice, list_or_span, list_or_span_schema, whole
from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS
from sits_mech.units import SceneError, shown, si_label

COMPONENTS = {name: argument for argument, name in (LOAD_ARGUMENTS | POSE_ARGUMENTS).items()}
"""Arguments by the names that their components have in Python, which study files may use as well."""
SCENE = "scene"
"""What varies with a list of scenes."""
ADAPTIVE = "adaptive"
"""How cases are combined that are refined."""
_COUNT = whole(2, MOST)


def _check(*rules: tuple[object, str]) -> None:
    """Refuse by the first rule that does not hold, in its words."""
    for holds, words in rules:
        if not holds:
            raise SceneError(words)


def _names(what: str) -> Reads:
    """Return what reads a name, or a list of different ones."""

    def check(value: Any) -> list[str]:
        found = value if isinstance(value, list) else [value]
        if not found or not all(isinstance(name, str) for name in found) or len(set(found)) < len(found):
            raise SceneError(f"must be {what}, or a list of different ones; got {shown(value)}")
        return found

    text = {"type": "string"}
    return Reads(check, {"anyOf": [text, {"type": "array", "items": text, "minItems": 1, "uniqueItems": True}]})


def _by_argument(table: Any) -> Any:
    """Return a table with loads and poses by the names of arguments."""
    if not isinstance(table, dict):
        return table
    for key in table:
        if COMPONENTS.get(key, key) != key and COMPONENTS[key] in table:
            raise SceneError(f"{COMPONENTS[key]} must be given once; got {key} beside it")
    return {COMPONENTS.get(key, key): item for key, item in table.items()}


def _values(value: Any, info: ValidationInfo) -> Any:
    """Return values of a key: a list as it is, a range written out, or of samples its ends and their unit."""
    count = () if info.data.get("combine") in SAMPLED or info.data.get("samples") else ("count",)
    form = f'a range {{ from = "1 mm", to = "5 mm"{", count = 41" * len(count)} }} with different ends in one unit'
    found = list_or_span(value, form, *count)
    if isinstance(found, list) or not count:
        return found
    first, last, unit = found
    return number_texts(np.linspace(first, last, _COUNT.check(value["count"])), unit)


def _limit(value: Any, info: ValidationInfo) -> float:
    """Return a limit in SI."""
    found, of = si_label(value), info.data.get("of", ())
    if isinstance(found, float) and math.isfinite(found) and len(of) < 2:
        return found
    what = "must be a number, or a quantity, for one variable under of"
    raise SceneError(f"{what}; got {shown(value)} for {', '.join(of)}")


_Formula = Annotated[Any, WithJsonSchema({"type": "string", "maxLength": LONGEST})]  # or `expression` refuses it
_Named = Annotated[dict[str, Any], BeforeValidator(_by_argument)]
_Varied = Annotated[Any, BeforeValidator(_values), WithJsonSchema(list_or_span_schema(count=_COUNT.schema))]


class Adaptive(BaseModel):
    """Up to what the cases of a grid are known, of which as few as predict the others are solved."""

    model_config = FORM
    of: Annotated[list[str], _names("a variable of the table")] = Field(
        description="Variables of the result that cases predict where they are not solved.")
    within: Annotated[float, SHARE] = Field(description="Error that they may have, over their range.")
    limit: Annotated[float, BeforeValidator(_limit), WithJsonSchema(NUMBER_OR_TEXT)] | None = Field(
        None, description="Of the one variable, in SI or with a unit: errors may be larger away from it.")


class StageTable(BaseModel):
    """A stage after the first."""

    model_config = FORM
    where: list[_Formula] = Field([], min_length=1, description="Conditions on the table of the stage before.")
    least: _Formula = Field(None, description="What is best where least: a variable of that table, or made of some.")
    largest: _Formula = Field(None, description="What is best where it is largest.")
    count: Annotated[int, whole(1)] | None = Field(None, description="How many cases go on; all without it.")
    request: Annotated[str, choice(*REQUESTS)] | None = Field(None, description="The request of its cases.")
    fixed: _Named = Field({}, description="What is other than in the stage before.")
    export: list[str] = Field([], min_length=1, description="Formats of `export`, for each case that is left.")

    @model_validator(mode="after")
    def _fits_together(self) -> StageTable:
        """Refuse what is no request and no export, or both, and an order that is none."""
        given = self.model_fields_set
        got = ", ".join(key for key in type(self).model_fields if key in given) or "nothing"
        ordered = len(given & {"least", "largest"}) == 1 or not given & {"least", "largest", "count"}
        _check(
            (("request" in given) != ("export" in given), f"must have a request or an export; got {got}"),
            (not {"fixed", "export"} <= given, "fixed must stand beside a request; got an export"),
            (ordered, f"must have least or largest, beside a count; got {got}"),
        )
        return self


class StudyTable(BaseModel):
    """A study file."""

    model_config = FORM
    scene: Annotated[list[str], _names("a scene")] = Field(
        description="A scene file in the same folder, or a name of the catalogue; or several, which vary.")
    request: Annotated[str, choice(*REQUESTS)] = Field(description="The request of every case.")
    combine: Annotated[str, choice("product", "zip", *SAMPLED, ADAPTIVE)] = Field(
        "product", description="All, in step, samples, or some of all.")
    samples: Annotated[int, whole(1, MOST)] | None = Field(None, description="Number of samples.")
    seed: Annotated[int, whole(0)] = Field(0, description="Of the samples.")
    where: list[_Formula] = Field([], description="Conditions: cases that break one are left out.")
    vary: Annotated[dict[str, _Varied], BeforeValidator(_by_argument)] = Field(
        min_length=1, description="Keys of the scene in quotes, arguments of the request bare: lists or ranges.")
    derive: Annotated[dict[str, _Formula], BeforeValidator(_by_argument)] = Field(
        {}, description="Keys and arguments by others.")
    fixed: _Named = Field({}, description="What is the same in all cases.")
    adaptive: Adaptive | None = Field(None, description='What is refined, and how far, beside combine = "adaptive".')
    then: list[StageTable] = Field([], description="Stages on the best cases of the one before.")

    @property
    def varied(self) -> dict[str, Any]:
        """What varies as it is written, several scenes first."""
        return ({SCENE: list(self.scene)} if len(self.scene) > 1 else {}) | self.vary

    @model_validator(mode="after")
    def _samples_fit(self) -> StudyTable:
        """Refuse samples without a number, a number of what is not drawn, and too many cases."""
        combine, drawn, count = self.combine, self.combine in SAMPLED, self.samples or 0
        cases = count * (len(self.varied) + 2 if combine == "saltelli" else 1)
        needed = f"must stand beside combine = {', '.join(SAMPLED)}; got {combine}"
        _check(
            *((drawn or key not in self.model_fields_set, f"{key}: {needed}") for key in ("samples", "seed")),
            (count or not drawn, f"samples: must be given, from 1 to {MOST}, for {combine}; it is missing"),
            (combine != "saltelli" or count.bit_count() == 1 < count,
             f"samples: must be a power of two for saltelli; got {count}"),
            (cases <= MOST, f"samples: must give at most {MOST} cases; got {cases}"),
        )
        return self

    @model_validator(mode="after")
    def _tables_fit(self) -> StudyTable:
        """Refuse what does not go with how cases are combined, and a key that stands in two tables."""
        combine, refined, form = self.combine, self.combine == ADAPTIVE, '{ of = "relative", within = 1e-3 }'
        _check(
            (refined or not self.adaptive, f'adaptive: must stand beside combine = "{ADAPTIVE}"; got {combine}'),
            (self.adaptive or not refined, f"adaptive: must be a table such as {form}; it is missing"),
            (not self.where or combine != "saltelli", "where: must not stand beside saltelli, which needs all cases"),
            *((not refined or not getattr(self, key), f"{key}: must not stand beside {ADAPTIVE}, which refines a grid")
              for key in ("where", "derive")),
        )
        for one, other in itertools.combinations(("vary", "derive", "fixed"), 2):
            for key in getattr(self, one).keys() & getattr(self, other).keys():
                raise SceneError(f"{key}: must stand under {one} or under {other}; it stands under both")
        return self
