"""L, R and Q over frequency, and what the terminals add: closed forms, limits, one frequency against many."""

import json

import numpy as np
import pytest

from sits_mech.analysis.spectrum import at_terminals, spectrum
from sits_mech.chain.models import magnetic_model
from sits_mech.magnetics.coils import resistance
from sits_mech.notes import OmissionKind, unpacked_omissions
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.units import frequency_range, quantity

POSE = Pose(0.0, 2e-3)


@pytest.fixture(scope="module")
def free() -> Sensor:
    """Two coils without target."""
    return load_sensor("biorob2018").model_copy(update={"target": None, "elastomer": None})


def test_each_frequency_is_what_the_model_says() -> None:
    """Whatever the order; Q by its definition; R falls as f^2 and L rises to that of free space at low frequency."""
    sensor = load_sensor("biorob2018")
    model, _ = magnetic_model(sensor, "planar", 1e-2)
    data = spectrum(sensor, model, POSE, [5e6, 1.0, 10.0])
    assert data["frequency"].to_numpy().tolist() == [1.0, 10.0, 5e6] and data.attrs["unit_L"] == "H/m"
    for hertz in (10.0, 5e6):
        alone, row = model.impedance(POSE, hertz), data.sel(frequency=hertz)
        np.testing.assert_array_equal(row["L"], alone.L)
        own = 2 * np.pi * hertz * alone.L.diagonal() / (alone.R.diagonal() + alone.R_dc)
        np.testing.assert_allclose(row["Q"], own, rtol=1e-14)
    R = data["R"].to_numpy()[:, 0, 0]
    assert R[1] / R[0] == pytest.approx(100.0, rel=1e-4)
    np.testing.assert_allclose(data["L"][0], data["L0"], rtol=1e-6)
    report = json.loads(data.attrs["report"])
    assert report["status"] == "converged"
    ends, tracks, stated = unpacked_omissions(report["left_out"])
    assert ends.kind == OmissionKind.PLATE_ENDS and ends.size > 0.1 and tracks.kind == OmissionKind.TRACKS
    assert "per metre" in str(stated.known["text"]) and not stated.counts


def test_terminals_of_two_coils_alone(free: Sensor) -> None:
    """Shorted idle coil: 3.577e-4 of L0 (NGSolve 3D: 0.8971 nH of 2507.57 nH, without resistance).

    With its resistance the network's closed form omega^2 M^2 / |Z_22|^2 takes over, and the lead is in both loops.
    """
    lead = free.readout.model_copy(update={"lead_inductance": 20e-9, "lead_resistance": 0.5})
    sensor = free.model_copy(update={"readout": lead})
    found = magnetic_model(sensor, "sheets")[0].impedance(POSE, 5e6)
    seen, missing = at_terminals(sensor, found)
    assert seen is not None and missing == ()
    omega, M = 2 * np.pi * 5e6, found.L[0, 1]
    idle = seen.R_ac[0] + 0.5 + 1j * omega * (found.L[1, 1] + 20e-9)
    brought = omega**2 * M**2 / idle
    assert found.L[0, 0] + 20e-9 - seen.L[0] == pytest.approx(-brought.imag / omega, rel=1e-6, abs=0)
    assert found.L[0, 0] + 20e-9 - seen.L[0] == pytest.approx(0.8971e-9, rel=2e-2)
    assert seen.R[0] == pytest.approx(seen.R_ac[0] + 0.5 + brought.real, rel=1e-12)
    np.testing.assert_allclose(seen.Q, omega * seen.L / seen.R, rtol=1e-14)
    Z = seen.R[0] + 1j * omega * seen.L[0]
    tank = 1 / (1 / Z + 1j * omega * 330e-12)  # in parallel
    np.testing.assert_allclose((seen.apparent_R[0], seen.apparent_L[0]), (tank.real, tank.imag / omega), rtol=1e-12)
    assert seen.tank_frequency[0] == pytest.approx(1 / (2 * np.pi * np.sqrt(seen.L[0] * 330e-12)), rel=1e-3)
    opened = sensor.model_copy(update={"readout": lead.model_copy(update={"idle_coil": "open"})})
    seen, _ = at_terminals(opened, found)
    assert seen is not None and seen.L[0] == pytest.approx(found.L[0, 0] + 20e-9, rel=1e-14, abs=0)


