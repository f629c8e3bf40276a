"""How a touch spreads over silicone: Hertz in numbers, even and uneven ground, lines that refuse."""

import numpy as np
import pytest

from sits_mech.mechanics.cells.spread import spreads
from sits_mech.scene.cells import load_cells
from sits_mech.units import SceneError

MU = 'elastomer.material={law="neo-hookean", shear_modulus="10 kPa", bulk_modulus="100 MPa"}'
COIL = (
    'coils=[{name="C", centre=[0, 0], turns=4, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]'
)


def cells(touch, *keys):
    places = 'targets=[{name="A", centre=["-7 mm", 0]}, {name="B", centre=["7 mm", 0]}]'
    return load_cells("biorob2018", [COIL, places, 'elastomer.width="30 mm"', MU, f"touch={touch}", *keys])


def covered(touch, thickness):
    soft = MU.partition("=")[2]
    cover = f'cover={{material={soft}, thickness="{thickness}", overhang="2 mm"}}'
    return cells(touch, cover, 'target.thickness="0.5 mm"')


def spread_of(found):
    """The middle of the force, and its mean square from there."""
    points, share = found
    assert share.sum() == pytest.approx(1.0, abs=1e-12)
    middle = share @ points
    return middle, float(share @ np.sum((points - middle) ** 2, axis=1))


def test_a_sphere_on_deep_silicone_is_hertz():
    """a^3 = 3 F R/(16 mu) of an incompressible half-space, the mean of r^2 2 a^2/5."""
    F, R = 1e-3, 2e-3
    own, point, *shifted = spreads(cells('{shape="sphere", radius="2 mm", x="0.5 mm"}'), F)
    a = (3.0 * F * R / (16.0 * 10e3)) ** (1.0 / 3.0)
    middle, square = spread_of(own)
    assert middle == pytest.approx([0.5e-3, 0.0], abs=1e-9) and square == pytest.approx(0.4 * a**2, rel=0.01)
    assert spread_of(point)[1] < 1e-5 * square
    away = [spread_of(each)[0] - middle for each in shifted]
    assert np.linalg.norm(away, axis=1) == pytest.approx(np.full(4, 0.375 * a), rel=1e-3)  # half of it pressed


def test_uneven_ground_lets_half_a_sphere_press():
    """In a cover over a target it is even but near the rim."""
    for x, ways in ((7, 2), (3.5, 6)):
        found = spreads(covered(f'{{shape="sphere", radius="20 mm", x="{x} mm"}}', "0.2 mm"), 1e-3)
        assert len(found) == ways


def test_flat_faces_lie_evenly_and_rigid_ones_between_that_and_their_border():
    (even,) = spreads(cells('{shape="pressure", width="20 mm", length="6 mm"}'), 1.0)
    assert spread_of(even)[1] == pytest.approx((20e-3**2 + 6e-3**2) / 12.0, rel=1e-3)
    own, edge = map(spread_of, spreads(covered('{shape="punch", diameter="4 mm", x="7 mm"}', "0.5 mm"), 1.0))
    assert own[1] == pytest.approx(2e-3**2 / 2.0, rel=0.01) and edge[1] == pytest.approx(4e-6, rel=2e-3)
    (point,) = spreads(cells('{shape="sphere", radius="4 mm", x="5 mm"}'), 1.0)  # on a bare target
    assert point[0].tolist() == [[5e-3, 0.0]]


@pytest.mark.parametrize(("touch", "F", "line"), [
    ('{shape="sphere", radius="20 mm"}', 0.1, "touch must lie on one target or on the silicone beside all, which a "
     "sphere of radius 20 mm sinks .* mm into under 0.1 N; it meets targets.A"),
    ('{shape="sphere", radius="1 mm"}', 1.0, "touch must be a pressure, a punch or a sphere that does not sink in "
     "whole on silicone; got a sphere of radius 1 mm, 1 N"),
    ('{shape="cylinder", radius="1 mm", length="2 mm", axis="y"}', 0.001, "on silicone; got a cylinder of radius 1 mm, "
     "2 mm long along y, 0.001 N"),
])
def test_a_sphere_that_meets_targets_or_sinks_in_whole_is_refused_in_one_line(touch, F, line):
    with pytest.raises(SceneError, match=line) as caught:
        spreads(cells(touch), F)
    assert "\n" not in str(caught.value)
