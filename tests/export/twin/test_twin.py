"""The evaluator that is copied: the calibration's digits, its inverse, the pad in time, and other array libraries."""

import json
import shutil
import subprocess
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.export.source import Source
from sits_mech.export.twin import twin as twin_module
from sits_mech.export.twin.arrays import inverse_arrays, twin_arrays
from sits_mech.export.twin.maps import over_wrenches
from sits_mech.export.twin.twin import FAULT_FLAGS, FAULT_FULL, FAULT_ZERO, IGNORED, OUTSIDE, UNSOLVED, Twin
from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.report.folder import read_calibration
from sits_mech.silicone.history import relaxed_share, retardation
from sits_mech.silicone.material import Silicone

PRONY = ((0.1, 0.5), (0.2, 8.0))


@pytest.fixture(scope="module")
def source(calibrated: Path) -> Source:
    """The small calibration."""
    return Source(*read_calibration(calibrated))


@pytest.fixture(scope="module")
def cal(source: Source) -> Calibration:
    """Its maps."""
    return sensor_calibration(source.sensor, source.data)


@pytest.fixture(scope="module")
def twin(source: Source, tmp_path_factory: pytest.TempPathFactory) -> Twin:
    """Its twin by way of the file, of a silicone that creeps."""
    numbers, _ = twin_arrays(source)
    weights, times = retardation(PRONY)
    shares, taus = np.array(PRONY).T
    numbers |= {"creep_weights": weights, "creep_times": times, "relaxation_times": taus}
    numbers |= {"relaxation_weights": shares / (1.0 - shares.sum()), "prony": np.array(PRONY)}
    path = tmp_path_factory.mktemp("twin") / "sensor.npz"
    np.savez(path, **numbers)
    return Twin.load(path)


@pytest.fixture(scope="module")
def wrenches(cal: Calibration) -> np.ndarray:
    """Ten thousand of the table's box."""
    found = np.zeros((10_000, 6))
    found[:, :2] = np.random.default_rng(1).uniform(cal.low, cal.high, (10_000, 2))
    return found


def test_shows_the_digits_of_the_calibration(twin: Twin, cal: Calibration, wrenches: np.ndarray) -> None:
    """Inductances to rounding, codes as integers: the same polynomials, summed in another order."""
    found = twin.read(wrenches)
    assert np.abs((found.L - cal.forward(wrenches[:, :2])) / cal.full_scale).max() < 1e-12
    assert np.abs(found.codes - cal.codes(wrenches[:, :2])).max() < 0.5 + 1e-6 and found.codes.dtype.kind == "i"
    assert not found.flags.any()


@pytest.mark.parametrize("name", ["wrench", "pose"])
def test_slopes_are_derivatives(name: str, twin: Twin) -> None:
    """Of every output by every scaled component, by central differences."""
    map_, h = twin._map(name), 1e-5
    x = np.random.default_rng(5).uniform(-0.9, 0.9, (len(map_.columns), 50))
    _, *slopes = map_.at(list(x), slopes=True)
    for row, slope in enumerate(slopes):
        move = h * np.eye(len(x))[row][:, None]
        by_difference = (map_.at(list(x + move))[0] - map_.at(list(x - move))[0]) / (2.0 * h)
        scale = np.abs(slope).max(axis=1, keepdims=True)
        assert np.abs((slope - by_difference) / scale).max() < 1e-6


def test_single_precision_holds_a_hundred_thousandth(twin: Twin, cal: Calibration, wrenches: np.ndarray) -> None:
    """Of full scale, L and codes; what comes back is single too."""
    found = twin.read(wrenches.astype(np.float32))
    assert found.L.dtype == np.float32
    assert np.abs((found.L - cal.forward(wrenches[:, :2])) / cal.full_scale).max() < 1e-5
    off = (found.codes - cal.codes(wrenches[:, :2])) / cal.code_calibration.full_scale
    assert np.abs(off).max() < 1e-5
    back = twin.estimate(found.L)
    assert back.wrench.dtype == np.float32 and np.abs(back.wrench - wrenches).max() < 1e-3


