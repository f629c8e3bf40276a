"""Plot the field: lines of the vector potential around the plates, and the current density within one.

In the section y = 0 the lines of equal vector potential (along y) are the lines of the magnetic flux. Phasors are shown
at the instant of the coils' largest current (the real part), current densities by their size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sits_mech.magnetics.field import PlanarField
from sits_mech.quantities import Array
from sits_mech.report.pictures.style import TRACKS, add_polygons, label_bar
from sits_mech.scene.sensor import Sensor
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

COPPER, METAL = "#b87333", "#8792a6"
"""Colours of the target, and of fixed metal."""
_LEVELS, _FINENESS = 36, 240  # lines on each side of zero, points across
_MARGIN = 3e-3  # around coils and plates [m]
_GATHER = 2.0  # exponent of the levels: dense near zero, where the lines leave the coils
_SHADES = np.linspace(0.0, 0.9, 256)  # of a colour map: without the yellow that white paper swallows
_DECADES = 3.0  # of current density shown
CURRENT = 1e-3
"""Of the driven coil [A]."""
CURRENT_HEIGHT = 0.6
"""Of the picture of the current density, over its width."""


def potential_height(field: PlanarField) -> float:
    """Return how high the picture of the flux lines is with axes, title and scale, over its width."""
    (left, right), (bottom, top) = _frame(field)
    return 0.85 * (top - bottom) / (right - left) + 0.42


def draw_potential(axes: Axes, field: PlanarField, currents: Array) -> None:
    """Draw flux lines by `currents` (coils,) [A] around coils and plates, dashed where the potential is negative."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    (left, right), (bottom, top) = _frame(field)
    x = np.linspace(left, right, _FINENESS)
    z = np.linspace(bottom, top, max(2, int(_FINENESS * (top - bottom) / (right - left))))
    places = x + 1j * z[:, None]
    inside = np.abs(places - field.division.centre) < 0.98 * field.division.radius
    A = np.full(places.shape, np.nan)
    A[inside] = field.potential(places[inside], np.asarray(currents, dtype=complex)).real
    steps = np.linspace(0.0, 1.0, _LEVELS + 1)[1:] ** _GATHER * float(np.nanmax(np.abs(A)))
    shades = ScalarMappable(
        norm=Normalize(-0.4e9 * steps[-1], 0.4e9 * steps[-1]), cmap=ListedColormap(colormaps["viridis"](_SHADES))
    )
    axes.contour(
        MM * x, MM * z, 1e9 * A, 1e9 * np.concatenate([-steps[::-1], steps]), cmap=shades.cmap, norm=shades.norm,
        linewidths=0.5, linestyles=[(0.0, (8.0, 3.0))] * _LEVELS + ["-"] * _LEVELS,
    )
    bar = axes.figure.colorbar(shades, ax=axes, shrink=0.7, aspect=30, location="bottom", extend="both")
    label_bar(bar, "Re $A$ along $y$ [nWb/m]; lines dashed where negative")
    _draw_parts(axes, field)
    axes.set(xlim=(MM * left, MM * right), ylim=(MM * bottom, MM * top), xlabel="$x$ [mm]", ylabel="$z$ [mm]")
    axes.set(aspect="equal", title=f"flux lines, {written_frequency(field.omega / (2.0 * np.pi))}")
    axes.grid(False)


def draw_current(axes: Axes, field: PlanarField, currents: Array) -> None:
    """Draw the current density over the target's section with its scale; `currents` (coils,) [A]."""
    from matplotlib.colors import LogNorm

    plate = field.plates[0]
    xi = _towards_ends(plate.width, 401) - plate.width / 2
    eta = _towards_ends(plate.thickness, 121)
    places = plate.placed(xi + 1j * eta[:, None])
    J = field.current_density(0, places.ravel(), np.asarray(currents, dtype=complex)).reshape(places.shape)
    size = 1e-6 * np.abs(J)
    norm = LogNorm(size.max() * 10**-_DECADES, size.max())
    shown = axes.pcolormesh(MM * xi, 1e6 * eta, size, cmap="inferno", norm=norm, shading="gouraud", rasterized=True)
    bar = axes.figure.colorbar(shown, ax=axes, shrink=0.7, aspect=30, location="bottom", extend="min")
    label_bar(bar, r"$|J_y|$ [A/mm$^2$]")
    axes.grid(False)
    axes.set(xlabel="along the plate [mm]", ylabel="above its bottom face [µm]")
    axes.set_title(f"current density in {plate.name}, {written_frequency(field.omega / (2.0 * np.pi))}")


def part_handles(plates: bool, metal: bool, turned: bool = False) -> list[Patch]:
    """Return what a legend says of tracks, target and fixed metal; `turned` of a section that is not along x."""
    from matplotlib.patches import Patch

    ways = ("into the page", "out of the page") if turned else ("along $+y$", "along $-y$")
    found = [Patch(color=shade, label=f"track, current {way}") for shade, way in zip(TRACKS, ways, strict=True)]
    found += [Patch(facecolor=COPPER, edgecolor="0.2", label="target")] * plates
    return found + [Patch(facecolor=METAL, edgecolor="0.2", label="fixed metal")] * metal


def driven_currents(sensor: Sensor, driven: str) -> Array:
    """Return the currents of all coils, of which one is driven, shape (coils,) [A]."""
    return np.array([CURRENT if coil.name == driven else 0.0 for coil in sensor.coils])


def written_frequency(frequency: float) -> str:
    """Return a frequency for a reader."""
    unit, scale = next((u, k) for u, k in (("MHz", 1e6), ("kHz", 1e3), ("Hz", 0.0)) if frequency >= k)
    return f"{frequency / (scale or 1.0):.4g} {unit}"


def _towards_ends(length: float, count: int) -> Array:
    """Return points of [0, length], dense at both ends, just inside."""
    return length * (0.5 - 0.4999999 * np.cos(np.linspace(0.0, np.pi, count)))


def _frame(field: PlanarField) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the picture's limits along x and z [m]."""
    places = np.concatenate([*(coil.place for coil in field.coils), *(plate.corners for plate in field.plates)])
    x, z = ((float(part.min() - _MARGIN), float(part.max() + _MARGIN)) for part in (places.real, places.imag))
    return x, z


def _draw_parts(axes: Axes, field: PlanarField) -> None:
    """Draw the coils' bars, red where a positive current comes along +y, and plates."""
    corners = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
    for coil in field.coils:
        half = (corners.real * coil.width + 1j * corners.imag * coil.thickness) / 2
        boxes = coil.place[:, None] + half * np.exp(-1j * coil.tilt)[:, None]
        shades = np.where(coil.sign > 0, *TRACKS)
        add_polygons(axes, MM * np.stack([boxes.real, boxes.imag], axis=-1), facecolors=list(shades), linewidth=0)
    for plate in field.plates:
        shade = COPPER if plate is field.plates[0] else METAL
        outline = MM * np.stack([plate.corners.real, plate.corners.imag], axis=-1)
        add_polygons(axes, outline[None], facecolors=shade, edgecolors="0.2", linewidth=0.4, zorder=3)
