"""The converters by hand, by their data sheets' own examples, and what they cannot follow."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from sits_mech.readout.converter import (
    CONVERTERS,
    code_of,
    conversion_time,
    converter,
    fault,
    frequency_of,
    inductance_noise,
    no_registers,
    parallel_resistance,
    relative_noise,
    tank_frequency,
    tank_inductance,
)
from sits_mech.readout.front_end import front_end, register_text

LDC1614, LDC1101 = CONVERTERS["LDC1614"], CONVERTERS["LDC1101"]


def test_tank_by_hand() -> None:
    """10 uH with 253.303 pF: 10 / (2 pi sqrt(2.53303)) MHz = 3.16228 MHz; back; R_p = L / (R C)."""
    f = tank_frequency(10e-6, 253.303e-12)
    assert float(f) == pytest.approx(3.16228e6, rel=1e-6)
    assert float(tank_inductance(f, 253.303e-12)) == pytest.approx(10e-6, rel=1e-14)
    R_p = float(parallel_resistance(10e-6, 4.0, 253.303e-12))
    assert R_p == pytest.approx((2.0 * np.pi * float(f) * 10e-6) ** 2 / 4.0, rel=1e-12)
    with pytest.raises(ValueError, match="L and capacitance: must be positive; got at least 1 H and 0 F"):
        tank_frequency(1.0, 0.0)


@pytest.mark.parametrize("R", [0.5, 2.7, 30.0])
def test_a_lossy_tank_swings_where_its_admittance_is_real(R: float) -> None:
    """By a root of Im(1 / (R + j w L) + j w C), and L comes back from there; none where 1/R^2 C/L leaves no root."""
    L, C = 2.4e-6, 330e-12

    def susceptance(f: float) -> float:
        omega = 2.0 * np.pi * f
        return float((1.0 / (R + 1j * omega * L) + 1j * omega * C).imag)

    f = float(tank_frequency(L, C, R))
    assert f == pytest.approx(brentq(susceptance, 3e6, 7e6, xtol=1e-6, rtol=1e-15), rel=1e-12)
    Q = 2.0 * np.pi * f * L / R
    assert f / float(tank_frequency(L, C)) - 1.0 == pytest.approx(-0.5 / Q**2, rel=1.0 / Q**2)
    assert float(tank_inductance(f, C, R)) == pytest.approx(L, rel=1e-13)
    at_f = 1.0 / (1.0 / (R + 2j * np.pi * f * L) + 2j * np.pi * f * C)
    assert float(parallel_resistance(L, R, C)) == pytest.approx(at_f.real, rel=1e-12)
    assert np.isnan(tank_frequency(L, C, 90.0)) and np.isnan(tank_inductance(6e6, C, 90.0))
    with pytest.raises(ValueError, match=r"R: must let every coil swing, below sqrt\(L / C\); got up to 90 ohm"):
        front_end(LDC1614, [L], [90.0], C)


def test_the_window_of_the_output_gain() -> None:
    """SNOSCZ0A, 7.3.3: of the result 0x07A3 gain 1 shows 0x07A, gain 16 0x7A3; OFFSET takes f_ref OFFSET / 2^16."""
    part, f = CONVERTERS["LDC1314"], 40e6 * 0x07A3 / 2**16
    assert [int(code_of(f, part, 40e6, gain=gain)) for gain in (1, 16)] == [0x07A, 0x7A3]
    shifted = float(code_of(2.0 * f, part, 40e6, 2, gain=16, offset=0x700))
    assert shifted == pytest.approx(0xA3, abs=1e-9)
    assert float(frequency_of(shifted, part, 40e6, 2, gain=16, offset=0x700)) == pytest.approx(2.0 * f, rel=1e-14)


@pytest.mark.parametrize(("far", "gain"), [(2.1e-6, 16), (1.3e-6, 8), (0.6e-6, 4), (0.25e-6, 1)])
def test_the_gain_is_the_largest_whose_window_holds_the_coils(far: float, gain: int) -> None:
    """Codes stay in its middle half; registers by the data sheet's addresses; its ends are codes 0 and 4096."""
    found = front_end(CONVERTERS["LDC1312"], [[2.3e-6, 2.2e-6], [far, 2.1e-6]], np.full((2, 2), 1.0), 330e-12)
    registers = {name: (address, value) for address, name, value in found.registers}
    assert found.gain == gain and np.all((found.code > 0) & (found.code < 4096))
    if gain == 1:
        assert "RESET_DEV" not in registers and not found.offset.any()
        return
    assert np.all(np.abs(found.code - 2048) <= 1024 + gain)
    assert registers["RESET_DEV"] == (0x1C, {4: 1, 8: 2, 16: 3}[gain] << 9)
    assert [registers[f"OFFSET{k}"] for k in (0, 1)] == [(0x0C + k, found.offset[k]) for k in (0, 1)]
    ends = found.reference * found.input_divider * (found.offset[:, None] / 2**16 + np.array([0, 1]) / gain)
    np.testing.assert_allclose(found.window, ends, rtol=1e-12)
    slope = (found.code + found.below[:, None]) / found.frequency
    np.testing.assert_allclose(slope, gain * 4096 / found.reference / found.input_divider, rtol=1e-12)