def test_estimates_the_wrench(twin: Twin, cal: Calibration, wrenches: np.ndarray) -> None:
    """Out and back to rounding; by codes to what their rounding is worth; as the calibration's own inverse."""
    found = twin.read(wrenches)
    back, by_codes = twin.estimate(found.L), twin.estimate_codes(found.codes)
    assert not back.flags.any() and np.abs(back.wrench - wrenches).max() < 1e-10
    worth = cal.code_calibration.force_error(wrenches[:, :2], np.full(2, 0.6))
    assert np.all(np.abs(by_codes.wrench - wrenches)[:, :2] < worth) and not by_codes.flags.any()
    own = cal.inverse(found.L[:50])
    assert np.abs(back.wrench[:50, :2] - own.forces).max() < 1e-10


FAULTS = {  # of two coils; the second time of each the well one first
    "full": (2**28 - 1, FAULT_FULL), "zero": (0, FAULT_ZERO), "amplitude": (0x1B3D3D64, FAULT_FLAGS),
    "under-range": (0x8B3D3D64, FAULT_FLAGS), "all": (2**32 - 1, FAULT_FLAGS),
}


@pytest.mark.parametrize("dtype", [np.int64, np.uint32, float])
def test_codes_of_a_coil_that_is_not_read_are_faults(dtype: type, twin: Twin) -> None:
    """Flags above the code's bits, full scale and zero, of the first coil that has one; a reading beside goes on."""
    wrench = np.array([[0.2, 1.0, 0.0, 0.0, 0.0, 0.0]])
    well = twin.read(wrench).codes[0].astype(np.int64)
    rows, flags = [well], [0]
    for code, flag in FAULTS.values():
        rows += [np.array([code, well[1]]), np.array([well[0], code]), np.array([code, 0])]
        flags += [UNSOLVED + flag] * 3
    found = twin.estimate_codes(np.array(rows).astype(dtype))
    assert found.flags.tolist() == flags and np.all(np.isnan(found.wrench[1:]))
    assert found.wrench[0] == pytest.approx(wrench[0], abs=1e-4)


