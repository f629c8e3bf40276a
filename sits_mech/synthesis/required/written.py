"""Define what a requirement file may hold: a model of each of its tables, whose schema is that of the files.

    scene = "biorob2018-w15"             # a scene file beside this one, or a name of the catalogue
    [loads]                              # ranges of components of the load, as of `Wrench`
    F_x = ["-1 N", "1 N"]
    F_z = ["0 N", "4 N"]
    overload = 1.5                       # times the loads, carried without harm; 1 by default
    [vary]                               # keys of the scene in quotes: bounds, or a list
    "elastomer.thickness" = { from = "1 mm", to = "6 mm" }
    "elastomer.material" = ["ecoflex-00-30", "dragon-skin-10"]
    "coils.*.turns" = [8, 10, 12]        # a star stands for every coil
    [require]                            # limits of figures, all optional
    resolution = { F_x = "10 mN", F_z = "20 mN" }
    error = { F_z = "5 %" }
    footprint = ["25 mm", "25 mm"]
    [tolerance]                          # one standard deviation of what is made, independent and normal
    "elastomer.thickness" = "0.05 mm"
    modulus = "10 %"
    [goal]
    minimise = "error.F_z"               # a figure, {figure = weight, ...}, or "feasible"
    yield = "95 %"

What the numbers mean together, and for the scene, is `requirements_of`; figures stand in `solved/figures.py`.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, create_model

from sits_mech.inputs import (
    FORM,
    NUMBER_OR_TEXT,
    Reads,
    list_or_span,
    list_or_span_schema,
    positive,
    quantity_schema,
    unknown,
    within,
)
from sits_mech.quantities import UNITS, WRENCH
from sits_mech.synthesis.required.kinds import ASKED, KINDS, FigureKind, figure_names, figure_unit
from sits_mech.units import SceneError, shown, si_value

FIGURES = (*figure_names(WRENCH), "footprint")
"""What may be minimised."""
LEAST_YIELD = 0.95
"""Of the sensors made, by default."""
LEAST_ERROR = 1e-4
"""Of a limit of an error: a hundredth of the tolerance that designs are solved to."""
_DEVIATION = "a positive standard deviation"
_BOUNDS = 'bounds { from = "1 mm", to = "6 mm" } with ends that rise, in one unit'
_MINIMISED = {
    "anyOf": [
        {"enum": [*FIGURES, "feasible"]},
        {"type": "object", "minProperties": 1, "propertyNames": {"enum": [*FIGURES]}, "additionalProperties": {}},
    ]
}


def _two(unit: str) -> dict[str, Any]:
    """Return the schema of two quantities."""
    return {"type": "array", "items": quantity_schema(unit), "minItems": 2, "maxItems": 2, "x-unit": unit}


def _pair(unit: str, words: str, value: Any) -> tuple[float, float]:
    """Return two quantities in SI."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise SceneError(f"must be {words}; got {shown(value)}")
    return si_value(value[0], unit), si_value(value[1], unit)


def _ends(unit: str, value: Any) -> tuple[float, float]:
    """Return least and greatest of a component of the load."""
    low, high = _pair(unit, f'least and greatest, such as ["0 {unit}", "4 {unit}"]', value)
    if not low < high or low > 0.0 or high < 0.0:
        raise SceneError(f"must rise, with no load between its ends; got {shown(value)}")
    return low, high


def _sides(unit: str, value: Any) -> dict[str, float]:
    """Return what is asked of both axes."""
    found = dict(zip(("x", "y"), _pair(unit, 'two lengths, such as ["25 mm", "25 mm"]', value), strict=True))
    if not min(found.values()) > 0.0:
        raise SceneError(f"must be positive; got {shown(value)}")
    return found


def _varied(value: Any) -> Any:
    """Return a list of values, or least, greatest and unit of bounds."""
    found = list_or_span(value, _BOUNDS)
    if isinstance(found, tuple) and not found[0] < found[1]:
        raise SceneError(f"must be {_BOUNDS}; got {shown(value)}")
    return found


def _deviation(value: Any) -> float:
    """Return the standard deviation of a key of the scene."""
    number = si_value(value, "m" if isinstance(value, str) else "")
    if not number > 0.0:
        raise SceneError(f"must be {_DEVIATION}; got {shown(value)}")
    return number


