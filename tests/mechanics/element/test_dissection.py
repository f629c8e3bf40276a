"""Orders of elimination: every displacement once, and nothing of one half ever meets the other."""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from sits_mech.mechanics.element.assembly import pattern
from sits_mech.mechanics.element.dissection import _cut, dissected
from sits_mech.mechanics.element.mesh import BRICK, TETRAHEDRON, solid_mesh
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.scene.sensor import Elastomer, load_sensor

LINES = np.linspace(0.0, 3.0, 7), np.linspace(0.0, 2.0, 5), np.linspace(0.0, 1.0, 4)


def box():
    """A body of bricks in contact, on half a pad."""
    return bonded_block(load_sensor("biorob2018-w15"), 2, 2.5, 0.0, 1e-2).body.pattern


def ring():
    """The same of a cylinder."""
    sensor = load_sensor("biorob2018-w15")
    layer = {"diameter": 20e-3, "thickness": 2e-3, "material": sensor.elastomer.material}
    sensor = sensor.model_copy(update={"elastomer": Elastomer.model_validate(layer)})
    return bonded_block(sensor, 2, 2.5, 0.0).body.pattern


def fan():
    """A section with split cells at its corners, guard and contact."""
    return bonded_body(load_sensor("biorob2018"), SectionFineness(4, 1.5, fan=True, guard=0.5, depth=1e-3)).pattern


def tetrahedra():
    """A box of tetrahedra, on the ground, with a part that joins two of its far corners."""
    mesh = solid_mesh(MeshTet.init_tensor(*LINES), TETRAHEDRON)[0]
    n = mesh.nodes.size
    ends = [int(np.argmin(mesh.nodes.sum(axis=1))), int(np.argmax(mesh.nodes.sum(axis=1)))]
    joined = np.array([[3 * end + k for end in ends for k in range(3)]])
    free = np.flatnonzero(np.repeat(mesh.nodes[:, 2] > 0.0, 3) | np.isin(np.arange(n), joined))
    return pattern(mesh, (mesh.dofs, joined), free, np.arange(n, n + 6))


@pytest.fixture(scope="module", params=[box, ring, fan, tetrahedra])
def found(request):
    return request.param()


def test_each_displacement_is_eliminated_once_and_the_border_later(found):
    m, fronts = len(found.free), found.dissection.fronts
    np.testing.assert_array_equal(np.sort(found.dissection.order), np.arange(m))
    pivots = [np.arange(front.start, front.stop) for front in fronts]
    np.testing.assert_array_equal(np.concatenate(pivots), np.arange(m))
    assert all(np.all(front.border >= front.stop) for front in fronts)
    assert len(fronts[-1].border) == 0


def test_each_stiffness_is_taken_up_once_where_all_its_displacements_are(found):
    place = np.full(found.free.max() + 1, -1)
    place[found.free[found.dissection.order]] = np.arange(len(found.free))
    taken = [np.zeros(len(numbers), dtype=int) for numbers in found.numbers]
    for front in found.dissection.fronts:
        rows = np.concatenate([np.arange(front.start, front.stop), front.border, [-1]])
        for share in front.shares:
            taken[share.group][share.members] += 1
            numbers = found.numbers[share.group][share.members]
            there = np.where(numbers < len(place), place[np.minimum(numbers, len(place) - 1)], -1)
            np.testing.assert_array_equal(rows[share.places], there)
    assert all(np.all(count == 1) for count in taken)


def test_each_half_finds_its_border_in_the_whole(found):
    fronts, halves = found.dissection.fronts, []
    for front in fronts:
        rows = np.concatenate([np.arange(front.start, front.stop), front.border])
        for half in front.halves:
            halves.append(half.front)
            border = fronts[half.front].border
            runs = [(begin, end, rows[at : at + end - begin]) for begin, end, at in half.runs]
            np.testing.assert_array_equal(np.concatenate([border[begin:end] for begin, end, _ in runs]), border)
            np.testing.assert_array_equal(np.concatenate([own for *_, own in runs]), border)
            at = np.array([[at, at + end - begin] for begin, end, at in half.runs])
            assert not np.any((at[:, 0] < front.pivots) & (at[:, 1] > front.pivots))
    assert sorted(halves) == list(range(len(fronts) - 1))


def test_a_slab_is_cut_across_its_shorter_side():
    """The last front of a slab of 24 x 8 x 2 bricks is one layer of nodes, 17 x 5 of them."""
    mesh = solid_mesh(MeshHex.init_tensor(*(np.arange(n + 1.0) for n in (24, 8, 2))), BRICK)[0]
    assert dissected(mesh, (mesh.dofs,), mesh.nodes.size).fronts[-1].pivots == 3 * 17 * 5


def test_irregular_meshes_are_not_peeled_one_element_after_another() -> None:
    """A cut that shares nothing, but leaves one of a thousand elements, would make a tree of a thousand levels."""
    cells = np.column_stack([np.arange(1000), np.arange(1, 1001)])
    weight = np.full(1001, 300.0)
    weight[1] = 0.0  # shared by elements 0 and 1 alone, and cut already
    found = _cut(cells, np.arange(1000.0)[None], weight)
    assert found is not None and min(found[0].sum(), (~found[0]).sum()) >= 1000 / 32