@pytest.mark.skipif(not shutil.which("node"), reason="no node")
def test_the_evaluator_in_javascript_knows_them(twin: Twin) -> None:
    """The same flags of the same codes, and the wrench of a reading."""
    well = twin.read(np.array([[0.2, 1.0, 0.0, 0.0, 0.0, 0.0]])).codes[0].tolist()
    rows = [well, *([code, well[1]] for code, _ in FAULTS.values()), *([well[0], code] for code, _ in FAULTS.values())]
    kept = {name: np.asarray(value).tolist() for name, value in twin.numbers.items() if not name.endswith("_float32")}
    kept = {name: value for name, value in kept.items() if name not in ("mullins", "compliance")}  # with NaN
    text = Path(twin_module.__file__).with_name("twin.js").read_text()
    ask = f"const t = twinOf({json.dumps(kept)}); console.log(JSON.stringify({json.dumps(rows)}.map(t.estimateCodes)))"
    done = subprocess.run(["node", "-"], input=f"{text}\n{ask}", capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    found, own = json.loads(done.stdout), twin.estimate_codes(np.array(rows))
    assert [each["flags"] for each in found] == own.flags.tolist()
    assert [each["wrench"][0] is None for each in found] == [False] + [True] * (len(rows) - 1)
    assert found[0]["wrench"] == pytest.approx(own.wrench[0], abs=1e-12)


def test_the_edge_is_held_and_told(twin: Twin, cal: Calibration) -> None:
    """Beyond the box as at its edge; a component that the map does not know is ignored; readings of nothing are NaN."""
    beyond = np.array([[1.3, 1.0, 0.0, 0.0, 0.0, 0.0], [0.5, -1.0, 0.0, 0.0, 0.0, 0.0]])
    at = np.array([[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]])
    assert np.array_equal(twin.read(beyond).L, twin.read(at).L)
    assert twin.read(beyond).flags.tolist() == [OUTSIDE] * 2 and not twin.read(at).flags.any()
    beside = at + [0.0, 0.0, 0.0, 0.2, 0.0, 0.0]
    assert twin.read(beside).flags.tolist() == [IGNORED] * 2
    wrong = twin.estimate(np.array([cal.L0 * 2.0, np.full(2, np.nan)]))
    assert np.all(wrong.flags & UNSOLVED) and np.all(np.isnan(wrong.wrench))
    near = twin.estimate(cal.forward([[1.015, 1.0], [1.05, 1.0]], beyond=True))
    assert near.flags.tolist() == [0, OUTSIDE] and near.wrench[:, 0] == pytest.approx([1.015, 1.02], abs=1e-9)


def test_what_is_no_number_is_told(twin: Twin, cal: Calibration) -> None:
    """NaN shows the domain's middle and a flag, the sensors beside it what they show alone, without a warning."""
    at = np.zeros((4, 6))
    at[:, :2] = [[0.1, 1.0], [np.nan, 1.0], [np.nan, np.nan], [0.1, 1.0]]
    middle = np.where(np.isnan(at), np.append(0.5 * (cal.low + cal.high), np.zeros(4)), at)
    at[3, 3] = np.nan
    found, as_told = twin.read(at), twin.read(middle)
    assert np.array_equal(found.L, as_told.L) and np.array_equal(found.codes, as_told.codes)
    assert found.flags.tolist() == [0, OUTSIDE, OUTSIDE, IGNORED] and np.all(np.isfinite(found.L))
    pose = 0.5 * (twin.numbers["pose_low"] + twin.numbers["pose_high"])
    poses = np.pad([pose, pose * np.nan], ((0, 0), (0, 3)))
    found = twin.read_pose(poses)
    assert np.array_equal(found.L[1], found.L[0]) and found.flags.tolist() == [0, OUTSIDE]
    assert np.array_equal(found.codes[1], found.codes[0])
    valid = np.ones((5, 5), dtype=np.uint8)
    valid[4, 4] = 0
    readings = np.array([as_told.L[0], as_told.L[0] * [1.0, np.nan], [np.nan, np.nan]])
    for each in (twin, Twin({**twin.numbers, "valid": valid})):
        back = each.estimate(readings)
        assert back.flags.tolist() == [0, UNSOLVED, UNSOLVED] and np.all(np.isnan(back.wrench[1:]))
        assert back.wrench[0, :2] == pytest.approx([0.1, 1.0], abs=1e-9)


def test_a_load_that_is_no_number_stays(twin: Twin) -> None:
    """What pressed is unknown from then on: flagged at every later step, at the middle; the sensor beside goes on."""
    load = np.zeros((2, 6))
    load[:, :2] = 0.2, 1.0
    broken = load * [[1.0], [np.nan]]
    state, alone = twin.start(2), twin.start(1)
    for given in (load, broken, load):
        state, shown = twin.step(state, given, 0.1)
        alone, own = twin.step(alone, load[:1], 0.1)
        assert np.array_equal(shown.L[0], own.L[0]) and shown.flags[0] == 0
    assert shown.flags[1] == OUTSIDE and np.array_equal(shown.L[1], twin.read(broken).L[1])


def test_a_wrench_without_twin_has_no_estimate(twin: Twin, cal: Calibration) -> None:
    """Where the domain says that another wrench shows the same, there is none."""
    valid = np.ones((5, 5), dtype=np.uint8)
    valid[4, 4] = 0  # the corner of the largest forces
    part = Twin({**twin.numbers, "valid": valid})
    found = part.estimate(cal.forward(np.array([[0.99, 2.99], [0.0, 1.0]])))
    assert found.flags.tolist() == [UNSOLVED, 0]


def test_a_fold_is_found(source: Source) -> None:
    """L_2 = (z - 0.6)^2 over 0 to 1: below 0.2 one wrench, above two show the same; flags as of the calibration."""
    x, z = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, 1.0, 9)] * 2, indexing="ij"))
    L = 1e-6 + 1e-8 * np.stack([x, (z - 0.6) ** 2 + 1e-3 * x], -1)
    free = ("H", np.full(2, np.nan))
    cal = calibration_of(np.stack([x, z], -1), L, forces=("F_x", "F_z"), coils=("C1", "C2"), free=free)
    over, notes = over_wrenches(Source(source.sensor, xr.Dataset()), cal, None), list[str]()
    numbers = over.arrays("wrench") | inverse_arrays(cal, None, over.base, notes)
    twin = Twin({**numbers, "coils": np.array(cal.coils), "codes": np.array(0)})
    wrench = np.zeros((400, 6))
    wrench[:, :2] = np.random.default_rng(2).uniform(0.02, 0.98, (400, 2))
    wrench = wrench[np.abs(wrench[:, 1] - 0.2) > 0.02]  # the edge lies between two nodes
    found = twin.estimate(twin.read(wrench).L)
    assert np.array_equal(found.flags == 0, wrench[:, 1] < 0.2) and "have no estimate" in notes[0]
    assert np.abs(found.wrench - wrench)[found.flags == 0].max() < 1e-6


