"""What plates at rest see of the coils: against the coils' potential summed at every point, and rings of two discs."""

from dataclasses import replace

import numpy as np
import pytest
from common.ring_discs import joint_reaction

from sits_mech.geometry.sheet_plan import Grading, disc_plan, rectangle_plan
from sits_mech.geometry.tracks import coil_tracks
from sits_mech.magnetics.coils import ring_field
from sits_mech.magnetics.coils.ring_field import coil_potential, filament_counts, ring_profile
from sits_mech.magnetics.coils.straight import track_potential
from sits_mech.magnetics.section.kernels import gauss_rule
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.classes import stacked
from sits_mech.magnetics.space.fields import Box, Prisms, chebyshev_points, gauss_points
from sits_mech.magnetics.space.modes import prepare_sheets
from sits_mech.magnetics.space.near import prepare_near
from sits_mech.magnetics.space.neighbours import field_of
from sits_mech.magnetics.space.sources import PlateCells, Posed, Sources
from sits_mech.memory import SECONDS
from sits_mech.quantities import Pose
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Conductor, SceneError, Target, load_sensor

MM = 1e-3
COPPER = metals()["copper"].conductivity
COILS = load_sensor("biorob2018").coils
BEHIND = Sources(COILS, "rings", (1 * MM, 0.5 * MM, -0.8 * MM), 0.6 * MM)
PLAN = rectangle_plan(8 * MM, 6 * MM, Grading(0.3 * MM, 2.0, 1.2 * MM))
LEVELS = np.array([0.0, 0.05, 0.08]) * MM


def test_potential_is_that_of_all_rings():
    """Under the windings, on the axis of a coil and far aside; the table's splines keep six digits of the largest."""
    some = np.random.default_rng(1)
    points = np.column_stack([some.uniform(-9, 9, (400, 2)), some.choice([-0.08, 0.0, 0.05], 400)]) * MM
    points[0] = COILS[0].centre[0] - 1 * MM, -0.5 * MM, 0.0
    found = BEHIND.potential(points)
    for k, coil in enumerate(COILS):
        exact = coil_potential(coil, points + BEHIND.place, BEHIND.distance)
        np.testing.assert_allclose(found[..., k], exact, rtol=0, atol=1e-6 * np.abs(exact).max())


def test_equal_coils_share_one_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nine of them, and all Gauss points of a division that are as high."""
    coil, asked = COILS[0], list[int]()
    coils = tuple(coil.model_copy(update={"centre": (x * MM, y * MM)}) for x in (-9, 0, 9) for y in (-9, 0, 9))
    monkeypatch.setattr(ring_field, "ring_profile", lambda *given: asked.append(1) or ring_profile(*given))
    plates = replace(BEHIND, coils=coils, distance=0.61 * MM)
    for shift in (0.0, 0.3):
        x, y = (part.ravel() + shift for part in np.meshgrid(np.arange(-12, 13), np.arange(-12, 13)))
        plates.potential(np.column_stack([x, y, 0.0 * x]) * MM)
    assert 0 < len(asked) <= 2


def test_potential_of_the_spirals_is_that_of_their_paths():
    points = np.array([[1.0, 2.0, 0.0], [-4.0, 0.3, 0.05]]) * MM
    seen = Sources(COILS[:1], "spiral", BEHIND.place, 0.6 * MM).potential(points)[..., 0]
    coil = COILS[0].model_copy(update={"centre": (0.0, 0.0)})
    path = track_potential(coil_tracks(coil, "spiral"), *map(gauss_rule, filament_counts(coil, 0.6 * MM)))
    exact = path((points + BEHIND.place - (*COILS[0].centre, 0.0)).T[None])[0].T
    np.testing.assert_allclose(seen[:, :2], exact, rtol=1e-9)


def test_a_rectangle_is_seen_by_its_tracks():
    coil = load_sensor("square-4").coils[0].model_copy(update={"centre": (0.0, 0.0)})
    points = np.array([[1.0, 2.0, 0.0], [-4.0, 0.3, 0.05]]) * MM
    seen = Sources((coil,), "rings", BEHIND.place, 0.6 * MM).potential(points)[..., 0]
    path = track_potential(coil_tracks(coil, "rings"), *map(gauss_rule, filament_counts(coil, 0.6 * MM)))
    exact = path((points + BEHIND.place).T[None])[0].T
    np.testing.assert_allclose(seen[:, :2], exact, rtol=1e-9)


@pytest.mark.slow
def test_means_over_cells_and_their_images():
    """Five Gauss points an axis tell them too; of cells no longer than twice the distance to 1e-3 of the largest."""
    prisms = stacked(PLAN, LEVELS)
    found = BEHIND.means(PLAN, prisms)
    points, weights = gauss_points(prisms, 5)
    for k, g in enumerate(PLAN.group):
        for s, sign in enumerate((1.0, -1.0)):
            moved = np.concatenate([points[..., :2] @ g.T, sign * points[..., 2:]], axis=-1)
            A = coil_potential(COILS[1], moved.reshape(-1, 3) + BEHIND.place, BEHIND.distance).reshape(moved.shape)
            exact = np.einsum("nqa,nq->na", A, weights)
            seen = np.moveaxis(found[:, k, s, :, 1], 0, -1)
            np.testing.assert_allclose(seen, exact, rtol=0, atol=1e-3 * np.abs(exact).max())


def test_a_plate_at_rest_answers_as_one_that_could_move():
    """Polynomials carry the coils' field to 1e-5; what gradients in it drive in the cells, 2e-3, one of them keeps."""
    box = Box(np.array([4.004, 3.003, 0.08]) * MM, (22, 18, 4), (1.5, 1.6, 20.0), 2 * MM)
    far = Sources(COILS, "rings", (1 * MM, 0.5 * MM, 2.08 * MM), 2 * MM)
    (plate,) = prepare_near([(PLAN, LEVELS)], (COPPER, 0.0), box, 5e7 * np.pi, nearby=far)
    (moving,) = prepare_sheets([(PLAN, LEVELS)], COPPER, box, 5e7 * np.pi)
    place = np.array([[*far.place[:2], 2 * MM]])
    (exact,), _ = moving.reactions([moving], Posed(COILS, "rings", np.eye(3)[None], place), 1e6)
    Y = plate.admittance(2e6 * np.pi)
    found = (Y @ np.eye(Y.size))[-2:, -2:]
    np.testing.assert_allclose(found, exact[0], rtol=0, atol=3e-3 * np.abs(exact).max())