def test_code_and_back() -> None:
    """5 MHz against 40 MHz is an eighth of 2^28; the divider halves it; LDC1101 has 24 bits."""
    assert float(code_of(5e6, LDC1614, 40e6)) == 2**25
    assert float(code_of(5e6, LDC1614, 40e6, 2)) == 2**24
    assert float(frequency_of(2**24, LDC1614, 40e6, 2)) == 5e6
    assert float(code_of(4e6, LDC1101, 16e6, 2)) == 2**21


def test_times_by_the_data_sheet() -> None:
    """(16 RCOUNT + 4) / f_ref; at 40 MHz the longest conversion takes 26.2 ms (SNOSCY9A, 8.1.4)."""
    assert conversion_time(0xFFFF, LDC1614, 40e6) == pytest.approx(26.2e-3, rel=1e-3)
    assert conversion_time(1000, LDC1101, 16e6) == pytest.approx((16000 + 55) / 16e6)


def test_noise_scales_and_rounds() -> None:
    """The quoted figure, 8e-7 at a tenth of the reference and RCOUNT 2048; RCOUNT^-3/2; then the code's own step."""
    quoted = float(relative_noise(4e6, LDC1614, 40e6, 2048))
    assert quoted == pytest.approx(8e-7, rel=0.05)
    assert float(relative_noise(4e6, LDC1614, 40e6, 512)) == pytest.approx(8.0 * quoted, rel=1e-3)
    rounding = 1.0 / (np.sqrt(12.0) * 0.1 * 2**28)
    assert rounding < float(relative_noise(4e6, LDC1614, 40e6, 0xFFFF)) < 1.2 * rounding
    assert float(inductance_noise(2e-6, 1e-7)) == pytest.approx(4e-13, rel=1e-6, abs=0)
    codes = np.round(code_of(tank_frequency(np.linspace(2e-6, 2.001e-6, 4001), 330e-12), LDC1614, 40e6))
    back = tank_inductance(frequency_of(codes, LDC1614, 40e6), 330e-12)
    spread = np.std(back - np.linspace(2e-6, 2.001e-6, 4001))
    f = float(tank_frequency(2e-6, 330e-12))
    assert spread == pytest.approx(float(inductance_noise(2e-6, 1 / (np.sqrt(12) * 2**28 * f / 40e6))), rel=0.05, abs=0)


def test_settings_of_a_pair() -> None:
    """Two coils of 2.3 uH and 2.7 ohm with 330 pF: every figure from the data sheet's formulas."""
    found = front_end(LDC1614, [[2.3e-6, 2.3e-6], [2.25e-6, 2.3e-6]], np.full((2, 2), 2.7), 330e-12, rcount=2000)
    f = np.sqrt(1.0 / (2.3e-6 * 330e-12) - (2.7 / 2.3e-6) ** 2) / (2.0 * np.pi)
    Q = 2.0 * np.pi * f * 2.3e-6 / 2.7
    assert (found.reference, found.input_divider, found.reference_divider) == (40e6, 1, 1)
    assert found.settlecount[1] == np.ceil(Q * 40e6 / (16 * f)) and found.frequency[1, 0] == pytest.approx(f)
    R_p = 2.3e-6 / (2.7 * 330e-12)
    current = LDC1614.drive[found.drive[1]]
    assert 4 / np.pi * R_p * current <= 1.8 < 4 / np.pi * R_p * LDC1614.drive[found.drive[1] + 1]
    each = (16 * 2000 + 4) / 40e6 + 16 * found.settlecount / 40e6 + 692e-9 + 5 / 40e6
    np.testing.assert_allclose(found.channel_time, each, rtol=1e-12)
    assert found.rate == pytest.approx(1.0 / each.sum()) and found.warnings == ()
    single = front_end(LDC1614, [2.3e-6], [2.7], 330e-12, rcount=2000)
    assert single.reference == 20e6 and single.rate == pytest.approx(20e6 / 32004)