def test_poses(twin: Twin, source: Source) -> None:
    """At the table's own poses what the table has, but for free space, by the map's error; that is the true one."""
    data = source.data
    pose = np.zeros((data["d_v"].size, 6))
    for k, name in enumerate(("d_h", "d_v", "alpha")):
        pose[:, k] = data[name].to_numpy().ravel()
    found = twin.read_pose(pose)
    L = twin.read(_loads(source)).L
    assert np.abs(found.L - L).max() < 3e-5 * L.min()  # free space once per metre and once in henry
    off = np.abs(found.L - L - (found.L - L)[0]).max(axis=0)
    assert np.all(off < twin.numbers["pose_error"][:2] + twin.numbers["wrench_error"][:2]) and not found.flags.any()
    assert np.all(twin.numbers["pose_error"][:2] < 1e-5 * np.ptp(L, axis=0))
    assert twin.read_pose(pose + [0.0, 5e-3, 0.0, 1e-3, 0.0, 0.0]).flags.tolist() == [OUTSIDE + IGNORED] * len(pose)


def _loads(source: Source) -> np.ndarray:
    """The table's wrenches."""
    F_x, F_z = np.meshgrid(source.data["F_x"], source.data["F_z"], indexing="ij")
    found = np.zeros((F_x.size, 6))
    found[:, 0], found[:, 1] = F_x.ravel(), F_z.ravel()
    return found


def test_creep_is_that_of_the_pad(twin: Twin) -> None:
    """Uneven steps, three sensors at once: the elastic load of `relaxed_share`; after long rest the slow answer."""
    random = np.random.default_rng(3)
    time = np.concatenate([[0.0], np.cumsum(10.0 ** random.uniform(-3.0, 0.5, 40))])
    share = np.concatenate([[0.0], random.uniform(0.0, 1.0, 40)])
    silicone = Silicone("s", "neo-hookean", (1e4,), 1e7, prony=PRONY)
    elastic = relaxed_share(silicone, time, share)
    peak = np.array([[0.5, 2.0, 0, 0, 0, 0], [-0.5, 1.0, 0, 0, 0, 0], [0.0, 3.0, 0, 0, 0, 0]])
    state = twin.start(3)
    for k in range(1, len(time)):
        state, shown = twin.step(state, share[k] * peak, float(time[k] - time[k - 1]))
        assert shown.L == pytest.approx(twin.read(elastic[k] * peak).L, rel=1e-13)
    state, shown = twin.step(state, share[-1] * peak, 1e4)
    state, shown = twin.step(state, share[-1] * peak, 1e4)
    assert shown.L == pytest.approx(twin.read(share[-1] * peak).L, rel=1e-10)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_each_sensor_has_its_own_time(n: int, twin: Twin) -> None:
    """As many as branches, fewer and more: each as alone; one time for all in any form is the same."""
    load = np.zeros((n, 6))
    load[:, 1] = np.linspace(1.0, 2.0, n)
    times = [0.02, 0.5, 3.0][:n]
    state, shown = twin.step(twin.start(n), load, times)
    state, shown = twin.step(state, 0.5 * load, np.array(times))
    _, back = twin.recover(twin.start(n), shown.L, np.array(times))
    for k, dt in enumerate(times):
        own, one = twin.step(twin.start(1), load[k : k + 1], dt)
        own, one = twin.step(own, 0.5 * load[k : k + 1], dt)
        assert shown.L[k] == pytest.approx(one.L[0], rel=1e-13) and state[..., k] == pytest.approx(own[..., 0])
        _, found = twin.recover(twin.start(1), one.L, dt)
        assert back.wrench[k] == pytest.approx(found.wrench[0], rel=1e-9)
    for same in (2, np.float32(2.0), np.array(2), np.full(n, 2.0)):
        assert np.array_equal(twin.step(twin.start(n), load, same)[1].L, twin.step(twin.start(n), load, 2.0)[1].L)
    small = twin.step(twin.start(n, load.astype(np.float32)), load.astype(np.float32), np.array(times))[1].L
    assert small.dtype == np.float32


