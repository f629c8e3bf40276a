"""What are the metals and silicones made of? Each constant with its source and the range it was fitted on.

Energies per reference volume, ``I1, I2`` invariants and ``lambda`` stretches of the isochoric part of F, ``J = det F``:

    neo-hookean     W = mu/2 (I1 - 3)                                           shear_modulus = mu
    mooney-rivlin   W = c10 (I1 - 3) + c01 (I2 - 3)                             c10, c01
    yeoh            W = c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3          c10, c20, c30
    ogden           W = sum_i 2 mu_i/alpha_i^2 (sum_j lambda_j^alpha_i - 3)     mu, alpha (lists)
    gent            W = -mu j_m/2 ln(1 - (I1 - 3)/j_m)                          shear_modulus = mu, j_m

each with ``K/2 (J - 1)^2`` added. All constants in Pa, but for alpha and j_m: plain numbers. They are those of slow
load on virgin material. Rate and history (mechanics/history.py) play a part where the table has the keys

    prony = [{weight = 0.1, time = "0.5 s"}, ...]     shares of the instantaneous stiffness, and their relaxation times
    mullins = {r = 2.5}                               softening after the largest load: 1/r is its depth, r > 1
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

from sits_mech.units import SceneError, quantity, shown, si_value

Constants = Mapping[str, float | tuple[float, ...]]

LAWS: Mapping[str, tuple[str, ...]] = {
    "neo-hookean": ("shear_modulus",),
    "mooney-rivlin": ("c10", "c01"),
    "yeoh": ("c10", "c20", "c30"),
    "ogden": ("mu", "alpha"),
    "gent": ("shear_modulus", "j_m"),
}
"""The constants of each law, in the order of its formula."""


_SOFTEST, _STIFFEST = 1e2, 1e8  # plausible shear moduli [Pa]
_LEAST_BULK = 2.0  # shear moduli; less is Poisson's ratio under 0.29


@dataclass(frozen=True)
class Metal:
    """A conductor.

    Attributes
    ----------
    name : str
        Name in the catalogue, or "" when the scene gives the numbers.
    conductivity : float
        [S/m].
    relative_permeability : float
        Constant and isotropic [-].
    source : str
        Where the numbers come from.
    """

    name: str
    conductivity: float
    relative_permeability: float = 1.0
    source: str = "the scene"


@dataclass(frozen=True)
class Silicone:
    """A hyperelastic law with its constants.

    Attributes
    ----------
    name : str
        Name in the catalogue, or "" when the scene gives the numbers.
    law : str
        A key of `LAWS`.
    constants : mapping
        The constants that `LAWS` names [Pa; alpha and j_m: -].
    bulk_modulus : float
        K [Pa].
    source : str
        Where the constants come from.
    fitted_range : tuple of float or None
        Smallest and largest engineering strain of the data behind the constants [-].
    rms : float or None
        Root mean square of what the fit leaves of the engineering stress [Pa].
    spread : float or None
        Largest over smallest value that the sources in `source` give for the stress at 100 % strain, less one [-].
    prony : tuple of (float, float)
        Share of the instantaneous stiffness [-] and relaxation time [s] of each branch; none: no viscosity.
    mullins : float or None
        Inverse depth r of the softening [-]; None: none.
    """

    name: str
    law: str
    constants: Constants = field(hash=False)
    bulk_modulus: float
    source: str = "the scene"
    fitted_range: tuple[float, float] | None = None
    rms: float | None = None
    spread: float | None = None
    prony: tuple[tuple[float, float], ...] = ()
    mullins: float | None = None

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at small strain [Pa]."""
        return _shear_modulus(self.law, self.constants)


def _shear_modulus(law: str, constants: Constants) -> float:
    """Return the initial shear modulus of a law [Pa]."""
    if law == "ogden":
        moduli = constants["mu"]
        return sum(moduli) if isinstance(moduli, tuple) else moduli
    terms = {"mooney-rivlin": ("c10", "c01"), "yeoh": ("c10",)}.get(law)
    if terms is None:
        return _number(constants["shear_modulus"])
    return 2.0 * sum(_number(constants[term]) for term in terms)


