"""Read what users write, by models of tables: one kind of annotation for keys, one line for what is refused.

A file, or a table of one, is a pydantic model; among the annotations of a key's type is what reads it, a `Reads`: a
check of the value, and the JSON Schema of what is written. `checked` reads tables by a model.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, ErrorDetails, core_schema

from sits_mech.units import QUANTITY_PATTERN, SceneError, printable, shown, si_value, split_quantity

Model = TypeVar("Model", bound=BaseModel)
NUMBER_OR_TEXT = {"anyOf": [{"type": "number"}, {"type": "string"}]}
"""JSON Schema of a quantity of any dimension."""
FORM = ConfigDict(frozen=True, extra="forbid")
"""Of models of files: values that stay, and no key that is not known."""
_LEAST, _MOST = 1e-30, 1e30  # of what is positive
_KINDS = {
    "tuple_type": "must be a list", "list_type": "must be a list", "string_type": "must be a text",
    "too_long": "must be a list of two", "too_short": "must not be empty", "model_type": "must be a table",
    "dict_type": "must be a table",
}
"""What each of pydantic's errors asks for, in the words of a file."""


def quantity_schema(unit: str, **limits: float) -> dict[str, Any]:
    """Return the JSON Schema of a written quantity: a number in SI, within limits, or a text with a unit."""
    texts = {"type": "string", "pattern": QUANTITY_PATTERN}
    return {"anyOf": [{"type": "number", **limits}, texts], "x-unit": unit or "1"}


