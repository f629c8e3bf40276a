"""Find the plates of a board's filled zones: rim and holes of each, clear of the coils' tracks.

A fill is written as one polygon, its holes tied to the rim by bridges: edges that go to the hole and come back over the
same two corners. Taking out each edge that has its opposite leaves the rims, the outer one and those of the holes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.boards.kicad import Board, place
from sits_mech.boards.route import Route, Run
from sits_mech.quantities import Array
from sits_mech.scene.outlines import distances, edges, inside_loops, signed_area
from sits_mech.units import SceneError

_GRID = 1e-9  # the board's own step [m]
_BLOCK = 256  # edges of a pour compared with a run at a time


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
        for other in routes:
            for run in other.runs:
                _check_clear(pour, run, f"{board.name}: net {other.net}")
    return tuple(found), tuple(notes)


def _pour(net: str, layer: str, points: Array) -> Pour:
    """Return a filled polygon as a plate."""
    rim, *holes = loops(points)
    return Pour(net, layer, rim if signed_area(rim) > 0.0 else rim[::-1], tuple(holes))


def loops(points: Array) -> list[Array]:
    """Return the rims of a polygon (k, 2), not closed, whose holes are tied in by bridges, the outer one first [m]."""
    corner = [(int(x), int(y)) for x, y in np.round(points / _GRID).tolist()]
    left: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for a, b in zip(corner, corner[1:] + corner[:1], strict=True):
        if a == b:
            continue
        if a in left.get(b, []):
            left[b].remove(a)  # the bridge's way back
        else:
            left.setdefault(a, []).append(b)
    found = []
    for start in list(left):
        while left[start]:
            found.append(_chained(left, start))
    rims = [np.array(loop) * _GRID for loop in found if len(loop) > 2]
    return sorted((_straight(rim) for rim in rims), key=lambda rim: -abs(float(signed_area(rim)))) or [points]


def _chained(left: dict[tuple[int, int], list[tuple[int, int]]], start: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the closed chain of edges from a corner, removing them from `left`."""
    loop, at = [start], left[start].pop()
    while at != start and left.get(at):
        loop.append(at)
        at = left[at].pop()
    return loop


def _straight(rim: Array) -> Array:
    """Return a rim without corners on straight stretches."""
    u, v = rim - np.roll(rim, 1, axis=0), np.roll(rim, -1, axis=0) - rim
    turn = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    kept = turn > 1e-9 * np.hypot(*u.T) * np.hypot(*v.T)
    return rim[kept] if kept.sum() > 2 else rim


def _check_clear(pour: Pour, run: Run, where: str) -> None:
    """Refuse a pour that touches the copper of a run on its layer."""
    if pour.layer != run.layer:
        return
    half, rims = run.width / 2, [pour.rim, *pour.holes]
    inside = inside_loops(rims, run.points[:1])[0]
    at = run.points[0] if inside else _met(rims, run, half)
    if at is not None:
        raise SceneError(
            f"{where}: its track must be clear of the pour of {pour.net or 'no net'} on {pour.layer}; got one that "
            f"touches it at {place(at)}"
        )


def _met(rims: Sequence[Array], run: Run, half: float) -> Array | None:
    """Return where a rim comes within `half` of a run's centre line; None where it does not."""
    a, b = edges(rims)
    low, high = run.points.min(axis=0) - half, run.points.max(axis=0) + half
    close = ((np.maximum(a, b) >= low) & (np.minimum(a, b) <= high)).all(axis=1)
    a, b, p, q = a[close], b[close], run.points[:-1], run.points[1:]
    for k in range(0, len(a), _BLOCK):
        one = distances(p[:, None], q[:, None], a[None, k : k + _BLOCK], b[None, k : k + _BLOCK])
        near = np.unravel_index(int(np.argmin(one)), one.shape)
        if one[near] < half:
            return np.asarray(p[near[0]])
    return None
