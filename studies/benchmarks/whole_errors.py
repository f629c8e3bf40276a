"""Does the error of an answer hold the question? Scenes by chance, by `auto` and by models that are asked for by name.

Sixty scenes: one to four coils in a row along x or y, in a triangle or a square, round or as rectangles; no target,
plates of four metals, short and long, discs on and off the axis, steel; poses shifted and tilted; pads under loads.
Every third one is asked of a model by name that leaves something out. Each is judged against the richest model that
holds it at a tenth of the tolerance, relative to the inductances without target,

    true = |L/L0 - L/L0 of the reference|,    told = the answer's error, omissions and all, over L0,

of each coil, the one with the largest true over told; mutual inductances of coils alone against Neumann's integral over
their turns' middles, which is right to some 1e-3 of L0. Wanted: true is within told (and the reference's own error) of
95 % of the answers with an error, 0.1 to 1 of it of 80 %, and no answer is called ok that is off by more than the
tolerance.

Run ``python -m benchmarks.whole_errors [--coarse] --output DIR``: one row a scene is kept in DIR as it is done, and a
stopped run goes on; then the counts, and a figure of true over told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common.accuracy import first_strain
from common.outputs import kept_rows, study_arguments, write_rows
from threadpoolctl import threadpool_limits

from sits_mech.chain.models import magnetic_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions
from sits_mech.chain.rests import at_rest
from sits_mech.chain.simulate import simulate, simulation_at
from sits_mech.geometry.collision import Collision
from sits_mech.geometry.tracks import coil_tracks
from sits_mech.geometry.windings import turn_radii
from sits_mech.magnetics.axis_fem import axisymmetric_fem
from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import Array, Impedance, Pose, SolveFailed, Wrench
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.status import OK, flags_of

ASKED, COUNT, COARSE = 3e-2, 60, (0, 2, 5, 8, 12)
STIFF = 3e-3  # tolerance of block as a reference
POINTS = 720  # of Neumann's integral around a turn
KINDS = ("alone", "plate", "on axis", "load", "plate", "steel on axis", "long", "beside", "steel", "plate")
NAMED = {"plate": "planar", "long": "planar", "on axis": "planar-fem", "steel": "planar-fem", "load": "planar"}
Row = dict[str, Any]


class Drawn(NamedTuple):
    """A scene by chance, with a pose or a load, and the model that is asked for."""

    kind: str
    sensor: Sensor
    pose: Pose | None
    load: Wrench | None
    asked: str


def places(some: np.random.Generator, count: int, pitch: float) -> Array:
    """Return places of coils in a row along x or y, a triangle or a square [mm]."""
    row = (np.arange(count) - (count - 1) / 2) * pitch
    if count < 3 or some.uniform() < 0.3:
        return np.outer(row, (1.0, 0.0) if some.uniform() < 0.6 else (0.0, 1.0))
    turned = 2.0 * math.pi * np.arange(count) / count
    return 0.5 * pitch / math.sin(math.pi / count) * np.stack([np.cos(turned), np.sin(turned)], axis=1)


def coils(some: np.random.Generator, kind: str) -> str:
    """Return coils of one shape."""
    count = 1 if "axis" in kind else int(some.integers(1, 5))
    turns, layers, inner = int(some.integers(4, 11)), int(some.integers(1, 3)), some.uniform(1.0, 3.0)
    length = inner * some.uniform(3.0, 8.0) if kind == "long" or (kind == "alone" and some.uniform() < 0.4) else inner
    size = f'inner_diameter="{inner:.4f} mm"'
    if length != inner:
        size = f'shape="rectangle", inner_width="{inner:.4f} mm", inner_length="{length:.4f} mm"'
    pitch = length + 2 * (0.2 * turns - 0.1) + some.uniform(0.3, 4.0)
    at = places(some, count, pitch) if "axis" not in kind else np.zeros((1, 2))
    tracks = 'track_width="0.1 mm", track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"'
    rows = (
        f'{{name="C{k + 1}", centre=["{x:.4f} mm", "{y:.4f} mm"], layers={layers}, turns={turns}, {size}, {tracks}}}'
        for k, (x, y) in enumerate(at.tolist())
    )
    return f"coils=[{', '.join(rows)}]"


def target(some: np.random.Generator, kind: str) -> str:
    """Return a plate of some metal."""
    metal = f"conductivity={some.choice([5.8e7, 3.5e7, 1.5e7, 1.4e6])}"  # copper, aluminium, brass, stainless
    if "steel" in kind:
        metal = f"conductivity={some.choice([7e6, 2e6])}, relative_permeability={some.choice([20.0, 100.0, 400.0])}"
    width, thickness = some.uniform(3.0, 9.0), 10 ** some.uniform(math.log10(0.05), math.log10(0.3))
    length = width * (some.uniform(5.0, 20.0) if kind == "long" else some.uniform(0.6, 1.6))
    sizes = f'shape="rectangle", width="{width:.4f} mm", length="{length:.4f} mm"'
    if "axis" in kind or (kind == "beside" and some.uniform() < 0.7):
        sizes = f'shape="disc", diameter="{width:.4f} mm"'
    return f'target={{{metal}, {sizes}, thickness="{thickness:.4f} mm"}}'


def draw(number: int) -> Drawn:
    """Return the scene of a number."""
    some, kind = np.random.default_rng([62, number]), KINDS[number % len(KINDS)]
    asked = NAMED.get(kind, "auto") if number % 3 == 0 else "auto"
    keys = [coils(some, kind), target(some, kind), f'frequency="{10 ** some.uniform(5.0, 7.0):.4f} Hz"']
    gap = some.uniform(0.8, 3.0)
    keys += [f'elastomer.thickness="{gap:.4f} mm"', "elastomer.standoff=0.0"]
    sensor = load_sensor("biorob2018", keys)
    if kind == "alone":
        return Drawn(kind, sensor.model_copy(update={"target": None, "elastomer": None}), Pose(0.0, 0.0), None, asked)
    assert sensor.target is not None
    pairs = zip(("width", "length"), sensor.target.extent, strict=True)
    keys += [f"elastomer.{name}={side * some.uniform(1.0, 2.0)}" for name, side in pairs]
    sensor = load_sensor("biorob2018", keys)
    if kind == "load":
        unit = Wrench(*(some.normal(size=2) * (0.3, 1.0)).tolist())
        unit = Wrench(unit.F_x, abs(unit.F_z))
        share = 10 ** some.uniform(-2.5, -1.0) / first_strain(sensor, unit)
        return Drawn(kind, sensor, None, Wrench(share * unit.F_x, share * unit.F_z), asked)
    if "axis" in kind:
        return Drawn(kind, sensor, Pose(0.0, 1e-3 * gap), None, asked)
    aside = 0.0 if kind == "steel" or asked != "auto" else float(some.uniform(-1e-3, 1e-3))
    tilt = some.uniform(-0.3, 0.3) * 1e-3 * gap / sensor.target.extent[0]
    return Drawn(kind, sensor, Pose(float(some.uniform(-1e-3, 1e-3)), 1e-3 * gap, float(tilt), aside), None, asked)


def answered(drawn: Drawn) -> tuple[Impedance, str]:
    """Return what the coils show, and its status."""
    if drawn.load is not None:
        models = {"mechanics": drawn.asked, "magnetics": "sheets"} if drawn.asked != "auto" else {}
        found = simulate(drawn.sensor, drawn.load, tolerance=ASKED, **models)
        return found.impedance, found.status
    assert drawn.pose is not None
    model, _ = magnetic_model(drawn.sensor, drawn.asked, ASKED, [drawn.pose])
    shown = model.impedance(drawn.pose, drawn.sensor.frequency)
    bounded = not any(item.unbounded for item in shown.report.left_out)
    return shown, flags_of(shown.report.estimated_error, ASKED, bounded=bounded)[0]


def reference(drawn: Drawn) -> Impedance | None:
    """Return the richest model's answer; None where no other model than the one in section holds the scene."""
    sensor, pose = drawn.sensor, drawn.pose
    try:
        if drawn.load is not None:
            left_out = mechanical_omissions(sensor, "block", [drawn.load])
            rest = at_rest(sensor, block_pad(sensor, STIFF), drawn.load, left_out)
            return simulation_at(sensor, Tracked(sheets(sensor, 0.1 * ASKED), sensor), rest).impedance
        assert pose is not None
        if "axis" in drawn.kind:
            return Tracked(axisymmetric_fem(sensor, 0.1 * ASKED), sensor).impedance(pose, sensor.frequency)
        return Tracked(sheets(sensor, 0.1 * ASKED), sensor).impedance(pose, sensor.frequency)
    except SceneError:
        return None


