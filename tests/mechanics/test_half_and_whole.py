"""Half a pad is the whole one reduced by its symmetry: same states, same stiffness, and what the symmetry hides."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import MeshHex

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.newton import smallest_eigenvalue, target_stiffness
from sits_mech.mechanics.equilibrium.outcome import Path
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def flush(*more):
    """A pad of 8 x 8 x 2 mm under a target as large: its free faces fold onto both planes at 8 N."""
    sides = [f'{part}.{side}="8 mm"' for part in ("target", "elastomer") for side in ("width", "length")]
    return load_sensor("biorob2018", [*sides, NEO_HOOKEAN, *more])


NARROW = [
    'target.width="30 mm"', 'target.length="6 mm"', 'elastomer.width="30 mm"', 'elastomer.length="6 mm"',
    'elastomer.thickness="10 mm"',
]
WIDE = ('target.width="15 mm"', 'target.length="15 mm"', NEO_HOOKEAN)
LOADS = {False: np.array([10.0, 50.0, 4.0]), True: np.array([1.0, 60.0, 0.3])}  # on the whole pad, scaled


@pytest.fixture(
    scope="module", params=[pytest.param(False, id="free"), pytest.param(True, id="contact", marks=pytest.mark.slow)]
)
def both(request):
    """Half a pad and the whole on its mirrored mesh, sheared, pressed and turned, each with its state at rest."""
    touching = request.param
    sensor, found = flush() if touching else load_sensor("biorob2018", WIDE), []
    for whole, share in ((False, 0.5), (True, 1.0)):
        body = bonded_block(sensor, 2 if touching else 1, 2.0, 0.0, 1e-2 if touching else 0.0, whole=whole).body
        load = share * np.append(LOADS[touching], np.zeros(3 * whole))
        end = advance(body, rest(body), Path((0.0 * load, load)))
        assert end.reached == 1.0
        found.append((body, end.state))
    half, state = found[0]
    assert sum(part(state.u, state.q).energy > 1e-4 for part in half.parts) == (2 if touching else 0)
    return found


def test_half_and_whole_rest_alike_on_the_mirrored_mesh(both):
    """All nodes of both halves, and the target: to 1e-6 of its displacement."""
    (half, one), (whole, two) = both
    size = np.abs(one.q).max()
    np.testing.assert_allclose(two.q, np.append(one.q, np.zeros(3)), atol=1e-6 * size)
    flip = np.array([1.0, -1.0, 1.0])
    u = two.u.reshape(-1, 3)
    for way in (np.ones(3), flip):
        apart, number = cKDTree(whole.mesh.nodes * way).query(half.mesh.nodes)
        assert apart.max() < 1e-9
        np.testing.assert_allclose(u[number] * way, one.u.reshape(-1, 3), atol=1e-6 * size)


def test_an_answer_without_a_state_is_no_start():
    """That of a formula, or an image: a load out of the plane goes from rest, as one in the plane does."""
    pad, load = block_pad(load_sensor("biorob2018", WIDE), 0.5).rough, Wrench(F_y=0.01)
    found = pad.equilibrium(load)
    assert pad.equilibrium(load, start=replace(found, state=np.zeros(0))).pose == found.pose


def test_hidden_stiffness_is_that_of_the_whole_pad(both):
    (half, one), (whole, two) = both
    own, hidden = target_stiffness(half, one)
    every, nothing = target_stiffness(whole, two)
    assert nothing is None
    size = 0.5 * np.abs(every).max()
    np.testing.assert_allclose(own, 0.5 * every[:3, :3], rtol=1e-6, atol=1e-6 * size)
    np.testing.assert_allclose(hidden, 0.5 * every[3:, 3:], rtol=1e-6, atol=1e-6 * size)
    np.testing.assert_allclose(every[:3, 3:], 0.0, atol=1e-6 * size)
    np.testing.assert_allclose(every[3:, :3], 0.0, atol=1e-6 * size)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensor", "load"),
    [
        (load_sensor("biorob2018", WIDE), (1.2, 6.0, 2e-3)),
        (flush(), (0.1, 8.0)),
    ],
    ids=["free", "sheared-contact"],
)
def test_a_force_of_no_size_along_y_changes_nothing(sensor, load):
    """The pose to 1e-6 of the displacement, its error and notes; an angle counts at the target's end."""
    pad, lever = block_pad(sensor), max(sensor.target.extent) / 2
    half, whole = pad.equilibrium(Wrench(*load)), pad.equilibrium(Wrench(*load, F_y=1e-9))
    ends = np.array([1.0, 1.0, lever, 1.0, lever, lever])
    away = half.pose.components - [0.0, 2.0 * MM, 0.0, 0.0, 0.0, 0.0]
    size = np.max(np.abs(away * ends))
    assert whole.state.size > half.state.size
    assert np.max(np.abs((whole.pose.components - half.pose.components) * ends)) < 1e-6 * size
    assert np.max(np.abs((whole.error.components - half.error.components) * ends)[:3]) < 1e-6 * size
    for own, other in zip(whole.report.notes, half.report.notes, strict=True):
        assert own.kind == other.kind and own.known.keys() == other.known.keys()
        for name, value in other.known.items():
            assert own.known[name] == (pytest.approx(value, rel=1e-6) if isinstance(value, float) else value)
    assert any(note.known.get("friction") == 0.0 for note in half.report.notes) == (load[1] == 8.0)


