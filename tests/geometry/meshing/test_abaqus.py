"""Input files of Abaqus: parts in their places, sets and surfaces, hybrid elements; damaged ones in one line."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.geometry.meshing.formats import read_named
from sits_mech.units import SceneError

CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
PART = "\n".join(["*Heading", "** a comment", "*Part, name=Pad", "*Node"] + [
    f"{10 * k}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(CUBE, 1)
] + ["*ELEMENT, TYPE=C3D8H, ELSET=All", "7, 10, 20, 30, 40,", "50, 60, 70, 80"])
GROUND = {(0, 1, 2, 3)}


def faces(text: str, folder: Path) -> tuple[np.ndarray, dict[str, set[tuple[int, ...]]], dict[str, list[int]]]:
    """Points, corners of the faces of each name, sorted, and nodes of each set."""
    path = folder / "pad.inp"
    path.write_text(text)
    found = read_named(path)
    blocks = {name: [face for block in own for face in block.tolist()] for name, own in found.faces.items()}
    named = {name: {tuple(sorted(face)) for face in own} for name, own in blocks.items()}
    return found.points, named, {name: own.tolist() for name, own in found.nodes.items()}


def test_hybrid_elements_sets_and_surfaces(tmp_path: Path) -> None:
    """C3D8H is a hexahedron whose row goes on; surfaces by sets and by elements, sets by steps and by others."""
    text = f"""{PART}
*Nset, nset=Ground, generate
10, 40, 10
*Nset, nset=both
ground, 50
*Elset, elset=_top_S2
7
*Surface, type=ELEMENT, name=Target
_top_S2, S2
*Surface, name=side
7, S3
*End Part
"""
    points, named, nodes = faces(text, tmp_path)
    assert points.tolist() == [list(map(float, corner)) for corner in CUBE]
    assert named == {"target": {(4, 5, 6, 7)}, "side": {(0, 1, 4, 5)}}
    assert nodes == {"ground": [0, 1, 2, 3], "both": [0, 1, 2, 3, 4]}


def test_parts_stand_where_their_instances_are(tmp_path: Path) -> None:
    """Shifted by 2 along x, then turned by 90 degrees about z; sets of the assembly speak of the part's nodes."""
    text = f"""{PART}
*End Part
*Assembly, name=A
*Instance, name=Pad-1, part=Pad
2., 0., 0.
0., 0., 0., 0., 0., 1., 90.
*End Instance
*Nset, nset=GROUND, instance=Pad-1
10, 20, 30, 40
*Elset, elset=_e, instance=Pad-1
7
*Surface, type=ELEMENT, name=target
_e, S2
*End Assembly
"""
    points, named, nodes = faces(text, tmp_path)
    np.testing.assert_allclose(points, [(-y, x + 2.0, z) for x, y, z in CUBE], atol=1e-12)
    assert named == {"target": {(4, 5, 6, 7)}} and nodes == {"ground": [0, 1, 2, 3]}


def test_sets_of_shells_name_faces(tmp_path: Path) -> None:
    """As gmsh writes them: elements CPS4 in sets."""
    _, named, _ = faces(f"{PART}\n*ELEMENT, type=CPS4, ELSET=ground\n8, 10, 20, 30, 40\n", tmp_path)
    assert named == {"ground": GROUND}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PART.replace("C3D8H", "C3D13"), r"line 13: must be a block \*element of Abaqus; got ValueError type C3D13"),
        (PART.replace("50, 60, 70, 80", "50, 60, 70"), r"line 13: must be a block \*element"),
        (PART.replace("50, 60, 70, 80", "50, 60, 70, 90"), "elements must be of nodes of the file; got node 90"),
        (f"{PART}\n*Surface, name=top\nall, S9\n", r"must name sides S1 to S6 of a hexahedron; got S9 of 7"),
        (f"{PART}\n*Surface, name=top\n7, S0\n", r"must name sides S1 to S6 of a hexahedron; got S0 of 7"),
        (PART.replace("0, 1, 1", "0, one, 1"), r"line 4: must be a block \*node of Abaqus; got ValueError could not"),
    ],
)
def test_what_is_damaged_is_one_line(text: str, words: str, tmp_path: Path) -> None:
    """With the line of the block."""
    with pytest.raises(SceneError, match=words) as caught:
        faces(text, tmp_path)
    assert "\n" not in str(caught.value)
