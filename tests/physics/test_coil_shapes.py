"""Coils of other shapes under plates: against rings, the section and themselves turned; who refuses them."""

from typing import Any

import numpy as np
import pytest
from common.track_losses import track_spectrum

from sits_mech.chain.models import magnetic_model
from sits_mech.geometry.tracks import TrackBars, coil_tracks
from sits_mech.geometry.windings import turn_radii
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.coils.straight import linkage
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.omitted.remote import remote_bounds
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Pose
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.sensor import Conductor, Sensor, Target, load_sensor

MM = 1e-3
F = 5e6
TRACK: dict[str, Any] = {"track_width": 0.1 * MM, "track_gap": 0.1 * MM, "track_thickness": 35e-6}
KEYS = TRACK | {"name": "C", "centre": (0.0, 0.0), "layers": 2, "turns": 6, "layer_pitch": 85e-6}
ROUND = Coil(**KEYS, inner_diameter=5 * MM)


def rectangle(width: float, length: float, **changes: Any) -> Coil:
    """Return a rectangular coil [mm]."""
    return Coil(**KEYS | changes, shape="rectangle", inner_width=width * MM, inner_length=length * MM)


def scene(coil: Coil, width: float = 8.0, length: float = 8.0, **changes: Any) -> Sensor:
    """Return a sensor of a coil and a copper plate [mm]."""
    plate = Target(material="copper", shape="rectangle", width=width * MM, length=length * MM, thickness=0.2 * MM,
                   load_height=0.0)
    return Sensor(**{"name": "s", "frequency": F, "coils": (coil,), "target": plate} | changes)


def as_path(coil: Coil, count: int) -> Coil:
    """Return a round coil as free tracks, polygons of its turns' areas."""
    angle, x = np.linspace(0.0, 2 * np.pi, count + 1), np.pi / count
    angle[-1] = 0.0
    lines = tuple(
        tuple((float(r * np.cos(a)), float(r * np.sin(a)), z) for a in angle)
        for z in coil.heights for r in turn_radii(coil) * np.sqrt(2 * x / np.sin(2 * x))
    )
    return Coil(name="C", shape="path", path=lines, track_width=coil.track_width, track_thickness=35e-6)


@pytest.mark.slow
def test_path_of_a_circle_is_rings_over_a_plate() -> None:
    """Shifted and tilted: change of L and R to 1e-4, L0 too."""
    pose = Pose(0.7 * MM, 1.8 * MM, 0.05)
    rings, path = (sheets(scene(coil), 2e-2).impedance(pose, F) for coil in (ROUND, as_path(ROUND, 64)))
    assert path.L0[0, 0] == pytest.approx(rings.L0[0, 0], rel=1e-4)
    assert (path.L - path.L0)[0, 0] == pytest.approx((rings.L - rings.L0)[0, 0], rel=1e-4)
    assert path.R[0, 0] == pytest.approx(rings.R[0, 0], rel=1e-4)
    assert path.R_dc[0] == pytest.approx(rings.R_dc[0], rel=1e-3)


@pytest.mark.slow
def test_coil_and_plate_turned_by_a_quarter() -> None:
    """The same digits: to rounding of the plate's modes."""
    along = sheets(scene(rectangle(2.0, 3.0), 9.0, 7.0), 2e-2).impedance(Pose(0.3 * MM, 1.5 * MM, 0.05), F)
    across = sheets(scene(rectangle(3.0, 2.0), 7.0, 9.0), 2e-2)
    turned = across.impedance(Pose(0.0, 1.5 * MM, 0.0, 0.3 * MM, -0.05, 0.0), F)
    assert turned.L[0, 0] == pytest.approx(along.L[0, 0], rel=1e-11)
    assert turned.R[0, 0] == pytest.approx(along.R[0, 0], rel=1e-9)