@pytest.mark.parametrize("omega", [2e6 * np.pi, 2e7 * np.pi])
@pytest.mark.parametrize("plan", [PLAN, disc_plan(8 * MM, Grading(0.4 * MM, 2.0, 1.5 * MM), orders=4)])
def test_a_plate_at_rest_answers_one_frequency_as_all(plan, omega):
    """By factors as by modes, below and above the highest frequency that cells resolve; its field too."""
    box, place = Box(np.array([4.004, 4.004, 0.08]) * MM, (6, 6, 2), (1.5, 1.6, 20.0), 2 * MM), np.array([[1, 0.5, 2]])
    far = Sources(COILS, "rings", (1 * MM, 0.5 * MM, 2.08 * MM), 2 * MM)
    posed = Posed(COILS, "rings", np.eye(3)[None], place * MM)
    both, alone = (
        prepare_near([(plan, LEVELS)], (COPPER, 0.0), box, 1e7 * np.pi, nearby=far, omega=at)[0]
        for at in (0.0, omega)
    )
    whole, own = ((Y @ np.eye(Y.size)) for Y in (plate.admittance(omega) for plate in (both, alone)))
    np.testing.assert_allclose(own, whole, rtol=0, atol=1e-10 * np.abs(whole).max())
    whole, own = (field_of(plate, posed, omega / (2 * np.pi), np.zeros((1, 3))) for plate in (both, alone))
    np.testing.assert_allclose(own, whole, rtol=0, atol=1e-10 * np.abs(whole).max())


@pytest.mark.slow
@pytest.mark.parametrize("frequency", [2e5, 5e6])
def test_ground_disc_behind_the_coil(frequency):
    """Both discs as rings together; the estimate is no worst case.

    Among other metal 5e-3 is promised of Delta L, of R what is told: plates have one level less there, and where the
    skin is thin, R is some 1e-2 off.
    """
    coil = COILS[0].model_copy(update={"centre": (0.0, 0.0)})
    target = Target(material="copper", shape="disc", diameter=8 * MM, thickness=0.2 * MM)
    plane = Conductor(name="ground", material="copper", shape="disc", diameter=16 * MM, thickness=0.035 * MM,
                      centre=(0.0, 0.0, -coil.height - 0.6175 * MM))
    scene = {"coils": (coil,), "target": target, "conductors": (plane,)}
    sensor = load_sensor("biorob2018").model_copy(update=scene)
    discs = [(4 * MM, 2.1 * MM, 0.2 * MM, COPPER), (8 * MM, plane.centre[2], 0.035 * MM, COPPER)]
    Z, step = joint_reaction(coil, discs, frequency, size=0.35 * MM)
    z = sheets(sensor, 5e-3).impedance(Pose(0.0, 2 * MM, 0.0), frequency)
    delta_L = Z.imag / (2 * np.pi * frequency)
    assert (z.L - z.L0).item() == pytest.approx(delta_L, rel=2e-3)
    assert abs(z.R.item() - Z.real) < min(2.0 * z.error_R.item(), 1.5e-2 * Z.real)
    assert abs(step.imag / Z.imag) < 5e-4
    assert z.report.estimated_error < 1e-2


