"""A silicone in numbers: a law with its constants, rate, history, and their source.

A material table names the ``law``, the constants that the law has (laws/: one file each, with its formula), and
``bulk_modulus``: ``K/2 (J - 1)^2`` is added to every law. All constants in Pa, but for plain numbers. They are those of
slow load on virgin material. What users rather have, E and nu, K, D1 or a hardness, words.py turns into them. Rate and
history (history.py) play a part where the table has the keys

    prony = [{weight = 0.1, time = "0.5 s"}, ...]     shares of the instantaneous stiffness, and their relaxation times
    mullins = {r = 2.5, m = "0 Pa", beta = 1.0}       softening after the largest load: 1/r is its depth, r > 1; m and
                                                      beta scale the energy over which it fades, and may be left out
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, BaseModel, Field, create_model, model_validator

from sits_mech.inputs import FORM, Reads, checked, choice, positive, quantity_of, quantity_schema, unknown, within
from sits_mech.quantities import SURE, Array
from sits_mech.silicone.laws import LAWS, Constants
from sits_mech.silicone.words import WORDS, in_constants
from sits_mech.units import SceneError, shown, si_value

_SOFTEST, _STIFFEST = 1e2, 1e8  # plausible shear moduli [Pa]
_LEAST_BULK = 2.0  # shear moduli; less is Poisson's ratio under 0.29
_RANGE_OF_THREE = 1.693  # mean range of three normal numbers, in deviations
_NOT_NEGATIVE = "zero or positive"


@dataclass(frozen=True)
class Softening:
    """Constants of the softening after the largest load, eta = 1 - erf((W_max - W)/(m + beta W_max))/r.

    Source: R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999) 2861, with the beta of W. V. Mars, Tire Sci.
    Technol. 32 (2004) 120. W is the energy density of the law, per volume without load.
    """

    r: float  # inverse depth, greater than 1 [-]
    m: float = 0.0  # energy density over which the softening fades where the largest one is small [Pa]
    beta: float = 1.0  # share of the largest energy density that is added to m [-]; m and beta are not both zero

    def factor(self, energy: ArrayLike, largest: ArrayLike, volume: float = 1.0) -> Array:
        """Return eta, the share of the virgin stress that is left [-].

        Parameters
        ----------
        energy, largest : array_like
            The present energy and the largest one so far, not below it: densities [Pa], or energies of a volume [J].
        volume : float
            That volume [m^3]; 1 for densities.
        """
        from scipy.special import erf

        energy, largest = np.asarray(energy, dtype=float), np.asarray(largest, dtype=float)
        scale = self.m * volume + self.beta * largest
        return np.asarray(1.0 - erf((largest - energy) / np.maximum(scale, 1e-300)) / self.r)


@dataclass(frozen=True)
class Silicone:
    """A hyperelastic law with its constants.

    Attributes
    ----------
    name : str
        Name in the catalogue, or "" when the scene gives the numbers.
    law : str
        A key of `sits_mech.silicone.laws.LAWS`.
    constants : mapping
        By the names of the law's `units`, and in these.
    bulk_modulus : float
        K [Pa].
    source : str
        Where the constants come from.
    fitted_range : tuple of float or None
        Smallest and largest engineering strain of the data behind the constants [-].
    rms : float or None
        Root mean square of what the fit leaves of the engineering stress [Pa].
    expansion : float or None
        Linear coefficient of thermal expansion [1/K]; None: unknown.
    temperature_range : tuple of float or None
        In which moduli are proportional to the absolute temperature, and the expansion holds [K]; None: unknown.
    spread : float or None
        Largest over smallest value that the sources in `source` give for the stress at 100 % strain, less one [-].
    mode_spread : float or None
        Largest factor, less one, between its energy and those of laws that fit its tests as well, pressed and sheared
        (analysis/material/alike.py) [-]: a half-width of 90 %.
    prony : tuple of (float, float)
        Share of the instantaneous stiffness [-] and relaxation time [s] of each branch; none: no viscosity.
    mullins : Softening or None
        After the largest load; None: none.
    """

    name: str
    law: str
    constants: Constants = field(hash=False)
    bulk_modulus: float
    source: str = "the scene"
    fitted_range: tuple[float, float] | None = None
    rms: float | None = None
    spread: float | None = None
    mode_spread: float | None = None
    expansion: float | None = None
    temperature_range: tuple[float, float] | None = None
    prony: tuple[tuple[float, float], ...] = ()
    mullins: Softening | None = None

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at small strain [Pa]."""
        return LAWS[self.law].shear_modulus(self.constants)

    @property
    def known_stretch(self) -> float:
        """Largest stretch that the data behind the constants reach [-]; nan if unknown."""
        return float("nan") if self.fitted_range is None else 1.0 + self.fitted_range[1]

    @property
    def modulus_deviation(self) -> float | None:
        """Standard deviation of its modulus's logarithm, by sources, three as a rule, and modes; None: unknown [-]."""
        if self.spread is None and self.mode_spread is None:
            return None
        return math.hypot(math.log1p(self.spread or 0.0) / _RANGE_OF_THREE, math.log1p(self.mode_spread or 0.0) / SURE)

    @property
    def is_untested(self) -> bool:
        """Whether neither a source, nor tests, nor a spread tell how well its constants are known."""
        return self.source == Silicone.source and self.fitted_range is None and self.modulus_deviation is None

    @property
    def has_history(self) -> bool:
        """Whether its rate or its largest load play a part."""
        return bool(self.prony) or self.mullins is not None

    def stiffened(self, share: float) -> Silicone:
        """Return a silicone of the same modulus whose energy has share mu/2 (I1 - 3)^2 more."""
        change = LAWS[self.law].stiffened
        if change is None:
            raise SceneError(f"stiffening: must be of a law that says how it stiffens; {self.law} does not")
        law, constants = change(self.constants, share)
        return replace(self, law=law, constants=constants)


