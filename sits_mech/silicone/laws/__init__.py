"""Registry of laws: a new one is a file beside this one and an entry here; all that reads laws reads this."""

from __future__ import annotations

from collections.abc import Mapping

from sits_mech.silicone.laws.gent import GENT
from sits_mech.silicone.laws.law import Constants, Law
from sits_mech.silicone.laws.mooney_rivlin import MOONEY_RIVLIN
from sits_mech.silicone.laws.neo_hookean import NEO_HOOKEAN
from sits_mech.silicone.laws.ogden import OGDEN
from sits_mech.silicone.laws.yeoh import YEOH

__all__ = ["LAWS", "Constants", "Law", "known_law"]

LAWS: Mapping[str, Law] = {law.name: law for law in (NEO_HOOKEAN, MOONEY_RIVLIN, YEOH, OGDEN, GENT)}
"""Laws by their names in material tables."""


def known_law(name: str) -> Law:
    """Return a law by its name; raise ValueError if there is none."""
    if name not in LAWS:
        raise ValueError(f'law: must be one of {", ".join(LAWS)}; got "{name}"')
    return LAWS[name]