def _weights(value: Any) -> dict[str, float]:
    """Return the weights of what is minimised, the footprint's for both its sides; none for "feasible"."""
    given = {value: 1.0} if isinstance(value, str) else value
    if not isinstance(given, dict) or not given:
        raise SceneError(f'must be a figure, {{figure = weight}} or "feasible"; got {shown(value)}')
    found: dict[str, float] = {}
    for name, weight in given.items() if [*given] != ["feasible"] else ():
        if name not in FIGURES:
            raise SceneError(unknown(name, (*FIGURES, "feasible")))
        number = si_value(weight, "")
        if not number > 0.0:
            raise SceneError(f"must be of positive weights; got {name} = {shown(weight)}")
        found |= dict.fromkeys(figure_names((), (name,)) if name == "footprint" else (name,), number)
    return found


def _entry(kind: Any, default: Any, words: str, **more: Any) -> tuple[Any, Any]:
    """Return type, default and meaning of a key."""
    return kind, Field(default, description=words, **more)


def _limit(key: str, kind: FigureKind) -> tuple[Any, Any]:
    """Return the limit of a kind of figure."""
    words = f"{kind.meaning}; at {'least' if kind.least else 'most'}."
    if kind.of == "axes":
        return _entry(Annotated[Any, Reads(partial(_sides, kind.unit), _two(kind.unit))], None, words)
    if not kind.of:
        return _entry(Annotated[float, positive(kind.unit)], None, words)
    each: Any = {name: (Annotated[float, positive(figure_unit(f"{key}.{name}"))], None) for name in WRENCH}
    return _entry(create_model(key, __config__=FORM, **each), None, words)


_RANGES: Any = {
    name: _entry(
        Annotated[Any, Reads(partial(_ends, UNITS[name]), _two(UNITS[name]))], None,
        f"Least and greatest [{UNITS[name]}].",
    )
    for name in WRENCH
}
_LIMITS: Any = {key: _limit(key, KINDS[key]) for key in ASKED}
_SPECIAL: Any = {
    "modulus": _entry(Annotated[float, positive("", _DEVIATION)], None, "All stiffnesses of the silicone together."),
    "coil_offset": _entry(
        Annotated[float, positive("m", _DEVIATION)], None, "Of the coils beside the pad, along x and along y [m]."),
    "repeatability": _entry(
        Annotated[float, positive("", _DEVIATION)], None,
        "Of one reading of an inductance, over the inductance, beside the converter's noise.",
    ),
}
_OVERLOAD = Annotated[float, within("", 1.0, 1e30, "1 or more")]
_YIELD = Annotated[float, within("", 0.5, 1.0 - 1e-9, "a share from 50 % to below 100 %")]


class _Deviations(BaseModel):
    """Standard deviations of any keys of a scene."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, Annotated[Any, Reads(_deviation, NUMBER_OR_TEXT)]]


_PARTS: Any = {
    "scene": _entry(str, ..., "A scene file in the same folder, or a name of the catalogue."),
    "loads": _entry(
        create_model("loads", __config__=FORM, **_RANGES, overload=_entry(
            _OVERLOAD, 1.0, "Times the loads, carried within the data of the silicone.")),
        ..., "Components of the load that vary, one at least.",
    ),
    "vary": _entry(
        dict[str, Annotated[Any, Reads(_varied, list_or_span_schema())]], ...,
        "Keys of the scene in quotes, a star for every coil: bounds or lists.", min_length=1,
    ),
    "require": _entry(create_model("require", __config__=FORM, **_LIMITS), {}, "Limits of figures, all optional."),
    "tolerance": _entry(
        create_model("tolerance", __base__=_Deviations, **_SPECIAL), {},
        "One standard deviation of what is made: of keys of the scene in quotes, and of these.",
    ),
    "goal": _entry(
        create_model(
            "goal", __config__=FORM,
            minimise=_entry(Annotated[Any, Reads(_weights, _MINIMISED)], {}, (
                'A figure, {figure = weight}, or "feasible": the first design within the limits.')),
            least_yield=_entry(
                _YIELD, LEAST_YIELD, "Share of the sensors made that must hold every limit.", alias="yield"
            ),
        ), {}, "What is best.",
    ),
}
Written = create_model("Requirements", __config__=FORM, __doc__="A requirement file.", **_PARTS)
"""A requirement file."""
SPECIAL = {"modulus": "", "coil_offset": "m", "repeatability": ""}
"""Tolerances that are no key of the scene, and their units."""
