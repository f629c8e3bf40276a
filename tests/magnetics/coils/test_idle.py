"""What shorted coils take: by the answer's own matrices, and at most where no pose is known."""

import numpy as np
import pytest

from sits_mech.analysis.readings.terminals import terminal_impedance
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.models import MAGNETICS
from sits_mech.chain.plans.plan import plan
from sits_mech.description import Question
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.coils.idle import idle_bound, idle_share
from sits_mech.magnetics.sheets import sheets
from sits_mech.notes import OmissionKind, Relative
from sits_mech.quantities import Array, Impedance, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
REPORT = SolveReport("none", 0, 0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return load_sensor("biorob2018")


def seen(L: Array, L0: Array, R: Array) -> Impedance:
    """An answer of some matrices at 1 rad/s."""
    none = np.zeros_like(L0)
    return Impedance(1.0 / (2.0 * np.pi), L, R, L0, np.zeros(len(L0)), none, none, "H", REPORT)


@pytest.mark.parametrize(("gap", "true"), [(1 * MM, 0.0054), (2 * MM, 0.0073), (5 * MM, 0.0104)])
def test_sections_take_their_own_coupling(sensor: Sensor, gap: float, true: float) -> None:
    """Twenty times that of rings in space, as two endless windings at the terminals show."""
    found = planar_bars(sensor, 1e-2).impedance(Pose(0.0, gap), sensor.frequency)
    assert idle_share(found) == pytest.approx(true, rel=0.01)
    pose = Pose(0.0, gap)
    every = MAGNETICS["planar"].omissions(sensor, Question(pose=pose, answer=(pose, found)))
    (item,) = (item for item in every if item.kind == OmissionKind.IDLE)
    assert item.size == idle_share(found) and item.relative_to == Relative.FREE and not item.counts


@pytest.mark.slow
def test_a_plan_holds_for_all_distances_beyond_rest(sensor: Sensor) -> None:
    """By formula (2), within twice the largest; and for the sheets' coils as well."""
    model = planar_bars(sensor, 1e-2)
    most = max(idle_share(model.impedance(Pose(0.0, d * MM), 5e6)) for d in (2.0, 3.0, 5.0, 8.0, 20.0))
    for name, loads, least in (("planar", [], most), ("auto", [Wrench(0.5, 2.0)], 3.92e-4)):  # sheets: at 5 mm
        left_out = plan(sensor, loads, magnetics=name).left_out
        (size,) = (item.size for item in left_out if item.kind == OmissionKind.IDLE)
        assert least < size < 2.0 * least


def test_shorted_at_the_terminals(sensor: Sensor) -> None:
    """In free space, henry and ohm, with tracks and without leads: M^2/L less what resistance takes of it."""
    open_ = sensor.model_copy(update={"readout": sensor.readout.model_copy(update={"idle_coil": "open"})})
    bare = sensor.model_copy(update={"target": None})
    found = sheets(bare, 1e-2).impedance(Pose(0.0, 2 * MM), sensor.frequency)
    (shorted, _), (alone, _) = (at_terminals(each, found) for each in (sensor, open_))
    assert shorted is not None and alone is not None
    missed = float(np.max(np.abs(shorted.L - alone.L)) / found.L0[0, 0])
    assert idle_share(found) == pytest.approx(3.58e-4, rel=1e-3)
    assert idle_bound(found) == pytest.approx(idle_share(found), rel=1e-9)
    assert missed == pytest.approx(idle_share(found), rel=0.05)


def test_many_coils_are_bounded_by_all() -> None:
    """Random passive targets over five coils: formula (2) is no less than (1), which terminals show."""
    random = np.random.default_rng(7)
    for _ in range(50):
        flux = random.normal(size=(5, 8)) * 0.1
        L0 = np.eye(5) + 0.04 * (lambda a: a + a.T)(np.triu(random.uniform(-1, 1, (5, 5)), 1))
        found = seen(L0 - flux @ flux.T, L0, 0.05 * flux @ flux.T)
        shorted = load_sensor("biorob2018").readout
        Z = found.R + 1j * found.L
        taken = np.abs(np.diag(Z) - terminal_impedance(Z, np.zeros(5), shorted, 1.0)).max()
        assert idle_share(found) == pytest.approx(taken, rel=1e-9)
        assert idle_share(found) <= idle_bound(found)


def test_coils_that_are_one_have_no_bound() -> None:
    """And a single one none beside it."""
    one = np.ones((2, 2))
    assert np.isinf(idle_bound(seen(np.zeros((2, 2)), one, 0.0 * one)))
    assert idle_bound(seen(np.eye(1), np.eye(1), np.zeros((1, 1)))) == 0.0


def test_the_bound_of_three_coils_by_hand() -> None:
    """Alike, and each k from both others: two take of the one that is driven; a plate takes of all, tracks lose."""
    k, t, lost = 0.1, 0.2, 0.05
    L0 = np.where(np.eye(3, dtype=bool), 1.0, k)
    bare = seen(L0, L0, np.zeros((3, 3)))
    assert idle_bound(bare) == pytest.approx(2.0 * k**2 / (1.0 - k))
    assert idle_share(bare) == pytest.approx(2.0 * k**2 / (1.0 + k))
    R = lost * (1.0 - np.eye(3)) + 1e-3 * np.eye(3)
    under = seen(L0 - t * np.eye(3), L0, R)
    assert idle_bound(under) == pytest.approx(2.0 * (k**2 + lost**2) / ((1.0 - t) * (1.0 - k / (1.0 - t))))
    close = seen(L0, np.where(np.eye(3, dtype=bool), 1.0, 0.6), R)
    assert idle_bound(close) == np.inf and idle_bound(seen(-0.1 * L0, L0, R)) == np.inf
    one = seen(L0[:1, :1], L0[:1, :1], R[:1, :1])
    assert idle_bound(one) == idle_share(one) == 0.0


@pytest.mark.parametrize("seed", range(8))
def test_the_bound_holds_what_is_taken(seed: int) -> None:
    """Of coils by chance over a plate by chance: at rest it holds for every smaller change."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    size = 1e-6 * rng.uniform(1.0, 3.0, n)
    scale = np.sqrt(np.outer(size, size))

    def alike(least: float, most: float) -> Array:
        half = np.triu(rng.uniform(least, most, (n, n)), 1)
        return (half + half.T) * scale

    L0 = np.diag(size) + alike(-0.15, 0.15)
    change = np.diag(size * rng.uniform(0.0, 0.3, n)) + alike(-0.05, 0.05)
    R = np.diag(size * rng.uniform(0.0, 0.05, n)) + alike(-0.02, 0.02)
    bound = idle_bound(seen(L0 - change, L0, R))
    for share in (0.0, 0.5, 1.0):
        assert idle_share(seen(L0 - share * change, L0, share * R)) <= bound < np.inf


def test_the_bound_is_of_the_worst_of_many_poses() -> None:
    """What metal takes at each, entry by entry; alone it is as at once."""
    L0 = np.array([[2.0, -0.1], [-0.1, 2.0]])
    near, far = np.array([[1.5, -0.05], [-0.05, 1.8]]), np.array([[1.9, -0.3], [-0.3, 1.95]])
    both = seen(np.stack([near, far]), L0, np.zeros((2, 2, 2)))
    one = seen(np.array([[1.5, -0.3], [-0.3, 1.8]]), L0, np.zeros((2, 2)))
    assert idle_bound(both) == idle_bound(one) > idle_bound(seen(near, L0, np.zeros((2, 2))))
