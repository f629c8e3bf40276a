"""Pads on meshes of the user's own: a mesh of the model's own shape, the examples, refusals in one line."""

import hashlib
import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import MeshHex, MeshHex2
from skfem.io.meshio import to_meshio

from sits_mech.chain.models import choose_mechanics
from sits_mech.geometry.meshing.bricks import box_bricks
from sits_mech.geometry.meshing.store import read_solid
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.equilibrium.body import State, rest
from sits_mech.mechanics.equilibrium.newton import newton, small_strain_compliance
from sits_mech.mechanics.levels import settle
from sits_mech.mechanics.pad.families import meshes_in_line
from sits_mech.mechanics.pad.solid import bonded_block, solid
from sits_mech.mechanics.pad.user import GROUPS, _level, mesh_notes, meshed_family
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, load_sensor, save_sensor, scene_text, sensor_from

MM = 1e-3
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
MESHES = Path(__file__).parents[3] / "meshes"
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
KZ, KX = 120.67, 4.482  # NGSolve 6.2: 20 x 20 x 2 mm under 15 x 15 mm [N/mm]


def scene(mesh, *more, size=15):
    """A pad of 20 x 20 x 2 mm under a square target."""
    sides = [f'target.{side}="{size} mm"' for side in ("width", "length")]
    return load_sensor("biorob2018", ["target.load_height=0", *sides, NEO_HOOKEAN, f'elastomer.mesh="{mesh}"', *more])


def on_mesh(sensor, *, constant=False):
    """The pad on the mesh of its scene, pressures linear or constant in each element."""
    return solid(sensor, _level(sensor, 0, constant=constant)[0], 0.0, 0.0)


def stiffness(found):
    """kz and kx [N/mm]."""
    k = np.linalg.inv(small_strain_compliance(found.body)[0]) * 3e4 * 2e-3 / found.share * MM
    return np.array([k[1, 1], k[0, 0]])


def box_file(path, *, half=True, groups=("ground", "target", "free", "symmetry"), size=15.0, change=None):
    """Write a pad of the model's own shape in hexahedra of eight nodes; `change` moves the points [mm]."""
    edge = size / 2
    x = np.array([0, 0.6, 0.93, 1.0]) * edge
    x = np.append(x, [edge + 0.5, 10.0])
    both = np.concatenate([-x[:0:-1], x])
    mesh = MeshHex.init_tensor(both, x if half else both, np.array([0, 1.6, 2.0]))
    corner = mesh.p[:, mesh.facets]
    low, high = corner.min(axis=1), corner.max(axis=1)
    outer = mesh.f2t[1] == -1
    top = (low[2] > 2 - 1e-9) & (np.abs(corner[:2]).max(axis=(0, 1)) < edge + 1e-9)
    kinds = np.select([high[2] < 1e-9, top, (high[1] < 1e-9) & half], [1, 2, 4], 3)[outer]
    points = mesh.p.copy()
    if change is not None:
        points = change(points)
    order = [0, 1, 4, 2, 3, 5, 7, 6]  # to the order of VTK
    cells = [("quad", mesh.facets[[0, 1, 3, 2]][:, outer].T), ("hexahedron", mesh.t[order].T)]
    marks = [kinds, np.full(mesh.t.shape[1], 9)]
    found = meshio.Mesh(points.T * MM, cells, cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks})
    for tag, name in enumerate(("ground", "target", "free", "symmetry"), start=1):
        if name in groups:
            found.field_data[name] = np.array([tag, 2])
    meshio.write(path, found, file_format="gmsh22", binary=False)
    return path


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    return box_file(tmp_path_factory.mktemp("meshes") / "box.msh")


def test_hexahedra_of_the_models_own_shape(box):
    """Against independent codes; the same numbers come from the same lines in the model's own mesh."""
    stiffer, softer = (stiffness(on_mesh(scene(box), constant=each)) for each in (False, True))
    assert np.all(softer < stiffer)
    np.testing.assert_allclose(stiffer, [KZ, KX], rtol=0.02)
    own = bonded_block(scene(box), 2, 2.0, 0.0)
    np.testing.assert_allclose(stiffer, stiffness(own), rtol=0.02)


