"""Outlines of scenes: areas, crossings, mesh files with named groups, and the scene keys that bring them."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from sits_mech.scene.parts.outlines import first_crossing, read_loops, read_mesh, signed_area
from sits_mech.scene.sensor import SceneError, Sensor, changed, load_sensor, save_sensor, scene_text, sensor_from

MESHES = Path(__file__).parents[3] / "meshes"
SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
HOLE = ((0.5, 0.5), (1.5, 0.5), (1.0, 1.5))
BOW = ((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0))


def outlined(**keys: object) -> Sensor:
    """The catalogue's sensor with a target of another outline."""
    table = load_sensor("biorob2018").model_dump(exclude_none=True)
    table["target"] = {"material": "copper", "shape": "outline", "thickness": 2e-4, **keys}
    return Sensor.model_validate(table)


def test_areas_and_crossings() -> None:
    """By hand; the crossing of a bow tie is its middle."""
    assert signed_area(np.array(SQUARE)) == 4.0 and signed_area(np.array(SQUARE[::-1])) == -4.0
    assert first_crossing((SQUARE, HOLE)) is None
    assert first_crossing((BOW,)) == pytest.approx((1.0, 1.0))
    assert first_crossing((SQUARE, ((1.0, 1.0), (3.0, 1.0), (1.0, 1.5)))) is not None
    assert first_crossing(((*SQUARE[:2], (1.0, 0.0), (1.0, 2.0)),)) is not None  # an edge that runs back on another


@pytest.mark.parametrize("name, area", [("cross", 39e-6), ("slotted_disc", None)])
def test_mesh_of_a_scene_is_found_beside_it_and_kept_as_corners(name: str, area: float | None, tmp_path: Path) -> None:
    """The path counts from the scene's folder; what is written needs the file no more."""
    (tmp_path / "plate.msh").write_bytes((MESHES / f"{name}.msh").read_bytes())
    scene = tmp_path / "scene.toml"
    lines = (Path(__file__).parents[3] / "sits_mech/scene/catalog/biorob2018.toml").read_text().splitlines()
    start = lines.index('shape = "rectangle"')
    scene.write_text("\n".join([*lines[:start], 'shape = "outline"', 'mesh = "plate.msh"', *lines[start + 3 :]]))
    sensor = load_sensor(scene)
    assert sensor.target is not None and sensor.target.points == read_loops(MESHES / f"{name}.msh", "target")[0]
    if area is not None:
        assert abs(signed_area(np.array(sensor.target.points))) == pytest.approx(area, rel=1e-9)
    save_sensor(sensor, tmp_path / "kept.toml")
    (tmp_path / "plate.msh").unlink()
    assert load_sensor(tmp_path / "kept.toml") == sensor
    with pytest.raises(SceneError, match=r"scene.toml: target: .*plate.msh: must be a mesh file that meshio reads"):
        load_sensor(scene)


@pytest.mark.parametrize("line, came", [
    ("GRID,1,7,0.,0.,0.", "GRID,1,7,"), ("GRID           1       7      0.      0.      0.", "GRID 1 7 "),
    ("GRID*                  1               7              0.              0.", "GRID[*] 1 7 "),
    ("GRDSET,,7", "GRDSET,,7"), ("INCLUDE 'cells.bdf'", "INCLUDE"), ("GRID,1,,0.,0.,0.", ""), ("GRID,1,0,0.,0.,0.", ""),
    ("GRID           1              0.      0.      0.", "")])
def test_a_nastran_file_gives_all_nodes_where_they_stand(line: str, came: str, tmp_path: Path) -> None:
    """Systems of nodes and included files, which meshio passes over, are refused; the basic system is not."""
    nodes = [f"GRID,{k},,{x},{y},0." for k, x, y in ((2, 1.0, 0.0), (3, 0.0, 1.0))]
    plate = tmp_path / "plate.bdf"
    plate.write_text("\n".join(["BEGIN BULK", line, *nodes, "CTRIA3,1,1,1,2,3", "ENDDATA", ""]))
    if came:
        with pytest.raises(SceneError, match=rf"plate.bdf: must give all nodes itself, .*; got {came}"):
            read_loops(plate)
    else:
        assert abs(signed_area(np.array(read_loops(plate)[0]))) == 0.5