@pytest.mark.parametrize("name", ["numpy", "torch", "jax.numpy", "array_api_strict"])
def test_times_that_are_none(name: str, twin: Twin) -> None:
    """Nothing but positive, whatever holds it; of the sensors or one."""
    pytest.importorskip(name.partition(".")[0])
    xp, load = import_module(name), np.zeros((3, 6))
    as_array = [xp.asarray(each) for each in (-1.0, 0.0, 0, float("nan"), [0.1, 0.0, 0.1], [0.1, -0.1, 0.1])]
    given, state = xp.asarray(load), twin.start(3, xp.asarray(load))
    for dt in (np.float32(-1.0), np.int64(0), np.array(0.0), *as_array, 0.0, -1, float("nan")):
        with pytest.raises(ValueError, match=r"^dt: must be positive \[s\]; got (0.0|-1.0|-0.1\d*|nan)$"):
            twin.step(state, given, dt)
        with pytest.raises(ValueError, match="dt: must be positive"):
            twin.recover(state, given[:, :2], dt)
    for dt in (xp.asarray([0.1, 0.1]), xp.asarray([0.1]), xp.asarray([[0.1], [0.1], [0.1]]), [0.1, 0.1]):
        with pytest.raises(ValueError, match=r"dt: must be one time or one for each of 3 sensors \[s\]; got shape \("):
            twin.step(state, given, dt)


def test_a_sudden_load_meets_the_unrelaxed_pad(twin: Twin) -> None:
    """After a step the elastic load is 1 - sum w of it."""
    load = np.array([[0.4, 1.5, 0, 0, 0, 0]])
    _, shown = twin.step(twin.start(1), load, 1e-9)
    assert shown.L == pytest.approx(twin.read(0.7 * load).L, rel=1e-9)


@pytest.mark.slow
def test_what_creeps_is_undone(twin: Twin) -> None:
    """G undoes C up to the elastic load's bend between samples, which falls as dt squared."""
    off = []
    for dt in (0.02, 0.01):
        time = np.arange(1, int(2.0 / dt) + 1) * dt
        states, error = (twin.start(1), twin.start(1)), 0.0
        for t in time:
            load = np.array([[0.3 * np.sin(3.0 * t), 1.0 - np.cos(2.0 * t), 0, 0, 0, 0]])
            ahead, shown = twin.step(states[0], load, dt)
            back, found = twin.recover(states[1], shown.L, dt)
            states, error = (ahead, back), max(error, float(np.abs(found.wrench - load).max()))
        off.append(error)
    assert off[0] < 1e-4 and 3.3 < off[0] / off[1] < 4.7