def _number(constant: float | tuple[float, ...]) -> float:
    """Return a constant that is one number."""
    return sum(constant) if isinstance(constant, tuple) else constant


def silicone_from(table: Mapping[str, Any], name: str = "") -> Silicone:
    """Return the silicone that a material table of a scene or of the catalogue describes.

    Parameters
    ----------
    table : mapping
        ``law``, the constants that `LAWS` names for it, ``bulk_modulus``, and optional ``prony`` and ``mullins``; as
        written, that is with or without units.
    name : str
        Name in the catalogue.

    Returns
    -------
    Silicone
        With its constants in SI.

    Raises
    ------
    SceneError
        When a key is unknown or missing, the constants give no positive shear modulus, or the weights of the Prony
        series leave none to slow load.
    """
    law = table.get("law")
    if not isinstance(law, str) or law not in LAWS:
        raise SceneError(f"law must be one of {', '.join(LAWS)}; got {shown(law)}")
    names = LAWS[law]
    allowed = ("law", *names, "bulk_modulus", "prony", "mullins", "source", "fitted_range", "rms", "spread")
    for key in table:
        if key not in allowed:
            raise SceneError(f"{key} is no key of a {law} material; it has {', '.join(allowed)}")
    for key in (*names, "bulk_modulus"):
        if key not in table:
            raise SceneError(f"{key} must be given for a {law} material; it is missing")
    constants = {key: _constant(key, table[key]) for key in names}
    _check(law, constants)
    bulk_modulus = _constant("bulk_modulus", table["bulk_modulus"])
    if isinstance(bulk_modulus, tuple) or not bulk_modulus > 0.0:
        raise SceneError(f"bulk_modulus must be a positive pressure; got {shown(table['bulk_modulus'])}")
    prony, mullins = _branches(table.get("prony", ())), _depth(table.get("mullins"))
    return Silicone(name, law, constants, bulk_modulus, prony=prony, mullins=mullins, **_provenance(table))


def _branches(entries: Any) -> tuple[tuple[float, float], ...]:
    """Return weight and time [s] of the branches of a Prony series, or refuse them."""
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
    if not sum(weight for weight, _ in found) < 1.0:
        raise SceneError(f"prony: the weights must sum to less than 1; got {sum(weight for weight, _ in found):g}")
    return tuple(found)


def _depth(table: Any) -> float | None:
    """Return the r of a table of softening, or refuse it."""
    if table is None:
        return None
    if not isinstance(table, Mapping) or set(table) != {"r"}:
        raise SceneError(f"mullins must be a table such as {{r = 2.5}}; got {shown(table)}")
    r = quantity(table["r"], "", "mullins.r")
    if not r > 1.0:
        raise SceneError(f"mullins.r must be greater than 1; got {r:g}")
    return r


def _constant(key: str, value: Any) -> float | tuple[float, ...]:
    """Return one constant in SI: a list for the Ogden terms, a number elsewhere."""
    unit = "" if key in ("alpha", "j_m", "spread", "fitted_range") else "Pa"
    try:
        if key not in ("mu", "alpha"):
            return si_value(value, unit)
        return tuple(si_value(item, unit) for item in (value if isinstance(value, list | tuple) else [value]))
    except SceneError as error:
        raise SceneError(f"{key} {error}") from None


def _check(law: str, constants: Constants) -> None:
    """Refuse constants without a positive stiffness at small strain."""
    mu, alpha = constants.get("mu"), constants.get("alpha")
    lists = isinstance(mu, tuple) and isinstance(alpha, tuple) and len(mu) == len(alpha) and 0.0 not in alpha
    if law == "ogden" and not (mu and lists):
        raise SceneError(f"mu and alpha must be lists of one length, without a zero alpha; got {mu} and {alpha}")
    if law == "gent" and not _number(constants["j_m"]) > 0.0:
        raise SceneError(f"j_m must be positive; got {constants['j_m']}")
    if not 0.0 < _shear_modulus(law, constants) < float("inf"):
        raise SceneError(f"{', '.join(LAWS[law])} must give a positive shear modulus; got {dict(constants)}")


