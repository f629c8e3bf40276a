"""A thin plate bonded on its pad: with closed forms, with a foil meshed in space (NGSolve), over degree and load."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import special

from sits_mech.mechanics.foil.bending import DEGREE, BondedPlate, bonded_plate, pressed_places
from sits_mech.quantities import Array, Wrench
from sits_mech.scene.parts.touch import Touch
from sits_mech.scene.sensor import Sensor, load_sensor

DISC = 'target={material="copper", shape="disc", diameter="12 mm", thickness="0.2 mm"}'
SPOT = 'touch={shape="pressure", diameter="2 mm"}'
PRESSED = Wrench(F_z=1.0)


def fitted(plate: BondedPlate, w: Callable[[Array, Array], Array]) -> Array:
    """Amplitudes of the shapes that make a polynomial w(x, y)."""
    x, y = plate.places.T
    return np.linalg.lstsq(plate.upwards[:, [1, 2, 4, *range(6, plate.upwards.shape[1])]], w(x, y), rcond=None)[0][3:]


@pytest.mark.parametrize("keys", [(), (DISC,)], ids=["rectangle", "disc"])
@pytest.mark.parametrize(("w", "twice"), [
    (lambda x, y: x**2 + y**2, lambda nu: 8.0 * (1.0 + nu)), (lambda x, y: x * y, lambda nu: 2.0 * (1.0 - nu)),
    (lambda x, y: x**2, lambda nu: 4.0),
], ids=["bowl", "twist", "cylinder"])
def test_the_energy_of_plates_of_even_curvature(
    keys: tuple[str, ...], w: Callable[[Array, Array], Array], twice: Callable[[float], float]
) -> None:
    """Twice the energy over D and area, (w_xx + w_yy)^2 - 2 (1 - nu) (w_xx w_yy - w_xy^2): Timoshenko, section 21."""
    plate = bonded_plate(load_sensor("biorob2018", keys))
    a, area = fitted(plate, w), plate.areas.sum()
    assert a @ plate.plate @ a == pytest.approx(twice(0.343) * area, rel=1e-9)
    at = plate.upwards[:, 6:]
    held = np.column_stack([np.ones(len(at)), plate.places]).T @ (at * plate.areas[:, None])
    np.testing.assert_allclose(held, 0.0, atol=1e-12 * area)


def on_springs(sensor: Sensor, k: float, degree: int) -> BondedPlate:
    """The target of a scene on springs of stiffness k [N/m^3] in place of its pad."""
    plate = bonded_plate(sensor, degree)
    return replace(plate, pad=k * plate.upwards.T @ (plate.areas[:, None] * plate.upwards))


def free_disc(r: Array, a: float, length: float, nu: float) -> Array:
    """w D / (F l^2) of a disc on springs under a force in its middle, l^4 = D/k; Timoshenko, section 57.

    w = A ber + B bei - kei/(2 pi), without moment, w_rr + nu w_r/r = 0, and shear, (w_rr + w_r/r)_r = 0, at its rim.
    """
    x, R = np.maximum(r / length, 1e-9), a / length
    slopes = [special.berp(R), special.beip(R), special.keip(R)]
    turned = [-special.bei(R), special.ber(R), special.ker(R)]
    pushed = [-special.beip(R), special.berp(R), special.kerp(R)]
    moment = [each - (1.0 - nu) * slope / R for each, slope in zip(turned, slopes, strict=True)]
    own = np.array([moment, pushed])
    A, B = np.linalg.solve(own[:, :2], own[:, 2] / (2.0 * np.pi))
    return np.asarray(A * special.ber(x) + B * special.bei(x) - special.kei(x) / (2.0 * np.pi))


def test_a_disc_on_springs_pressed_in_its_middle_is_as_by_closed_form() -> None:
    """Its radius is twice its bending length; a force at a point is no polynomial, so that degrees approach it."""
    sensor = load_sensor("biorob2018", [DISC, 'touch={shape="sphere", radius="5 mm"}'])
    D, a = 0.1, 6e-3
    length, off = 0.5 * a, []
    for degree in (4, DEGREE, 10):
        plate = on_springs(sensor, D / length**4, degree)
        w = -plate.upwards @ sum(plate.answers([PRESSED], D))[:, 0] * D / length**2
        true = free_disc(np.hypot(*plate.places.T), a, length, 0.343)
        off.append(float(np.abs(w - true).max() / true.max()))
    assert off[0] > off[1] > off[2] and off[1] < 0.06 and off[2] < 0.015


# studies/common/ngsolve_foil.py, 1 N on a spot of 1 mm radius: heights over that of a rigid target, less one, in the
# middle, at the ends along x and y, in a corner; and in the middle and at the rim of a disc, by load
FOILS = [
    ("15 mm", "0.1 mm", (1.176, -1.612, 0.688, -1.673)), ("15 mm", "0.2 mm", (0.2101, -0.3419, 0.1656, -0.3420)),
    ("15 mm", "0.4 mm", (0.0286, -0.0469, 0.0233, -0.0467)), ("8 mm", "0.2 mm", (0.0292, -0.0102, -0.0102, -0.0352)),
]
DISCS = [
    ("0.1 mm", 1.0, 1.023, -0.703), ("0.1 mm", 6.0, 0.675, -0.410), ("0.2 mm", 1.0, 0.1546, -0.1082),
    ("0.2 mm", 6.0, 0.1803, -0.1173), ("0.4 mm", 1.0, 0.0196, -0.0143), ("0.4 mm", 6.0, 0.0243, -0.0150),
]


@pytest.mark.parametrize(("width", "thickness", "known"), FOILS)
def test_a_foil_bends_as_one_that_is_meshed(width: str, thickness: str, known: tuple[float, ...]) -> None:
    keys = [f'target.width="{width}"', f'target.thickness="{thickness}"', SPOT]
    sensor = load_sensor("biorob2018", keys)
    plate, half = bonded_plate(sensor), 0.5 * sensor.target.width
    there = np.array([(0.0, 0.0), (half, 0.0), (0.0, 4e-3), (half, 4e-3)])
    rigid, bend = plate.heights(there) @ plate.answers([PRESSED], sensor.target.bending_stiffness)
    np.testing.assert_allclose(bend[:, 0] / rigid[:, 0], known, atol=0.1 * np.abs(known).max())


@pytest.mark.parametrize(("thickness", "force", "middle", "rim"), DISCS)
def test_a_foil_bends_so_also_at_finite_strain(thickness: str, force: float, middle: float, rim: float) -> None:
    """1 N presses 2 mm by 2 %, 6 N by 9 %: as much over what it moves as without load, within 30 % of stiff foils.

    One that bends by as much as it moves bends less under the larger load, by as much as a half.
    """
    own = 'elastomer.material={law="neo-hookean", shear_modulus="20 kPa", bulk_modulus="20 MPa"}'
    sensor = load_sensor("triaxial-3", [f'target.thickness="{thickness}"', own, SPOT])
    places = np.array([(0.0, 0.0), (6e-3, 0.0)])
    plate, known = bonded_plate(sensor), np.array([middle, rim])
    rigid, bend = plate.heights(places) @ plate.answers([PRESSED], sensor.target.bending_stiffness)
    shares = bend[:, 0] / rigid[:, 0]
    assert np.all(np.abs(shares / known - 1.0) < (1.0 if abs(middle) > 0.5 and force > 2.0 else 0.3))


def test_what_a_touch_presses_has_its_middle_and_its_size() -> None:
    """Second moments: r^2/4 of a disc, b^2/12 of a side."""
    for keys, moments in (
        ({"shape": "sphere", "radius": 1e-3}, (0.0, 0.0)), ({"shape": "pressure", "diameter": 4e-3}, (1e-6, 1e-6)),
        ({"shape": "punch", "width": 2e-3, "length": 3e-3}, (1e-6 / 3.0, 0.75e-6)),
        ({"shape": "cylinder", "radius": 1e-3, "length": 3e-3, "axis": "y"}, (0.0, 0.75e-6)),
    ):
        places, shares = pressed_places(Touch(**keys))
        assert shares.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(shares @ places, 0.0, atol=1e-15)
        np.testing.assert_allclose(shares @ places**2, moments, atol=1e-18)
