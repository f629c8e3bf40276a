"""How is the deformed layer looked at in ParaView? One .vtu for each load, and a .pvd that puts them in order.

Every converged load of the calibration is a time step, shear by shear, each with rising normal force. A file holds the
section y = 0: the layer's cells with their smallest volume ratio J, the target, and the coils' tracks; ``part`` tells
them apart (0, 1, 2), ``displacement`` is that of layer and target from rest. The layer is solved anew, each load from
the one before, by the calibration's model; one by the linear model, which has no mesh to show, by the planar one. The
target is at its pose, which the 3D pad extrapolates from two meshes: it stands off the layer by that model's error.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from sits_mech.cases import DONE
from sits_mech.export.source import Source
from sits_mech.geometry.windings import coil_bars
from sits_mech.mechanics.block import BlockPad, block_pad, deformed_section
from sits_mech.mechanics.layer import PlanarLayer, deformed_mesh, planar_layer
from sits_mech.mechanics.pad.section import layer_parts
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, Wrench
from sits_mech.report.pictures.cuts import target_cut
from sits_mech.scene.files import write_bytes, write_text
from sits_mech.scene.sensor import SceneError, Sensor

_LAYER, _TARGET, _COIL = 0.0, 1.0, 2.0


def write_vtu(source: Source, path: Path) -> tuple[str, ...]:
    """Write the series beside `path`, which lists it; one that ends in .vtu holds the last load, the list beside it.

    Returns
    -------
    tuple of str
        One line for each load that could not be shown.

    Raises
    ------
    SceneError
        When a file cannot be written.
    """
    name = source.request["mechanics"]
    model = (block_pad if name == "block" else planar_layer)(source.sensor, source.request["tolerance"])
    shown = name in ("block", "planar")
    notes = [] if shown else [f"the layer is shown at finite strain in plane strain; the calibration is by {name!r}"]
    steps: list[tuple[str, str]] = []
    for F_x in source.data["F_x"].to_numpy():
        last: Equilibrium | None = None
        for F_z in source.data["F_z"].to_numpy():
            if source.data["status"].sel(F_x=F_x, F_z=F_z).item() != DONE:
                continue
            try:
                last = model.equilibrium(Wrench(float(F_x), float(F_z)), start=last)
            except SolveFailed as error:
                notes.append(f"F_x = {F_x:.4g} N, F_z = {F_z:.4g} N: not shown: {error}")
                continue
            file = f"{path.stem}_{len(steps):04d}.vtu"
            write_bytes(path.parent / file, vtu_file(model, last))
            steps.append((file, f"F_x = {F_x:.6g} N, F_z = {F_z:.6g} N"))
    if path.suffix == ".vtu" and steps:
        write_bytes(path, (path.parent / steps[-1][0]).read_bytes())
        notes.append(f"{path.name} holds the last load, {steps[-1][1]}; {path.stem}.pvd lists all {len(steps)}")
        path = path.with_suffix(".pvd")
    write_text(path, _collection(steps))
    return tuple(notes)


def vtu_file(model: PlanarLayer | BlockPad, found: Equilibrium) -> bytes:
    """Return the file of one load: layer, target and tracks in the section y = 0."""
    sensor = model.sensor
    points, quads, J = _section(model, found)
    still = replace(found, state=np.concatenate([found.state[:1], np.zeros(found.state.size - 1)]))
    kept, quads = np.unique(quads, return_inverse=True)  # a section of a solid leaves most of its nodes out
    points, at_rest = points[kept], _section(model, still)[0][kept]
    target, _ = layer_parts(sensor)
    plate, there = (target_cut(target, pose) for pose in (found.pose, _rest(sensor)))
    pieces = [(points, quads.reshape(-1, 4), points - at_rest), _boxes(plate, (plate - there).reshape(-1, 2))]
    tracks = _tracks(sensor)
    pieces.append(_boxes(tracks, np.zeros((4 * len(tracks), 2))))
    first = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
    cells = np.vstack([piece[1] + start for piece, start in zip(pieces, first, strict=False)])
    part = np.repeat([_LAYER, _TARGET, _COIL], [len(piece[1]) for piece in pieces])
    ratio = np.concatenate([J, np.ones(len(cells) - len(J))])
    mesh = meshio.Mesh(
        _flat(np.vstack([piece[0] for piece in pieces])), [("quad", cells)],
        point_data={"displacement": _flat(np.vstack([piece[2] for piece in pieces]))},
        cell_data={"J": [ratio], "part": [part]},
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:  # meshio writes files alone
        file = Path(folder) / "layer.vtu"
        mesh.write(file)
        return file.read_bytes()


def _section(model: PlanarLayer | BlockPad, found: Equilibrium) -> tuple[Array, NDArray[np.int64], Array]:
    """Return points, quadrilaterals and volume ratios of the layer in the section y = 0."""
    return deformed_section(model, found) if isinstance(model, BlockPad) else deformed_mesh(model, found)


def _rest(sensor: Sensor) -> Pose:
    """Return where the target is without load."""
    if sensor.elastomer is None:
        raise SceneError("elastomer: must be given for --to vtu; it is missing")
    return Pose(0.0, sensor.elastomer.standoff + sensor.elastomer.thickness, 0.0)


def _boxes(corners: Array, moved: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """Return points, cells and displacements of separate quadrilaterals, corners of shape (m, 4, 2)."""
    return corners.reshape(-1, 2), np.arange(4 * len(corners)).reshape(-1, 4), moved


def _tracks(sensor: Sensor) -> Array:
    """Return the corners of every track's section [m], shape (m, 4, 2)."""
    found = []
    for coil in sensor.coils:
        bars = coil_bars(coil)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (bars.width / 2, bars.thickness / 2)
        found.append(np.stack([bars.x, bars.z], axis=1)[:, None, :] + corners)
    return np.concatenate(found)


def _flat(plane: Array) -> Array:
    """Return x, y = 0, z."""
    return np.column_stack([plane[:, 0], np.zeros(len(plane)), plane[:, 1]])


def _collection(steps: list[tuple[str, str]]) -> str:
    """Return the list of files, each with its load."""
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">']
    lines.append("  <Collection>")
    for number, (file, load) in enumerate(steps):
        lines.append(f'    <!-- {load} --><DataSet timestep="{number}" group="" part="0" file="{file}"/>')
    return "\n".join([*lines, "  </Collection>", "</VTKFile>", ""])