@pytest.mark.slow
def test_mirrored_poses_of_a_square() -> None:
    """d_h and -d_h, and d_y instead, are one, but for weak combinations of fields, sought among random currents."""
    model = sheets(scene(rectangle(2.0, 2.0)), 2e-2)
    zero, shift = np.zeros(3), 0.6 * MM * np.array([1.0, -1.0, 0.0])
    beside = 0.6 * MM * np.array([0.0, 0.0, 1.0])
    found = model.impedance(Pose(shift, np.full(3, 1.5 * MM), zero, beside, zero, zero), F)
    change = np.abs(found.L - found.L0)[0, 0, 0]
    assert np.ptp(found.L[:, 0, 0]) < 1e-7 * change and np.ptp(found.R[:, 0, 0]) < 1e-6 * found.R[0, 0, 0]


@pytest.mark.slow
def test_close_to_a_wide_plate() -> None:
    """Between the answer and that of an image in copper, half a skin depth (29 um) deep, lies the estimated error."""
    sensor = scene(rectangle(2.0, 2.0), 14.0, 14.0)
    found, tracks = sheets(sensor, 2e-2).impedance(Pose(0.0, 0.4 * MM), F), coil_tracks(sensor.coils[0])
    up = np.array([0.0, 0.0, 0.8 * MM + 29.5e-6])
    image = TrackBars(*(p * (1, 1, -1) + up for p in (tracks.start, tracks.end)), tracks.width, tracks.thickness)
    change = float(found.L[0, 0] - found.L0[0, 0])
    assert change == pytest.approx(-linkage(tracks, image), abs=float(found.error_L[0, 0]) + 3e-3 * abs(change))


@pytest.mark.slow
def test_long_coil_under_a_long_plate_is_the_section() -> None:
    """What a longer pair adds per metre; the rest falls like the square of the length: one step of that is taken."""
    section = planar_bars(scene(rectangle(4.0, 4.0, layers=1, turns=4)), 1e-4).impedance(Pose(0.0, 4 * MM), F)
    lengths, found = np.array([20.0, 32.0, 44.0]), []
    for length in lengths:
        sensor = scene(rectangle(4.0, length, layers=1, turns=4), 8.0, length + 10.0)
        z = sheets(sensor, 1e-2).impedance(Pose(0.0, 4 * MM), F)
        found.append([(z.L - z.L0)[0, 0], z.R[0, 0]])
    slope = np.diff(found, axis=0) / np.diff(lengths)[:, None] / MM
    middle = (lengths[1:] + lengths[:-1]) / 2
    limit = slope[1] + (slope[1] - slope[0]) / ((middle[1] / middle[0]) ** 2 - 1)
    assert limit[0] == pytest.approx((section.L - section.L0)[0, 0], rel=5e-3)
    assert limit[1] == pytest.approx(section.R[0, 0], rel=2e-2)


@pytest.mark.slow
def test_the_section_of_a_rectangle_is_that_of_a_circle() -> None:
    """Both planar models see bars at y = 0 alone."""
    pose = Pose(0.2 * MM, 1.5 * MM, 0.02)
    for model, tolerance in ((planar_bars, 1e-3), (planar_fem, 1e-2)):
        a, b = (model(scene(coil), tolerance).impedance(pose, F) for coil in (ROUND, rectangle(5.0, 7.0)))
        assert b.L[0, 0] == pytest.approx(a.L[0, 0], rel=1e-9) and b.R[0, 0] == pytest.approx(a.R[0, 0], rel=1e-6)


def test_refusals() -> None:
    """By name: what is not round has no axis; a slanted track no section. What chooses a model knows."""
    disc = Target(material="copper", shape="disc", diameter=8 * MM, thickness=0.2 * MM, load_height=0.0)
    with pytest.raises(ValueError, match="coils.C.shape must be circle for axisymmetric; got rectangle$"):
        axisymmetric(scene(rectangle(2.0, 2.0), target=disc))
    line = tuple((x * MM, y * MM, -0.1 * MM) for x, y in ((0, -1), (4, -1), (3, 1), (0, 1), (0, -0.5)))
    slanted = Coil(name="P", shape="path", track_width=1e-4, track_thickness=35e-6, path=(line,))
    for model in (planar_bars, planar_fem):
        with pytest.raises(ValueError, match="coils.P.*must .*; got"):
            model(scene(slanted), 1e-2)
    above = Pose(0.0, 2 * MM)
    assert magnetic_model(scene(slanted), "auto", 1e-2, [above])[1].name == "sheets"
    assert magnetic_model(scene(rectangle(2.0, 2.0), target=disc), "auto", 1e-2, [above])[1].name == "sheets"
    assert magnetic_model(scene(rectangle(2.0, 2.0)), "auto", 1e-2, [above])[1].name == "sheets"


