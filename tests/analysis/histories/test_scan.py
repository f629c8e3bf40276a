"""Codes over time: of constant, rising and swinging inductances against closed forms; noise by its deviation."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.analysis.histories.response import in_time
from sits_mech.analysis.histories.scan import checked_count, scan, windows, with_codes
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.notes import Note, NoteKind, unpacked
from sits_mech.readout.converter import CONVERTERS, code_of, conversion_time, tank_frequency, tank_inductance
from sits_mech.readout.front_end import front_end
from sits_mech.scene.sensor import SceneError, load_sensor

C = 330e-12
L0, R0 = np.array([2.0e-6, 2.1e-6]), np.array([3.0, 1.5])  # channels of different settling


def front(part="LDC1614", coils=2, rcount=2048):
    several = np.resize(L0, coils), np.resize(R0, coils)
    return front_end(CONVERTERS[part], *several, C, rcount=rcount)


def of_frequency(frequency):
    return tank_inductance(frequency, C)


def code(one, frequency):
    return code_of(frequency, one.part, one.reference, one.input_divider)


def test_a_constant_load_gives_the_converter_s_codes():
    """In every scan the code of the converter, rounded; and the inductance of that code."""
    one = front()
    found = scan(one, C, [0.0, 5.0 * one.period], np.tile(L0, (2, 1)), seed=None)
    expected = np.rint(code(one, tank_frequency(L0, C)))
    assert found.code.shape == (5, 2) and np.all(found.code == expected) and found.code.dtype == np.int64
    assert found.L == pytest.approx(np.tile(L0, (5, 1)), rel=2e-8)


@pytest.mark.parametrize(("part", "coils"), [("LDC1614", 4), ("LDC1612", 2), ("LDC1101", 1)])
def test_channels_go_one_after_the_other(part, coils):
    """Windows within their channels' times, by the data sheet's formulas; the same each scan."""
    one = front(part, coils)
    begin, window = windows(one)
    assert window == pytest.approx(16 * 2048 / one.reference)
    if coils > 1:
        step = conversion_time(2048, one.part, one.reference) + 16 * one.settlecount / one.reference
        step = step + 692e-9 + 5 / one.reference
        np.testing.assert_allclose(begin, np.r_[0.0, np.cumsum(step)[:-1]] + 16 * one.settlecount / one.reference)
        assert one.period == pytest.approx(step.sum(), rel=1e-12)
    else:
        assert begin == pytest.approx(0.0)
        assert one.period == pytest.approx(conversion_time(2048, one.part, one.reference))
    found = scan(one, C, [0.0, 3.5 * one.period], np.tile(np.resize(L0, coils), (2, 1)), seed=None)
    np.testing.assert_allclose(found.time, one.period * np.arange(3)[:, None] + begin + 0.5 * window)
    np.testing.assert_allclose(found.ready, found.time + 0.5 * window + one.part.overhead / one.reference)


def test_a_ramp_is_read_at_the_middle_of_the_window():
    """A frequency that rises evenly has its mean there: what each coil shows is of its own time."""
    one, rise = front(), 2e5  # [Hz/s]
    time = np.linspace(0.0, 20.0 * one.period, 7)
    f0 = tank_frequency(L0, C)
    found = scan(one, C, time, of_frequency(f0 + rise * time[:, None]), seed=None)
    assert np.abs(found.code - code(one, f0 + rise * found.time)).max() <= 0.501
    assert found.code[0, 1] - code(one, f0[1]) > 1e3  # the second coil is read later


@pytest.mark.parametrize("share", [0.3, 0.9, 1.6])
def test_a_swinging_load_is_attenuated_and_late(share):
    """``f0 + a sin(2 pi nu t)`` gives ``sin(pi nu T)/(pi nu T)`` of a, in phase with the middle of the window."""
    one = front()
    nu, a, f0 = share / windows(one)[1], 300.0, tank_frequency(L0, C)
    time = np.linspace(0.0, 40.0 * one.period, 40 * 400 + 1)
    swing = np.sin(2 * np.pi * nu * time)
    found = scan(one, C, time, of_frequency(f0 + a * swing[:, None]), seed=None)
    expected = code(one, f0 + a * np.sinc(share) * np.sin(2 * np.pi * nu * found.time))
    assert np.abs(found.code - expected).max() < 0.5 + 2e-5 * float(code(one, a))


def test_the_grid_of_a_history_converges():
    """Codes of half as many samples differ eight times as much or more from those of a fine grid."""
    one, f0 = front(), tank_frequency(L0, C)
    duration = 20.0 * one.period

    def codes(count):
        time = np.linspace(0.0, duration, count)
        swing = 3e4 * np.sin(2 * np.pi * time / (8.0 * one.period))[:, None]
        return scan(one, C, time, of_frequency(f0 + swing), seed=None).L

    coarse, fine = (np.sqrt(np.mean((codes(k) / codes(8001) - 1.0) ** 2)) for k in (101, 201))
    assert 6.0 < coarse / fine < 20.0


def test_noise_has_the_converter_s_deviation_and_no_memory():
    """Over 4000 scans: deviation within 5 % (its own is 1.1 %), neighbours uncorrelated; none without a seed."""
    one = front(rcount=100)
    history = [0.0, 4000.5 * one.period], np.tile(L0, (2, 1))
    found = scan(one, C, *history, seed=7)
    assert found.L.std(axis=0, ddof=1) == pytest.approx(one.noise, rel=0.05)
    left = (found.L - found.L.mean(axis=0)) / found.L.std(axis=0)
    assert np.abs(np.mean(left[1:] * left[:-1], axis=0)).max() < 0.06 and abs(np.mean(left[:, 0] * left[:, 1])) < 0.06
    assert np.array_equal(found.code, scan(one, C, *history, seed=7).code)
    assert not np.array_equal(found.code, scan(one, C, *history, seed=8).code)
    assert np.ptp(scan(one, C, *history, seed=None).code, axis=0).max() == 0


def test_a_later_start_shifts_all():
    one = front()
    late = scan(one, C, [1.0, 1.0 + 7.5 * one.period], np.tile(L0, (2, 1)), seed=None)
    assert late.code.shape == (7, 2)
    assert late.time[0, 0] == pytest.approx(1.0 + windows(one)[0][0] + 0.5 * late.window)


@pytest.mark.parametrize(
    ("time", "L", "message"),
    [
        ([0.0, 1.0, 1.0], np.tile(L0, (3, 1)), "time: must rise.*got 1 s and then 1 s"),
        ([0.0, 2.0, 1.0], np.tile(L0, (3, 1)), "time: must rise.*got 2 s and then 1 s"),
        ([0.0], L0[None], r"time: must rise.*got shape \(1,\)"),
        ([0.0, 1.0], np.tile(L0, (3, 1)), r"L: must be positive, of shape \(2, 2\); got \(3, 2\)"),
        ([0.0, 1.0], -np.tile(L0, (2, 1)), "L: must be positive"),
        ([0.0, 1e-4], np.tile(L0, (2, 1)), r"time: must last one scan of .* s; got 0.0001 s"),
        ([], L0[:0, None], r"time: must rise.*got shape \(0,\)"),
        ([0.0, 1e6], np.tile(L0, (2, 1)), "time: must hold at most 10000000 samples"),
    ],
)
def test_what_is_no_history_is_refused(time, L, message):
    with pytest.raises(ValueError, match=message):
        scan(front(), C, time, L)


@pytest.fixture(scope="module")
def sensor():
    return load_sensor("biorob2018")


@pytest.fixture(scope="module")
def data(sensor):
    """A second at rest, one of pressing, one under the load."""
    wrench = np.zeros((4, 6))
    wrench[2:, 1] = 1.0
    loads = LoadHistory(np.array([0.0, 1.0, 2.0, 3.0]), wrench)
    return in_time(sensor, loads, mechanics="linear", magnetics="planar", tolerance=0.1)


@pytest.mark.slow
def test_codes_follow_the_load(sensor, data):
    found = with_codes(sensor, data, seed=None)
    code, at = found["code"].to_numpy(), found["code_time"].to_numpy()
    still = np.all(at < 0.9, axis=1)
    assert np.ptp(code[still], axis=0).max() == 0
    assert code[-1].min() > code[0].max()  # a nearer target lowers L
    moving = (at[:, 0] > 1.05) & (at[:, 0] < 1.95)
    middle = np.interp(at[moving, 0], data["time"], data["L"][:, 0, 0])
    read = found["code_L"].to_numpy()[moving, 0]
    slope = np.polyfit(middle, read, 1)
    assert np.abs(read - np.polyval(slope, middle)).max() < 2e-3 * np.ptp(read)


def test_coils_are_read_one_after_the_other(sensor, data):
    found = with_codes(sensor, data, rcount=4096)
    at = found["code_time"].to_numpy()
    assert np.all(np.diff(at.ravel()) > 0.0)
    assert np.diff(at[:, 0]) == pytest.approx(found.attrs["period"])
    assert found.sizes["scan"] == int(3.0 / found.attrs["period"])


def test_noise_is_the_same_for_one_seed(sensor, data):
    one, other, none = (with_codes(sensor, data, seed=seed)["code"] for seed in (1, 1, None))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, none)


def test_without_a_converter_the_reason_is_told(sensor, data):
    off = sensor.model_copy(update={"readout": sensor.readout.model_copy(update={"converter": "none"})})
    found = with_codes(off, data)
    assert "code" not in found
    before = unpacked(data.attrs["notes"])
    assert unpacked(found.attrs["notes"]) == (*before, Note.of(NoteKind.NO_CODES, text="the scene has no converter"))
    short = data.isel(time=slice(0, 2))
    brief = with_codes(sensor, short.assign_coords(time=[0.0, 1e-3]))
    assert unpacked(brief.attrs["notes"])[-1].kind is NoteKind.NO_CODES


def test_reference_counts_of_the_part(sensor):
    assert checked_count(sensor, None) == 0xFFFF
    assert checked_count(sensor, 4096) == 4096
    with pytest.raises(SceneError, match="rcount: must be from 9 to 65535 for the LDC1614; got 3"):
        checked_count(sensor, 3)
