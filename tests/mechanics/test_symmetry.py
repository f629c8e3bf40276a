"""Images of loads and poses: a group, the one that is solved, and the real pads that answer alike."""

import itertools

import numpy as np
import pytest

from sits_mech.chain.rests import at_rest
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.symmetry import Symmetry, image_of, symmetry_of
from sits_mech.quantities import Pose, Wrench
from sits_mech.scene.sensor import load_sensor

PLATE = 'target={material="copper", thickness=2e-4, '
KINDS = ("none", "rectangle", "square", "disc")
LOADS = [Wrench(*load) for load in np.random.default_rng(3).normal(size=(20, 6)).tolist()]
LOADS += [Wrench(*(part * on for part, on in zip(LOADS[0].components, mask, strict=True)))
          for mask in itertools.product((0.0, 1.0), repeat=6)]


@pytest.mark.parametrize(("kind", "count"), [*zip(KINDS, (1, 4, 8, 8), strict=True)])
def test_the_images_are_a_group(kind: str, count: int) -> None:
    """The product of two is one of them; forces turn as vectors, moments as axial ones."""
    images = Symmetry(kind).images  # type: ignore[arg-type]
    assert len(images) == count and np.array_equal(images[0], np.eye(6))
    for one, two in itertools.product(images, repeat=2):
        assert any(np.array_equal(one @ two, other) for other in images)
    for image in images:
        arm, force = np.array([0.3, -0.2, 0.0]), np.array([0.7, 0.1, 0.0])
        moment = np.cross(arm, force)
        whole = Wrench(force[0], 0.4, moment[1], force[1], moment[0], moment[2]).components
        turn = image[np.ix_([0, 3], [0, 3])]
        arm[:2], force[:2] = turn @ arm[:2], turn @ force[:2]
        moment = np.cross(arm, force)
        expected = Wrench(force[0], 0.4, moment[1], force[1], moment[0], moment[2]).components
        np.testing.assert_allclose(image @ whole, expected, atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_one_image_is_solved_and_leads_back(kind: str) -> None:
    """Back to the load; the same one for all its images; in the plane where one is; itself its own."""
    symmetry = Symmetry(kind)  # type: ignore[arg-type]
    for load in LOADS:
        found, back = symmetry.standard(load)
        np.testing.assert_allclose(back @ found.components, load.components, rtol=0.0, atol=2e-11)
        np.testing.assert_allclose(back @ back.T, np.eye(6), atol=1e-15)
        again, same = symmetry.standard(found)
        assert again == found and np.array_equal(same, np.eye(6))
        images = [Wrench(*(image @ load.components)) for image in symmetry.images]
        assert {symmetry.standard(image)[0] for image in images} == {found}
        assert not found.out_of_plane or all(image.out_of_plane for image in images)
    assert symmetry.without_images(LOADS) == list(dict.fromkeys(symmetry.standard(load)[0] for load in LOADS))


def test_a_disc_takes_shear_from_any_direction_into_the_plane() -> None:
    """With the moment that goes with it, and what presses; a moment about the shear, or about z, stays beside it."""
    disc = Symmetry("disc")
    for angle in np.linspace(0.0, 2.0 * np.pi, 13):
        c, s = float(np.cos(angle)), float(np.sin(angle))
        found, back = disc.standard(Wrench(0.3 * c, 1.0, 2e-3 * c, 0.3 * s, -2e-3 * s))
        assert found == Wrench(0.3, 1.0, 2e-3)
        turned = [1e-4 * c, 2e-3, 1e-2 * c, 1e-4 * s, -1e-2 * s, 0.0]
        np.testing.assert_allclose(back @ [1e-4, 2e-3, 1e-2, 0.0, 0.0, 0.0], turned, atol=1e-18)
        assert disc.standard(Wrench(0.0, 1.0, 2e-3 * c, 0.0, -2e-3 * s))[0] == Wrench(0.0, 1.0, 2e-3)
        found, _ = disc.standard(Wrench(0.3 * c, 1.0, 2e-3 * s, 0.3 * s, 2e-3 * c, 1e-3))
        assert found.F_y == 0.0 and found.F_x == 0.3 and abs(found.M_z) == 1e-3 and found.out_of_plane


def test_what_a_load_cannot_cause() -> None:
    """No shift beside the plane under a load in it, none at all without shear, as much in x as in y on the diagonal."""
    for kind, load, zero in (
        ("rectangle", Wrench(0.3, 1.0, 1e-3), (3, 4, 5)), ("rectangle", Wrench(0.0, 1.0, M_z=1e-3), (0, 2, 3, 4)),
        ("rectangle", Wrench(F_y=0.2), (0, 2, 5)), ("none", Wrench(), ()), ("disc", Wrench(0.0, 1.0), (0, 2, 3, 4, 5)),
        ("square", Wrench(0.3, 1.0, F_y=0.2), ()),
    ):
        pose = Symmetry(kind).projection(load) @ np.arange(1.0, 7.0)  # type: ignore[arg-type]
        expected = np.where(np.isin(np.arange(6), zero), 0.0, np.arange(1.0, 7.0))
        np.testing.assert_array_equal(pose, expected)
    d_h, d_v, alpha, d_y, alpha_x, alpha_z = Symmetry("square").projection(Wrench(0.3, F_y=0.3)) @ np.arange(1.0, 7.0)
    assert d_h == d_y == 2.5 and alpha == -alpha_x == -1.0 and (d_v, alpha_z) == (2.0, 0.0)


@pytest.mark.parametrize(
    ("name", "changes", "kind"),
    [
        ("biorob2018", (), "square"), ("biorob2018-w15", (), "rectangle"), ("triaxial-4", (), "square"),
        ("triaxial-3", (), "disc"), ("triaxial-4", ("elastomer.length=0.03",), "rectangle"),
        ("triaxial-3", (PLATE + 'shape="rectangle", width=8e-3, length=8e-3}',), "square"),
        ("triaxial-3", (PLATE + 'shape="outline", points=[[0, 0], [5e-3, 0], [0, 4e-3]]}',), "none"),
    ],
)
def test_pad_and_target_make_the_symmetry(name: str, changes: tuple[str, ...], kind: str) -> None:
    """Coils play no part."""
    assert symmetry_of(load_sensor(name, list(changes))).kind == kind


def test_an_unknown_error_stays_its_own() -> None:
    """Infinite or NaN in one component: the others are as they are, swapped or left out."""
    swap = Symmetry("square").images[4]
    error = [1.0, 2.0, 3.0, np.inf, 5.0, np.nan]
    np.testing.assert_array_equal(image_of(np.abs(swap), error), [np.inf, 2.0, 5.0, 1.0, 3.0, np.nan])
    kept = Symmetry("rectangle").projection(Wrench(0.3, 1.0))
    np.testing.assert_array_equal(image_of(kept, error), [1.0, 2.0, 3.0, 0.0, 0.0, 0.0])


def _turned(name: str, load: Wrench) -> float:
    """How far the whole pad under a load is from the image that stands for it, over the stated error."""
    sensor = load_sensor(name)
    layer = block_pad(sensor, 5e-2)
    direct, image = layer.equilibrium(load), at_rest(sensor, layer, load, ())
    off, stated = direct.pose.components - image.pose.components, direct.error.components
    return float(np.max(np.abs(off) / stated))


def test_a_mirrored_load_is_answered_by_the_same_digits() -> None:
    """Corners of fine meshes do not come to rest, and stop elsewhere by rounding: one image is solved for both."""
    sensor = load_sensor("biorob2018")
    one, other = (at_rest(sensor, block_pad(sensor, 0.5), Wrench(F_x=F_x, F_z=1.0), ()) for F_x in (0.3, -0.3))
    mirror = Symmetry("rectangle").images[2]
    assert other.pose == Pose.of(image_of(mirror, one.pose.components)) and other.error == one.error


@pytest.mark.slow
def test_a_quarter_turn_of_the_real_pad() -> None:
    """Shear along y of the whole square pad is shear along x of half of it: the meshes are images, to rounding."""
    assert _turned("biorob2018", Wrench(0.0, 1.0, F_y=-0.3, M_x=2e-4)) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("load", [Wrench(0.4, 1.0, F_y=0.3), Wrench(-0.2, 2.0, 3e-4, 0.4, 2e-4, 1e-3)])
def test_any_turn_of_the_real_round_pad(load: Wrench) -> None:
    """The mesh is its image under quarter turns alone: what its cells miss is less than a tenth of the stated error."""
    assert _turned("triaxial-3", load) < 0.1
