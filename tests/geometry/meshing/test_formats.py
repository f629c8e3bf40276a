"""Meshes as other programs write them: elements, orders of nodes and names of faces, in each format."""

from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import meshio
import numpy as np
import pytest

from sits_mech.geometry.meshing.formats import read_named
from sits_mech.geometry.meshing.store import read_solid
from sits_mech.units import SceneError

gmsh = pytest.importorskip("gmsh")
W, L, T = 12e-3, 10e-3, 3e-3
KINDS = ("tet4", "tet10", "hex8", "hex20", "hex27", "prism6")
WAYS = ("gmsh .msh", "gmsh .msh 2.2", "gmsh .inp", "gmsh .med", "meshio .inp", "meshio .xdmf", "meshio .vtu",
        "meshio .vtk", "gmsh .mesh", "gmsh .su2", "gmsh .bdf", "gmsh .unv")
SIDES = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7))  # of Exodus' hexahedra
PAGE = Path(__file__).parents[3] / "docs" / "howto" / "own_mesh.md"


def written(kind: str, folder: Path) -> None:
    """A box with named faces by gmsh, as it numbers nodes."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    if kind.startswith("tet"):
        solid = occ.addBox(-W / 2, -L / 2, 0, W, L, T)
    else:
        bottom = occ.addRectangle(-W / 2, -L / 2, 0, W, L)
        occ.synchronize()
        for _, curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve, 4)
        gmsh.model.mesh.setTransfiniteSurface(bottom)
        if kind.startswith("hex"):
            gmsh.model.mesh.setRecombine(2, bottom)
        solid = next(tag for dim, tag in occ.extrude([(2, bottom)], 0, 0, T, [2], recombine=True) if dim == 3)
    occ.synchronize()
    groups: dict[str, list[int]] = {"ground": [], "target": [], "free": []}
    for _, face in gmsh.model.getBoundary([(3, solid)], oriented=False):
        z = occ.getCenterOfMass(2, face)[2]
        groups["ground" if z < 1e-9 else "target" if z > T - 1e-9 else "free"].append(face)
    for name, faces in groups.items():
        gmsh.model.addPhysicalGroup(2, faces, name=name)
    gmsh.model.addPhysicalGroup(3, [solid], name="pad")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 4e-3)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", kind == "hex20")
    gmsh.model.mesh.generate(3)
    if kind in ("tet10", "hex20", "hex27"):
        gmsh.model.mesh.setOrder(2)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    for suffix in ("msh", "inp", "med", "mesh", "su2", "bdf", "unv"):
        gmsh.write(str(folder / f"{kind}.{suffix}"))
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write(str(folder / f"{kind}_22.msh"))
    gmsh.finalize()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All kinds by gmsh, and by meshio what it makes of them."""
    made = tmp_path_factory.mktemp("formats")
    for kind in KINDS:
        written(kind, made)
        own = meshio.read(made / f"{kind}.msh")
        sets = {name: parts for name, parts in own.cell_sets.items() if not name.startswith("gmsh:")}
        for suffix in ("inp", "xdmf", "vtu", "vtk"):
            cells = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in own.cells]
            mesh = meshio.Mesh(own.points, cells, cell_sets=sets)
            if suffix != "inp":
                mesh.cell_sets_to_data()
            if suffix != "xdmf" or find_spec("h5py"):
                with suppress(KeyError):  # of a kind that meshio has no word for
                    mesh.write(made / f"{kind}_m.{suffix}")
    return made


def found(kind: str, way: str, folder: Path) -> str:
    """What comes of a format: "names", "none", or "-" where it is not written or not read; names hold their areas."""
    program, suffix, *version = way.split()
    path = folder / f"{kind}{'_m' if program == 'meshio' else '_22' if version else ''}{suffix}"
    if not path.exists():
        return "-"
    try:
        mesh = read_solid(path, ("ground", "target"))[0]
    except ValueError as error:
        assert "\n" not in str(error) and path.name in str(error)
        return "none" if "names are kept in" in str(error) else "-"
    for name in ("ground", "target"):
        corners = mesh.p[:, mesh.facets[:, mesh.boundaries[name]]]
        sides = [corners[:, k] - corners[:, k - 2] for k in range(len(mesh.facets))]
        cross = np.cross(sides[-1], sides[-2], axis=0) / 2.0
        assert np.linalg.norm(cross, axis=0).sum() == pytest.approx(W * L, rel=1e-6)
    points, weights = np.full((3, 1), 0.25 if len(mesh.t) == 4 else 0.5), 1 / 6 if len(mesh.t) == 4 else 1.0
    volume = np.abs(mesh.mapping().detDF(points)).sum() * weights
    assert volume == pytest.approx(W * L * T, rel=1e-6)
    return "names"


def test_the_table_of_formats_is_the_page_s(folder: Path) -> None:
    """Every format by every element; what is read has the volume and the faces' areas."""
    there = [way for way in WAYS if find_spec("h5py") or way.split()[1] not in (".med", ".xdmf")]
    rows = [f"| {way} | {' | '.join(found(kind, way, folder) for kind in KINDS)} |" for way in there]
    page = PAGE.read_text()
    assert f"| written by | {' | '.join(KINDS)} |" in page and [row for row in rows if row not in page] == []


