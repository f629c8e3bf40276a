"""Which model must agree with which, to what: the table below, a line each; no model is its own witness.

    planar       planar-fem     two-dimensional both: integral equation against finite elements
    planar       sheets         a strip under a track that is as good as straight: what each further metre of strip adds
    axisymmetric sheets         a coaxial disc, from a skin thicker than the disc to one far thinner, and between
    axisymmetric Dodd-Deeds     a disc far wider than its gap against the infinite plate's integral
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change

from sits_mech.chain.models import MAGNETICS
from sits_mech.geometry.windings import coil_sections
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Sensor, Target, load_sensor

MM = 1e-3
COPPER = 5.8e7
AXIS, OFF, TILTED = Pose(0.0, 2 * MM), Pose(1.5 * MM, 1.5 * MM), Pose(-1 * MM, 2 * MM, 0.15)
slow = pytest.mark.slow

# model, model, scene, pose, f [Hz], largest difference over Delta L and R; 0.2 mm of copper is (f / 109 kHz)^.5 skins
TABLE = (
    ("planar", "planar-fem", "plate", AXIS, 5e3, 1e-3, 1e-2),  # t = 0.2 delta
    ("planar", "planar-fem", "plate", OFF, 1e6, 1e-3, 1e-2),  # t = 3 delta
    pytest.param("planar", "planar-fem", "plate", TILTED, 5e6, 1e-3, 1e-2, marks=slow),  # t = 7 delta
    pytest.param("axisymmetric", "sheets", "disc", AXIS, 5e3, 2e-3, 2e-2, marks=slow),  # thin: test_sheets has FEM
    ("axisymmetric", "sheets", "disc", AXIS, 1e5, 2e-3, 2e-2),  # t = delta, where the regimes meet
    pytest.param("axisymmetric", "sheets", "disc", AXIS, 1e6, 2e-3, 3e-2, marks=slow),  # t = 3 delta
    pytest.param("axisymmetric", "sheets", "disc", AXIS, 5e6, 2e-3, 3e-2, marks=slow),  # thick: test_sheets has FEM
)
STRIP = ((5e3, 5e-3, 1e-2), (5e6, 5e-3, 2e-2))  # f [Hz], over Delta L and R per metre
PLATE = ((5e3, 3e-3, 1e-2), pytest.param(5e6, 3e-3, 2e-2, marks=slow))


def coil(x: float = 0.0, name: str = "C") -> Coil:
    return Coil(
        name=name, centre=(x, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def disc(radius: float) -> Sensor:
    """One coil under a coaxial disc."""
    target = Target(conductivity=COPPER, shape="disc", diameter=2 * radius, thickness=0.2 * MM)
    return Sensor(name="disc", frequency=5e6, coils=(coil(),), target=target)


def strip(length: float) -> Sensor:
    """One turn of 1 m radius, over whose track a strip 4 mm wide lies."""
    turn = Coil(
        name="C", centre=(0.0, 0.0), layers=1, turns=1, inner_diameter=2.0, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )
    target = Target(conductivity=COPPER, shape="rectangle", width=4 * MM, length=length, thickness=0.2 * MM)
    return Sensor(name="strip", frequency=5e6, coils=(turn,), target=target)


def reaction(model: str, sensor: Sensor, pose: Pose, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """Delta L and R by a model at the tolerance it promises in the table."""
    z = MAGNETICS[model](sensor, 5e-3 if model == "sheets" else 1e-3).impedance(pose, frequency)
    return z.L - z.L0, z.R


@pytest.mark.parametrize("first, second, scene, pose, f, error_L, error_R", TABLE)
def test_table(first: str, second: str, scene: str, pose: Pose, f: float, error_L: float, error_R: float) -> None:
    sensor = load_sensor("biorob2018") if scene == "plate" else disc(3.5 * MM)
    (L1, R1), (L2, R2) = (reaction(model, sensor, pose, f) for model in (first, second))
    assert np.abs(L2 - L1).max() <= error_L * np.abs(L1).max()
    assert np.abs(R2 - R1).max() <= error_R * np.abs(R1).max()


@pytest.mark.slow
@pytest.mark.parametrize("f, error_L, error_R", STRIP)
def test_sheets_of_growing_length_tend_to_planar_per_metre(f: float, error_L: float, error_R: float) -> None:
    """The strip's two ends drop out of the difference of two lengths."""
    pose, lengths = Pose(1.00005, 2 * MM), (16 * MM, 24 * MM)
    (L1, R1), (L2, R2) = (reaction("sheets", strip(length), pose, f) for length in lengths)
    L, R = reaction("planar", strip(lengths[0]), pose, f)
    step = lengths[1] - lengths[0]
    assert (L2 - L1)[0, 0] / step == pytest.approx(L[0, 0], rel=error_L, abs=0)
    assert (R2 - R1)[0, 0] / step == pytest.approx(R[0, 0], rel=error_R)


@pytest.mark.parametrize("f, error_L, error_R", PLATE)
def test_wide_disc_tends_to_the_infinite_plate(f: float, error_L: float, error_R: float) -> None:
    L, R = reaction("axisymmetric", disc(20 * MM), AXIS, f)
    plate = coil_change(coil_sections(coil()), 2 * MM, f, [Layer(COPPER, 0.2 * MM)])
    assert L[0, 0] == pytest.approx(float(plate.delta_L), rel=error_L)
    assert R[0, 0] == pytest.approx(float(plate.R), rel=error_R)


def turns(width: float, thickness: float, strips: int = 1, layers: int = 1) -> Coil:
    """One turn of 5 mm within, or as many strips and layers as fill it [mm]."""
    return Coil(
        name="C", centre=(0.0, 0.0), layers=layers, turns=strips, inner_diameter=5 * MM,
        track_width=width * MM / strips, track_gap=1e-9, track_thickness=thickness * MM / layers,
        layer_pitch=(1.0 + 1e-9) * thickness * MM / layers,
    )


BROAD, TALL = ((2.0, 0.035), (20, 1)), ((0.5, 1.0), (1, 20))


@pytest.mark.parametrize(("model", "sides", "parts"), [
    ("planar", *BROAD),
    *(pytest.param(model, *sides, marks=slow)
      for model, sides in (("sheets", BROAD), ("axisymmetric", BROAD), ("sheets", TALL), ("planar", TALL))),
])
def test_near_metal_a_broad_or_tall_track_is_worth_the_strips_that_fill_it(
    model: str, sides: tuple[float, float], parts: tuple[int, int]
) -> None:
    """0.15 mm under copper, where one or two filaments in its middle are 3 to 20 % off."""
    shape = {"shape": "disc", "diameter": 12 * MM}
    if model == "planar":
        shape = {"shape": "rectangle", "width": 12 * MM, "length": 1.0}
    target = Target(conductivity=COPPER, thickness=0.2 * MM, **shape)
    one, many = (
        reaction(model, Sensor(name="s", frequency=1e6, coils=(coil,), target=target), Pose(0.0, 0.15 * MM), 1e6)
        for coil in (turns(*sides), turns(*sides, *parts))
    )
    count = math.prod(parts) ** 2
    assert one[0] == pytest.approx(many[0] / count, rel=1e-3)
    assert one[1] == pytest.approx(many[1] / count, rel=3e-3)