def test_free_space_of_any_coils_without_a_target() -> None:
    """In henry, by sheets where they are not round."""
    model, choice = magnetic_model(scene(rectangle(2.0, 2.0), target=None))
    found = model.impedance(Pose(0.0, 1e-3), F)
    assert choice.name == "sheets" and found.unit_L == "H" and found.L[0, 0] == found.L0[0, 0] > 0.0


@pytest.mark.slow
def test_far_metal_is_bounded_for_a_rectangle() -> None:
    """More than a solved plate takes, less than fifty times that."""
    far = Conductor(name="far", material="copper", shape="rectangle", centre=(12 * MM, 0.0, 3 * MM), width=2 * MM,
                    length=2 * MM, thickness=0.5 * MM)
    sensor = scene(rectangle(2.0, 2.0), target=None)
    bound = float(remote_bounds(sensor, [far], Pose(0.0, 2 * MM))[0, 0])
    found = sheets(sensor.model_copy(update={"conductors": (far,)}), 2e-2).impedance(Pose(0.0, 2 * MM), F)
    taken = abs(float((found.L - found.L0)[0, 0] / found.L0[0, 0]))
    assert taken < bound < 50 * taken


@pytest.mark.slow
def test_track_losses_of_a_square() -> None:
    """As rings of its length: little more than the direct current's at 10 kHz, some 5 to 60 % more at 5 MHz."""
    R = track_spectrum(rectangle(2.0, 2.0), [1e4, F]).R
    R_dc = sheets(scene(rectangle(2.0, 2.0)), 2e-2).impedance(Pose(0.0, 2 * MM), F).R_dc[0]
    assert R[0] == pytest.approx(R_dc, rel=1e-3) and 1.05 < R[1] / R_dc < 1.6


@pytest.mark.slow
def test_round_coils_answer_as_before_beside_a_square() -> None:
    """A mixture of shapes: the round one's own numbers do not know of the other."""
    biorob = load_sensor("biorob2018")
    other = rectangle(2.0, 2.0, name="S", centre=(12 * MM, 0.0))
    mixed = biorob.model_copy(update={"coils": (*biorob.coils, other)})
    alone, both = (sheets(sensor, 2e-2).impedance(Pose(0.0, 2 * MM), F) for sensor in (biorob, mixed))
    np.testing.assert_allclose(both.L0[:2, :2], alone.L0, rtol=1e-12)
    np.testing.assert_allclose(both.L[:2, :2], alone.L, rtol=2e-3)


@pytest.mark.slow
def test_a_plane_between_the_layers() -> None:
    """Coils half above and half below a sheet of copper: each sees it as the other does, turned upside down."""
    heights = (-0.1 * MM, -0.9 * MM)
    coils = [rectangle(2.0, 2.0, layers=1).model_copy(update={"layer_z": (z,)}) for z in heights]
    both = rectangle(2.0, 2.0).model_copy(update={"layer_z": heights})
    plane = Conductor(name="plane", material="copper", shape="rectangle", centre=(0.0, 0.0, -0.5 * MM), width=6 * MM,
                      length=6 * MM, thickness=0.1 * MM)
    found = []
    for coil in (*coils, both):
        z = sheets(scene(coil, target=None, conductors=(plane,)), 2e-2).impedance(Pose(0.0, 2 * MM), F)
        found.append(float((z.L - z.L0)[0, 0]))
    assert found[0] == pytest.approx(found[1], rel=1e-6) and found[0] < 0.0
    assert 2 * found[0] > found[2] > 4 * found[0]
