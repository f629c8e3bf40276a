"""Draw plan and section of a scene with dimensions in millimetres, before anything is solved.

The plan shows all parts from above, through each other. The section is that of y = 0 where this plane cuts a coil, else
that through the coil next to it; both are drawn to one scale, the target at rest. The sizes are those of the scene as
it was read, so that a metre written for a millimetre shows. All numbers here are in millimetres.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sits_mech.geometry.outline import from_above, pad_outlines, target_outline
from sits_mech.geometry.tracks import coil_lines
from sits_mech.geometry.windings import kinds_of
from sits_mech.quantities import Array
from sits_mech.report.pictures.cuts import Plane, boxes, chords, coil_cut, conductor_cut, names_cut
from sits_mech.report.pictures.indenter import draw_from_above, draw_from_the_side, height_shown
from sits_mech.report.pictures.style import COLUMN, TRACKS, add_polygons, new_figure
from sits_mech.scene.parts.outlines import inside_loops
from sits_mech.scene.sensor import Coil, Conductor, Cover, Elastomer, Sensor, Target
from sits_mech.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW, _LABEL = 0.075, 0.05  # between lines of dimensions, and between labels, over the drawing's size
_MOST = 9  # distances of neighbouring coils that are written

Span = tuple[float, float, str]  # from where to where, and what stands at it


class DrawnPlate(NamedTuple):
    """A flat part at rest [mm]: rim and holes (k, 2), or rims; bottom, top (NaN where no pad is), sizes, colour."""

    name: str
    loops: tuple[Array, ...]
    bottom: float
    top: float
    sizes: str
    shade: str
    fixed: Conductor | None = None


class Drawing(NamedTuple):
    """What is drawn [mm]: parts from below, where the section is, least and greatest x, y, z, the largest size."""

    sensor: Sensor
    plates: tuple[DrawnPlate, ...]
    plane: Plane
    low: Array
    high: Array
    size: float


def scene_drawing(sensor: Sensor) -> Figure:
    """Return plan and section of a scene with its dimensions [mm]; SceneError when matplotlib is missing."""
    it = _drawing(sensor)
    rows = [_rows(it, axis) for axis in (0, 1)]
    left, right = it.low[0] - _ROW * it.size * (len(rows[1]) + 0.5), it.high[0] + 0.3 * it.size
    bottom, top = it.low[1] - _ROW * it.size * (len(rows[0]) + 0.5), it.high[1] + 0.5 * _ROW * it.size
    half = max(it.high[2] - it.low[2], _LABEL * it.size * len(_levels(it))) / 2 + 0.06 * it.size
    missing = max(0.0, 1.6 * half - (right - left)) / 2  # of a sheet's width, for a scene taller than wide
    left, right = left - missing, right + missing
    lines, width = _list_of_parts(it), 1.6 * COLUMN
    shares = (float((top - bottom) / (right - left)), float(2.0 * half / (right - left)))
    height = sum(shares) + 0.07 + 0.028 * len(lines)
    with new_figure(height, rows=2, width=width, shares=shares) as (figure, (plan, section)):
        _draw_plan(plan, it, rows)
        _draw_section(section, it)
        plan.set(xlim=(left, right), ylim=(bottom, top))
        middle = (it.low[2] + it.high[2]) / 2
        section.set(xlim=(left, right), ylim=(middle - half, middle + half))
        for axes in (plan, section):
            axes.set_aspect("equal")
            axes.set_axis_off()
        figure.suptitle(fill(f"{sensor.name}: sizes in mm, nothing solved", 64), fontsize=9)
        figure.supxlabel("\n".join(lines), fontsize=6.5, ha="left", x=0.03)
    return figure


def _drawing(sensor: Sensor) -> Drawing:
    """Return the parts of a scene and how far they reach."""
    plates = _plates(sensor)
    middle = min((coil.centre[1] for coil in sensor.coils), key=lambda y: (abs(y), y))
    plane = Plane() if names_cut(sensor)[0] else Plane(0.0, middle)
    corners = np.vstack([loop for plate in plates for loop in plate.loops] + [_disc(coil) for coil in sensor.coils])
    tracks = [0.0, *(-MM * coil.height for coil in sensor.coils)]
    if sensor.substrate_radius is not None:
        tracks.append(float(np.min(_tracks(sensor, plane)[0][..., 1], initial=0.0)))
    heights = [*tracks, *(z for plate in plates for z in (plate.bottom, plate.top))]
    heights.append(np.nanmax(heights) + (0.0 if sensor.touch is None else height_shown(sensor.touch)))
    low, high = np.r_[corners.min(axis=0), np.nanmin(heights)], np.r_[corners.max(axis=0), np.nanmax(heights)]
    return Drawing(sensor, tuple(plates), plane, low, high, float(np.max(high - low)))


def _plates(sensor: Sensor) -> list[DrawnPlate]:
    """Return fixed plates, pad and target at rest."""
    found, rest, where = [], np.nan, "; no pad: its height is that of a pose"
    for part in sensor.conductors:
        own, (low, high) = tuple(MM * loop for loop in from_above(part)), (MM * z for z in part.span)
        words = f"{_sizes(part)}, middle at z = {MM * part.centre[2]:.4g}{_turned(part)}"
        found.append(DrawnPlate(part.name, own, low, high, words, "#8792a6", part))
    layer, target = sensor.elastomer, sensor.target
    if layer is not None:
        bottom, rest, where = MM * layer.standoff, MM * (layer.standoff + layer.thickness), ""
        rims = tuple(MM * own.rim for own in pad_outlines(layer, target))
        sizes = _sizes(layer) if layer.kind != "pillars" else f"{len(rims)} pillars {_sizes(layer)}"
        found.append(DrawnPlate("pad", rims, bottom, rest, sizes, "#efcf9f"))
    if target is not None:
        found += _cover(sensor, target, rest)
        own = tuple(MM * np.array(loop) for loop in target_outline(target).loops)
        found.append(DrawnPlate("target", own, rest, rest + MM * target.thickness, _sizes(target) + where, "#b87333"))
    return found


def _cover(sensor: Sensor, target: Target, rest: float) -> list[DrawnPlate]:
    """Return the cover on a pad whose upper face is at a height [mm]; none without one."""
    cover, layer = sensor.cover, sensor.elastomer
    if cover is None or layer is None:
        return []
    rim, size = (MM * np.array(cover.rim(target, layer)),), cover.extent(target, layer)
    words = f"{_by(size[: 1 if target.is_round else 2])}, {MM * cover.thickness:.4g} over the target"
    top = rest + MM * (target.thickness + cover.thickness)
    return [DrawnPlate("cover", rim, rest, top, f"{'⌀ ' * target.is_round}{words}", "#d9c9a8")]


def _disc(coil: Coil) -> Array:
    """Return the corners of the box around a coil [mm]."""
    return MM * (np.array(coil.centre) + np.array(coil.extent) / 2 * [[-1.0, -1.0], [1.0, 1.0]])


def _sizes(part: Target | Elastomer | Conductor) -> str:
    """Return the sizes of a part in words."""
    if isinstance(part, Elastomer):
        across = _by(part.extent) if part.diameter is None else f"⌀ {MM * part.diameter:.4g}"
        across += "" if part.pitch is None else f" every {MM * part.pitch:.4g}"
    elif part.points is not None:
        count = len(part.holes)
        across = f"{_by(np.ptp(np.array(part.points), axis=0).tolist())}, outline of {len(part.points)} corners"
        across += f", {count} hole{'s' * (count > 1)}" if count else ""
    else:
        across = _by(part.extent) if part.diameter is None else f"⌀ {MM * part.diameter:.4g}"
        across += f" / {MM * part.hole:.4g}" if part.hole else ""
    return f"{across}, {MM * part.thickness:.4g} thick"


def _turned(part: Conductor) -> str:
    """Return in words by what a fixed plate is turned."""
    angles = {key: np.degrees(getattr(part, key)) for key in ("alpha", "alpha_x", "alpha_z")}
    return "".join(f", {key} {angle:.4g} deg" for key, angle in angles.items() if angle)


def _by(sizes: Sequence[float]) -> str:
    """Return sizes [m] in millimetres as words."""
    return " x ".join(f"{MM * size:.4g}" for size in sizes)


def _is_round(part: Target | Elastomer) -> bool:
    """Tell whether a part is a disc or a cylinder."""
    return part.is_round if isinstance(part, Elastomer) else part.diameter is not None


def _rows(it: Drawing, axis: int) -> list[list[Span]]:
    """Return the lines of dimensions along x or y: coils, their distances, target, pad; what is round along x only."""
    places = sorted({round(MM * coil.centre[axis], 6) for coil in it.sensor.coils})
    found = [] if axis else [[_across(min(it.sensor.coils, key=lambda coil: (coil.centre[1], coil.centre[0])))]]
    found += [[(a, b, f"{b - a:.4g}") for a, b in pairwise(places)]] if 1 < len(places) <= _MOST + 1 else []
    cover = it.sensor.target if it.sensor.cover is not None else None  # of the target's outline
    for part, plate in ((it.sensor.target, "target"), (cover, "cover"), (it.sensor.elastomer, "pad")):
        if part is not None and not (_is_round(part) and axis == 1):
            rims = np.vstack(next(each.loops for each in it.plates if each.name == plate))
            low, high = float(rims[:, axis].min()), float(rims[:, axis].max())
            found.append([(low, high, f"{plate} {'⌀ ' * _is_round(part)}{high - low:.4g}")])
    return found


def _across(coil: Coil) -> Span:
    """Return the size of a coil along x."""
    low, high = _disc(coil)[:, 0].tolist()
    return low, high, f"{coil.name} {'⌀ ' if coil.shape == 'circle' else ''}{high - low:.4g}"


def _draw_plan(axes: Axes, it: Drawing, rows: list[list[list[Span]]]) -> None:
    """Draw what is seen from above, with dimensions below and to the left."""
    for plate in it.plates:
        rim, *holes = plate.loops
        add_polygons(axes, rim[None], facecolors=(plate.shade, 0.45), edgecolors=plate.shade, linewidth=0.9)
        for other in holes:
            inside = inside_loops([rim], other[:1])[0]
            shade = "white" if inside else (plate.shade, 0.45)
            add_polygons(axes, other[None], facecolors=shade, edgecolors=plate.shade, linewidth=0.9)
    for coil in it.sensor.coils:
        x, y = (MM * place for place in coil.centre)
        for line, _ in coil_lines(coil):
            axes.plot(*MM * line[:, :2].T, color="#7a4a1c", linewidth=0.35)
        axes.annotate(coil.name, (x, y), (0, 2), textcoords="offset points", ha="center", fontsize=7)
    corners = [tuple(plate.loops[0].max(axis=0).round(2).tolist()) for plate in it.plates[: len(it.sensor.conductors)]]
    for k, (plate, corner) in enumerate(zip(it.plates, corners, strict=False)):
        below = -1.0 - 7.0 * corners[:k].count(corner)  # points: one under another where plates have one corner
        style: dict[str, Any] = {"textcoords": "offset points", "fontsize": 6, "color": "0.25"}
        axes.annotate(plate.name, corner, (-2, below), ha="right", va="top", **style)
    for axis, kinds in enumerate(rows):
        for k, spans in enumerate(kinds):
            for span in spans:
                _dimension(axes, it, span, axis, it.low[1 - axis] - (k + 0.8) * _ROW * it.size)
    if it.sensor.touch is not None:
        draw_from_above(axes, it.sensor.touch)
    y, out = MM * it.plane.offset, 0.03 * it.size
    axes.plot([it.low[0] - out, it.high[0] + out], [y, y], color="0.2", linewidth=0.6, dashes=(12, 3, 2, 3))
    axes.annotate("A", (it.high[0] + 1.4 * out, y), va="center", fontsize=8, weight="bold")


def _dimension(axes: Axes, it: Drawing, span: Span, axis: int, at: float) -> None:
    """Draw one dimension line along x or y, `at` the other coordinate, with its two lines towards the parts."""
    low, high, text = span
    ends = [(low, at), (high, at)] if axis == 0 else [(at, low), (at, high)]
    short = high - low < 0.1 * it.size
    arrow = {"arrowstyle": "|-|,widthA=.15,widthB=.15" if short else "<|-|>,head_length=.25,head_width=.1"}
    axes.annotate(
        "", ends[1], ends[0], arrowprops=arrow | {"shrinkA": 0, "shrinkB": 0, "linewidth": 0.5, "color": "0.2"}
    )
    for x, y in ends:
        far = (x, it.low[1] - 0.01 * it.size) if axis == 0 else (it.low[0] - 0.01 * it.size, y)
        axes.plot([x, far[0]], [y, far[1]], color="0.6", linewidth=0.3)
    middle = ((low + high) / 2, at) if axis == 0 else (at, (low + high) / 2)
    white = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axes.annotate(
        text, middle, ha="center", va="center", fontsize=6.5, rotation=90.0 * axis, bbox=None if short else white
    )


def _tracks(sensor: Sensor, plane: Plane) -> tuple[Array, Array]:
    """Return corners [mm] and sign of all tracks that the section cuts."""
    corners, sign = zip(*(coil_cut(coil, plane, sensor.substrate_radius) for coil in sensor.coils), strict=True)
    return MM * np.concatenate(corners), np.concatenate(sign)


def _draw_section(axes: Axes, it: Drawing) -> None:
    """Draw what the section cuts, with the height of each part beside it."""
    for plate in it.plates:
        if np.isfinite(plate.top):
            pieces = chords(plate.loops, Plane(0.0, MM * it.plane.offset))
            corners = boxes(pieces[:, 0], pieces[:, 1], plate.bottom, plate.top)
            corners = corners if plate.fixed is None else MM * conductor_cut(plate.fixed, it.plane)
            add_polygons(axes, corners, facecolors=plate.shade, edgecolors="0.3", linewidth=0.3)
            for z in _interfaces(it.sensor.elastomer) if plate.name == "pad" else ():
                axes.hlines(np.full(len(pieces), z), *pieces.T, color="0.3", linewidth=0.5)
    touch, tops = it.sensor.touch, [plate.top for plate in it.plates if plate.name == "target"]
    if touch is not None and np.isfinite(tops).all():
        over = getattr(it.sensor.cover, "thickness", 0.0)
        place = np.array([*touch.place, *(top / MM + over for top in tops)])
        draw_from_the_side(axes, touch, place, np.array([0.0, 0.0, 1.0]), it.plane)
    corners, sign = _tracks(it.sensor, it.plane)
    add_polygons(axes, corners, facecolors=np.where(sign > 0.0, *TRACKS).tolist(), linewidth=0)
    axes.plot([it.low[0], it.high[0]], [0.0, 0.0], color="0.5", linewidth=0.3, zorder=0.5)
    levels, gap = _levels(it), _LABEL * it.size
    start = (it.low[2] + it.high[2]) / 2 - gap * (len(levels) - 1) / 2
    for k, (low, high, name) in enumerate(levels):
        x, z, label = it.high[0] + 0.02 * it.size, (low + high) / 2, start + k * gap
        axes.plot([x, x], [low, high], color="0.2", linewidth=1.2, solid_capstyle="butt")
        axes.plot([x, x + 0.03 * it.size, x + 0.045 * it.size], [z, label, label], color="0.4", linewidth=0.4)
        axes.annotate(f"{name} {high - low:.4g}", (x + 0.05 * it.size, label), va="center", fontsize=6.5)
    title = f"section A, {it.plane.words}"
    axes.annotate(title, (it.low[0], it.high[2]), (0, 6), textcoords="offset points", fontsize=6.5)


def _interfaces(pad: Elastomer | None) -> list[float]:
    """Return the heights of a pad's interfaces [mm]."""
    return [] if pad is None else [MM * (pad.standoff + height) for height in pad.interfaces]