@dataclass(frozen=True, eq=False)  # pydantic asks for a hash
class Reads:
    """What reads a key, among the annotations of its type: a check, and the JSON Schema of what is written.

    The check returns the value, or refuses it, saying what it must be and what came.
    """

    check: Callable[[Any], Any]
    schema: dict[str, Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a schema that checks before pydantic's own."""
        return core_schema.no_info_before_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Return the JSON Schema."""
        return dict(self.schema)


def within(unit: str, low: float, high: float, words: str) -> Reads:
    """Return what reads a quantity between `low` and `high` in SI, with its words for errors."""

    def check(value: object) -> float:
        number = si_value(value, unit)
        if not low <= number <= high:
            raise SceneError(f"must be {words}; got {shown(value)}")
        return number

    return Reads(check, quantity_schema(unit, minimum=low, maximum=high))


def whole(low: int, high: int | None = None) -> Reads:
    """Return what reads a whole number from `low` on, to `high` if given."""
    words = f" from {low} to {high}" if high is not None else f", {low} or more"

    def check(value: object) -> int:
        if isinstance(value, int) and not isinstance(value, bool) and low <= value <= (value if high is None else high):
            return value
        raise SceneError(f"must be a whole number{words}; got {shown(value)}")

    return Reads(check, {"type": "integer", "minimum": low} | ({} if high is None else {"maximum": high}))


def choice(*known: str) -> Reads:
    """Return what reads one of some names."""

    def check(value: object) -> object:
        if value in known:
            return value
        raise SceneError(unknown(value, known))

    return Reads(check, {"enum": list(known)})


def quantity_of(unit: str) -> Reads:
    """Return what reads a quantity in SI."""
    return Reads(partial(si_value, unit=unit), quantity_schema(unit))


def positive(unit: str, words: str = "positive") -> Reads:
    """Return what reads a positive quantity in SI."""
    return within(unit, _LEAST, _MOST, words)


def list_or_span(value: Any, form: str, *more: str) -> Any:
    """Return a list of different values as it is, or of a range, a table as `form` has it, its ends and their unit.

    The ends differ; `more` are keys that it has beside "from" and "to".
    """
    if isinstance(value, list) and value:
        if len({json.dumps(item, default=str) for item in value}) == len(value):
            return value
        raise SceneError(f"must be a list of different values; got {shown(value)}")
    if isinstance(value, dict) and set(value) == {"from", "to", *more}:
        (first, unit), (last, other) = (split_quantity(value[end], end) for end in ("from", "to"))
        if unit == other and first != last:
            return first, last, unit
    raise SceneError(f"must be a list of values that is not empty, or {form}; got {shown(value)}")


def list_or_span_schema(**more: Any) -> dict[str, Any]:
    """Return the JSON Schema of what `list_or_span` reads; `more` are schemas of keys that a range may have."""
    span = dict.fromkeys(("from", "to"), NUMBER_OR_TEXT) | more
    table = {"type": "object", "additionalProperties": False, "required": ["from", "to"], "properties": span}
    return {"anyOf": [{"type": "array", "minItems": 1, "uniqueItems": True}, table]}


def unknown(name: object, known: Iterable[str]) -> str:
    """Return the words for a name that is not among `known`: the list, and what was probably meant."""
    known = list(known)
    return f"must be one of {', '.join(known)}; got {meant(name, known)}"


def meant(name: object, known: Sequence[str]) -> str:
    """Return a name that is not among `known` as it is shown, and what was probably meant."""
    near = difflib.get_close_matches(str(name).lower(), known, n=1) if isinstance(name, str) else []
    return shown(name) + (f' (did you mean "{near[0]}"?)' if near else "")


def checked(model: type[Model], given: Mapping[str, Any], whole: str, place: str = "", first: int = 0) -> Model:
    """Return tables as a model reads them; `whole` names them, `first` is the number of a list's first part.

    Raises SceneError in one line: `place`, the key, what it must be, what came.
    """
    try:
        return model.model_validate(given)
    except ValidationError as error:
        text = _refusal(error, given, model, whole, first)
        raise SceneError(f"{place}: {text}" if place else text) from None


def _refusal(error: ValidationError, given: Mapping[str, Any], model: type[BaseModel], whole: str, first: int) -> str:
    """Return the first error of tables that a model refused, as `checked`.

    Unknown keys come before their consequences, parts of lists by their names.
    """
    found = error.errors(include_url=False)
    one = next((item for item in found if item["type"] == "extra_forbidden"), found[0])
    named = (str(step + first if isinstance(step, int) else step) for step in _named(one["loc"], given))
    key, cause = printable(".".join(named)), one.get("ctx", {}).get("error")
    if cause is not None:
        return f"{key}: {cause}" if key else str(cause)
    return f"{key or whole}: {_must(one, model)}"


def _must(one: ErrorDetails, model: type[BaseModel]) -> str:
    """Return what a key must be by one of pydantic's errors, and what came."""
    kind, steps = one["type"], one["loc"]
    table = _table(model, steps[:-1])
    if kind == "extra_forbidden" and steps[-1] in (elsewhere := getattr(table, "elsewhere", {})):
        return f"must be left out: {elsewhere[steps[-1]]}; got {shown(one['input'])}"
    if kind == "extra_forbidden":
        homes = " or ".join(home for home, keys in _keys(model) if steps[-1] in keys)
        return f"the key {unknown(steps[-1], _names(table))}" + (f", which stands {homes}" if homes else "")
    if kind == "missing":
        return "must be given; it is missing"
    must = _KINDS.get(kind, one["msg"].replace("Input should be", "must be", 1))
    if kind in ("tuple_type", "list_type") and _table(model, steps) is not table:
        must = f"must be a list of tables, as under [[{'.'.join(map(str, steps))}]]"
    return f"{must}; got {shown(one['input'])}"


def _named(steps: tuple[int | str, ...], given: Mapping[str, Any]) -> tuple[int | str, ...]:
    """Return the steps of a key with the name of the part in place of its number, where it has one."""
    match steps:
        case (str(parts), int(number), *rest) if isinstance(given.get(parts), list):
            part = given[parts][number]
            name = part.get("name") if isinstance(part, Mapping) else None
            return (parts, name if isinstance(name, str) and name else number, *rest)
    return steps


def _table(model: type[BaseModel], steps: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the model of the table at the end of some steps down from a model, or of the last one on the way."""
    for step in steps:
        field = model.model_fields.get(str(step))
        model = model if field is None else next(_models(field.annotation), model)
    return model


def _names(table: type[BaseModel]) -> list[str]:
    """Return the keys of a table."""
    return [field.alias or name for name, field in table.model_fields.items()]


def _keys(model: type[BaseModel], way: str = "") -> Iterator[tuple[str, list[str]]]:
    """Yield the tables of a file in words, with the keys of each."""
    yield (f"in {way}" if way else "above the first table"), _names(model)
    for name, field in model.model_fields.items():
        for part in _models(field.annotation):
            step = f"{way.strip('[]')}.{name}".lstrip(".")
            yield from _keys(part, f"[[{step}]]" if get_origin(field.annotation) is tuple else f"[{step}]")


def _models(annotation: Any) -> Any:
    """Yield the models in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)
