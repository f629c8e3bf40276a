"""Plates close to the coils: discs as rings at any gap and thickness, wide plates as infinite ones, batches."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change
from common.sheet_scenes import sheet_scene

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.modes import Factored
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import divisions
from sits_mech.magnetics.space import plates as preparing
from sits_mech.magnetics.space.coupling import Sheeted
from sits_mech.magnetics.space.far import FieldRequest, answered_by, seen_from
from sits_mech.magnetics.space.near import Near
from sits_mech.magnetics.space.rungs import LADDER
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import array_bytes
from sits_mech.quantities import Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


def disc(diameter: float, thickness: float) -> Sensor:
    """One coil, outer diameter 6.8 mm, under a coaxial disc."""
    target = f'target={{material="copper", shape="disc", diameter={diameter}, thickness={thickness}}}'
    scene = load_sensor("biorob2018", [target, 'coils.C1.centre=["0 mm","0 mm"]', 'coils.C2.centre=["30 mm","0 mm"]'])
    return scene.model_copy(update={"coils": scene.coils[:1]})


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many divisions answered cell by cell."""
    counts: list[int] = []

    answer = Near.reactions

    def counted(*given):  # type: ignore[no-untyped-def]
        found = answer(*given)
        counts.append(len(found))
        return found

    monkeypatch.setattr(Near, "reactions", counted)
    return counts


# Foil, a wide disc, a thick one close to the coil, a block: diameter, thickness, gap, frequency; tolerance.
DISCS = (
    (10 * MM, 35e-6, 0.8 * MM, 25e6, 5e-2),
    (40 * MM, 0.2 * MM, 2 * MM, 5e6, 1e-2),
    (10 * MM, 35e-6, 0.8 * MM, 25e6, 1e-3),
    (8 * MM, 0.5 * MM, 0.2 * MM, 1e6, 5e-3),
    (8 * MM, 2 * MM, 1 * MM, 1e6, 5e-3),
    (4.6 * MM, 0.2 * MM, 0.05 * MM, 5e6, 1e-2),
    (10 * MM, 0.2 * MM, 0.05 * MM, 5e6, 1e-2),
)


@pytest.mark.slow
@pytest.mark.parametrize("diameter, thickness, gap, frequency, tolerance", DISCS)
def test_discs_as_rings(
    diameter: float, thickness: float, gap: float, frequency: float, tolerance: float, asked: list[int]
) -> None:
    """Inductance and resistance within the errors told, L within what was asked, told so but for a seventh."""
    scene, pose = disc(diameter, thickness), Pose(0.0, gap)
    z = sheets(scene, tolerance).impedance(pose, frequency)
    exact = axisymmetric(scene, min(tolerance, 2e-3)).impedance(pose, frequency)
    assert asked, "polynomials carried the field"
    change = abs(exact.L - exact.L0)[0, 0]
    assert exact.error_L[0, 0] < 0.1 * tolerance * change
    assert z.error_L[0, 0] < 1.15 * tolerance * change and abs(z.L - exact.L)[0, 0] < tolerance * change
    assert abs(z.L - exact.L)[0, 0] < z.error_L[0, 0] + exact.error_L[0, 0]
    assert abs(z.R - exact.R)[0, 0] < z.error_R[0, 0] + exact.error_R[0, 0]


@pytest.mark.slow
def test_wide_plate_as_infinite(sensor: Sensor) -> None:
    """20 mm wide at 0.3 mm: Dodd and Deeds, less what the plate lacks of infinity."""
    wide = [f'{part}.{side}="20 mm"' for part in ("elastomer", "target") for side in ("width", "length")]
    z = sheets(load_sensor("biorob2018", wide), 1e-2).impedance(Pose(0.0, 0.3 * MM), 5e6)
    plate = [Layer(metals()["copper"].conductivity, 0.2 * MM)]
    exact = coil_change(coil_sections(sensor.coils[0]), 0.3 * MM, 5e6, plate)
    assert (z.L - z.L0)[0, 0] == pytest.approx(float(exact.delta_L), rel=1e-2)
    assert z.R[0, 0] == pytest.approx(float(exact.R), rel=1e-1)


@pytest.mark.slow
def test_a_pose_does_not_depend_on_its_batch(sensor: Sensor) -> None:
    """Tilted, turned over and level alike; reciprocal and passive."""
    model = sheets(sensor, 5e-2)
    poses = Pose(np.array([0.0, 0.3, -0.2]) * MM, np.array([0.3, 0.35, 0.4]) * MM, np.array([0.0, 0.01, -0.02]))
    z = model.impedance(poses, 5e6)
    for k in range(3):
        own = model.impedance(Pose(poses.d_h[k], poses.d_v[k], poses.alpha[k]), 5e6)
        np.testing.assert_allclose(z.L[k], own.L, rtol=1e-12)
    np.testing.assert_allclose(z.L, np.swapaxes(z.L, 1, 2), rtol=0)
    assert np.all(np.linalg.eigvalsh(z.R) > 0.0)