def test_spectrum_carries_the_terminals(free: Sensor) -> None:
    """A range gives what each frequency alone gives; R_ac tends to R_dc but for the rings' (w/r)^2 / 12 < 7e-4."""
    model, _ = magnetic_model(free, "sheets")
    data = spectrum(free, model, POSE, [1e3, 1e6])
    seen, _ = at_terminals(free, model.impedance(POSE, 1e3))
    assert seen is not None
    for name, value in (("L", seen.L), ("R", seen.R), ("Q", seen.Q)):
        np.testing.assert_allclose(data[f"terminal_{name}"][0], value, rtol=2e-4)
    np.testing.assert_allclose(data["tank_frequency"][0], seen.tank_frequency, rtol=2e-4)
    omega = 2.0 * np.pi * seen.self_resonance
    np.testing.assert_allclose(omega**2 * seen.L * seen.own_capacitance, 1.0, rtol=1e-12)
    np.testing.assert_allclose(data["R_track"][0], data["R_dc"], rtol=7e-4)
    assert np.all(data["R_track"][1] > 1.02 * data["R_dc"]) and np.all(data["shift"] < 0.0)


def test_fewer_filaments_than_asked_have_the_whole_step_as_error(free: Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """It holds what all of them give, whose error is ten times less and more."""
    every = magnetic_model(free, "sheets")[0].impedance(POSE, 5e6)
    monkeypatch.setattr(resistance, "_MOST", 400)
    other = free.model_copy(update={"frequency": 5.01e6})  # whose filaments are others than those that are kept
    few = magnetic_model(other, "sheets")[0].impedance(POSE, 5e6)
    off = np.abs(few.R - every.R)[0, 0]
    assert 0.0 < off < few.error_R[0, 0] and few.error_R[0, 0] > 10.0 * every.error_R[0, 0]


@pytest.mark.slow
def test_beyond_what_the_tracks_can_be_divided_for(free: Sensor) -> None:
    """By fewer filaments, the whole step between two divisions as the error."""
    model, _ = magnetic_model(free, "sheets")
    found = model.impedance(POSE, 5e8)
    seen, _ = at_terminals(free, found)
    assert seen is not None and 10.0 < seen.R_ac[0] / found.R_dc[0] < 30.0
    assert found.error_R[0, 0] > 0.05 * seen.R_ac[0]


def test_written_ranges() -> None:
    """Evenly spaced in the logarithm, ends exact."""
    values = frequency_range("1 kHz:10 MHz:5", "--frequency")
    np.testing.assert_allclose(values, [1e3, 1e4, 1e5, 1e6, 1e7], rtol=1e-12)
    assert frequency_range("5 MHz", "--frequency") == [quantity("5 MHz", "Hz", "f")]
    for wrong in ("0 Hz:1 kHz:3", "-1 Hz", "1 kHz:1 MHz", "1 m:2 m:3", "1 kHz:1 MHz:1"):
        with pytest.raises(SceneError, match="--frequency"):
            frequency_range(wrong, "--frequency")


@pytest.mark.parametrize("wrong", [[], [1e3, 1e3], [0.0, 1.0]])
def test_frequencies_must_differ(free: Sensor, wrong: list[float]) -> None:
    """One line."""
    with pytest.raises(SceneError, match="frequencies must be one or more different"):
        spectrum(free, magnetic_model(free)[0], POSE, wrong)


@pytest.mark.slow
def test_report_of_the_planar_finite_elements() -> None:
    """Whatever kind of number a model reports with."""
    sensor = load_sensor("biorob2018")
    model, _ = magnetic_model(sensor, "planar-fem", 1e-2)
    report = json.loads(spectrum(sensor, model, POSE, [1e4, 1e5]).attrs["report"])
    assert report["model"] == "planar-fem" and report["iterations"] >= 4 and report["unknowns"] > 1000