def _levels(it: Drawing) -> list[Span]:
    """Return bottom, top and name of each part and of the stand-off, from below."""
    deep = MM * max(coil.height for coil in it.sensor.coils)
    found = [(-deep, 0.0, "coils"), *((plate.bottom, plate.top, plate.name) for plate in it.plates)]
    pad = it.sensor.elastomer
    if pad is not None and pad.standoff > 0.0:
        found.append((0.0, MM * pad.standoff, "stand-off"))
    if pad is not None and pad.interfaces:
        ends = [MM * pad.standoff, *_interfaces(pad), MM * (pad.standoff + pad.thickness)]
        found += [(low, high, f"layer {k}:") for k, (low, high) in enumerate(pairwise(ends), 1)]
    return sorted((level for level in found if np.isfinite(level[1])), key=lambda level: level[0] + level[1])


def _winding(coil: Coil) -> str:
    """Return sizes, turns, layers and tracks of a coil in words."""
    lengths = (coil.track_width, coil.track_thickness, coil.track_gap)
    wide, thick, gap = (f"{MM * length:.4g}" for length in lengths)
    heights = [MM * z for z in coil.heights]
    layers = f"{len(heights)} layers {MM * coil.layer_pitch:.4g} apart" if len(heights) > 1 else "one layer"
    if coil.layer_z or coil.shape == "path":
        layers = f"copper at z = {', '.join(f'{z:.4g}' for z in heights)}"
    outer = _by(coil.extent)
    if coil.shape == "path":
        count = len(coil.path)
        return f"{outer}; free tracks in {count} piece{'s' if count > 1 else ''}, {layers}; {wide} x {thick}"
    outer = f"{MM * coil.outer_diameter:.4g}" if coil.is_round else outer
    return f"{_inside(coil)} to {outer}; {coil.turns} turns in {layers}; tracks {wide} x {thick}, gaps {gap}"


