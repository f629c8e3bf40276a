"""Load the metals and silicones of the catalogue; each constant has its source."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from sits_mech.inputs import unknown
from sits_mech.silicone.material import Silicone, silicone_from
from sits_mech.units import SceneError, si_value


@dataclass(frozen=True)
class Metal:
    """A conductor; coefficients are None where not known."""

    name: str  # in the catalogue, or "" with numbers of the scene
    conductivity: float  # [S/m]
    relative_permeability: float = 1.0  # constant and isotropic [-]
    source: str = "the scene"
    loss_tangent: float = 0.0  # of mu_r (1 - j tan delta) [-]
    temperature_coefficient: float | None = None  # of resistivity, rho = rho_20 (1 + a (T - 20 degC)) [1/K]
    permeability_coefficient: float | None = None  # of relative permeability, alike [1/K]
    expansion: float | None = None  # of lengths [1/K]
    temperature_range: tuple[float, float] = (0.0, math.inf)  # in which these hold [K]
    youngs_modulus: float | None = None  # [Pa]
    poissons_ratio: float | None = None

    @property
    def susceptibility(self) -> complex:
        """The complex susceptibility ``mu_r (1 - j tan delta) - 1``."""
        return self.relative_permeability * (1.0 - 1j * self.loss_tangent) - 1.0


def _catalogued(file: str) -> dict[str, Any]:
    """Return the tables of one of the catalogue's material files."""
    text = (resources.files("sits_mech") / "scene" / "catalog" / "materials" / file).read_text(encoding="utf-8")
    return tomllib.loads(text)


@cache
def metals() -> Mapping[str, Metal]:
    """Return the catalogue's metals by name."""
    return {name: _metal(name, item) for name, item in _catalogued("metals.toml").items()}


def _metal(name: str, item: Mapping[str, Any]) -> Metal:
    """Return a metal of the catalogue; what its table does not give is unknown."""
    known = "temperature_coefficient", "expansion", "youngs_modulus", "poissons_ratio"
    own = {key: float(item[key]) for key in known if key in item}
    low, high = (si_value(end, "K") for end in item.get("temperature_range", (0.0, 1e4)))
    steady = 0.0 if item["relative_permeability"] == 1.0 else None
    return Metal(
        name, float(item["conductivity"]), float(item["relative_permeability"]), str(item["source"]),
        permeability_coefficient=steady, temperature_range=(low, high), **own,
    )


@cache
def silicones() -> Mapping[str, Silicone]:
    """Return the catalogue's silicones by name."""
    return {name: silicone_from(item, name) for name, item in _catalogued("silicones.toml").items()}


def check_model(kind: str, asked: str, known: Sequence[str]) -> None:
    """Refuse a model of a kind that is not among `known`."""
    if asked not in known:
        raise SceneError(f"model ({kind}) {unknown(asked, known)}")
