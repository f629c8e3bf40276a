"""Write the deformed layer for ParaView: a folder, one .vtu for each load, a .pvd that puts them in order.

Every converged load of the calibration is a time step, each row of loads with rising normal force. A file holds the
elastomer with the smallest volume ratio J of each cell, the target, and the coils; ``part`` tells them apart (0, 1, 2),
``displacement`` is that of elastomer and target from rest. A pad in space (the calibration's model `block`) is shown
whole, with each layer of a coil as a ring from its innermost to its outermost track; a layer in plane strain as the
section y = 0. The layer is solved anew, each load from the one before, by the calibration's model; one by the linear
model, which has no mesh to show, by the planar one. The target is at its pose, which the 3D pad extrapolates from two
meshes: it stands off the layer by that model's error.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from sits_mech.export.source import Source, own_folder
from sits_mech.geometry.outline import target_outline
from sits_mech.geometry.tracks import coil_tracks
from sits_mech.mechanics.block import BlockPad, block_pad
from sits_mech.mechanics.layer import PlanarLayer, axisymmetric_pad, deformed_mesh, planar_layer
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.mechanics.touch import touched
from sits_mech.quantities import Array, Equilibrium, MechanicalModel, Pose, SolveFailed, Wrench
from sits_mech.readout.loads import load_words, points, varied, wrench_of
from sits_mech.report.pictures.cuts import coil_cut, target_cut, target_points
from sits_mech.report.pictures.pad import deformed_pad
from sits_mech.scene.files import write_bytes, write_text
from sits_mech.scene.sensor import Coil, SceneError, Sensor
from sits_mech.status import ANSWERED

_LAYER, _TARGET, _COIL = 0.0, 1.0, 2.0  # marks of cells by what they are
_AROUND = 48  # sides of a coil's ring

_MODELS: dict[str, Callable[[Sensor, float], PlanarLayer | BlockPad]] = {
    "block": block_pad, "planar": planar_layer, "axisymmetric": axisymmetric_pad,
}
Cells = list[tuple[str, NDArray[np.int64]]]


@dataclass(frozen=True)
class Piece:
    """A part of a picture: points (n, 3), how far they moved, cells by their kind, volume ratio of each."""

    part: float
    points: Array
    moved: Array
    cells: Cells
    J: Array


def write_vtu(source: Source, path: Path) -> tuple[str, ...]:
    """Write the series into the folder `path`, whose list has its name; return one line for each load not shown.

    Raise SceneError when `path` is no folder's, or a file cannot be written.
    """
    name = source.request["mechanics"]
    model = _MODELS.get(name, planar_layer)(source.sensor, source.request["tolerance"])
    own_folder(path, "vtu", (".pvd", ".vtu"), "load_*.vtu")
    shown = name in _MODELS
    notes = [] if shown else [f"the layer is shown at finite strain in plane strain; the calibration is by {name!r}"]
    steps: list[tuple[str, str]] = []
    for wrench, found in _loaded(source, touched(model, source.sensor)):
        if isinstance(found, SolveFailed):
            notes.append(f"{_words(wrench)}: not shown: {found}")
            continue
        file = f"load_{len(steps):04d}.vtu"
        write_bytes(path / file, vtu_file(model, found))
        steps.append((file, _words(wrench)))
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">']
    lines.append("  <Collection>")
    for number, (file, load) in enumerate(steps):
        lines.append(f'    <!-- {load} --><DataSet timestep="{number}" group="" part="0" file="{file}"/>')
    write_text(path / f"{path.name}.pvd", "\n".join([*lines, "  </Collection>", "</VTKFile>", ""]))
    return tuple(notes)


def _loaded(source: Source, model: MechanicalModel) -> Iterator[tuple[Wrench, Equilibrium | SolveFailed]]:
    """Give every converged load of the table with its equilibrium, normal forces rising, or why there is none."""
    data = source.data
    rows = [name for name in varied(data) if name != "F_z"]
    last = None
    before: list[float] = []
    for row in points(data.transpose(*rows, *(["F_z"] if "F_z" in data.dims else []), ...)):
        here, wrench = [float(row[name]) for name in rows], wrench_of(row)
        if row["status"].item() not in ANSWERED:
            continue
        try:
            last = model.equilibrium(wrench, start=last if here == before else None)
            yield wrench, last
        except SolveFailed as error:
            yield wrench, error
        before = here


def _words(wrench: Wrench) -> str:
    """Return a load for a reader: the forces of the plane, and what else there is."""
    each = {name: value for name, value in vars(wrench).items() if value != 0.0 or name in ("F_x", "F_z")}
    return load_words(each)


def vtu_file(model: PlanarLayer | BlockPad, found: Equilibrium) -> bytes:
    """Return the file of one load: elastomer, target and coils."""
    still = replace(found, state=np.concatenate([found.state[:1], np.zeros(found.state.size - 1)]))
    pieces = (_solid if isinstance(model, BlockPad) else _section)(model, found, still)  # type: ignore[arg-type]
    first = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    blocks = [(kind, cells + start) for piece, start in zip(pieces, first, strict=False) for kind, cells in piece.cells]
    parts = [np.full(len(cells), piece.part) for piece in pieces for _, cells in piece.cells]
    ends = np.cumsum([*map(len, parts)])
    mesh = meshio.Mesh(
        np.vstack([piece.points for piece in pieces]), blocks,
        point_data={"displacement": np.vstack([piece.moved for piece in pieces])},
        cell_data={"J": np.split(np.concatenate([piece.J for piece in pieces]), ends[:-1]), "part": parts},
    )
    with tempfile.TemporaryDirectory() as folder:  # meshio writes files alone
        file = Path(folder) / "layer.vtu"
        mesh.write(file)
        return file.read_bytes()


def _solid(model: BlockPad, found: Equilibrium, still: Equilibrium) -> list[Piece]:
    """Return the whole pad, the target and the coils in space."""
    places, cells, J = deformed_pad(model, found)
    kind = "hexahedron" if cells.shape[1] == 8 else "tetra"
    kept, cells = np.unique(cells, return_inverse=True)
    at_rest = deformed_pad(model, still)[0][kept]
    pieces = [Piece(_LAYER, places[kept], places[kept] - at_rest, [(kind, cells.reshape(len(J), -1))], J)]
    if model.sensor.target is not None:
        target = model.sensor.target
        rim = target_outline(target).rim
        k, number = len(rim), np.arange(len(rim))
        corners = np.vstack([np.column_stack([rim, np.full(k, z)]) for z in (0.0, target.thickness)])
        faces = [("polygon", np.array([number[::-1], k + number]))]
        faces.append(("quad", np.column_stack([number, np.roll(number, -1), k + np.roll(number, -1), k + number])))
        there = target_points(corners, found.pose)
        pieces.append(Piece(_TARGET, there, there - target_points(corners, _rest(model.sensor)), faces, np.ones(2 + k)))
    return [*pieces, *(piece for coil in model.sensor.coils for piece in _winding(coil))]


def _winding(coil: Coil) -> list[Piece]:
    """Return a coil's layers as flat rings, or its straight tracks."""
    if coil.is_round:
        return [_ring(coil, z) for z in coil.heights]
    tracks = coil_tracks(coil)
    aside = np.column_stack([tracks.way[:, 1], -tracks.way[:, 0], np.zeros(len(tracks.way))])
    aside *= tracks.width[:, None] / 2
    sides = (tracks.start - aside, tracks.start + aside, tracks.end + aside, tracks.end - aside)
    places, count = np.concatenate(sides), len(aside)
    quads = np.arange(count)[:, None] + count * np.arange(4)
    return [Piece(_COIL, places, np.zeros_like(places), [("quad", quads)], np.ones(count))]