def neumann(sensor: Sensor) -> Array:
    """Return mutual inductances of coils by Neumann's integral over their turns' middles, zero on the diagonal [H]."""
    lines = [_turns(coil) for coil in sensor.coils]
    found = np.zeros((len(lines),) * 2)
    for i, one in enumerate(lines):
        for j, other in enumerate(lines[:i]):
            found[i, j] = found[j, i] = sum(_mutual(a, b) for a in one for b in other)
    return found


def _turns(coil: Any) -> list[Array]:
    """Return points along the middle of each turn, shape (m, 3) [m]."""
    if not coil.is_round:
        tracks = coil_tracks(coil)
        return [np.linspace(a, b, 33) for a, b in zip(tracks.start, tracks.end, strict=True)]
    angle = np.linspace(0.0, 2.0 * math.pi, POINTS + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    middle = np.array([*coil.centre, 0.0])
    return [middle + r * circle + (0.0, 0.0, z) for z in coil.heights for r in turn_radii(coil)]


def _mutual(one: Array, other: Array) -> float:
    """Return mu0/(4 pi) of the integral of dl . dl'/distance over two lines, by midpoints."""
    (a, da), (b, db) = ((0.5 * (line[1:] + line[:-1]), np.diff(line, axis=0)) for line in (one, other))
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    return float(1e-7 * np.sum((da @ db.T) / distance))


def over_free(found: Impedance) -> tuple[Array, Array]:
    """Return each coil's L over its L0, and its error."""
    free = np.diag(found.L0)
    return np.diag(found.L) / free, np.diag(found.error_L) / free


def measure(number: int) -> Row:
    """Return the row of a scene."""
    drawn = draw(number)
    row: Row = {"scene": number, "kind": drawn.kind, "asked": drawn.asked, "coils": len(drawn.sensor.coils)}
    try:
        found, status = answered(drawn)
    except (SolveFailed, Collision, SceneError) as reason:
        return row | {"status": "no answer", "why": str(reason)}
    row |= {"model": found.report.model, "unit": found.unit_L, "status": status}
    if drawn.kind == "alone":
        scale = np.sqrt(np.outer(*2 * [np.diag(found.L0)]))
        off = np.abs(found.L - neumann(drawn.sensor)) / scale
        return row | {"true": float(np.max(off[~np.eye(len(off), dtype=bool)], initial=0.0)), "told": math.nan}
    best = reference(drawn)
    if best is None:
        return row | {"true": math.nan, "told": math.nan}
    (r, stated), (right, own) = over_free(found), over_free(best)
    true, change = np.abs(r - right), float(np.abs(right - 1.0).max())
    worst = int(np.argmax(true / stated))
    bounded = not any(item.unbounded for item in found.report.left_out)
    return row | {
        "change": change, "true": float(true[worst]), "told": float(stated[worst]) if bounded else math.nan,
        "of reference": float(own[worst]), "off": float(true.max()) / change,
    }


def counts(rows: Sequence[Row]) -> list[Row]:
    """Return what the scenes say together: how many of how many."""
    judged = [row for row in rows if math.isfinite(row.get("told", math.nan))]
    fine = [row for row in rows if row["status"] == OK and math.isfinite(row.get("true", math.nan))]

    def part(what: str, some: Sequence[bool], wanted: str) -> Row:
        return {"what": what, "of": len(some), "hold": sum(some), "wanted": wanted}

    within = [row["true"] <= row["told"] + row["of reference"] for row in judged]
    off = [row.get("off", row["true"]) - row.get("of reference", 0.0) / row.get("change", 1.0) for row in fine]
    return [
        part("no answer, named", [row["status"] == "no answer" for row in rows], ""),
        part("not bounded, and said", [row["status"] == "not bounded" for row in rows], ""),
        part("in henry", [row.get("unit") == "H" for row in rows if row["asked"] == "auto"], "all"),
        part("true within told", within, "95 %"),
        part("true over told 0.1 to 1", [0.1 <= row["true"] / row["told"] <= 1.0 for row in judged], "80 %"),
        part("ok and within the tolerance", [each <= ASKED for each in off], "all"),
    ]


def drawn_figure(rows: Sequence[Row], path: Path) -> None:
    """Write true over told errors as a picture."""
    judged = [row for row in rows if math.isfinite(row.get("told", math.nan))]
    with new_figure() as (figure, (axes,)):
        for kind in dict.fromkeys(KINDS):
            own = [row for row in judged if row["kind"] == kind]
            axes.plot([row["told"] for row in own], [max(row["true"], 1e-8) for row in own], ".", label=kind)
        ends = np.array([1e-7, 1.0])
        axes.plot(ends, ends, color="k", lw=0.5)
        axes.plot(ends, 0.1 * ends, color="k", lw=0.5, ls=":")
        axes.set(xscale="log", yscale="log", xlabel="error told, of L0", ylabel="true error, of L0")
        axes.set_title("Errors hold what the models leave out: below the line")
        figure.legend(loc="outside lower center", ncols=4)
        save_figure(figure, path)


def main() -> None:
    """Go through the scenes; write rows, counts and figure."""
    coarse, folder = study_arguments(__doc__ or "")
    with threadpool_limits(limits=1):
        rows = kept_rows(COARSE if coarse else range(COUNT), measure, folder)
    write_rows(rows, folder / "scenes.csv", missing=math.nan)
    print(write_rows(counts(rows), folder / "counts.csv"))
    drawn_figure(rows, folder / "whole_errors.png")


if __name__ == "__main__":
    main()