def test_half_a_pad_is_the_whole_pad(tmp_path, box):
    whole = box_file(tmp_path / "whole.msh", half=False, groups=("ground", "target", "free"))
    np.testing.assert_allclose(
        stiffness(on_mesh(scene(whole))), stiffness(on_mesh(scene(box))), rtol=1e-7
    )


@pytest.mark.slow
def test_a_whole_mesh_bears_all_six_components(tmp_path, box):
    """Along x as half of it does; along y as along x."""
    whole = scene(box_file(tmp_path / "whole.msh", half=False, groups=GROUPS))
    pad = block_pad(whole, 1e-2)
    along, across = (pad.equilibrium(Wrench(F_x, 4.0, F_y=F_y)) for F_x, F_y in ((0.6, 0.0), (0.0, 0.6)))
    half = block_pad(scene(box)).equilibrium(Wrench(0.6, 4.0))
    np.testing.assert_allclose(along.pose.centre[[0, 2]], [half.pose.d_h, half.pose.d_v], rtol=1e-6)
    np.testing.assert_allclose(across.pose.centre[[1, 0, 2]], along.pose.centre, atol=1e-9)


@pytest.mark.slow
def test_pose_and_its_error(box):
    """13 N sink 0.09766 mm to 0.6 %: NGSolve and FElupe; two layers of hexahedra, divided."""
    found = block_pad(scene(box)).equilibrium(Wrench(F_z=13.0))
    sink = (2.0 * MM - found.pose.d_v) / MM
    assert abs(sink - 0.09766) < found.error.d_v / MM + 0.006 * sink and found.error.d_v / MM < 0.02 * sink
    assert found.report.min_J > 0.0


@pytest.mark.slow
def test_errors_of_uneven_tetrahedra(tmp_path):
    """A whole pad cut askew into tetrahedra: what holds it in its plane is small beside the load, and so are errors.

    The bricks before the cut know the answer to 1 %.
    """
    bricks = box_file(tmp_path / "whole.msh", half=False, groups=GROUPS)
    given = meshio.read(bricks)
    points, hexahedra = given.points, given.cells_dict["hexahedron"].astype(np.int64)
    tets = MeshHex(points.T, hexahedra[:, [0, 3, 1, 4, 2, 7, 5, 6]].T).to_meshtet().t.T.copy()
    turned = np.linalg.det(points[tets[:, 1:]] - points[tets[:, :1]]) < 0.0
    tets[turned, :2] = tets[turned, 1::-1]
    lines = ["*Node", *(f"{k}, {x:.17g}, {y:.17g}, {z:.17g}" for k, (x, y, z) in enumerate(points, 1))]
    lines += ["*Element, type=C3D4H", *(f"{k}, " + ", ".join(map(str, cell + 1)) for k, cell in enumerate(tets, 1))]
    for name, (tag, _) in given.field_data.items():
        faces = given.cells_dict["quad"][given.cell_data_dict["gmsh:physical"]["quad"] == tag]
        lines += [f"*Nset, nset={name}", *(f"{node + 1}," for node in np.unique(faces))] if name != "free" else []
    path = tmp_path / "cut.inp"
    path.write_text("\n".join(lines))
    known, found = (block_pad(scene(each), 0.5).equilibrium(Wrench(F_z=4.0)) for each in (bricks, path))
    off = abs(found.pose.d_v - known.pose.d_v)
    assert off < found.error.d_v + known.error.d_v and found.error.d_v < 0.15 * (2.0 * MM - known.pose.d_v)