def _inside(coil: Coil) -> str:
    """Return the inner size of a coil's turns, and their shape, in words."""
    across = f"{MM * coil.inner_diameter:.4g}" if coil.inner_diameter else _by((coil.inner_width, coil.inner_length))
    if coil.is_round:
        return f"⌀ {across}"
    return across if coil.shape == "rectangle" else f"{coil.shape} {across} inside"


def _list_of_parts(it: Drawing) -> list[str]:
    """Return one line for each kind of coil and each part: what it is and how large."""
    lines, (kinds, numbers) = [], kinds_of(it.sensor.coils)
    for k, coil in enumerate(kinds):
        names = [each.name for each, number in zip(it.sensor.coils, numbers, strict=True) if number == k]
        name = ", ".join(names) if len(names) < 6 else f"{names[0]} to {names[-1]} ({len(names)})"
        lines.append(f"{name}: {_winding(coil)}")
    materials = {"pad": it.sensor.elastomer, "target": it.sensor.target, "cover": it.sensor.cover}
    for plate in it.plates:
        part = materials.get(plate.name)
        made = part.words if isinstance(part, Elastomer | Cover) else "" if part is None else part.material
        lines.append(f"{plate.name}: {plate.sizes}{f', {made}' if made else ''}")
    if it.sensor.touch is not None:
        x, y = (f"{MM * place:.4g}" for place in it.sensor.touch.place)
        lines.append(f"touch, dashed: {it.sensor.touch.words}, at x = {x}, y = {y}")
    lines.append("tracks in the section: current along +y orange, along -y blue")
    radius = it.sensor.substrate_radius
    return lines + (
        [] if radius is None else [f"coils on a cylinder of radius {MM * radius:.4g} along y; plan unrolled"]
    )
