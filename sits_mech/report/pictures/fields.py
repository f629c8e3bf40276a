"""What does the field look like? Lines of the vector potential around the plates, and the current density within one.

In the section y = 0 the lines of equal vector potential (along y) are the lines of the magnetic flux. Phasors are shown
at the instant of the coils' largest current (the real part), current densities by their size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sits_mech.magnetics.field import PlanarField
from sits_mech.quantities import Array
from sits_mech.report.pictures.curves import add_polygons, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3
_GATHER = 2.0  # exponent of the levels: dense near zero, where the lines leave the coils
_DECADES = 3.0  # of current density shown


def potential_view(
    field: PlanarField, currents: Array, *, levels: int = 36, fineness: int = 240, margin: float = 3e-3
) -> Figure:
    """Return a picture of the flux lines around coils and plates.

    Parameters
    ----------
    field : PlanarField
        From `PlanarFem.field`.
    currents : ndarray, shape (coils,)
        Current of each coil [A].
    levels : int
        Number of lines on each side of zero, denser near zero.
    fineness : int
        Points along the picture's width.
    margin : float
        Shown around coils and plates [m].
    """
    (left, right), (bottom, top) = _frame(field, margin)
    x = np.linspace(left, right, fineness)
    z = np.linspace(bottom, top, max(2, int(fineness * (top - bottom) / (right - left))))
    places = x + 1j * z[:, None]
    inside = np.abs(places - field.division.centre) < 0.98 * field.division.radius
    A = np.full(places.shape, np.nan)
    A[inside] = field.potential(places[inside], np.asarray(currents, dtype=complex)).real
    steps = np.linspace(0.0, 1.0, levels + 1)[1:] ** _GATHER * float(np.nanmax(np.abs(A)))
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    with new_figure(0.9 * (top - bottom) / (right - left) + 0.25) as (figure, (axes,)):
        lines = axes.contour(
            _MM * x, _MM * z, 1e9 * A, 1e9 * np.concatenate([-steps[::-1], steps]), cmap="turbo", linewidths=0.5,
            linestyles="solid",
        )  # fmt: skip
        shades = ScalarMappable(norm=Normalize(-0.4e9 * steps[-1], 0.4e9 * steps[-1]), cmap="turbo")
        lines.set_norm(shades.norm)
        bar = figure.colorbar(shades, ax=axes, shrink=0.7, aspect=30, location="bottom", extend="both")
        bar.set_label("Re $A$ along $y$ [nWb/m]", fontsize=7)
        bar.ax.tick_params(labelsize=6)
        _draw_parts(axes, field)
        axes.set_xlim(_MM * left, _MM * right)
        axes.set_ylim(_MM * bottom, _MM * top)
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_xlabel("$x$ [mm]")
        axes.set_ylabel("$z$ [mm]")
    return figure


def current_view(field: PlanarField, currents: Array, *, number: int = 0) -> Figure:
    """Return a picture of the current density over one plate's section, in the plate's own axes.

    Parameters
    ----------
    field : PlanarField
    currents : ndarray, shape (coils,)
        Current of each coil [A].
    number : int
        Which of the field's plates; the target is 0.
    """
    plate = field.plates[number]
    xi = _towards_ends(plate.width, 401) - plate.width / 2
    eta = _towards_ends(plate.thickness, 121)
    places = plate.placed(xi + 1j * eta[:, None])
    J = field.current_density(number, places.ravel(), np.asarray(currents, dtype=complex)).reshape(places.shape)
    from matplotlib.colors import LogNorm

    size = 1e-6 * np.abs(J)
    with new_figure(0.55) as (figure, (axes,)):
        norm = LogNorm(size.max() * 10**-_DECADES, size.max())
        shown = axes.pcolormesh(_MM * xi, 1e6 * eta, size, cmap="inferno", norm=norm, shading="gouraud")
        bar = figure.colorbar(shown, ax=axes, aspect=25, extend="min")
        bar.set_label(r"$|J_y|$ [A/mm$^2$]", fontsize=7)
        bar.ax.tick_params(labelsize=6)
        axes.grid(False)
        axes.set_xlabel(r"along the plate [mm]")
        axes.set_ylabel(r"above its bottom face [µm]")
        axes.set_title(f"{plate.name}, {field.omega / (2 * np.pi):.3g} Hz", fontsize=8)
    return figure


def _towards_ends(length: float, count: int) -> Array:
    """Points of [0, length], dense at both ends, just inside."""
    return np.asarray(length * (0.5 - 0.4999999 * np.cos(np.linspace(0.0, np.pi, count))))


def _frame(field: PlanarField, margin: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """What the picture shows along x and z [m]."""
    places = np.concatenate([*(coil.place for coil in field.coils), *(plate.corners for plate in field.plates)])
    across = (float(places.real.min() - margin), float(places.real.max() + margin))
    return across, (float(places.imag.min() - margin), float(places.imag.max() + margin))


def _draw_parts(axes: Axes, field: PlanarField) -> None:
    """Coils' bars, red where a positive current comes along +y, and plates."""
    corners = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
    for coil in field.coils:
        half = (corners.real * coil.width + 1j * corners.imag * coil.thickness) / 2
        boxes = coil.place[:, None] + half * np.exp(-1j * coil.tilt)[:, None]
        shades = np.where(coil.sign > 0, "tab:red", "tab:blue")
        add_polygons(axes, _MM * np.stack([boxes.real, boxes.imag], axis=-1), facecolors=list(shades), linewidth=0)
    for plate in field.plates:
        shade = "#b87333" if plate.relative_permeability == 1.0 else "0.45"
        outline = _MM * np.stack([plate.corners.real, plate.corners.imag], axis=-1)
        add_polygons(axes, outline[None], facecolors=shade, edgecolors="0.2", linewidth=0.4, zorder=3)