def flush(*more):
    """A pad of 8 x 8 mm under a target as large."""
    sides = [f'{part}.{side}="8 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    return load_sensor("biorob2018", ["target.load_height=0", *sides, NEO_HOOKEAN, *more])


def flush_file(path, tetrahedra, bonded=4.0):
    """Write half a pad of 8 x 8 x 2 mm under a target as large; in bricks, or each cut into tetrahedra [mm]."""
    x = 4.0 * np.array([0.0, 0.62, 1.0] if tetrahedra else [0.0, 5 / 9, 8 / 9, 1.0])
    bricks = MeshHex.init_tensor(np.concatenate([-x[:0:-1], x]), x, np.array([0.0, 0.6, 1.4, 2.0]))
    mesh = bricks.to_meshtet() if tetrahedra else bricks
    outer = mesh.boundary_facets()
    corner = mesh.p[:, mesh.facets[:, outer]]
    low, high = corner.min(axis=1), corner.max(axis=1)
    top = (low[2] > 2.0 - 1e-9) & (np.abs(corner[:2]).max(axis=(0, 1)) < bonded + 1e-9)
    kinds = np.select([high[2] < 1e-9, top, high[1] < 1e-9], [1, 2, 4], 3)
    cells = mesh.t.T.copy() if tetrahedra else mesh.t[[0, 1, 4, 2, 3, 5, 7, 6]].T
    if tetrahedra:
        sides = mesh.p.T[cells[:, 1:]] - mesh.p.T[cells[:, :1]]
        turned = np.linalg.det(sides) < 0.0
        cells[turned, :2] = cells[turned, 1::-1]
    names = ("triangle", "tetra") if tetrahedra else ("quad", "hexahedron")
    both = list(zip(names, (mesh.facets[:, outer].T, cells), strict=True))
    marks = [kinds, np.full(len(cells), 9)]
    found = meshio.Mesh(mesh.p.T * MM, both, cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks})
    found.field_data = {name: np.array([tag, 2]) for tag, name in enumerate((*GROUPS, "symmetry"), start=1)}
    meshio.write(path, found, file_format="gmsh22", binary=False)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("tetrahedra", [False, True])
def test_contact_is_that_of_the_models_own_mesh(tmp_path, tetrahedra):
    """A flush pad whose faces fold at 8 N: its pose within both errors."""
    mesh = f'elastomer.mesh="{flush_file(tmp_path / "flush.msh", tetrahedra)}"'
    own, found = (block_pad(flush(*keys)).equilibrium(Wrench(F_z=8.0)) for keys in ((), (mesh,)))
    assert found.pose.d_v == pytest.approx(own.pose.d_v, abs=own.error.d_v + found.error.d_v)
    assert any(note.kind is NoteKind.FACE_TOUCHES and note.known["surface"] == "target" for note in found.report.notes)


@pytest.mark.slow
def test_a_top_that_is_not_bonded_lies_on_the_target(tmp_path):
    """Of 8 x 8 mm under the target the middle is bonded; the rest is held by its plane, and is stiffer for it."""
    mesh = f'elastomer.mesh="{flush_file(tmp_path / "part.msh", False, 32 / 9)}"'
    pads = (block_pad(flush(mesh, f'elastomer.contact="{way}"')) for way in ("auto", "never"))
    held, free = (pad.equilibrium(Wrench(F_z=1.0)) for pad in pads)
    assert held.pose.d_v > free.pose.d_v
    assert any(note.kind is NoteKind.FACE_TOUCHES and note.known["surface"] == "target" for note in held.report.notes)
    assert not any(note.known.get("surface") == "sides" for note in held.report.notes)


@pytest.mark.slow
def test_contact_that_cannot_be_followed_is_worth_the_whole_displacement(tmp_path, monkeypatch):
    mesh = f'elastomer.mesh="{flush_file(tmp_path / "part.msh", True)}"'
    pad, on = block_pad(flush(mesh)), settle._on

    def without(line, numbers, *more):
        """Contact that never gets there."""
        found = on(line, range(settle.PAIR), *more)
        return found if numbers[0] < settle.PAIR else found._replace(part=0.0)

    monkeypatch.setattr(settle, "_on", without)
    found = pad.equilibrium(Wrench(F_z=8.0))
    assert found.report.estimated_error == 1.0 and found.error.d_v == pytest.approx(2.0 * MM - found.pose.d_v)
    assert any(note.kind is NoteKind.CONTACT_LOST for note in found.report.notes)