def test_refusals(twin: Twin, tmp_path: Path) -> None:
    """One line each."""
    with pytest.raises(ValueError, match=r"wrench: must be of shape \(n, 6\); got \(3, 2\)"):
        twin.read(np.zeros((3, 2)))
    with pytest.raises(ValueError, match=r"L: must be of shape \(n, 2\); got \(2,\)"):
        twin.estimate(np.ones(2))
    with pytest.raises(ValueError, match=r"must be the sensor.npz of a twin; got: "):
        Twin.load(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("no numbers")
    with pytest.raises(ValueError, match="must be the sensor.npz of a twin"):
        Twin.load(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", a=np.ones(2))
    with pytest.raises(ValueError, match="it holds no wrench_coefficients"):
        Twin.load(tmp_path / "other.npz")
    less = {name: value for name, value in twin.numbers.items() if not name.startswith(("guess", "pose"))}
    with pytest.raises(ValueError, match="guess: two coils cannot"):
        Twin({**less, "no_inverse": np.array("two coils cannot")}).estimate(np.ones((1, 2)))
    with pytest.raises(ValueError, match="pose: must be of a twin with a map of poses"):
        Twin(less).read_pose(np.zeros((1, 6)))
    with pytest.raises(ValueError, match="codes: must be of a twin with a converter"):
        Twin({**twin.numbers, "codes": np.array(0)}).estimate_codes(np.ones((1, 2)))


@pytest.mark.parametrize("name", ["torch", "jax.numpy", "array_api_strict"])
def test_arrays_of_other_libraries_go_through(name: str, twin: Twin, wrenches: np.ndarray) -> None:
    """Each in its own arrays and precision, the same numbers: readings, estimates, steps in time."""
    pytest.importorskip(name.partition(".")[0])
    xp = import_module(name)
    given = xp.asarray(wrenches[:200].astype(np.float32))
    found, state = twin.read(given), twin.start(200, given)
    state, shown = twin.step(state, given, 0.1)
    state, back = twin.recover(twin.start(200, given), found.L, 0.1)
    own = twin.read(wrenches[:200].astype(np.float32))
    _, slow = twin.step(twin.start(200, own.L), wrenches[:200].astype(np.float32), 0.1)
    for ours, theirs in ((own.L, found.L), (slow.L, shown.L)):
        assert type(theirs) is type(given) and str(theirs.dtype).endswith("float32")
        assert np.asarray(theirs) == pytest.approx(ours, rel=1e-6)
    assert np.abs(np.asarray(found.codes) - own.codes).max() <= 1 and type(back.wrench) is type(given)
    assert np.asarray(twin.estimate(found.L).wrench) == pytest.approx(wrenches[:200], abs=1e-3)
    assert type(twin.estimate_codes(found.codes).wrench) is type(given)
    assert type(twin.read_pose(given).L) is type(given)
    times = np.linspace(0.05, 0.2, 200)
    _, own_time = twin.step(twin.start(200, own.L), wrenches[:200].astype(np.float32), times)
    for dt in (times, xp.asarray(times.astype(np.float32))):
        _, shown = twin.step(twin.start(200, given), given, dt)
        assert str(shown.L.dtype).endswith("float32") and np.asarray(shown.L) == pytest.approx(own_time.L, rel=1e-6)
    none = twin.read(given * float("nan"))
    assert np.all(np.asarray(none.flags) == OUTSIDE + IGNORED) and np.all(np.isfinite(np.asarray(none.L)))


def test_a_step_is_traced_by_jax(twin: Twin, wrenches: np.ndarray) -> None:
    """Compiled, and with a derivative: that of the map."""
    jax = pytest.importorskip("jax")
    given = jax.numpy.asarray(wrenches[:4].astype(np.float32))
    state, shown = jax.jit(twin.step)(twin.start(4, given), given, 0.01)
    assert np.asarray(shown.L) == pytest.approx(np.asarray(twin.step(twin.start(4, given), given, 0.01)[1].L), rel=1e-6)
    times = jax.numpy.asarray([0.01, 0.02, 0.01, 0.02])
    for dt in (times, times[0]):
        _, shown = jax.jit(twin.step)(twin.start(4, given), given, dt)
        own = twin.step(twin.start(4, given), given, dt)[1]
        assert np.asarray(shown.L) == pytest.approx(np.asarray(own.L), rel=1e-6)
    slope = jax.jacfwd(lambda F: twin.read(F[None]).L[0])(given[0])
    h = np.zeros((2, 6))
    h[:, 1] = 1e-3, -1e-3
    L = twin.read(wrenches[:1] + h).L
    assert np.asarray(slope[:, 1]) == pytest.approx((L[0] - L[1]) / 2e-3, rel=1e-3)