PUSHES = Wrench(F_z=2.0), Wrench(F_z=2.0, F_y=1e-6), Wrench(1e-6, 2.0, 1e-9, -1e-6, 2e-9, 1e-9)


@pytest.fixture(scope="module")
def fallen():
    """What ends a pad 6 mm long and 10 mm high under 2 N, with pushes of no size aside and without."""
    sizes = [f"{part}.{side}" for part in ("target", "elastomer") for side in ('width="30 mm"', 'length="6 mm"')]
    pad, found = block_pad(load_sensor("biorob2018", [*sizes, 'elastomer.thickness="10 mm"'])), []
    for wrench in PUSHES:
        with pytest.raises(SolveFailed, match="buckles") as caught:
            pad.equilibrium(wrench)
        found.append(caught.value)
    return pad, found


@pytest.mark.slow
def test_half_a_pad_sees_that_it_falls_sideways(fallen):
    """It does so at 0.875 N, found to the smallest increment of the path, 1 % of it or up to four."""
    _, ended = fallen
    half, *whole = (each.last.wrench.F_z for each in ended)
    assert half == pytest.approx(0.875, abs=0.08)
    assert whole == pytest.approx([half, half], rel=0.03)
    for each in ended:
        assert any(note.known.get("end") in ("buckled", "sideways") for note in each.report.notes)
        assert abs(each.last.pose.d_h) < 1e-5 * MM and each.last.report.min_J > 0.9


@pytest.mark.slow
def test_it_is_only_what_the_symmetry_hides_that_gives_way(fallen):
    """Along x the pad is 30 mm long: half of it, without a look aside, carries the load."""
    sensor = fallen[0].sensor
    body = bonded_block(sensor, 1, 2.0, 0.0).body
    state = rest(body)
    scale = sensor.elastomer.silicone.shear_modulus * sensor.elastomer.thickness**2
    for F_z in (0.6, 1.2):
        load = np.array([0.0, 0.5 * F_z / scale, 0.0])
        found = advance(replace(body, hidden=None), state, Path((state.load, load)))
        assert found.reached == 1.0
        state = found.state
        own, hidden = target_stiffness(body, state)
        assert smallest_eigenvalue(own) > 0.0 and (smallest_eigenvalue(hidden) > 0.0) == (F_z < 0.8)


