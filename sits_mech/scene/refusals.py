"""Say what a file's tables are refused for, by the models that read them: one line, the first mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from sits_mech.scene.materials import unknown
from sits_mech.units import printable, shown

_KINDS = {
    "tuple_type": "a list", "too_long": "a list of two", "too_short": "one or more", "model_type": "a table",
    "dict_type": "a table",
}
"""What each of pydantic's errors asks for, in the words of a file."""


def refusal(error: ValidationError, given: Mapping[str, Any], model: type[BaseModel], whole: str) -> str:
    """Return the first error of tables that a model refused: key, what it must be, what came.

    Unknown keys come before their consequences, parts of lists by their names; `whole` names the tables.
    """
    found = error.errors(include_url=False)
    first = next((item for item in found if item["type"] == "extra_forbidden"), found[0])
    steps = first["loc"]
    key = printable(".".join(str(step) for step in _named(steps, given)))
    if first["type"] == "extra_forbidden":
        return f"{key}: the key {unknown(steps[-1], _keys(model, steps[:-1]))}"
    if first["type"] == "missing":
        return f"{key}: must be given; it is missing"
    cause = first.get("ctx", {}).get("error")
    if cause is not None:
        text = str(cause)
        return f"{key}: {text}" if key else text
    expected = _KINDS.get(first["type"])
    must = f"must be {expected}" if expected else first["msg"].replace("Input should be", "must be", 1)
    return f"{key or whole}: {must}; got {shown(first['input'])}"


def _named(steps: tuple[int | str, ...], given: Mapping[str, Any]) -> tuple[int | str, ...]:
    """Return the steps of a key with the name of the part in place of its number, where it has one."""
    match steps:
        case (str(parts), int(number), *rest) if isinstance(given.get(parts), list):
            part = given[parts][number]
            name = part.get("name") if isinstance(part, Mapping) else None
            return (parts, name if isinstance(name, str) and name else number, *rest)
    return steps


def _keys(model: type[BaseModel], steps: tuple[int | str, ...]) -> list[str]:
    """Return the keys of the table at the end of some steps down from a model, as they are written."""
    for step in steps:
        field = model.model_fields.get(str(step))
        model = model if field is None else next(_models(field.annotation), model)
    return [field.alias or name for name, field in model.model_fields.items()]


def _models(annotation: Any) -> Any:
    """Yield the models in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)