@pytest.mark.parametrize("tetrahedra", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_refined_pad_carries_the_state_of_the_first(tmp_path, tetrahedra):
    """Groups, bonds and rigid target are there: a rest carried over keeps its motion, and comes to rest from there."""
    if tetrahedra:
        sensor = flush(f'elastomer.mesh="{flush_file(tmp_path / "flush.msh", True)}"')
    else:
        sensor = scene(pieces_file(tmp_path / "one.msh", [([-4.0, 0.0, 4.0], [-4.0, 0.0, 4.0], [0.0, 2.0])]))
    family = meshed_family(sensor, 0.0, 0.1)
    first, finer, onto = family.coarse, family.fine, family.carrier(1)
    np.testing.assert_allclose(onto.displacements(first.mesh.nodes.ravel()), finer.mesh.nodes.ravel())
    assert len(finer.mesh.cells) == 8 * len(first.mesh.cells) and np.allclose(family.terms[1], [2.0**-1.2, 2.0**-2.4])
    load = np.array([0.3, 3.0, 0.1, 0.0, 0.0, 0.0])[: first.components]
    coarse = newton(first, rest(first), load).state
    carried = State(onto.displacements(coarse.u), coarse.q, onto.pressures(coarse.p), load)
    bonded = bonded_displacement(finer.X, coarse.q)
    np.testing.assert_allclose(carried.u[finer.bonded], bonded, atol=1e-12)
    fine = newton(finer, carried, load).state
    assert coarse.residual < 1e-9 and fine.residual < 1e-9 and fine.iterations <= 5


def test_a_users_mesh_may_touch_what_is_near_it(tmp_path):
    """Of the families of a mesh the last two have contact, less deep on finer levels."""
    sensor = scene(pieces_file(tmp_path / "one.msh", [([-4.0, 0.0, 4.0], [-4.0, 0.0, 4.0], [0.0, 2.0])]))
    families = meshes_in_line(sensor, 0.1, whole=True)
    assert [bool(families[number].coarse.parts) for number in range(4)] == [False, False, True, True]


EXAMPLES = {
    "dome": ({"diameter": 16 * MM, "thickness": 3 * MM}, {"shape": "disc", "diameter": 8 * MM}),
    "slotted": ({"width": 20 * MM, "length": 20 * MM, "thickness": 2 * MM}, {"width": 12 * MM, "length": 12 * MM}),
    "pillars": ({"width": 15 * MM, "length": 15 * MM, "thickness": 3 * MM}, {"width": 12 * MM, "length": 12 * MM}),
}

MARKS = dict.fromkeys(("dome", "slotted", "pillars"), pytest.mark.slow)


def example(name):
    """The scene of an example mesh."""
    pad, plate = EXAMPLES[name]
    base = load_sensor("biorob2018").model_dump(exclude_none=True)
    material = {"law": "neo-hookean", "shear_modulus": 3e4, "bulk_modulus": 3e7}
    base["elastomer"] = {**pad, "material": material, "mesh": str(MESHES / f"{name}.msh")}
    base["target"] = {"shape": "rectangle", "material": "copper", "thickness": 0.2 * MM, **plate}
    return sensor_from(base)


@pytest.mark.parametrize("name", [pytest.param(name, marks=MARKS.get(name, ())) for name in EXAMPLES])
def test_example_is_softer_than_the_box_around_it(name):
    """A pad cut out of a larger one is softer, by the energy; and the index knows its file."""
    sensor = example(name)
    stiffer, softer = (stiffness(on_mesh(sensor, constant=each)) for each in (False, True))
    plain = sensor.model_copy(update={"elastomer": sensor.elastomer.model_copy(update={"mesh": None})})
    assert np.all(stiffer < 1.1 * stiffness(bonded_block(plain, 2, 2.0, 0.0))) and np.all(softer < stiffer)
    assert hashlib.sha256((MESHES / f"{name}.msh").read_bytes()).hexdigest() in (MESHES / "README.md").read_text()


@pytest.mark.slow
def test_graded_tetrahedra_of_the_models_own_shape():
    """Quarter of a thickness at the edge: the mean of both answers within 1.5 % of NGSolve's, between them."""
    stiffer, softer = (stiffness(on_mesh(scene(MESHES / "box.msh"), constant=each)) for each in (False, True))
    assert np.all(softer < [KZ, 1.01 * KX]) and np.all(stiffer > [KZ, KX])
    np.testing.assert_allclose(2.0 / (1.0 / stiffer + 1.0 / softer), [KZ, KX], rtol=0.015)
    assert hashlib.sha256((MESHES / "box.msh").read_bytes()).hexdigest() in (MESHES / "README.md").read_text()


@pytest.mark.slow
def test_pressed_tetrahedra_sink_as_far_as_hexahedra():
    """13 N sink 0.09766 mm to 0.6 %: NGSolve and FElupe. Two layers of hexahedra are within 2 %, and own to more."""
    found = block_pad(scene(MESHES / "box.msh")).equilibrium(Wrench(F_z=13.0))
    sink = (2.0 * MM - found.pose.d_v) / MM
    assert sink == pytest.approx(0.09766, rel=0.02) and abs(sink - 0.09766) < found.error.d_v / MM


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_loaded_example(name):
    pad = block_pad(example(name))
    found = pad.equilibrium(Wrench(0.2, 1.0))
    back = pad.equilibrium(Wrench(-0.2, 1.0), start=found)
    assert found.report.estimated_error < 0.15 and found.report.min_J > 0.0  # of two meshes
    assert back.pose.d_h == pytest.approx(-found.pose.d_h, abs=2 * found.error.d_h)  # the mesh is not its mirror image


def test_recipe_makes_the_same_pads(tmp_path):
    pytest.importorskip("pygmsh")
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    if gmsh.__version__ != "4.15.2":
        pytest.skip("another gmsh makes other meshes")
    namespace = {"__name__": "pads", "__file__": str(MESHES / "pads.py")}
    exec(compile((MESHES / "pads.py").read_text(), "pads.py", "exec"), namespace)
    namespace["main"](tmp_path)
    for name in (*EXAMPLES, "box"):
        assert (tmp_path / f"{name}.msh").read_bytes() == (MESHES / f"{name}.msh").read_bytes()


def test_a_mesh_is_found_beside_its_scene(tmp_path, box):
    shutil.copy(box, tmp_path / "own.msh")
    text = scene_text(scene(box)).replace(str(box), "own.msh")
    (tmp_path / "scene.toml").write_text(text)
    sensor = load_sensor(tmp_path / "scene.toml")
    assert sensor.elastomer.mesh == str(tmp_path / "own.msh")
    assert choose_mechanics(sensor).name == "block"
    with pytest.raises(SceneError, match="without a mesh of its own for planar; got elastomer.mesh; block would$"):
        choose_mechanics(sensor, "planar")


def inside_out(points):
    """Push an inner node through its neighbours."""
    moved = points.copy()
    moved[0, np.argmin(np.abs(points - [[0], [4.5], [1.6]]).sum(axis=0))] += 6.0
    return moved


def rewritten(path, given, points, blocks, marks=None):
    """Write a mesh with the groups of another one."""
    marks = given.cell_data["gmsh:physical"] if marks is None else marks
    found = meshio.Mesh(points, blocks, cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks})
    found.field_data = given.field_data
    meshio.write(path, found, file_format="gmsh22", binary=False)
    return path