class BranchTable(BaseModel):
    """A branch of a Prony series."""

    model_config = FORM
    weight: Annotated[float, positive("")]
    time: Annotated[float, positive("s")]


class SofteningTable(BaseModel):
    """Constants of `Softening`."""

    model_config = FORM
    r: Annotated[float, within("", math.nextafter(1.0, 2.0), 1e30, "greater than 1")]
    m: Annotated[float, within("Pa", 0.0, 1e30, _NOT_NEGATIVE)] = 0.0
    beta: Annotated[float, within("", 0.0, 1e30, _NOT_NEGATIVE)] = 1.0

    @model_validator(mode="after")
    def _fades(self) -> SofteningTable:
        """Refuse a softening that does not fade."""
        if self.m + self.beta == 0.0:
            raise SceneError("m and beta must not be both zero; got 0 Pa and 0")
        return self


def _shares(branches: list[BranchTable]) -> tuple[tuple[float, float], ...]:
    """Return weights and times [s] of a Prony series, or refuse them."""
    total = sum(each.weight for each in branches)
    if not total < 1.0:
        raise SceneError(f"must have weights that sum to less than 1; got {total:g}")
    return tuple((each.weight, each.time) for each in branches)


def _range(unit: str, words: str) -> Reads:
    """Return what reads the two ends of a range, of words."""

    def check(ends: Any) -> tuple[float, ...]:
        found = tuple(si_value(end, unit) for end in ends) if isinstance(ends, list | tuple) else ()
        if len(found) != 2 or not found[0] < found[1]:
            raise SceneError(f"must be the {words}; got {shown(ends)}")
        return found

    return Reads(check, {"type": "array", "items": quantity_schema(unit), "minItems": 2, "maxItems": 2})


def _printable(value: object) -> str:
    """Return a text that can be printed."""
    if not isinstance(value, str) or not value.isprintable():
        raise SceneError(f"must be a printable text; got {shown(value)}")
    return value


class _Known(BaseModel):
    """Keys of a material table of any law, beside its constants."""

    model_config = FORM
    bulk_modulus: Annotated[float, positive("Pa", "a positive pressure")]
    prony: Annotated[list[BranchTable], AfterValidator(_shares)] = Field(
        default_factory=list, validate_default=True, description="Shares of the first stiffness that relax.")
    mullins: Annotated[SofteningTable, AfterValidator(lambda found: Softening(**dict(found)))] | None = Field(
        None, description="Softening after the largest load: 1/r is its depth, r > 1; m + beta W_max its energy.")
    source: Annotated[str, Reads(_printable, {"type": "string"})] = "the scene"
    fitted_range: Annotated[Any, _range("", "smallest and largest strain")] = None
    temperature_range: Annotated[Any, _range("K", "lowest and the highest temperature")] = None
    rms: Annotated[float, within("Pa", 0.0, 1e30, _NOT_NEGATIVE)] | None = None
    spread: Annotated[float, quantity_of("")] | None = None
    mode_spread: Annotated[float, within("", 0.0, 1e30, _NOT_NEGATIVE)] | None = None
    expansion: Annotated[float, quantity_of("1/K")] | None = None