def test_the_order_of_nodes_does_not_matter(folder: Path, tmp_path: Path) -> None:
    """Neither which numbers they have nor in which order the middles of edges stand."""
    given, rng = meshio.read(folder / "tet10.msh"), np.random.default_rng(1)
    number = rng.permutation(len(given.points))
    points = np.empty_like(given.points)
    points[number] = given.points
    cells = [(block.type, number[np.asarray(block.data, dtype=np.int64)]) for block in given.cells]
    cells = [(kind, own[:, [0, 1, 2, 3, 7, 5, 4, 9, 8, 6]] if kind == "tetra10" else own) for kind, own in cells]
    sets = {name: parts for name, parts in given.cell_sets.items() if not name.startswith("gmsh:")}
    mesh = meshio.Mesh(points, cells, cell_sets=sets)
    mesh.cell_sets_to_data()
    mesh.write(tmp_path / "other.vtu")
    one, other = (read_solid(path, ("ground",))[0] for path in (folder / "tet10.msh", tmp_path / "other.vtu"))
    assert np.linalg.det(one.mapping().DF(np.full((3, 1), 0.25))[..., 0].transpose(2, 0, 1)) == pytest.approx(
        np.linalg.det(other.mapping().DF(np.full((3, 1), 0.25))[..., 0].transpose(2, 0, 1)), rel=1e-9)
    assert len(one.boundaries["ground"]) == len(other.boundaries["ground"])


def test_sets_that_hide_each_other_keep_their_faces(folder: Path, tmp_path: Path) -> None:
    """Gmsh's own sets take some faces from the names in meshio's numbers; those of one physical number are one face."""
    mesh = meshio.read(folder / "tet4.msh")
    mesh.cell_sets_to_data()
    mesh.write(tmp_path / "hidden.vtu")
    own, other = (read_named(path).faces for path in (folder / "tet4.msh", tmp_path / "hidden.vtu"))
    assert {name: sum(map(len, own[name])) for name in ("ground", "target", "free")} == {
        name: sum(map(len, other[name])) for name in ("ground", "target", "free")}


def test_side_sets_of_exodus(folder: Path, tmp_path: Path) -> None:
    """Faces by element and side, which meshio leaves out; the first block of cells in space counts."""
    netcdf = pytest.importorskip("netCDF4")
    given = meshio.read(folder / "hex8.msh")
    cells = np.vstack([block.data for block in given.cells if block.type == "hexahedron"]).astype(np.int64)
    meshio.Mesh(given.points, [("hexahedron", cells)]).write(tmp_path / "box.e")
    z = given.points[cells][:, :, 2]
    with netcdf.Dataset(tmp_path / "box.e", "a") as file:
        file.createDimension("num_side_sets", 2)
        file.createDimension("len_name", 33)
        file.createVariable("ss_names", "S1", ("num_side_sets", "len_name"))
        for k, (name, height) in enumerate((("ground", 0.0), ("target", T)), 1):
            faces = [(cell, side) for side, own in enumerate(SIDES, 1) for cell in np.flatnonzero(
                np.abs(z[:, list(own)] - height).max(axis=1) < 1e-9) + 1]
            file.createDimension(f"num_side_ss{k}", len(faces))
            for column, start in enumerate(("elem", "side")):
                file.createVariable(f"{start}_ss{k}", "i4", (f"num_side_ss{k}",))[:] = [face[column] for face in faces]
            file["ss_names"][k - 1] = np.array(list(name.ljust(33, "\0")), dtype="S1")
    mesh = read_solid(tmp_path / "box.e", ("ground", "target"))[0]
    assert len(mesh.boundaries["ground"]) == len(mesh.boundaries["target"]) == 9


@pytest.mark.parametrize("suffix", ["msh", "inp", "vtu", "med", "e", "bdf", "avs", "xdmf", "cgns"])
def test_damaged_files_are_one_line(suffix: str, folder: Path, tmp_path: Path) -> None:
    """Cut off, with letters for numbers, empty, or with nothing of a mesh."""
    source = folder / f"tet4.{suffix}"
    whole = source.read_bytes() if source.exists() else b"mesh 1 2 3\n" * 50
    rng = np.random.default_rng(0)
    for k in range(8):
        damaged = bytearray(whole[: int(len(whole) * rng.random())] if k % 2 else whole)
        for place in rng.integers(0, max(len(damaged), 1), 4 * (k > 1) * bool(damaged)):
            damaged[place] = rng.integers(33, 126)
        path = tmp_path / f"damaged.{suffix}"
        path.write_bytes(b"" if k == 1 else damaged)
        try:
            read_solid(path, ("ground", "target"))
        except ValueError as error:
            assert "\n" not in str(error) and "damaged" in str(error)
    with pytest.raises(SceneError, match=r"none\.\w+: must be a"):
        read_named(tmp_path / f"none.{suffix}")