@pytest.mark.slow
def test_no_step_where_polynomials_begin(sensor: Sensor) -> None:
    """Both ways answer alike, within a fifth of the error told."""
    model = sheets(sensor, 1e-2)
    gaps = np.geomspace(0.4, 1.2, 9) * MM
    z = model.impedance(Pose(np.full(9, 0.5 * MM), gaps), 5e6)
    change = np.log(-(z.L - z.L0)[:, 0, 0])
    smooth = np.polynomial.Polynomial.fit(np.log(gaps), change, 4)(np.log(gaps))
    assert np.max(np.abs(change - smooth)) < 0.5 * np.max(z.error_L[:, 0, 0] / np.abs(z.L - z.L0)[:, 0, 0])


def test_plates_and_what_they_answer_are_gone_with_their_preparation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Counters of a thousand plates, and factors of sixteen, held plates beyond any limit of memory."""
    plates: list[weakref.ref[object]] = []
    for name in ("prepared", "prepared_near"):
        make = getattr(preparing, name)
        make.cache_clear()

        def made(*given, make=make):  # type: ignore[no-untyped-def]
            found = make(*given)
            plates.extend(map(weakref.ref, found))
            return found

        monkeypatch.setattr(preparing, name, made)
    below = '{name="below",shape="rectangle",width="6 mm",length="5 mm",thickness="0.2 mm",material="copper"'
    scene = load_sensor("biorob2018", [f'conductors=[{below},centre=["1 mm","0 mm","-1.5 mm"]}}]', "target.width=6e-3"])
    for gap in (5e-4, 2e-3):
        sheets(scene, 1e-1).impedance(Pose(0.0, gap), 5e6)
    gc.collect()
    assert {type(each()) for each in plates} == {Near, Sheeted}
    divisions.prepared.cache_clear()
    divisions.prepared_near.cache_clear()
    gc.collect()
    assert {each() for each in plates} == {None}


def test_no_frequency_takes_more_memory_than_another(monkeypatch: pytest.MonkeyPatch, sensor: Sensor) -> None:
    """A plate close to its coils keeps n currents of a class and n of what they see, or half a factor of both parts."""
    plates, make, sizes = list[Near](), preparing.prepared_near, []
    monkeypatch.setattr(preparing, "prepared_near", lambda *given: plates.extend(found := make(*given)) or found)
    for frequency in (5.0e6, 4.9e6, 1e5):
        sheets(sensor, 1e-1).impedance(Pose(0.0, 5e-4), frequency)
        sizes.append(array_bytes(plates[-5]))
    assert len({id(plate.classes) for plate in plates}) == 2 * len({id(plate.classes) for plate in plates[:5]})
    assert sizes[1] == sizes[2] == pytest.approx(sizes[0], rel=2e-2)  # n + 1 for n
    assert sizes[0] > sum(len(part.unit) ** 2 * 8 for part in plates[0].classes)


def test_a_round_plate_close_to_coils_is_prepared_once_for_all_frequencies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its complex classes have modes at once, where the scene's frequency is asked first too."""
    kept, make = list[int](), preparing.prepared_near
    monkeypatch.setattr(preparing, "prepared_near", lambda *given: kept.append(id(found := make(*given))) or found)
    scene = disc(5 * MM, 0.1 * MM)
    for frequency in (5e6, 4e6):
        sheets(scene, 1e-1).impedance(Pose(0.0, 6e-5), frequency)
    assert len(kept) == 2 and len(set(kept)) == 1


@pytest.mark.parametrize("asked", [5e6, 3e5])
def test_a_plate_close_to_coils_answers_one_frequency_as_all(sensor: Sensor, asked: float) -> None:
    """By factors as by modes, below the highest frequency that cells resolve; its field too, and what others see."""
    rung, scale = LADDER[0][1], (0.3 * MM, 5e6, (5 * MM, 5 * MM), 1.5 * MM)
    omega, poses = 2 * np.pi * asked, Pose(np.array([0.1, -0.2]) * MM, np.array([0.4, 0.5]) * MM, np.array([0.0, 0.02]))
    seen = Posed(sensor.coils, "rings", rotation_matrix(poses.rotation), poses.centre)
    point = FieldRequest(np.array([[1 * MM, 0.0, -0.2 * MM]]), lambda B: B[None])
    found = []
    for alone in (0.0, omega):
        plates = divisions.prepared_near(sensor.target, rung, scale, 1 * MM, None, alone)  # type: ignore[arg-type]
        values, field = plates[0].reactions(plates, seen, asked, None, point)
        far = seen_from(plates[0], 1 * MM, omega, 1e-3)
        found.append([np.stack(values), field, *answered_by(plates, seen, asked, far)[0][:1]])
    assert isinstance(plates[0].classes[0].reduced, Factored)
    for whole, own in zip(*found, strict=True):
        np.testing.assert_allclose(own, whole, rtol=0, atol=1e-10 * np.abs(whole).max())
    with pytest.raises(ValueError, match=r"omega: must be .* rad/s, for which the plate is solved; got"):
        plates[0].reactions(plates, seen, 1.1 * asked)


def test_a_foil_nine_gaps_a_cell_is_as_finite_elements_have_it() -> None:
    """20 um thick, 54 um over the windings: L was 6e-4 off by five points a cell; common/reference_sheets.json."""
    scene, omega_L = sheet_scene(36), -2.7647186789110863e-05
    found = sheets(scene.sensor, 1e-2).impedance(scene.pose, scene.sensor.frequency)
    off = 2 * np.pi * scene.sensor.frequency * (found.L - found.L0).item() / omega_L - 1.0
    assert abs(off) < 1e-4
