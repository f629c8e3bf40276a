"""Which pads, silicones and histories of load are the references of loops? Five pads, three paths, as scenes too.

Lengths in mm, peak loads in N (N/m of a layer in plane strain) on a copper target 0.2 mm thick, at its upper face.
Targets are narrower than their pads, and loads such that no free face folds: contact is off on both sides.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from common.reference_cases import Case

from sits_mech.quantities import Array


class LoadPath(NamedTuple):
    """Shares of the peak loads, linear between corners.

    Attributes
    ----------
    time : tuple of float, length n
        Corners [s].
    F_x, F_z : tuple of float, length n
        Shares of the peaks [-].
    steps : tuple of int, length n - 1
        Recorded times from each corner to the next.
    holds : tuple of bool, length n - 1
        Whether the steps grow after the corner, as what creeps there slows down.
    """

    time: tuple[float, ...]
    F_x: tuple[float, ...]
    F_z: tuple[float, ...]
    steps: tuple[int, ...]
    holds: tuple[bool, ...]

    def times(self, parts: int = 1) -> Array:
        """Return the recorded times, each step in equal parts [s]."""
        found = [0.0]
        for a, b, count, hold in zip(self.time[:-1], self.time[1:], self.steps, self.holds, strict=True):
            share = np.linspace(0.0, 1.0, count + 1)[1:]
            found += (a + (b - a) * (share**2 if hold else share)).tolist()
        at = np.arange(parts * (len(found) - 1) + 1) / parts
        return np.interp(at, np.arange(len(found)), found)

    def shares(self, times: Array) -> Array:
        """Return the shares of F_x and F_z at times [s], shape (n, 2)."""
        return np.stack([np.interp(times, self.time, values) for values in (self.F_x, self.F_z)], axis=1)


PATHS: Mapping[str, LoadPath] = {
    "two triangles": LoadPath(
        (0.0, 1.0, 2.0, 3.0, 4.0), (0.0,) * 5, (0.0, 1.0, 0.0, 1.0, 0.0), (10,) * 4, (False,) * 4
    ),
    "step, hold, off, hold": LoadPath(
        (0.0, 0.05, 3.0, 3.05, 6.0), (0.0,) * 5, (0.0, 1.0, 1.0, 0.0, 0.0), (3, 14, 3, 14),
        (False, True, False, True),
    ),
    "pressed, sheared, half let go": LoadPath(
        (0.0, 0.5, 1.0, 1.5, 2.2, 3.0), (0.0, 0.0, 0.0, 1.0, 1.0, 1.0), (0.0, 1.0, 1.0, 1.0, 0.4, 0.4),
        (8, 6, 8, 10, 6), (False, True, False, False, True),
    ),
}
TWO = ((0.2, 0.5), (0.1, 5.0))
THREE = ((0.15, 0.2), (0.1, 1.0), (0.05, 10.0))
PADS: tuple[Case, ...] = (
    Case("layer 20 x 2, neo-Hooke, two branches", "plane", (20.0, 1e3), (15.0, 1e3), 2.0, (120.0, 1400.0, 0.0),
         height=0.2, prony=TWO),
    Case("layer 10 x 5, Yeoh, softened", "plane", (10.0, 1e3), (6.0, 1e3), 5.0, (14.0, 160.0, 0.0), "yeoh",
         height=0.2, mullins={"r": 2.5}),
    Case("layer 8 x 4, Ogden, three branches, softened", "plane", (8.0, 1e3), (5.0, 1e3), 4.0, (14.0, 130.0, 0.0),
         "ogden 4", height=0.2, prony=THREE, mullins={"r": 2.0, "m": 0.01, "beta": 0.8}),
    Case("disc 6 on 10 x 4, neo-Hooke, two branches", "round", (10.0, 10.0), (6.0, 6.0), 4.0, (0.0, 0.6, 0.0),
         height=0.2, prony=TWO),
    Case("5 x 5 on 8 x 8 x 4, Yeoh, a branch", "box", (8.0, 8.0), (5.0, 5.0), 4.0, (0.08, 0.5, 0.0), "yeoh",
         height=0.2, prony=((0.25, 1.0),)),
)


def wrenches(pad: Case, path: LoadPath, times: Array) -> Array:
    """Return F_x, F_z and M at times [s], shape (n, 3) [N, N mm]."""
    shares = path.shares(times)
    return np.stack([pad.load[0] * shares[:, 0], pad.load[1] * shares[:, 1], np.zeros(len(times))], axis=1)


def takes(pad: Case, path: LoadPath) -> bool:
    """Whether a pad is loaded along a path: what is solved round its axis is not sheared."""
    return pad.kind != "round" or not any(path.F_x)