def test_holes_come_with_an_outline() -> None:
    """In millimetres around the target's centre."""
    rim, hole = (tuple((1e-3 * x, 1e-3 * y) for x, y in loop) for loop in (SQUARE, HOLE))
    sensor = outlined(points=rim, holes=(hole,))
    assert sensor.target is not None and sensor.target.holes == (hole,)
    assert changed(sensor, ["name=again"]).target == sensor.target


@pytest.mark.parametrize(
    "keys, reason",
    [
        ({"points": BOW}, r"rims that do not cross or touch; they do at \(1, 1\) m"),
        ({"points": SQUARE, "holes": [[(1.0, 1.0), (3.0, 1.0), (1.0, 1.5)]]}, "do not cross or touch"),
        ({"points": SQUARE, "holes": [[(1.0, 1.0), (1.5, 1.0)]]}, "holes must be at least three corners"),
        ({"points": SQUARE, "mesh": "cross.msh"}, "mesh must come with shape"),
        ({"mesh": 3}, "mesh and mesh_group must be a file and a name; got 3"),
        ({"mesh": str(MESHES / "cross.msh"), "mesh_group": "rim"}, '"rim"; its groups are target'),
        ({"mesh": str(MESHES / "README.md")}, "must be a mesh file that meshio reads"),
    ],
)
def test_bad_outlines(keys: dict[str, object], reason: str) -> None:
    """One line each."""
    with pytest.raises(ValueError, match=reason):
        outlined(**keys)


def test_cells_that_meshio_does_not_know_are_said_to_be_so(tmp_path: Path) -> None:
    """Prisms of 15 nodes, as Gmsh and Abaqus write them: a reason, where meshio has a bare KeyError."""
    numbers = " ".join(str(k) for k in range(1, 16))
    nodes = "\n".join(f"{k} {k} {k * k} {k**3}" for k in range(1, 16))
    format_, cells = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", f"$Elements\n1\n1 18 2 1 1 {numbers}\n$EndElements\n"
    (tmp_path / "prism.msh").write_text(f"{format_}$Nodes\n15\n{nodes}\n$EndNodes\n{cells}")
    with pytest.raises(SceneError, match=".*prism.msh: must be .* got: 'wedge15', which meshio does not know"):
        read_mesh(tmp_path / "prism.msh")


def test_coils_have_one_winding() -> None:
    """Spirals by the scene; a mixture has no model."""
    spirals = changed(load_sensor("biorob2018"), ["coils.C1.winding=spiral", "coils.C2.winding=spiral"])
    assert [coil.winding for coil in spirals.coils] == ["spiral", "spiral"]
    with pytest.raises(SceneError, match="round coils must all have one winding; got rings and spiral"):
        changed(spirals, ["coils.C2.winding=rings"])


def test_fixed_plates_have_outlines() -> None:
    """As targets have them, from the plate's centre; written and read back; other plates keep their text."""
    rim, hole = [[-8e-3, -8e-3], [8e-3, -8e-3], [8e-3, 8e-3], [-8e-3, 9e-3]], [[0, 1e-3], [1e-3, -1e-3], [-1e-3, 0]]
    ground = {"name": "GND", "material": "copper", "centre": [0, 0, -1e-3], "thickness": 35e-6}
    table = load_sensor("biorob2018").model_dump(exclude_none=True)
    sensor = sensor_from(table | {"conductors": [ground | {"shape": "outline", "points": rim, "holes": [hole]}]})
    assert sensor.conductors[0].extent == (16e-3, 18e-3) and len(sensor.conductors[0].holes) == 1
    assert sensor_from(tomllib.loads(scene_text(sensor))) == sensor
    disc = sensor_from(table | {"conductors": [ground | {"shape": "disc", "diameter": 8e-3}]})
    assert "holes" not in scene_text(disc)
    for keys, reason in (
        ({"shape": "outline"}, "conductors.GND: points must be given for an outline; it is missing"),
        ({"shape": "disc", "diameter": 8e-3, "holes": [hole]}, "conductors.GND: holes must come with shape = .outl"),
        ({"shape": "outline", "points": rim, "holes": [rim[:3]]}, r"do at \(-0.008, -0.008\) m"),
        ({"shape": "outline", "points": [*rim, rim[0]]}, r"do at \(-0.008, -0.008\) m"),
        ({"shape": "outline", "points": rim, "holes": [[[0, 0], [9e-3, 0], [0, 1e-3]]]}, "rims that do not cross"),
    ):
        with pytest.raises(SceneError, match=reason):
            sensor_from(table | {"conductors": [ground | keys]})
