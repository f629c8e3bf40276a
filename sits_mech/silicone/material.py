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
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import SURE, Array
from sits_mech.silicone.laws import LAWS, Constants, Law
from sits_mech.silicone.words import in_constants
from sits_mech.units import SceneError, quantity, shown

_SOFTEST, _STIFFEST = 1e2, 1e8  # plausible shear moduli [Pa]
_LEAST_BULK = 2.0  # shear moduli; less is Poisson's ratio under 0.29
_RANGE_OF_THREE = 1.693  # mean range of three normal numbers, in deviations
_NUMBERS = {"rms": "Pa", "spread": "", "mode_spread": "", "expansion": "1/K"}  # what is known of the constants
_RANGES = {
    "fitted_range": ("", "smallest and largest strain"),
    "temperature_range": ("K", "lowest and the highest temperature"),
}


@dataclass(frozen=True)
class Softening:
    """Constants of the softening after the largest load, eta = 1 - erf((W_max - W)/(m + beta W_max))/r.

    Source: R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455 (1999) 2861, with the beta of W. V. Mars, Tire Sci.
    Technol. 32 (2004) 120. W is the energy density of the law, per volume without load.

    Attributes
    ----------
    r : float
        Inverse depth, greater than 1 [-].
    m : float
        Energy density over which the softening fades where the largest one is small [Pa].
    beta : float
        Share of the largest energy density that is added to m [-]; m and beta are not both zero.
    """

    r: float
    m: float = 0.0
    beta: float = 1.0

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


def silicone_from(table: Mapping[str, Any], name: str = "") -> Silicone:
    """Return the silicone of a material table (with or without units), constants in SI.

    `name`: in the catalogue. Raise SceneError for an unknown or missing key, no positive shear modulus, or Prony
    weights that leave none to slow load.
    """
    table = in_constants(table)
    name_of_law = table.get("law")
    if not isinstance(name_of_law, str) or name_of_law not in LAWS:
        raise SceneError(f"law must be one of {', '.join(LAWS)}; got {shown(name_of_law)}")
    law = LAWS[name_of_law]
    allowed = ("law", *law.units, "bulk_modulus", "prony", "mullins", "source", *_RANGES, *_NUMBERS)
    for key in table:
        if key not in allowed:
            raise SceneError(f"{key} is no key of a {law.name} material; it has {', '.join(allowed)}")
    for key in (*law.units, "bulk_modulus"):
        if key not in table:
            raise SceneError(f"{key} must be given for a {law.name} material; it is missing")
    constants = _constants(law, table)
    bulk_modulus = quantity(table["bulk_modulus"], "Pa", "bulk_modulus")
    if not bulk_modulus > 0.0:
        raise SceneError(f"bulk_modulus must be a positive pressure; got {shown(table['bulk_modulus'])}")
    prony, mullins = _branches(table.get("prony", ())), _softening(table.get("mullins"))
    return Silicone(name, law.name, constants, bulk_modulus, prony=prony, mullins=mullins, **_provenance(table))


def _branches(entries: Any) -> tuple[tuple[float, float], ...]:
    """Return weights and times [s] of a Prony series, or refuse them."""
    if not isinstance(entries, list | tuple) or not all(isinstance(entry, Mapping) for entry in entries):
        raise SceneError(f'prony must be a list of tables {{weight = 0.1, time = "0.5 s"}}; got {shown(entries)}')
    found = []
    for number, entry in enumerate(entries):
        if set(entry) != {"weight", "time"}:
            raise SceneError(f"prony.{number} must have the keys weight and time; got {', '.join(map(str, entry))}")
        weight = quantity(entry["weight"], "", f"prony.{number}.weight")
        time = quantity(entry["time"], "s", f"prony.{number}.time")
        if not (weight > 0.0 and time > 0.0):
            raise SceneError(f"prony.{number} must have a positive weight and time; got {weight:g} and {time:g} s")
        found.append((weight, time))
    total = sum(weight for weight, _ in found)
    if not total < 1.0:
        raise SceneError(f"prony: the weights must sum to less than 1; got {total:g}")
    return tuple(found)


def _softening(table: Any) -> Softening | None:
    """Return the softening of a table, or refuse it."""
    if table is None:
        return None
    if not isinstance(table, Mapping) or "r" not in table or not set(table) <= {"r", "m", "beta"}:
        raise SceneError(f'mullins must be a table such as {{r = 2.5, m = "0 Pa", beta = 1.0}}; got {shown(table)}')
    r, m, beta = (
        quantity(table.get(key, default), unit, f"mullins.{key}")
        for key, default, unit in (("r", 0.0, ""), ("m", 0.0, "Pa"), ("beta", 1.0, ""))
    )
    if not r > 1.0:
        raise SceneError(f"mullins.r must be greater than 1; got {r:g}")
    if not (m >= 0.0 and beta >= 0.0 and m + beta > 0.0):
        raise SceneError(f"mullins: m and beta must not be negative, and not both zero; got {m:g} Pa and {beta:g}")
    return Softening(r, m, beta)


def _constants(law: Law, table: Mapping[str, Any]) -> Constants:
    """Return a law's constants in SI, or refuse them without a positive initial stiffness."""
    found: dict[str, float | tuple[float, ...]] = {}
    for key, unit in law.units.items():
        if law.lists:
            entries = table[key] if isinstance(table[key], list | tuple) else [table[key]]
            found[key] = tuple(quantity(entry, unit, key) for entry in entries)
        else:
            found[key] = quantity(table[key], unit, key)
    refusal = law.refusal(found)
    if refusal:
        raise SceneError(refusal)
    if not 0.0 < law.shear_modulus(found) < float("inf"):
        raise SceneError(f"{', '.join(law.units)} must give a positive shear modulus; got {found}")
    return found


def _provenance(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return source, fitted range, residual and spread, if a table has them."""
    found: dict[str, Any] = {key: quantity(table[key], unit, key) for key, unit in _NUMBERS.items() if key in table}
    source = table.get("source", Silicone.source)
    if not isinstance(source, str) or not source.isprintable():
        raise SceneError(f"source must be a printable text; got {shown(source)}")
    for key in ("rms", "mode_spread"):
        if found.get(key, 0.0) < 0.0:
            raise SceneError(f"{key} must not be negative; got {shown(table[key])}")
    ranges = {key: _rising(key, table[key], *_RANGES[key]) for key in _RANGES if key in table}
    return found | ranges | {"source": source}


def _rising(key: str, ends: Any, unit: str, words: str) -> tuple[float, ...]:
    """Return the two ends of a range in SI, or refuse them."""
    found = tuple(quantity(end, unit, key) for end in ends) if isinstance(ends, list | tuple) else ()
    if len(found) != 2 or not found[0] < found[1]:
        raise SceneError(f"{key} must be the {words}; got {shown(ends)}")
    return found


def table_of(silicone: Silicone) -> dict[str, Any]:
    """Return the material table of `silicone` in SI; `silicone_from` gives the same silicone back."""
    table: dict[str, Any] = {"law": silicone.law, **silicone.constants, "bulk_modulus": silicone.bulk_modulus}
    if silicone.prony:
        table["prony"] = [{"weight": weight, "time": time} for weight, time in silicone.prony]
    if silicone.mullins is not None:
        table["mullins"] = vars(silicone.mullins).copy()
    if silicone.source != Silicone.source:
        table["source"] = silicone.source
    extras = {key: getattr(silicone, key) for key in (*_RANGES, *_NUMBERS)}
    table |= {key: item for key, item in extras.items() if item is not None}
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