def cut(path):
    """Cut the mesh in a file in two along x = 0 by duplicated nodes; the new faces are in no group."""
    given = meshio.read(path)
    there = np.flatnonzero(np.abs(given.points[:, 0]) < 1e-9)
    copy = np.arange(len(given.points))
    copy[there] = len(copy) + np.arange(there.size)
    blocks = []
    for block in given.cells:
        right = given.points[block.data].mean(axis=1)[:, 0] > 0.0
        blocks.append((block.type, np.where(right[:, None], copy[block.data], block.data)))
    return rewritten(path, given, np.vstack([given.points, given.points[there]]), blocks)


def with_middles(path, given):
    """Write a mesh of tetrahedra with nodes at the middles of their edges, triangles as they are."""
    corners = given.cells_dict["tetra"]
    ends = np.sort(corners[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    points = np.vstack([given.points, given.points[edges].mean(axis=1)])
    cells = np.hstack([corners, len(given.points) + number.reshape(-1, 6)])
    marks = given.cell_data_dict["gmsh:physical"]
    blocks = [("triangle", given.cells_dict["triangle"]), ("tetra10", cells)]
    return rewritten(path, given, points, blocks, [marks["triangle"], marks["tetra"]])


def test_a_cut_pad_is_refused_with_where(tmp_path):
    """It is softer than the whole one: 509 instead of 379 um of shear, once answered without a word."""
    path = cut(box_file(tmp_path / "cut.msh"))
    said = r"cut by duplicated nodes; 20 faces .* \(18 nodes too many.* about \(0, "
    with pytest.raises(ValueError, match=said) as caught:
        block_pad(scene(path))
    assert str(path) in str(caught.value) and "--weld" in str(caught.value) and "\n" not in str(caught.value)


def test_a_welded_pad_is_the_whole_one_and_says_so(tmp_path, box):
    welded = scene(cut(box_file(tmp_path / "cut.msh")), "elastomer.weld=true")
    found, whole = (stiffness(on_mesh(sensor)) for sensor in (welded, scene(box)))
    np.testing.assert_allclose(found, whole, rtol=1e-9)
    merged = Note.of(NoteKind.NODES_MERGED, mesh=str(welded.elastomer.mesh), count=18)
    assert mesh_notes(welded) == (merged,)
    assert mesh_notes(scene(box)) == ()
    save_sensor(welded, tmp_path / "scene.toml")
    assert load_sensor(tmp_path / "scene.toml") == welded
    assert "weld" not in scene_text(scene(box))


def test_quadratic_tetrahedra_are_welded_as_well(tmp_path):
    """The nodes at the middles of the edges with those at their ends."""
    pads = []
    for path in (flush_file(tmp_path / "whole.msh", True), cut(flush_file(tmp_path / "cut.msh", True))):
        curved = with_middles(path.with_suffix(".10.msh"), meshio.read(path))
        pads.append(flush(f'elastomer.mesh="{curved}"', "elastomer.weld=true"))
    whole, welded = (stiffness(on_mesh(sensor)) for sensor in pads)
    np.testing.assert_allclose(welded, whole, rtol=1e-9)


@pytest.mark.slow
def test_faces_in_no_group_are_told(tmp_path, box):
    """They are free, as those that are named so; the answer says it."""
    given = meshio.read(box)
    marks = [each.copy() for each in given.cell_data["gmsh:physical"]]
    middle = given.points[given.cells_dict["quad"]].mean(axis=1) / MM
    marks[0][(middle[:, 0] < -9.9) & (middle[:, 1] < 4.0)] = 7
    sensor = scene(rewritten(tmp_path / "some.msh", given, given.points, given.cells, marks))
    found = block_pad(sensor).equilibrium(Wrench(F_z=1.0))
    (note,) = (each for each in found.report.notes if each.kind is NoteKind.FACES_FREE)
    assert note.known["mesh"].endswith("some.msh") and note.known["count"] == 2
    assert (note.known["x"], note.known["y"]) == pytest.approx((-10e-3, 2.25e-3), abs=5e-6)
    np.testing.assert_allclose(stiffness(on_mesh(sensor)), stiffness(on_mesh(scene(box))))


COLUMNS = [([-7.0, -3.0], [-7.0, 7.0], [0.0, 1.0, 2.0]), ([3.0, 7.0], [-7.0, 7.0], [0.0, 1.0, 2.0])]


def pieces_file(path, boxes, both=0):
    """Write a pad of boxes that do not touch, bonded at z = 0 and 2 mm; `both` faces of the target are free, too."""
    parts = [MeshHex.init_tensor(*(np.array(lines) for lines in box)) for box in boxes]
    mesh = parts[0] if len(parts) == 1 else sum(parts[1:], parts[0])
    outer = mesh.facets[:, mesh.boundary_facets()][[0, 1, 3, 2]].T
    z = mesh.p[2, outer]
    marks = np.select([z.max(axis=1) < 1e-9, z.min(axis=1) > 2.0 - 1e-9], [1, 2], 3)
    outer = np.vstack([outer, outer[marks == 2][:both]])
    marks = [np.append(marks, np.full(both, 3)), np.full(mesh.t.shape[1], 9)]
    blocks = [("quad", outer), ("hexahedron", mesh.t[[0, 1, 4, 2, 3, 5, 7, 6]].T)]
    given = meshio.Mesh([], [], field_data={name: np.array([k, 2]) for k, name in enumerate(GROUPS, start=1)})
    return rewritten(path, given, mesh.p.T * MM, blocks, marks)


def test_pieces_that_each_stand_between_ground_and_target_carry_together(tmp_path):
    """Two columns are twice as stiff as one."""
    one, two = (
        on_mesh(scene(pieces_file(tmp_path / f"{name}.msh", boxes)))
        for name, boxes in (("one", COLUMNS[:1]), ("two", COLUMNS))
    )
    sunk = [small_strain_compliance(own.body)[0] for own in (one, two)]
    k = [np.linalg.inv(each[:2, :2]) for each in sunk]
    assert k[1][0, 0] == pytest.approx(2.0 * np.linalg.inv(sunk[0])[0, 0], rel=0.3) and k[1][1, 1] > 1.9 * k[0][1, 1]


def mixed_file(path):
    """Write a hexahedron and a wedge beside it."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2],
                       [2, 0, 0], [2, 0, 2]]) * MM
    cells = [("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]]), ("wedge", [[1, 8, 2, 5, 9, 6]])]
    meshio.write(path, meshio.Mesh(points, cells), file_format="gmsh22", binary=False)
    return path


def lost_file(path):
    """Write a pad one face of whose group `target` lies above it."""
    given = meshio.read(pieces_file(path, COLUMNS))
    points, quads = given.points, given.cells_dict["quad"].copy()
    above = np.array([[0, 0, 3], [1, 0, 3], [1, 1, 3], [0, 1, 3]]) * MM
    quads = np.vstack([quads, len(points) + np.arange(4)])
    marks = given.cell_data_dict["gmsh:physical"]
    blocks = [("quad", quads), ("hexahedron", given.cells_dict["hexahedron"])]
    return rewritten(
        path, given, np.vstack([points, above]), blocks, [np.append(marks["quad"], 2), marks["hexahedron"]]
    )


FLAWED = {
    r"1 hexahedron, the first about \(0.5, 0.5, 1\) mm; 1 wedge, the first about \(1.333, 0.3333, 1\) mm": mixed_file,
    r"the group target must hold faces of cells; 1 of 3 are none, the first about \(0.5, 0.5, 3\) mm": lost_file,
    r"1 are in target and free, the first about \(-5, 0, 2\) mm": lambda path: pieces_file(path, COLUMNS, 1),
    r"1 of 3 pieces \(1 of 5 cells\) have no face in the group ground, the first about \(0, 0, 1.75\) mm": (
        lambda path: pieces_file(path, [*COLUMNS, ([-1.0, 1.0], [-1.0, 1.0], [1.5, 2.0])])
    ),
    r"1 of 3 pieces \(1 of 5 cells\) have no face in the group target, the first about \(0, 0, 0.25\) mm": (
        lambda path: pieces_file(path, [*COLUMNS, ([-1.0, 1.0], [-1.0, 1.0], [0.0, 0.5])])
    ),
}


@pytest.mark.parametrize("said", FLAWED)
def test_flaws_are_refused_with_where(tmp_path, said):
    path = FLAWED[said](tmp_path / "flawed.msh")
    with pytest.raises(ValueError, match=said) as caught:
        block_pad(scene(path))
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


REFUSED = {
    "must name groups": {"groups": ("ground", "free")},
    r"inside out; .* about \(": {"change": inside_out},
    "must lie at z = 2 mm .*, the file in metres": {"change": lambda points: points * [[1], [1], [0.5]]},
    "must lie under the target": {"size": 17.0},
    "must lie within the elastomer": {"change": lambda points: points * [[1.0], [1.5], [1.0]]},
    "symmetry must lie": {"change": lambda points: points * [[1.0], [0.9], [1.0]] + [[0.0], [0.5], [0.0]]},
}


@pytest.mark.parametrize("said", REFUSED)
def test_refusals(tmp_path, said):
    path = box_file(tmp_path / "bad.msh", **REFUSED[said])
    with pytest.raises(ValueError, match=said) as caught:
        block_pad(scene(path))
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_no_mesh_and_no_solid(tmp_path):
    (tmp_path / "text.msh").write_text("no mesh")
    for path, said in ((tmp_path / "none.msh", "meshio reads"), (tmp_path / "text.msh", "meshio reads"),
                       (MESHES / "cross.msh", "must hold cells")):
        with pytest.raises(ValueError, match=said):
            block_pad(scene(path))


def test_lines_are_where_they_were_put():
    assert box_bricks(np.array([0.0, 2.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0]))[0].p.max() == 2.0



@pytest.mark.slow
def test_quadratic_tetrahedra_with_straight_edges_are_the_linear_ones(tmp_path):
    with_middles(tmp_path / "dome10.msh", meshio.read(MESHES / "dome.msh"))
    plain = example("dome")
    pad = plain.elastomer.model_copy(update={"mesh": str(tmp_path / "dome10.msh")})
    found = stiffness(on_mesh(plain.model_copy(update={"elastomer": pad})))
    np.testing.assert_allclose(found, stiffness(on_mesh(plain)), rtol=1e-9)


def test_bricks_of_27_nodes_are_those_of_eight_where_they_are_straight(tmp_path, box):
    given = meshio.read(box)
    solid = to_meshio(MeshHex2.from_mesh(read_solid(box, GROUPS).mesh), encode_cell_data=False)
    cells = solid.cells_dict["hexahedron27"]
    place = cKDTree(solid.points).query(given.points)[1]
    marks = given.cell_data_dict["gmsh:physical"]
    marks = [marks["quad"], marks["hexahedron"]]
    blocks = [("quad", place[given.cells_dict["quad"]]), ("hexahedron27", cells)]
    finer = meshio.Mesh(solid.points, blocks, cell_data={"gmsh:physical": marks, "gmsh:geometrical": marks})
    finer.field_data = given.field_data
    meshio.write(tmp_path / "box27.msh", finer, file_format="gmsh22", binary=False)
    plain = stiffness(on_mesh(scene(box)))
    np.testing.assert_allclose(stiffness(on_mesh(scene(tmp_path / "box27.msh"))), plain, rtol=1e-9)


@pytest.mark.slow
def test_a_mesh_in_its_own_sizes_is_differentiated_by_its_silicone_alone(box):
    """By the modulus, against differences; its sizes are refused by name."""
    sensor, load = scene(box), Wrench(F_x=0.2, F_z=2.0)
    pad = block_pad(sensor, 0.1).rough
    found = pad.equilibrium(load)
    slope = pad.slopes(found, [parameter(sensor, "modulus")]).pose[:, 0]
    one, other = (
        block_pad(parameter(sensor, "modulus").changed(way), 0.1).rough.equilibrium(load).pose.components
        for way in (1e-3, -1e-3)
    )
    np.testing.assert_allclose(slope, (one - other) / 2e-3, atol=1e-4 * np.max(np.abs(slope)))
    with pytest.raises(SceneError, match=r"elastomer\.thickness: must be a number that can be changed a little"):
        pad.slopes(found, [parameter(sensor, "elastomer.thickness")])