def test_registers() -> None:
    """Bit fields of SNOSCY9A: dividers, drive current in bits 15..11, two channels in turn, the 10 MHz filter."""
    found = front_end(LDC1614, [[2.3e-6, 2.3e-6]], [[2.7, 2.7]], 330e-12, rcount=0x04D6)
    values = {name: value for _, name, value in found.registers}
    assert values["RCOUNT1"] == 0x04D6 and values["CLOCK_DIVIDERS0"] == 0x1001
    assert values["DRIVE_CURRENT0"] == found.drive[0] << 11
    assert values["MUX_CONFIG"] == 0x820D and values["CONFIG"] == 0x1601
    text = register_text(found)
    assert "0x08 = 0x04D6  RCOUNT0" in text and "0x1B = 0x820D  MUX_CONFIG" in text
    assert text.splitlines()[-1].startswith("0x1A")
    one = front_end(LDC1614, [[2.3e-6]], [[2.7]], 330e-12)
    assert dict((name, value) for _, name, value in one.registers)["MUX_CONFIG"] == 0x020D  # no scan
    four = front_end(LDC1614, [[2.3e-6] * 4], [[2.7] * 4], 330e-12)
    assert dict((name, value) for _, name, value in four.registers)["MUX_CONFIG"] == 0xC20D


@pytest.mark.parametrize(("frequency", "code"), [(0.9e6, 1), (1.1e6, 4), (3.2e6, 4), (3.4e6, 5), (9e6, 5), (11e6, 7)])
def test_the_deglitch_filter_is_the_next_wider_one(frequency: float, code: int) -> None:
    """Of 1, 3.3, 10 and 33 MHz, SNOSCY9A on MUX_CONFIG, the lowest that exceeds the sensor's frequency."""
    capacitance = 1.0 / ((2.0 * np.pi * frequency) ** 2 * 2.3e-6)
    found = front_end(LDC1614, [[2.3e-6, 2.3e-6]], [[2.7, 2.7]], capacitance)
    assert {name: value for _, name, value in found.registers}["MUX_CONFIG"] & 7 == code


def test_the_single_channel_part() -> None:
    """LDC1101: 24 bits, divider for a 16 MHz clock, R_p_min below 0.8 R_p, no settling."""
    found = front_end(LDC1101, [2.3e-6], [2.7], 330e-12, rcount=1000)
    assert found.input_divider == 2 and found.rate == pytest.approx(16e6 / 16055)
    values = {name: value for _, name, value in found.registers}
    assert values["RP_SET"] == 0x80 | 6 and values["LHR_CONFIG"] == 1  # 1.5 kohm <= 0.8 * 2.58 kohm
    assert values["LHR_RCOUNT_LSB"] + 256 * values["LHR_RCOUNT_MSB"] == 1000
    modes = {name: values[name] for name in ("DIG_CONFIG", "ALT_CONFIG", "D_CONFIG", "START_CONFIG")}
    slowest = 15 if found.frequency.min() > 8e6 else int(16 - 8e6 / found.frequency.min())  # SNOSD01D, MIN_FREQ
    assert modes == {"DIG_CONFIG": slowest << 4 | 7, "ALT_CONFIG": 1, "D_CONFIG": 1, "START_CONFIG": 0}
    lossy = {name: value for _, name, value in front_end(LDC1101, [2.3e-6], [10.0], 330e-12).registers}
    assert lossy["RP_SET"] == 0x80 | 7  # 0.8 * 0.7 kohm is below all: the least, 0.75 kohm
    two = front_end(LDC1101, [[2.3e-6] * 2], [[2.7] * 2], 330e-12)
    assert any("2 coils, but the LDC1101 reads 1: take 2" in line for line in two.warnings)


def test_another_part_of_one_channel_is_no_LDC1101() -> None:
    """Its drive, its divider and its registers are its own data: by current, by none, and none that are not known."""
    part = replace(LDC1614, name="one more", channels=1, dividers=(1,), registers=no_registers)
    found, known = (front_end(each, [2.3e-6], [2.7], 330e-12, rcount=1000) for each in (part, LDC1614))
    assert found.registers == () and register_text(found) == "" and found.input_divider == 1
    assert found.drive == known.drive and np.array_equal(found.amplitude, known.amplitude)
    quiet = replace(part, drive=part.drive[:1])
    assert any("less than 1.2 V" in line for line in front_end(quiet, [2.3e-6], [2.7], 330e-12).warnings)


def test_the_slowest_load_settles() -> None:
    """SETTLECOUNT is at least Q f_ref / (16 f) (SNOSCY9A): of each coil, at the load where that is the most."""
    L, R = np.array([[2.3e-6, 2.3e-6], [2.0e-6, 2.1e-6]]), np.array([[0.5, 3.0], [2.7, 2.0]])
    found = front_end(LDC1614, L, R, 330e-12)
    needed = (2.0 * np.pi * L / R).max(axis=0) * found.reference / 16.0  # Q / f = 2 pi L / R
    np.testing.assert_array_equal(found.settlecount, np.maximum(4, np.ceil(needed)))


