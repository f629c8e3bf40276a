"""Find the heights of a board's copper layers and what is between, from its stack-up or evenly over its thickness.

z is counted here from the top face of the uppermost copper layer, down: z <= 0. Dielectrics of thicknesses t_i and
relative permittivities eps_i in series are one of sum t_i / sum (t_i / eps_i).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from sits_mech.boards.expressions import Node, child, children, copper_layers, numbers, texts
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

_COPPER = 35e-6  # thickness where the file gives none [m]
_THICKNESS = 1.6e-3  # of a board whose file gives none [m]
METRES = 1e-3  # metres in a millimetre


@dataclass(frozen=True)
class CopperLayer:
    """A copper layer."""

    z: float  # of its middle [m]
    thickness: float  # [m]
    above: float = math.nan  # sum of t over all dielectrics above it [m]; NaN where a permittivity is not known
    gap: float = math.nan  # sum of t / eps over them [m]; NaN likewise


def permittivity(layers: Iterable[CopperLayer]) -> float | None:
    """Return the relative permittivity between the uppermost and the lowest of some layers; None where unknown."""
    ordered = sorted(layers, key=lambda layer: layer.z)
    lower, upper = ordered[0], ordered[-1]
    gap = lower.gap - upper.gap
    return (lower.above - upper.above) / gap if gap > 0.0 else None


def stack(tree: Node, where: str) -> tuple[dict[str, CopperLayer], tuple[str, ...]]:
    """Return the copper layers from the top down, and assumptions; raise SceneError without layers or thickness."""
    names = tuple(copper_layers(tree).values())
    if not names:
        raise SceneError(f"{where}: must have copper layers, such as F.Cu; got none")
    listed = child(child(tree, "setup") or [], "stackup")
    if listed is not None:
        found = _listed(listed, where)
        if all(name in found for name in names):
            return {name: found[name] for name in names}, ()
    return _even(tree, names, where)


def _listed(stackup: Node, where: str) -> dict[str, CopperLayer]:
    """Return the layers of a stack-up; sublayers of a dielectric are in its one entry."""
    found = {}
    depth, above, gap = 0.0, 0.0, 0.0
    for node in children(stackup, "layer"):
        name, kind = str(node[1]), "".join(texts(node, "type"))
        sheets = _values(node, "thickness")
        thickness = METRES * sum(sheets)
        if kind == "copper" and not thickness > 0.0:
            raise SceneError(f"{where}: stackup: {name} must have a thickness above 0 mm; got {sum(sheets):g} mm")
        if kind == "copper":
            found[name] = CopperLayer(-depth - thickness / 2, thickness, above, gap)
        elif found:
            relative = _values(node, "epsilon_r")
            known = len(relative) == len(sheets) and min(relative, default=0.0) > 0.0
            above += thickness
            gap += METRES * sum(t / e for t, e in zip(sheets, relative, strict=True)) if known else math.nan
        depth += thickness if found else 0.0
    return found


def _values(node: Node, key: str) -> list[float]:
    """Return the first number behind each of a node's entries of one key: one for each sheet of a layer."""
    return [float(item[1]) for item in children(node, key) if isinstance(item[1], float)]


def _even(tree: Node, names: tuple[str, ...], where: str) -> tuple[dict[str, CopperLayer], tuple[str, ...]]:
    """Return layers of usual copper, evenly over the board's thickness."""
    general, given = child(tree, "general") or [], _THICKNESS
    if child(general, "thickness") is not None:
        given = METRES * numbers(general, "thickness", 1, f"{where}: general")[0]
    if not given > len(names) * _COPPER:
        raise SceneError(f"{where}: thickness must be above {len(names)} times 35 um; got {mm(given)}")
    pitch = (given - _COPPER) / max(len(names) - 1, 1)
    layers = {name: CopperLayer(-_COPPER / 2 - k * pitch, _COPPER) for k, name in enumerate(names)}
    apart = f", {pitch / METRES:.4g} mm apart" if len(names) > 1 else ""
    thick = f"thickness {given / METRES:g} mm"
    note = f"{where}: no whole stack-up: copper of 35 um assumed on {', '.join(names)}{apart} ({thick})"
    return layers, (note,)