def test_the_components_in_the_plane_come_first(fallen):
    """A load that leaves the plane ends where its part in the plane ends; a state to go on from is there."""
    (pad, ended), asked = fallen, PUSHES[2]
    last, message = ended[2].last, str(ended[2])
    part = last.wrench.F_z / asked.F_z
    assert 0.0 < part < 1.0 and f"({part:.1%} of the path)" in message
    np.testing.assert_allclose(last.wrench.components, part * np.append(asked.components[:3], np.zeros(3)), rtol=1e-9)
    for name, value in vars(asked).items():
        assert f"{name} = {value:.6g} N" in message
    again = pad.equilibrium(last.wrench, start=last)
    away = np.abs(again.pose.components - last.pose.components)  # the last one of a path that ends is of two meshes
    assert np.all(away <= last.error.components + again.error.components)


@pytest.mark.slow
def test_a_path_that_failed_carries_all_six_components():
    """Sheared aside and twisted, more than a law that softens carries: the wrench and the pose there."""
    softens = 'elastomer.material={law="yeoh", c10=1.5e4, c20=-3e3, c30=0.0, bulk_modulus=3e7}'
    pad = block_pad(load_sensor("biorob2018", [*NARROW, softens, 'elastomer.contact="never"']), 1e-2)
    with pytest.raises(SolveFailed, match="could be followed to") as caught:
        pad.equilibrium(Wrench(0.01, 0.1, 1e-5, 10.0, 1e-4, 1e-4))
    last = caught.value.last
    assert 0.0 < last.wrench.F_y < 10.0 and 0.0 < last.wrench.F_z < 0.1 + 1e-9
    assert np.all(last.pose.components != 0.0) and np.all(last.error.components > 0.0)


@pytest.mark.slow
def test_a_whole_mesh_of_the_users_must_not_fall_sideways_either(tmp_path):
    """Loads in the plane keep it there; a push out of it is answered all the same."""
    lines = np.linspace(-15, 15, 7), np.linspace(-3, 3, 5), np.linspace(0, 10, 6)
    mesh = MeshHex.init_tensor(*lines)
    low, high = (pick(mesh.p[:, mesh.facets], axis=1) for pick in (np.min, np.max))
    outer = mesh.f2t[1] == -1
    kinds = np.select([high[2] < 1e-9, low[2] > 10 - 1e-9], [1, 2], 3)[outer]
    cells = [("quad", mesh.facets[[0, 1, 3, 2]][:, outer].T), ("hexahedron", mesh.t[[0, 1, 4, 2, 3, 5, 7, 6]].T)]
    marks = [kinds, np.full(mesh.t.shape[1], 9)]
    data = {"gmsh:physical": marks, "gmsh:geometrical": marks}
    file = meshio.Mesh(mesh.p.T * 1e-3, cells, cell_data=data)
    file.field_data.update({name: np.array([tag, 2]) for tag, name in enumerate(("ground", "target", "free"), 1)})
    meshio.write(tmp_path / "narrow.msh", file, file_format="gmsh22", binary=False)
    pad = block_pad(load_sensor("biorob2018", [*NARROW, f'elastomer.mesh="{tmp_path / "narrow.msh"}"']), 1e-2)
    with pytest.raises(SolveFailed, match="buckles") as caught:
        pad.equilibrium(Wrench(F_z=2.0))
    assert caught.value.last.wrench.F_z == pytest.approx(0.8, abs=0.1)


def test_a_target_that_is_held_upright_does_not_fall_sideways():
    """Where six parts of a base cell, extrapolated, hold it at 8.49419 mm."""
    found = block_pad(load_sensor("biorob2018", NARROW), 1e-2).controlled(
        Control(F_z=2.0, d_y=0.0, alpha_x=0.0, alpha_z=0.0)
    )
    assert found.report.status == "converged" and found.report.estimated_error < 1e-2
    assert abs(found.pose.d_v - 8.49419e-3) < found.error.d_v < 1e-2 * (10e-3 - found.pose.d_v)
