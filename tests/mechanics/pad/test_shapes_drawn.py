"""Wide targets and pillars against meshes of the user's own, drawn by gmsh in tetrahedra."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor

MESHES = Path(__file__).parents[3] / "meshes"
PILLARS = ('elastomer.shape="pillars"', 'elastomer.pitch="2.5 mm"', 'elastomer.diameter="1.5 mm"')
REST = np.array([0.0, 2e-3, 0.0])


def scene(target, pad, *more):
    """Target and pad 2 mm thick of given sizes [mm], a number for what is round; the force acts at the bonded face."""
    plate, layer = (
        f'diameter="{size} mm"' if isinstance(size, int) else f'width="{size[0]} mm", length="{size[1]} mm"'
        for size in (target, pad)
    )
    shape = "disc" if isinstance(target, int) else "rectangle"
    law = 'law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7'
    return load_sensor("biorob2018", [
        f'target={{material="copper", shape="{shape}", {plate}, thickness="0.2 mm", load_height="0 mm"}}',
        f'elastomer={{material={{{law}}}, thickness="2 mm", {layer}}}', *more,
    ])


def edge(x, y, z, rim):
    """Sizes of tetrahedra [mm]: a fifth of the thickness at bonded edges, at a place `rim` within a side of the pad."""
    return min(1.6, 0.4 + 0.5 * float(np.hypot(rim, min(z, 2.0 - z))))


def box(geometry):
    """Half of 8 x 8 x 2 mm."""
    geometry.add_box([-4, 0, 0], [8, 4, 2])
    return lambda dim, tag, x, y, z, *_: edge(x, y, z, 4.0 - max(abs(x), y))


def cylinder(geometry):
    """Half of one 8 mm across and 2 mm high."""
    half_of(geometry, [geometry.add_cylinder([0, 0, 0], [0, 0, 2], 4)])
    return lambda dim, tag, x, y, z, *_: edge(x, y, z, 4.0 - np.hypot(x, y))


def box_under_a_disc(geometry):
    """Half of 8 x 8 x 2 mm, the disc of 10 mm drawn on it."""
    disc = geometry.boolean_intersection([geometry.add_disk([0, 0, 2], 5), geometry.add_rectangle([-4, 0, 2], 8, 4)])
    geometry.boolean_fragments(geometry.add_box([-4, 0, 0], [8, 4, 2]), disc)
    return lambda dim, tag, x, y, z, *_: edge(x, y, z, min(4.0 - max(abs(x), y), abs(5.0 - np.hypot(x, y))))


def cylinder_under_a_square(geometry):
    """Half of one 8 mm across and 2 mm high, the square of 7 mm drawn on it."""
    whole = half_of(geometry, [geometry.add_cylinder([0, 0, 0], [0, 0, 2], 4)])
    square = [geometry.add_disk([0, 0, 2], 4), geometry.add_rectangle([-3.5, 0, 2], 7, 3.5)]
    geometry.boolean_fragments(whole, geometry.boolean_intersection(square))
    return lambda dim, tag, x, y, z, *_: edge(x, y, z, min(4.0 - np.hypot(x, y), abs(3.5 - max(abs(x), y))))


def two_pillars(size):
    """Half of two, 1.5 mm across and 2 mm high, 2.5 mm apart."""

    def draw(geometry):
        for x in (-1.25, 1.25):
            half_of(geometry, [geometry.add_cylinder([x, 0, 0], [0, 0, 2], 0.75)])
        return lambda dim, tag, x, y, z, *_: size

    return draw


def half_of(geometry, parts):
    """What of a solid is at y >= 0."""
    return geometry.boolean_intersection([*parts, geometry.add_box([-8, 0, -1], [16, 8, 5])])


@pytest.fixture(scope="module")
def recipe():
    pytest.importorskip("pygmsh")
    pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    namespace = {"__name__": "pads", "__file__": str(MESHES / "pads.py")}
    exec(compile((MESHES / "pads.py").read_text(), "pads.py", "exec"), namespace)
    return namespace


def drawn(recipe, draw, reach, path):
    """Write a drawing as a mesh file; a reach below zero is a radius."""
    import meshio

    name = "dome" if reach < 0 else "box"  # the recipe takes domes' targets as round
    recipe["PADS"][name] = (draw, 2.0, abs(reach))
    meshio.write(path, recipe["drawn"](name), file_format="gmsh22", binary=False)
    return f'elastomer.mesh="{path}"'


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "pad", "draw", "reach"),
    [
        ((10, 10), (8, 8), box, 4),
        (10, 8, cylinder, -4),
        (10, (8, 8), box_under_a_disc, -5),
        ((7, 7), 8, cylinder_under_a_square, 3.5),
    ],
    ids=["square over a box", "coin over a cylinder", "coin over a box", "square over a cylinder"],
)
def test_a_wide_target_is_that_on_a_mesh_of_the_users(recipe, tmp_path, target, pad, draw, reach):
    """Shear, pressure and moment at once: apart by no more than both errors, and by 5 % of each component at most."""
    load = Wrench(0.05, 0.5, 1e-4)
    mesh = drawn(recipe, draw, reach, tmp_path / "own.msh")
    theirs, ours = (block_pad(scene(target, pad, *more)).equilibrium(load) for more in ([mesh], []))
    apart = np.abs(theirs.pose.components - ours.pose.components)[:3]
    assert np.all(apart < (theirs.error.components + ours.error.components)[:3])
    assert np.all(apart < 0.05 * np.abs(ours.pose.components[:3] - REST))


@pytest.mark.slow
def test_pillars_are_those_on_a_mesh_of_the_users(recipe, tmp_path):
    """Apart by no more than both errors, and by 5 % at most: straight tetrahedra make polygons of circles."""
    load, mesh = Wrench(0.002, 0.012, 1e-5), drawn(recipe, two_pillars(0.2), 50, tmp_path / "own.msh")
    theirs, ours = (block_pad(scene((6, 2), (6, 2), *PILLARS, *more)).equilibrium(load) for more in ([mesh], []))
    apart = np.abs(theirs.pose.components - ours.pose.components)[:3]
    assert np.all(apart < (theirs.error.components + ours.error.components)[:3])
    assert np.all(apart < 0.05 * np.abs(ours.pose.components[:3] - REST))
