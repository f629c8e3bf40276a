"""Parts in each other's way are refused when a scene is loaded: which two, and by how much."""

from typing import Any

import pytest

from sits_mech.scene.apart import Prism, gap_in_plan
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor, sensor_from

MM = 1e-3
DISC = {"material": "copper", "shape": "disc", "diameter": 8 * MM, "thickness": 0.2 * MM}
TRIANGLE = DISC | {"shape": "outline", "points": [[-4e-3, -4e-3], [4e-3, -4e-3], [-4e-3, 4e-3]]}
del TRIANGLE["diameter"]


def nut(x: float, z: float, *, y: float = 0.0, round_: bool = False, name: str = "nut") -> dict[str, Any]:
    """A plate of 2 mm, 0.5 mm thick."""
    sizes = {"shape": "disc", "diameter": 2 * MM} if round_ else {"shape": "rectangle", "width": 2e-3, "length": 2e-3}
    return sizes | {"name": name, "material": "copper", "centre": [x * MM, y * MM, z * MM], "thickness": 0.5 * MM}


def scene(*parts: dict[str, Any], **changes: Any) -> Sensor:
    """The published sensor, pad of 20 x 20 x 2 mm, coils 7 mm across at 4 mm to both sides, among plates."""
    table = load_sensor("biorob2018").model_dump(exclude_none=True) | {"conductors": list(parts)} | changes
    return sensor_from({key: part for key, part in table.items() if part is not None})


@pytest.mark.parametrize(
    ("part", "said"),
    [
        (nut(0.0, 1.0), r"elastomer, which reaches from z = 0 mm to 2 mm; got .* overlaps it by 1\.25 mm"),
        (nut(10.5, 1.0), r"elastomer, .* overlaps it by 0\.5 mm"),
        (nut(11.0, 1.0), r"elastomer, .* touches it"),
        (nut(6.0, 2.25), r"elastomer, .* touches it"),
        (nut(4.9, 2.26), r"target, which reaches from z = 2 mm to 2\.2 mm"),
        (nut(5.0, 2.26), r"target, .* touches it"),
        (nut(0.0, 2.45), r"target, .* touches it"),
        (nut(-4.0, -0.3), r"coils.C1, which reaches from z = -0\.12 mm to 0 mm"),
        (nut(0.0, -0.37), r"coils.C1, .* touches it"),
    ],
)
def test_a_conductor_in_the_way_is_refused_by_name(part: dict[str, Any], said: str) -> None:
    """By 0.5 mm, by a hair of rounding, or at a face."""
    with pytest.raises(SceneError, match=f"^scene: conductors.nut must be clear of {said}"):
        scene(part)


@pytest.mark.parametrize("part", [nut(11.01, 1.0), nut(5.01, 2.26), nut(0.0, 2.46), nut(0.0, -0.38)])
def test_a_hundredth_of_a_millimetre_is_clear(part: dict[str, Any]) -> None:
    """Beside and above the pad, above the target, below the coils."""
    assert scene(part).conductors[0].name == "nut"


def test_the_film_below_the_layer_belongs_to_it() -> None:
    """A plate between coils and layer; and the target stands higher."""
    layer = {"material": "ecoflex-00-30", "width": 20e-3, "length": 20e-3, "thickness": 2e-3, "standoff": 1e-3}
    with pytest.raises(SceneError, match=r"elastomer, which reaches from z = 0 mm to 3 mm"):
        scene(nut(0.0, 0.5), elastomer=layer)
    with pytest.raises(SceneError, match=r"target, which reaches from z = 3 mm"):
        scene(nut(4.0, 3.4), elastomer=layer)
    assert scene(nut(0.0, 0.5), elastomer=None).elastomer is None


@pytest.mark.parametrize(
    ("target", "x", "y", "clear"),
    [
        (DISC, 3.53, 3.53, False), (DISC, 3.54, 3.54, True),  # discs of 8 and 2 mm: 5 mm apart at 45 degrees
        (TRIANGLE, 1.0, 1.0, False), (TRIANGLE, 1.02, 1.02, True), (TRIANGLE, -1.0, -1.0, False),
    ],
)
def test_round_plates_and_outlines_are_what_they_are(target: dict[str, Any], x: float, y: float, clear: bool) -> None:
    """Not the boxes around them; a square's corner reaches the triangle's long side at 1 mm both ways."""
    part = nut(x, 2.11, y=y, round_=target is DISC) | {"thickness": 0.1 * MM}
    if clear:
        assert scene(part, target=target).target is not None
    else:
        with pytest.raises(SceneError, match="must be clear of target"):
            scene(part, target=target)


def test_a_hole_in_a_target_has_room() -> None:
    """A plate within the hole's rim; not one that reaches over it."""
    holes = [[[-1.5e-3, -1.5e-3], [1.5e-3, -1.5e-3], [1.5e-3, 1.5e-3], [-1.5e-3, 1.5e-3]]]
    square = [[-4e-3, -4e-3], [4e-3, -4e-3], [4e-3, 4e-3], [-4e-3, 4e-3]]
    target = TRIANGLE | {"points": square, "holes": holes}
    part = nut(0.0, 2.11) | {"thickness": 0.1 * MM}
    assert scene(part, target=target).target is not None
    with pytest.raises(SceneError, match="must be clear of target"):
        scene(part | {"centre": [1e-3, 0.0, 2.11e-3]}, target=target)


def test_conductors_keep_clear_of_each_other() -> None:
    """Two nuts on one bolt."""
    with pytest.raises(SceneError, match="conductors.other must be clear of conductors.nut, .* touches it"):
        scene(nut(0.0, -2.0), nut(2.0, -2.0, name="other"))
    assert len(scene(nut(0.0, -2.0), nut(2.01, -2.0, name="other")).conductors) == 2


def test_coils_bend_with_their_substrate() -> None:
    """On a radius of 10 mm the coils' outer edge, 7.5 mm along the arc, is at x = 6.8 mm and z = -2.7 mm."""
    bare = {"target": None, "elastomer": None, "substrate_radius": 10e-3}
    for x, z in ((7.6, -2.6), (4.0, -0.9)):
        with pytest.raises(SceneError, match="must be clear of coils.C2"):
            scene(nut(x, z), **bare)
    assert scene(nut(7.0, -0.3), **bare).substrate_radius == 10e-3
    with pytest.raises(SceneError, match="must be clear of coils.C2"):
        scene(nut(7.0, -0.3), **bare | {"substrate_radius": None})


def test_gaps_by_hand() -> None:
    """Corner to corner 3-4-5, a disc beside a side and off a corner, one in another."""
    box = Prism("a", (0.0, 0.0), (2.0, 4.0), 0.0, 1.0)
    assert gap_in_plan(box, Prism("b", (5.0, 7.0), (2.0, 2.0), 0.0, 1.0)) == pytest.approx(5.0)
    assert gap_in_plan(Prism("c", (3.0, 0.0), (2.0, 2.0), 0.0, 1.0, True), box) == pytest.approx(1.0)
    assert gap_in_plan(Prism("c", (4.0, 6.0), (2.0, 2.0), 0.0, 1.0, True), box) == pytest.approx(4.0)
    assert gap_in_plan(Prism("d", (0.0, 0.5), (1.0, 1.0), 0.0, 1.0), box) == pytest.approx(-1.5)