def _ring(coil: Coil, z: float) -> Piece:
    """Return a layer of a coil as a flat ring."""
    angle, number = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False), np.arange(_AROUND)
    round_ = np.column_stack([np.cos(angle), np.sin(angle)])
    radii = (0.5 * coil.inner_diameter, 0.5 * coil.outer_diameter)
    flat = np.asarray(coil.centre) + np.vstack([radius * round_ for radius in radii])
    after = np.roll(number, -1)
    quads = np.column_stack([number, _AROUND + number, _AROUND + after, after])
    points_ = np.column_stack([flat, np.full(2 * _AROUND, z)])
    return Piece(_COIL, points_, np.zeros_like(points_), [("quad", quads)], np.ones(_AROUND))


def _section(model: PlanarLayer, found: Equilibrium, still: Equilibrium) -> list[Piece]:
    """Return layer, target and tracks in the section y = 0."""
    places, quads, J, *_ = deformed_mesh(model, found)
    kept, quads = np.unique(quads, return_inverse=True)
    at_rest = deformed_mesh(model, still).points[kept]
    layer = Piece(_LAYER, _flat(places[kept]), _flat(places[kept] - at_rest), [("quad", quads.reshape(-1, 4))], J)
    target, _ = layer_parts(model.sensor)
    plate, there = (target_cut(target, pose) for pose in (found.pose, _rest(model.sensor)))
    tracks = np.concatenate([coil_cut(coil)[0] for coil in model.sensor.coils])
    return [layer, _boxes(_TARGET, plate, plate - there), _boxes(_COIL, tracks, np.zeros_like(tracks))]


def _rest(sensor: Sensor) -> Pose:
    """Return where the target is without load."""
    if sensor.elastomer is None:
        raise SceneError("elastomer: must be given for --to vtu; it is missing")
    return Pose(0.0, sensor.elastomer.standoff + sensor.elastomer.thickness, 0.0)


def _boxes(part: float, corners: Array, moved: Array) -> Piece:
    """Return separate quadrilaterals of a section, corners and how far they moved of shape (m, 4, 2)."""
    quads = np.arange(4 * len(corners)).reshape(-1, 4)
    return Piece(
        part, _flat(corners.reshape(-1, 2)), _flat(moved.reshape(-1, 2)), [("quad", quads)], np.ones(len(corners))
    )


def _flat(plane: Array) -> Array:
    """Return x, y = 0, z."""
    return np.column_stack([plane[:, 0], np.zeros(len(plane)), plane[:, 1]])
