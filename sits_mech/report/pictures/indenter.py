"""Draw what touches the target, from above and in an upright section [mm].

Of a sphere or a cylinder a cap is shown, of a punch its foot, of a pressure its area with arrows: dashed, as an outline
in projection, whether the section goes through it or not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sits_mech.quantities import Array
from sits_mech.report.pictures.cuts import Plane
from sits_mech.scene.parts.touch import Touch
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_COLOR = "#3b4a6b"
_HEIGHT = 0.25  # of a flat one's width, what is shown of it
_CAP = 0.6  # rad, half of the arc that is shown of a round one


def draw_from_above(axes: Axes, touch: Touch) -> None:
    """Draw a touch at rest from above: its area or line, or a cross at its point."""
    border = MM * (touch.border + touch.place)
    if len(border) < 3:
        axes.plot(*border.T, color=_COLOR, linewidth=1.2, marker="x", markersize=5)
    else:
        axes.plot(*np.vstack([border, border[:1]]).T, color=_COLOR, linewidth=0.9, linestyle="--")


def draw_from_the_side(axes: Axes, touch: Touch, place: Array, normal: Array, plane: Plane) -> Line2D:
    """Draw a touch at a place, x, y, z in space [m], on a face with a normal (3,); return its line for a legend."""
    along = np.array([np.cos(plane.angle), np.sin(plane.angle), 0.0])
    up = np.array([normal @ along, normal[2]])
    up /= np.linalg.norm(up)
    side, start = np.array([up[1], -up[0]]), MM * np.array([place @ along, place[2]])
    line = start + _outline(touch, plane.angle) @ np.array([side, up])
    (drawn,) = axes.plot(*line.T, color=_COLOR, linewidth=0.9, linestyle="--", zorder=5, label=f"touch: {touch.shape}")
    if touch.shape == "pressure":
        for foot in np.linspace(line[0], line[-1], 5):
            axes.annotate("", foot, foot + up * height_shown(touch), arrowprops={"arrowstyle": "->", "color": _COLOR})
    return drawn


def _outline(touch: Touch, angle: float) -> Array:
    """Return the outline of a touch seen along the section, from its place, along face and normal (n, 2) [mm]."""
    across = touch.border @ [np.cos(angle), np.sin(angle)] * MM
    low, high, top = float(across.min()), float(across.max()), height_shown(touch)
    if touch.radius is None:
        ends = np.array([[low, 0.0], [high, 0.0]])
        return ends if touch.shape == "pressure" else np.array([[low, top], *ends, [high, top]])
    if high > low + 1e-6 * MM * touch.radius:  # a cylinder from its side
        return np.array([[low, top], [low, 0.0], [high, 0.0], [high, top]])
    turn = np.linspace(-_CAP, _CAP, 61)
    return np.array(MM * touch.radius * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)]))


def height_shown(touch: Touch) -> float:
    """Return how much of a touch is shown above the face [mm]."""
    if touch.radius is not None:
        return float(MM * touch.radius * (1.0 - np.cos(_CAP)))
    return float(_HEIGHT * MM * np.ptp(touch.border[:, 0]))
