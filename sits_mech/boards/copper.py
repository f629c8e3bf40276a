"""What copper a board has: tracks, vias and pads, zones, its layers. Lengths in metres, y up, seen from the top."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from sits_mech.boards.stackup import METRES, CopperLayer
from sits_mech.quantities import Array

GRID = 1e-9  # the step of a board's places [m]


@dataclass(frozen=True)
class Track:
    """A straight track from the first to the last of two points, or an arc through three; drawn copper as well."""

    layer: str
    points: Array  # (2, 2) or (3, 2) x, y [m]
    width: float  # [m]
    net: str  # empty for copper without one
    footprint: int = -1  # whose copper it is; -1 for a track of the board


@dataclass(frozen=True)
class Hole:
    """A via or a pad: what joins copper that ends in it."""

    name: str  # as "J1.2"; empty for a via and a pad without number, which are passed through
    place: Array  # (2,) its middle [m]
    size: tuple[float, float]  # along its own axes [m]
    angle: float  # of those axes, counter-clockwise [rad]
    layers: tuple[str, ...]  # copper layers that it is on
    net: str
    footprint: int = -1  # whose pad it is; -1 for a via

    def holds(self, points: Array) -> Array:
        """Tell which points (n, 2) lie on the hole's copper, a round one where both sizes are the same via's."""
        x, y = (points - self.place).T
        c, s = math.cos(self.angle), math.sin(self.angle)
        a, b = np.abs(c * x + s * y), np.abs(c * y - s * x)
        if self.footprint < 0:
            return np.asarray(np.hypot(a, b) <= self.size[0] / 2)
        return np.asarray((a <= self.size[0] / 2) & (b <= self.size[1] / 2))


@dataclass(frozen=True)
class Zone:
    """A copper zone."""

    net: str
    layers: tuple[str, ...]  # where it may be filled
    fills: tuple[tuple[str, Array], ...]  # layer and polygon (k, 2) [m], holes tied to the rim by bridges of no width
    pen: float = 0.0  # width of the line round them, copper as well [m]
    drawn: bool = False  # a drawn polygon


@dataclass(frozen=True, eq=False)
class Board:
    """A board: its nets and copper, the layers from the top down."""

    name: str  # of its file
    stack: Mapping[str, CopperLayer]
    nets: tuple[str, ...]
    tracks: tuple[Track, ...]
    holes: tuple[Hole, ...]
    zones: tuple[Zone, ...]
    notes: tuple[str, ...]  # what was assumed
    footprints: tuple[str, ...] = ()  # references, by the numbers that tracks and pads have; empty without one

    def references(self, tracks: Iterable[Track]) -> list[str]:
        """Return the footprints that some tracks are of."""
        return sorted({self.footprints[track.footprint] for track in tracks if track.footprint >= 0} - {""})


def board_point(point: Iterable[float]) -> str:
    """Return a point as KiCad shows it: millimetres, y down."""
    x, y = point
    return f"({x / METRES:.4f}, {-y / METRES + 0.0:.4f}) mm"