def test_warnings_in_plain_words() -> None:
    """Too fast, too slow for the part, too lossy, too weak a swing."""
    fast = front_end(LDC1614, [2.3e-6], [0.5], 50e-12)
    assert any("outside 1000 to 1e+07 Hz" in line and "raise the capacitance" in line for line in fast.warnings)
    lossy = front_end(LDC1614, [2.3e-6], [40.0], 330e-12)
    assert any("too lossy: less resistance" in line for line in lossy.warnings)
    assert any("may stop" in line for line in lossy.warnings)
    still = front_end(LDC1614, [40e-6], [0.5], 330e-12)
    assert any("more than the part damps" in line for line in still.warnings)
    slow = front_end(LDC1614, [[2.3e-6, 2.3e-6]], [[1.0, 1.0]], 330e-12, clock=20e6)
    assert slow.input_divider == 2 and slow.warnings == ()
    late = front_end(LDC1614, [[2.3e-6, 2.3e-6]], [[1.0, 1.0]], 330e-12, clock=8e6)
    assert any("raise the clock" in line for line in late.warnings)


def test_what_cannot_be_set_is_refused() -> None:
    """Unknown part, clock, count, resistance."""
    assert {"LDC1614", "LDC1612", "LDC1101"} <= CONVERTERS.keys()
    with pytest.raises(ValueError, match=f"^converter: must be one of {', '.join(CONVERTERS)}; got LDC9$"):
        converter("LDC9")
    with pytest.raises(ValueError, match="clock: must be from 2e.06 to 4e.07 Hz, or its own, up to .*; got 1e.08"):
        front_end(LDC1614, [2e-6], [1.0], 330e-12, clock=1e8)
    with pytest.raises(ValueError, match="rcount: must be from 9 to 65535 for the LDC1614; got 3"):
        front_end(LDC1614, [2e-6], [1.0], 330e-12, rcount=3)
    with pytest.raises(ValueError, match="L and R: must be finite"):
        front_end(LDC1614, [2e-6], [0.0], 330e-12)


def test_noise_is_that_of_the_largest_inductance() -> None:
    """Of each coil over all its loads: a relative deviation of the frequency is twice that of L."""
    L, R = np.array([[2.3e-6, 2.0e-6], [2.2e-6, 2.1e-6]]), np.full((2, 2), 2.7)
    found = front_end(LDC1614, L, R, 330e-12)
    own = relative_noise(tank_frequency(L, 330e-12, R), found.part, found.reference, found.rcount, found.input_divider)
    assert found.noise == pytest.approx(2.0 * L.max(axis=0) * own.max(axis=0))


def test_faults_have_their_words() -> None:
    """Flags above the code's bits, full scale, zero; none of a code, nor of the next part's."""
    part = converter("LDC1614")
    assert fault(38701223, part) == "" and fault(2**28 - 2, part) == ""
    assert "full scale: the coil is open" in fault(2**28 - 1, part) and "zero: " in fault(0, part)
    assert fault(0x1B3D3D64, part) == "the LDC1614 flags the amplitude"
    assert fault(0xC0000001, part) == "the LDC1614 flags over-range, under-range"
    assert "flags an error" in fault(2**24, converter("LDC1101"))
    for code in (2**12 - 1, 0):
        assert "out of range of the window of gain and offset" in fault(code, converter("LDC1314"))


def test_the_own_oscillator_is_a_clock() -> None:
    """Beyond what may come from outside; its register says so, and a warning how far codes may be off."""
    L, R = np.full((1, 2), 2.4e-6), np.full((1, 2), 2.6)
    own, outside = (front_end(converter("LDC1614"), L, R, 330e-12, clock=clock) for clock in (43.4e6, 40e6))
    assert own.is_internal and not outside.is_internal and own.reference == 21.7e6
    assert dict((name, value) for _, name, value in own.registers)["CONFIG"] == 0x1401
    assert any("off alike by up to 24 %" in line for line in own.warnings)
    with pytest.raises(ValueError, match="from 2e.06 to 4e.07 Hz, or its own, up to 5.5e.07 Hz for .*; got 6e"):
        front_end(converter("LDC1614"), L, R, 330e-12, clock=60e6)
    with pytest.raises(ValueError, match="from 1e.06 to 1.6e.07 Hz for the LDC1101"):
        front_end(converter("LDC1101"), L[:, :1], R[:, :1], 220e-12, clock=43.4e6)