def _provenance(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return source, fitted range, residual and spread where a table has them."""
    found: dict[str, Any] = {key: _constant(key, table[key]) for key in ("rms", "spread") if key in table}
    source, strains = table.get("source", "the scene"), table.get("fitted_range", (0.0, 0.0))
    if not isinstance(source, str) or not source.isprintable():
        raise SceneError(f"source must be a printable text; got {shown(source)}")
    if not isinstance(strains, list | tuple) or len(strains) != 2:
        raise SceneError(f"fitted_range must be the smallest and largest strain; got {shown(strains)}")
    low, high = (_constant("fitted_range", strain) for strain in strains)
    if "fitted_range" in table:
        found["fitted_range"] = (low, high)
    return found | {"source": source}


def table_of(silicone: Silicone) -> dict[str, Any]:
    """Return the material table that describes `silicone`; `silicone_from` gives the same silicone back.

    Parameters
    ----------
    silicone : Silicone
        Of the scene's own; catalogued ones are written by name.

    Returns
    -------
    dict
        Keys of a scene file's material table, SI values.
    """
    constants = {key: list(item) if isinstance(item, tuple) else item for key, item in silicone.constants.items()}
    table: dict[str, Any] = {"law": silicone.law, **constants, "bulk_modulus": silicone.bulk_modulus}
    if silicone.prony:
        table["prony"] = [{"weight": weight, "time": time} for weight, time in silicone.prony]
    if silicone.mullins is not None:
        table["mullins"] = {"r": silicone.mullins}
    if silicone.source != "the scene":
        table["source"] = silicone.source
    if silicone.fitted_range is not None:
        table["fitted_range"] = list(silicone.fitted_range)
    extras = {"rms": silicone.rms, "spread": silicone.spread}
    return table | {key: item for key, item in extras.items() if item is not None}


def implausible(silicone: Silicone) -> tuple[str, ...]:
    """Return a line for each constant that hardly any silicone has: a slip of unit, as a rule; all are solved.

    Parameters
    ----------
    silicone : Silicone
        Of any law.
    """
    found, mu, bulk_modulus = [], silicone.shear_modulus, silicone.bulk_modulus
    if not _SOFTEST <= mu <= _STIFFEST:
        range_ = f"{_SOFTEST:g} Pa to {_STIFFEST:g} Pa"
        found.append(f"implausible: a shear modulus of {mu:.3g} Pa; silicones have {range_}: is the unit right?")
    if bulk_modulus < _LEAST_BULK * mu:
        what = f"a bulk modulus of {bulk_modulus:.3g} Pa under {_LEAST_BULK:g} times the shear modulus of {mu:.3g} Pa"
        found.append(f"implausible: {what}; silicones have some thousand times: is the unit right?")
    return tuple(found)


def _catalogued(file: str) -> dict[str, Any]:
    """Return the tables of one of the catalogue's material files."""
    text = (resources.files("sits_mech") / "catalog" / "materials" / file).read_text(encoding="utf-8")
    return tomllib.loads(text)


@cache
def metals() -> Mapping[str, Metal]:
    """Return the catalogue's metals by name."""
    return {
        name: Metal(name, float(item["conductivity"]), float(item["relative_permeability"]), str(item["source"]))
        for name, item in _catalogued("metals.toml").items()
    }


@cache
def silicones() -> Mapping[str, Silicone]:
    """Return the catalogue's silicones by name."""
    return {name: silicone_from(item, name) for name, item in _catalogued("silicones.toml").items()}


def unknown(name: object, known: Iterable[str]) -> str:
    """Return what to say of a name that is not among `known`: the list, and what was probably meant."""
    known = list(known)
    near = difflib.get_close_matches(str(name).lower(), known, n=1) if isinstance(name, str) else []
    hint = f' (did you mean "{near[0]}"?)' if near else ""
    return f"must be one of {', '.join(known)}; got {shown(name)}{hint}"
