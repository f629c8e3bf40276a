"""Read a file's tables by a model, or say what they are refused for: one line, the first mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from sits_mech.scene.materials import unknown
from sits_mech.units import SceneError, printable, shown

Model = TypeVar("Model", bound=BaseModel)

_KINDS = {
    "tuple_type": "must be a list", "list_type": "must be a list", "string_type": "must be a text",
    "too_long": "must be a list of two", "too_short": "must not be empty", "model_type": "must be a table",
    "dict_type": "must be a table",
}
"""What each of pydantic's errors asks for, in the words of a file."""


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
    return f"{key or whole}: {_must(one, model, key)}"


def _must(one: ErrorDetails, model: type[BaseModel], key: str) -> str:
    """Return what a key must be by one of pydantic's errors, and what came."""
    kind, steps = one["type"], one["loc"]
    table = _table(model, steps[:-1])
    if kind == "extra_forbidden":
        return f"the key {unknown(steps[-1], [field.alias or name for name, field in table.model_fields.items()])}"
    if kind == "missing":
        return "must be given; it is missing"
    must = _KINDS.get(kind, one["msg"].replace("Input should be", "must be", 1))
    if kind in ("tuple_type", "list_type") and _table(model, steps) is not table:
        must = f"must be tables under [[{key}]]"
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


def _models(annotation: Any) -> Any:
    """Yield the models in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)
