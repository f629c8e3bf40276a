"""Turn the words that users have for a silicone into a law and its constants.

    E (young_modulus), nu (poisson_ratio)   mu = E/(2 (1 + nu)),  K = E/(3 (1 - 2 nu));  nu = 0.4995 without one
    E, K                                    mu = 3 K E/(9 K - E)
    mu, K                                   shear_modulus, bulk_modulus
    D1                                      K = 2/D1, of Abaqus' U = ... + (J - 1)^2/D1, with any law
    shore_a, shore_00                       a hardness S by the relation of its durometer, times 0.43 (see below)

Without a ``law`` it is neo-Hooke's. Of a hardness E is, with the spring force F [N] and the depth
h = 2.5 mm (1 - S/100) of ASTM D2240,

    A      E = 0.0981 MPa (56 + 7.623 S)/(0.1375 (254 - 2.54 S))        A. N. Gent, Rubber Chem. Technol. 31 (1958) 896
    00     E = 9/16 F R^(-1/2) h^(-3/2),  F = 0.203 + 0.00908 S       H. Hertz (1881), a ball of R = 1.19 mm, nu = 1/2

and silicones in tension have less: eight of 00-10 to A 44 (L. Marechal and others, Soft Robotics 2020), fitted by
neo-Hooke up to 60 % of strain, have 0.26 to 0.55 times that, 0.43 in the mean of logarithms. That factor is taken, and
its range is the ``spread`` of the silicone, 0.55/0.26 - 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sits_mech.units import SceneError, quantity, shown

_ALIASES = {"E": "young_modulus", "nu": "poisson_ratio", "K": "bulk_modulus", "G": "shear_modulus"}
_WORD_OF = {name: word for word, name in _ALIASES.items()}
_NU = 0.4995  # K/mu = 1000
_TENSION, _SPREAD = 0.43, 1.1  # of eight silicones
_HARDNESS = {"shore_a": (5.0, 80.0), "shore_00": (5.0, 80.0)}  # in which durometers are read
_STIFFNESS, _BULK = ("shear_modulus", "young_modulus", *_HARDNESS), ("bulk_modulus", "poisson_ratio", "D1")
_OWN = ("young_modulus", "poisson_ratio", "D1", *_HARDNESS)
WORDS = ("E", "nu", "K", "mu", *_OWN)
"""Words for constants beside those of the laws."""


def modulus_of_hardness(scale: str, hardness: float) -> float:
    """Return Young's modulus in tension by a hardness, "shore_a" or "shore_00" [Pa]; within a factor of 0.6 to 1.3."""
    if scale == "shore_a":
        E = 0.0981e6 * (56.0 + 7.62336 * hardness) / (0.137505 * (254.0 - 2.54 * hardness))
    else:
        F, h = 0.203 + 0.00908 * hardness, 2.5e-3 * (1.0 - hardness / 100.0)
        E = 9.0 / 16.0 * F / (1.19e-3**0.5 * h**1.5)
    return _TENSION * E


def in_constants(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a material table by constants alone; raise SceneError where its words contradict each other."""
    plain = table.get("law", "neo-hookean") == "neo-hookean"
    found = _named(table, _ALIASES | ({"mu": "shear_modulus"} if plain else {}))
    own = [key for key in found if key in _OWN]
    if plain and (own or "shear_modulus" in found):
        found.setdefault("law", "neo-hookean")
    if not own:
        return found
    _check_words(found, plain)
    return _stated(found, plain)


def _check_words(found: Mapping[str, Any], plain: bool) -> None:
    """Refuse words that contradict each other, or are no words of the law."""
    ways, ends = ([key for key in found if key in some] for some in (_STIFFNESS, _BULK))
    if plain and len(ways) != 1:
        raise SceneError(f"a silicone must have one of E, mu, shore_a, shore_00; got {', '.join(ways) or 'none'}")
    if len(ends) > 1:
        raise SceneError(f"a silicone must have one of K, nu, D1; got {', '.join(ends)}")
    foreign = [key for key in (*ways, *ends) if key not in ("shear_modulus", "bulk_modulus", "D1")]
    if not plain and foreign:
        word = _WORD_OF.get(foreign[0], foreign[0])
        raise SceneError(f"{word} must be of neo-hookean; other laws take K or D1; got law {shown(found['law'])}")


def _named(table: Mapping[str, Any], aliases: Mapping[str, str]) -> dict[str, Any]:
    """Return a table by the names that words stand for, each once."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = aliases.get(key, key)
        if name in found:
            both = ", ".join(word for word in table if aliases.get(word, word) == name)
            raise SceneError(f"{name} must be given once; got {both}")
        found[name] = value
    return found


def _stated(found: dict[str, Any], plain: bool) -> dict[str, Any]:
    """Return a table with the law's constants in place of words; each stands once."""
    given = {key: found.pop(key) for key in _OWN if key in found}
    nu = quantity(given.get("poisson_ratio", _NU), "", "nu")
    if not 0.0 < nu < 0.5:
        raise SceneError(f"nu must lie between 0 and 0.5, such as 0.4995 (K of 1000 shear moduli); got {nu:g}")
    for scale in _HARDNESS.keys() & given.keys():
        given["young_modulus"], words = _of_hardness(scale, given[scale])
        found = {"spread": _SPREAD, "source": words} | found
    if "D1" in given:
        found["bulk_modulus"] = 2.0 / _positive(given["D1"], "D1", "0.1 1/MPa")
    if "young_modulus" in given:
        E, K = _positive(given["young_modulus"], "E", "60 kPa"), quantity(found.get("bulk_modulus", 0.0), "Pa", "K")
        if K and not 9.0 * K > E:
            raise SceneError(f"K must be above E/9; got {K:g} Pa with E of {E:g} Pa")
        found["shear_modulus"] = 3.0 * K * E / (9.0 * K - E) if K else E / (2.0 * (1.0 + nu))
    if plain:
        ratio = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
        found.setdefault("bulk_modulus", ratio * _positive(found["shear_modulus"], "mu", "20 kPa"))
    return found


def _of_hardness(scale: str, value: Any) -> tuple[float, str]:
    """Return Young's modulus of a hardness [Pa], and its source in words; refuse what a durometer does not read."""
    hardness, (low, high) = quantity(value, "", scale), _HARDNESS[scale]
    if not low <= hardness <= high:
        raise SceneError(f"{scale} must lie between {low:g} and {high:g}; got {hardness:g}")
    words = f"Shore {scale[6:].upper()} {hardness:g}, by its durometer and tension tests of 8 silicones"
    return modulus_of_hardness(scale, hardness), words


def _positive(value: Any, key: str, such: str) -> float:
    """Return D1 [1/Pa] or a modulus [Pa], or refuse it."""
    found = quantity(value, "1/Pa" if key == "D1" else "Pa", key)
    if not found > 0.0:
        raise SceneError(f'{key} must be above zero, such as "{such}"; got {shown(value)}')
    return found