def _terms(unit: str) -> Reads:
    """Return what reads a constant of a law of several terms: one, or a list."""
    one = quantity_of(unit)

    def check(value: Any) -> tuple[float, ...]:
        return tuple(map(one.check, value if isinstance(value, list | tuple) else [value]))

    return Reads(check, {"anyOf": [one.schema, {"type": "array", "items": one.schema}]})


def constants_elsewhere() -> dict[str, str]:
    """Return what one who gives a constant of a silicone beside its table is answered, by key."""
    keys = {key for law in LAWS.values() for key in law.units} | {"law", "youngs_modulus", *WORDS, *_Known.model_fields}
    return dict.fromkeys(keys, 'constants of a silicone stand in a table, material = {E = "60 kPa", nu = 0.499}')


@cache
def material_table(law: str) -> type[BaseModel]:
    """Return the model of a material table of a law, by constants alone."""
    kind, units = _terms if LAWS[law].lists else quantity_of, LAWS[law].units
    fields: Any = {key: (Annotated[Any, kind(unit)], ...) for key, unit in units.items()}
    return create_model(law, __base__=_Known, law=(Annotated[str, choice(law)], ...), **fields)


def silicone_from(table: Mapping[str, Any], name: str = "") -> Silicone:
    """Return the silicone of a material table (with or without units), constants in SI.

    `name`: in the catalogue. Raise SceneError for an unknown or missing key, no positive shear modulus, or Prony
    weights that leave none to slow load.
    """
    table = in_constants(table)
    if not isinstance(law := table.get("law"), str) or law not in LAWS:
        raise SceneError(f"law: {unknown(law, LAWS)}")
    own, found = LAWS[law], dict(checked(material_table(law), table, "silicone"))
    constants: Constants = {key: found.pop(key) for key in own.units}
    if refusal := own.refusal(constants):
        raise SceneError(refusal)
    if not 0.0 < own.shear_modulus(constants) < math.inf:
        raise SceneError(f"{', '.join(own.units)} must give a positive shear modulus; got {constants}")
    return Silicone(name, found.pop("law"), constants, **found)


def table_of(silicone: Silicone) -> dict[str, Any]:
    """Return the material table of `silicone` in SI; `silicone_from` gives the same silicone back."""
    known = {key: getattr(silicone, key) for key in _Known.model_fields}
    usual = {key: getattr(Silicone, key, None) for key in known}
    table: dict[str, Any] = {"law": silicone.law, **silicone.constants}
    table |= {key: item for key, item in known.items() if item != usual[key]}
    if silicone.prony:
        table["prony"] = [{"weight": weight, "time": time} for weight, time in silicone.prony]
    if silicone.mullins is not None:
        table["mullins"] = vars(silicone.mullins).copy()
    return {key: list(item) if isinstance(item, tuple) else item for key, item in table.items()}


def implausible(silicone: Silicone) -> tuple[str, ...]:
    """Return a line for each constant that hardly any silicone has, usually a slip of unit; all are solved."""
    found, mu, bulk_modulus = [], silicone.shear_modulus, silicone.bulk_modulus
    if not _SOFTEST <= mu <= _STIFFEST:
        range_ = f"{_SOFTEST:g} Pa to {_STIFFEST:g} Pa"
        found.append(f"implausible: a shear modulus of {mu:.3g} Pa; silicones have {range_}: is the unit right?")
    if bulk_modulus < _LEAST_BULK * mu:
        what = f"a bulk modulus of {bulk_modulus:.3g} Pa under {_LEAST_BULK:g} times the shear modulus of {mu:.3g} Pa"
        found.append(f"implausible: {what}; silicones have some thousand times: is the unit right?")
    return tuple(found)