def test_heights_of_a_plate_take_as_many_points_as_their_distance_asks():
    """Of cells up to twelve gaps long means are 2e-4 of the field off at most, as 12 points an axis have it."""
    plan, clearance, half = rectangle_plan(8 * MM, 6 * MM, Grading(0.3 * MM, 2.0, 0.6 * MM)), 0.05 * MM, 0.1 * MM
    cells = PlateCells(plan, LEVELS, Box(np.array([4.0 * MM, 3.0 * MM, half]), (9, 9, 7), (1.1, 1.1, 4.0), clearance))
    pose = Posed(COILS[:1], "rings", np.eye(3)[None], np.array([[0.4 * MM, 0.1 * MM, clearance]]))
    found, corners = cells.along(pose)[0, 0], plan.nodes[plan.cells]
    for k, z in enumerate(half * (1.0 + chebyshev_points(7))):
        points, weights = gauss_points(Prisms(corners, *2 * (np.full(len(corners), z),)), 12, through=1)
        at = points.reshape(-1, 3) + pose.places[0] - np.array((*COILS[0].centre, 0.0))
        A = coil_potential(COILS[0].model_copy(update={"centre": (0.0, 0.0)}), at, clearance).reshape(points.shape)
        exact = np.einsum("nqa,nq->an", A, weights)
        np.testing.assert_allclose(found[:, 0, :, k], exact, rtol=0, atol=2e-4 * np.abs(exact).max())
    counts = np.diff(cells.points[2], append=cells.points[1].size).reshape(-1, 7).sum(axis=0)
    assert (np.diff(counts) >= 0).all()
    assert counts.sum() < 7 * counts.max() * 2 / 3  # with one rule for all: 1


def test_poses_in_the_plane_of_all_coils_take_half_of_the_points_and_of_the_currents(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As those do that turn out of it by nothing that counts; currents of the other classes are none."""
    box = Box(np.array([4.0, 3.0, 0.08]) * MM, (9, 9, 5), (1.1, 1.1, 4.0), 0.2 * MM)
    plates = prepare_near([(PLAN, LEVELS)], (COPPER, 0.0), box, omega=2e7 * np.pi)
    pose, asked = Pose(np.array([0.1, -0.3]) * MM, np.array([0.4, 0.5]) * MM, np.array([0.0, 0.02])), list[int]()
    potential = ring_field._Table.potential
    counted = lambda table, points: (asked.append(points.size), potential(table, points))[1]  # noqa: E731
    monkeypatch.setattr(ring_field._Table, "potential", counted)
    found = []
    for aside in (0.0, 1e-12):
        places = pose.centre + (0.0, aside, 0.0)
        seen = Posed(COILS, "rings", rotation_matrix(pose.rotation), places)
        assert seen.mirrored == (aside == 0.0)
        found.append(plates[0].reactions(plates, seen, 1e7)[0][0])
    few, whole = np.reshape(asked, (2, -1)).sum(axis=1)
    assert 2 * few == whole
    np.testing.assert_allclose(*found, rtol=0, atol=1e-9 * np.abs(found[1]).max())
    driving = plates[0].cells.means(plates[0].cells.along(seen))
    sizes = [np.abs(part.induced(driving, False)).max() for part in plates[0].classes]
    none = [not part.induced(driving, True).any() for part in plates[0].classes]
    assert sum(none) == 4 and max(np.compress(none, sizes)) < 1e-6 * max(sizes)


@pytest.mark.parametrize("backed", [pytest.param(False, marks=pytest.mark.slow), True])
def test_straight_tracks_that_take_too_long_are_refused_before_they_are_summed(
    backed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Close to a target, and of a plate at rest, by the points that all divisions take."""
    sensor = load_sensor("biorob2018")
    plate = Conductor(name="back", material="copper", shape="rectangle", centre=(0.0, -2e-3), width=2e-2, length=2e-2,
                      thickness=1e-4)  # fmt: skip
    asked = sensor.model_copy(update={"conductors": (plate,), "target": None} if backed else {})
    monkeypatch.setenv(SECONDS.variable, "20")

    def summed(*given: object) -> None:
        raise AssertionError("the field was summed")

    monkeypatch.setattr("sits_mech.magnetics.coils.straight._strand_potential", summed)
    with pytest.raises(SceneError, match=r"^coils: the field of \d+ straight filaments at \d+ points must take"):
        sheets(asked, 1e-2, windings="spiral").impedance(Pose(0.0, 1e-4), 5e6)


def test_points_are_as_many_as_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    sensor = load_sensor("biorob2018")
    plan, levels = rectangle_plan(2e-2, 2e-2, Grading(2e-4, 1.9, 3e-3)), np.array([0.0, 1e-4])
    seen, sources = list[int](), Sources(sensor.coils, "rings", (0.0, 0.0, 1e-3), 1e-3)
    found = Sources.potential
    monkeypatch.setattr(Sources, "potential", lambda self, points: (seen.append(len(points)), found(self, points))[1])
    sources.means(plan, stacked(plan, levels))
    assert sources.points(plan, stacked(plan, levels)) == sum(seen)
