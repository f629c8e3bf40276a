"""Find the plates of a board's filled zones: rim and holes of each, clear of the coils' tracks.

A fill is written as one polygon, its holes tied to the rim by bridges: edges that go to the hole and come back over the
same two corners. Taking out each edge that has its opposite leaves the rims, the outer one and those of the holes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sits_mech.boards.kicad import Board, place
from sits_mech.boards.route import Route, Run
from sits_mech.quantities import Array
from sits_mech.scene.outlines import polygon, signed_area
from sits_mech.units import SceneError

_GRID = 1e-9  # the board's own step [m]


@dataclass(frozen=True)
class Pour:
    """A plate of copper."""

    net: str
    layer: str
    rim: Array  # (n, 2) counter-clockwise [m]
    holes: tuple[Array, ...]  # [m]

    @property
    def area(self) -> float:
        """Return the area of the copper [m^2]."""
        return float(signed_area(self.rim)) - sum(abs(float(signed_area(hole))) for hole in self.holes)


def pours(board: Board, routes: Sequence[Route]) -> tuple[tuple[Pour, ...], tuple[str, ...]]:
    """Return the filled copper of nets other than the coils', and omissions; raise SceneError if it touches a coil."""
    nets = {found.net for found in routes}
    found, notes = [], []
    for zone in board.zones:
        title, on = f"zone {zone.net or 'without net'}", ", ".join(zone.layers)
        if zone.net in nets:
            notes.append(f"{title} on {on}: left out, it is of the coil's own net")
        elif not zone.fills:
            notes.append(f"{title} on {on}: left out, it is not filled: fill all zones in KiCad and save")
        else:
            found += [_pour(zone.net, layer, points) for layer, points in zone.fills]
    for pour in found:
        copper = polygon([pour.rim, *pour.holes])
        for other in routes:
            for run in other.runs:
                _check_clear(pour, copper, run, f"{board.name}: net {other.net}")
    return tuple(found), tuple(notes)


def _pour(net: str, layer: str, points: Array) -> Pour:
    """Return a filled polygon as a plate."""
    rim, *holes = loops(points)
    return Pour(net, layer, rim if signed_area(rim) > 0.0 else rim[::-1], tuple(holes))


def loops(points: Array) -> list[Array]:
    """Return the rims of a polygon (k, 2) whose holes are tied in by bridges, the outer one first [m]."""
    import shapely

    whole = shapely.make_valid(shapely.Polygon(np.round(points / _GRID)), method="structure")
    if not whole.area > 0.0:
        return [points]
    largest = max(shapely.get_parts(whole), key=lambda piece: piece.area).simplify(0.0)
    return [shapely.get_coordinates(ring)[:-1] * _GRID for ring in (largest.exterior, *largest.interiors)]


def _check_clear(pour: Pour, copper: Any, run: Run, where: str) -> None:
    """Refuse a pour, a polygon of shapely beside it, that touches the copper of a run on its layer."""
    if pour.layer != run.layer:
        return
    import shapely

    pieces = shapely.linestrings(np.stack([run.points[:-1], run.points[1:]], axis=1))
    near = np.flatnonzero(shapely.dwithin(copper, pieces, run.width / 2))
    at = run.points[near[0]] if len(near) else None
    if at is not None:
        raise SceneError(
            f"{where}: its track must be clear of the pour of {pour.net or 'no net'} on {pour.layer}; got one that "
            f"touches it at {place(at)}"
        )
