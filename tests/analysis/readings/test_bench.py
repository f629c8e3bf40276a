"""What a bench sees: absolute inductances, terminals, settings, forces from readings, by a table made by hand."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from common.track_losses import track_spectrum

from sits_mech.analysis.readings import bench
from sits_mech.analysis.readings.codes import tank_of
from sits_mech.analysis.readings.measured import read_measured
from sits_mech.cli.main import run
from sits_mech.cli.read import _loop
from sits_mech.export.calibrations import invert
from sits_mech.labels import unit_of
from sits_mech.quantities import Impedance, SolveReport, Wrench
from sits_mech.readout.calibration import calibration
from sits_mech.report.tables.readings import inversion_table
from sits_mech.scene.sensor import (
    Sensor,
    changed,
    load_sensor,
    provenance,
    save_sensor,
    scene_hash,
    scene_table,
    scene_text,
    sensor_from,
)
from sits_mech.store import save_table
from sits_mech.version import __version__

WARM = ('temperature="50 degC"', 'readout.capacitance_coefficient="30 ppm/K"', 'readout.clock_coefficient="-2 ppm/K"')
F_X, F_Z = np.linspace(-1.0, 1.0, 7), np.linspace(0.0, 4.0, 7)


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    """The published sensor."""
    return load_sensor("biorob2018-w15")


def test_branches_of_a_loop(sensor: Sensor) -> None:
    """Two triangles whose falling half lags by 0.1 s (1 - s) s: both branches by formula, of the last cycle."""
    time = np.linspace(0.0, 2.0, 401)
    share = 1.0 - np.abs(2.0 * (time % 1.0) - 1.0)
    lag = np.where(time % 1.0 > 0.5, 0.1 * share * (1.0 - share), 0.0) + np.where(time < 1.0, 0.3 * share, 0.0)
    data = xr.Dataset(coords={"time": time, "coil": ["C1", "C2"], "coil_2": ["C1", "C2"]}, attrs={"unit_L": "H"})
    data["L"] = (("time", "coil", "coil_2"), (2e-6 * (1.0 - 0.1 * (share - lag)))[:, None, None] * np.eye(2))
    data["L0"], data["share"] = (("coil", "coil_2"), 2.5e-6 * np.eye(2)), ("time", share)
    s = np.linspace(0.0, 1.0, 41)
    up, down = bench.branches(sensor, data)
    np.testing.assert_allclose(up, np.tile(2e-6 * (1.0 - 0.1 * s), (2, 1)).T, rtol=1e-9)
    np.testing.assert_allclose(down, np.tile(2e-6 * (1.0 - 0.1 * (s - 0.1 * s * (1.0 - s))), (2, 1)).T, rtol=1e-5)
    per_metre = bench.branches(sensor, data.assign_attrs(unit_L="H/m"))[0]
    np.testing.assert_allclose(per_metre, up / 2.5e-6 * bench.self_inductances(sensor), rtol=1e-12)


def relative(F_x: np.ndarray, F_z: np.ndarray) -> np.ndarray:
    """L over L0 of two coils."""
    common, odd = 0.85 * np.exp(-0.01 * F_z) * (1.0 + 1e-3 * F_x**2), 0.01 * F_x * (1.0 + 0.05 * F_z)
    return np.stack([common + odd, common - odd], -1)


def table(sensor: Sensor, unit: str = "H/m") -> xr.Dataset:
    """A calibration's table as by a planar model, L0 = 4e-4 H/m, or in henry, L0 = 2.5e-6 H."""
    L0 = 4e-4 if unit == "H/m" else 2.5e-6
    x, z = np.meshgrid(F_X, F_Z, indexing="ij")
    names = ["C1", "C2"]
    data = xr.Dataset(coords={"F_x": F_X, "F_z": F_Z, "coil": names, "coil_2": names})
    pair = ("F_x", "F_z", "coil", "coil_2")
    data["L"] = (pair, L0 * (relative(x, z)[..., None] * np.eye(2) - 0.02 * (1.0 - np.eye(2))))
    data["R"] = (pair, np.broadcast_to(16.0 * (L0 / 4e-4) * np.eye(2), data["L"].shape).copy())
    data["error_L"], data["error_R"] = 1e-5 * abs(data["L"]), 1e-2 * data["R"]
    data["L0"] = (("coil", "coil_2"), L0 * np.array([[1.0, -0.02], [-0.02, 1.0]]))
    for name in ("d_h", "d_v", "alpha", "L_v_percent", "L_h_percent"):
        data[name] = (("F_x", "F_z"), x + z)
    data["status"] = (("F_x", "F_z"), np.full(x.shape, "ok", dtype=object))
    attributes = {"unit_L": unit, "frequency": sensor.frequency, "version": __version__, "name": sensor.name}
    return data.assign_attrs(**attributes, scene_hash=scene_hash(sensor), scene=scene_text(sensor))


def test_absolute_resistances_are_of_the_coils(sensor: Sensor) -> None:
    """As much of the metre as of the losses: direct current in ohm, too."""
    eye, report = np.eye(2), SolveReport("by hand", 1, 1, 0.0, 0.0, 0.0)
    found = Impedance(5e6, 4e-4 * eye, 16.0 * eye, 4e-4 * eye, np.full(2, 8.0), 0 * eye, 0 * eye, "H/m", report)
    seen, _ = bench.absolute(sensor, found)
    np.testing.assert_allclose(seen.R_dc, 0.5 * np.diagonal(seen.R), rtol=1e-12)


@pytest.mark.slow
def test_relative_change_of_the_rings(sensor: Sensor) -> None:
    """A table per metre gives henry by L0 of the rings; one in henry is taken as it is."""
    L0 = bench.self_inductances(sensor)
    cal = bench.sensor_calibration(sensor, table(sensor))
    np.testing.assert_allclose(cal.forward(F_x=0.3, F_z=1.0), L0 * relative(np.array(0.3), np.array(1.0)), rtol=1e-6)
    own = bench.sensor_calibration(sensor, table(sensor, "H"))
    np.testing.assert_allclose(own.L0, 2.5e-6, rtol=1e-12)
    np.testing.assert_allclose(bench.model_errors(sensor, table(sensor, "H")), 1e-5 * 2.5e-6 * 0.861, rtol=2e-3)


def by_tracks(sensor: Sensor) -> float:
    """What uneven current takes from L of each coil of a table of even current [H]."""
    return float(track_spectrum(sensor.coils[0], [sensor.frequency]).shift[0])


def test_leads_and_tracks_at_the_terminals(sensor: Sensor) -> None:
    """Leads add in series; the resistance is the tracks', the leads' and the target's share."""
    data = table(sensor)
    plain, missing = bench.terminals(sensor, data)
    assert any("idle coils" in text for text in missing)
    leads = ['readout.lead_inductance="50 nH"', 'readout.lead_resistance="0.3 ohm"']
    led, _ = bench.terminals(changed(sensor, leads), data)
    np.testing.assert_allclose(led["L"] - plain["L"], 50e-9, rtol=1e-9)
    np.testing.assert_allclose(led["R"] - plain["R"], 0.3, rtol=1e-9)
    L0, uneven = bench.self_inductances(sensor), by_tracks(sensor)
    assert -20e-9 < uneven < -15e-9
    np.testing.assert_allclose(plain["L"], L0 * relative(*np.meshgrid(F_X, F_Z, indexing="ij")) + uneven, rtol=1e-12)
    assert np.all(plain["R"] > 16.0 * L0[0] / 4e-4) and np.all(plain["R"] < 5.0)


def test_idle_coil_of_a_model_in_henry(sensor: Sensor) -> None:
    """The shorted coil takes M^2 / L: 4e-4 of L0 here; an open one nothing."""
    shorted, missing = bench.terminals(sensor, table(sensor, "H"))
    opened, _ = bench.terminals(changed(sensor, ['readout.idle_coil="open"']), table(sensor, "H"))
    taken = (opened["L"] - shorted["L"]).sel(F_x=0.0, F_z=0.0, coil="C1")
    assert missing == () and float(taken) == pytest.approx(0.02**2 / 0.85 * 2.5e-6, rel=0.01)


def test_a_table_of_another_sensor_is_refused(sensor: Sensor) -> None:
    """Of other coils, target or layer; readout and what is known of it may be another."""
    data = table(sensor).assign_attrs(provenance(sensor))
    bench.sensor_calibration(bench.with_idle(sensor, "open"), data)
    for key, part in (("coils.C1.turns=8", "coils"), ('target.thickness="50 um"', "target")):
        with pytest.raises(ValueError, match=f"table: must be of .*; its {part} differs: it is of BioRob"):
            bench.sensor_calibration(changed(sensor, [key]), data)


def test_coils_and_terminals_beside_each_other(sensor: Sensor) -> None:
    """By hand: the diagonal of L, and with it lead and shorted coil; nothing where a load has no result."""
    led = changed(sensor, ['readout.lead_inductance="50 nH"'])
    data = table(led, "H").assign_attrs(tracks="uneven")
    data["status"][0, 0] = "stalled"
    found = bench.with_terminals(led, data)
    assert found["L_coil"].dims == found["L_terminal"].dims == ("F_x", "F_z", "coil")
    np.testing.assert_array_equal(found["L_coil"].sel(coil="C2"), data["L"].sel(coil="C2", coil_2="C2"))
    L = found.sel(F_x=0.0, F_z=0.0, coil="C1")
    M = 0.02 * 2.5e-6
    assert float(L["L_coil"] + 50e-9 - L["L_terminal"]) == pytest.approx(M**2 / (0.85 * 2.5e-6 + 50e-9), rel=0.01)
    assert found["L_terminal"][0, 0].isnull().all() and found["L_terminal"].notnull().sum() == 2 * (7 * 7 - 1)
    assert unit_of("L_coil[C1]", "H/m") == "H/m" and unit_of("L_terminal[C1]", "H") == "H"


def test_a_table_of_one_load_that_failed_has_no_terminals(sensor: Sensor) -> None:
    """All NaN, and no error; a table per metre has coils alone."""
    data = table(sensor, "H")
    data["status"][:] = "stalled"
    assert bench.with_terminals(sensor, data)["L_terminal"].isnull().all()
    assert {"L_coil", "L_terminal"} & set(bench.with_terminals(sensor, table(sensor))) == {"L_coil"}


def test_idle_coils_are_open_where_there_is_no_converter(sensor: Sensor) -> None:
    """As a meter reads them, unless the scene says otherwise; what a scene says is written to its file."""
    none = {"readout": {"converter": "none"}}
    bare = sensor_from(scene_table(sensor) | none)
    assert bare.readout.idle_coil == "open" and sensor.readout.idle_coil == "shorted"
    said = sensor_from(scene_table(sensor) | {"readout": {"converter": "none", "idle_coil": "shorted"}})
    assert said.readout.idle_coil == "shorted" and changed(bare, []).readout == bare.readout
    data = table(bare, "H").assign_attrs(tracks="uneven")
    opened = data["L"].sel(coil="C1", coil_2="C1")
    np.testing.assert_allclose(bench.with_terminals(bare, data)["L_terminal"].sel(coil="C1"), opened, rtol=1e-12)
    known = bench.terminal_calibration(bare, data), bench.sensor_calibration(bare, data)
    read, own = (each.forward(F_x=0.3, F_z=1.0) for each in known)
    np.testing.assert_allclose(read, own, rtol=1e-9)


def lossy(sensor: Sensor, data: xr.Dataset) -> np.ndarray:
    """R of the coils at the terminals, alike under all loads of a table per metre [ohm]."""
    own = track_spectrum(sensor.coils[0], [sensor.frequency])
    return 16.0 * bench.self_inductances(sensor) / 4e-4 + float(own.R[0])


@pytest.mark.parametrize("keys", [(), ('readout.converter="LDC1314"',), WARM])
def test_codes_become_the_inductances_they_are_of(sensor: Sensor, keys: tuple[str, ...], tmp_path: Path) -> None:
    """Of the table's loads, as a file of a bench, with the window of a part of 12 bits, warm tracks and capacitor."""
    scene, data = changed(sensor, list(keys)), table(sensor, "H")
    data["R"] = data["R"] * (1.0 + 0.02 * data["F_z"] + 0.01 * data["F_x"] * xr.DataArray([1.0, -1.0], dims="coil"))
    seen, front = bench.terminals(scene, data)[0], bench.sensor_front_end(scene, data)[0]
    codes = bench.table_codes(scene, data, front).stack(load=("F_x", "F_z")).transpose("load", "coil")
    each = zip(codes["load"].values, codes.values.tolist(), strict=True)
    rows = "\n".join(f"{x},{z},{a!r},{b!r}" for (x, z), (a, b) in each)
    (tmp_path / "bench.csv").write_text(f"F_x,F_z,code1,code2\n{rows}\n")
    tank = tank_of(scene, data)
    back = read_measured(tmp_path / "bench.csv", ("F_x", "F_z"), ("C1", "C2"), tank)
    L, R = (seen[name].to_numpy().reshape(-1, 2) for name in ("L", "R"))
    np.testing.assert_allclose(tank.resistance(L), R, rtol=2e-4)
    np.testing.assert_allclose(back.L, L, rtol=5e-7)
    lossless = read_measured(tmp_path / "bench.csv", ("F_x", "F_z"), ("C1", "C2"), replace(tank, resistance=None))
    assert np.all(lossless.L > (1.0 + 1e-4) * L)


def test_settings_follow_the_scene(sensor: Sensor) -> None:
    """Frequency by hand, the part of the scene, no part, a clock."""
    data = table(sensor)
    found, missing = bench.sensor_front_end(sensor, data, clock=20e6, rcount=4096)
    L = bench.self_inductances(sensor)[0] * relative(np.array(-1.0), np.array(4.0))[0] + by_tracks(sensor)
    R = lossy(sensor, data)[0]
    assert found.frequency[0, 1] == pytest.approx(np.sqrt(1.0 / (L * 330e-12) - (R / L) ** 2) / (2.0 * np.pi), rel=1e-9)
    assert found.part.name == "LDC1614" and found.reference == 20e6 and any("5e+06 Hz" in text for text in missing)
    other, _ = bench.sensor_front_end(changed(sensor, ['readout.converter="LDC1612"']), data)
    assert other.part.name == "LDC1612"
    with pytest.raises(ValueError, match='readout.converter must be a part, such as "LDC1614"; got "none"'):
        bench.sensor_front_end(changed(sensor, ['readout.converter="none"']), data)


def test_codes_of_forces(sensor: Sensor) -> None:
    """By hand: lead in series, the tank's frequency, 28 bits over 40 MHz; forces apart or in one array."""
    led = changed(sensor, ['readout.lead_inductance="50 nH"'])
    known = bench.sensor_calibration(led, table(led))
    F = np.random.default_rng(2).uniform([-1.0, 0.0], [1.0, 4.0], (20, 2))
    L = bench.self_inductances(led) * relative(*F.T) + 50e-9 + by_tracks(led)
    f = np.sqrt(1.0 / (L * 330e-12) - (lossy(led, table(led)) / L) ** 2) / (2.0 * np.pi)
    np.testing.assert_allclose(known.codes(F), 2.0**28 * f / 40e6, rtol=1e-7)
    np.testing.assert_array_equal(known.codes(F_x=F[:, 0], F_z=F[:, 1]), known.codes(F))
    np.testing.assert_array_equal(known.forward(F[0]), known.forward(F_x=F[0, 0], F_z=F[0, 1]))
    in_codes = bench.code_calibration(led, table(led), clock=32e6)
    np.testing.assert_allclose(in_codes.forward(F), 1.25 * known.codes(F), rtol=1e-9)
    assert in_codes.unit == "code" and np.all(in_codes.inverse(np.rint(in_codes.forward(F))).status == "ok")
    with pytest.raises(ValueError, match=r'readout.converter must be a part, such as "LDC1614"; got "none"'):
        bench.sensor_calibration(changed(sensor, ['readout.converter="none"']), table(sensor)).codes(F)
    with pytest.raises(ValueError, match="codes: must come from a sensor and its table; this calibration has ind"):
        calibration(table(sensor)).codes(F)


@pytest.fixture
def folder(sensor: Sensor, tmp_path: Path) -> Path:
    """A finished calibration."""
    save_table(table(sensor), tmp_path / "result.nc")
    save_sensor(sensor, tmp_path / "scene.toml")
    return tmp_path


@pytest.mark.slow
def test_invert_command(sensor: Sensor, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Henry, per metre, per cent and plain numbers lead to the same forces."""
    ratio = relative(np.array(0.4), np.array(1.5))
    L0, uneven = bench.self_inductances(sensor), by_tracks(sensor)
    written = [
        [f"{1e6 * (L0[k] * ratio[k] + uneven):.12g} uH" for k in (0, 1)],
        [f"{100.0 * (L0[k] * ratio[k] + uneven) / (L0[k] + uneven):.12g} %" for k in (0, 1)],
        [f"{4e-4 * ratio[k]:.12g} H/m" for k in (0, 1)],
        [f"{4e-4 * ratio[k]:.12g}" for k in (0, 1)],
    ]
    for l1, l2 in written:
        assert run(["invert", str(folder), "--l1", l1, "--l2", l2, "--json"]) == 0
        record = json.loads(capsys.readouterr().out)
        assert record["forces"]["F_x"] == pytest.approx(0.4, abs=1e-4)
        assert record["forces"]["F_z"] == pytest.approx(1.5, abs=1e-3)
        assert record["status"] == "ok" and record["unit_L"] == "H" and record["no_inverse"] == []
        assert record["domain"] == {"F_x": [-1.0, 1.0], "F_z": [0.0, 4.0]}
        assert 0.0 < record["error"]["F_z"] < record["error_by_model"]["F_z"] < 0.1
    assert run(["invert", str(folder), "--l1", written[1][0], "--l2", written[1][1]]) == 0
    assert "F_x" in capsys.readouterr().out


def test_invert_refuses_in_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Outside the table, too few coils, inductances of another scale, no calibration."""
    for words, message in [
        (["--l1", "50 %", "--l2", "50 %"],
         'error: --l1 "50 %" --l2 "50 %": must belong to a load of the calibration (F_x -1 to 1, F_z 0 to 4); got'
         " readings of a load outside; the nearest, F_x = "),
        (["--l1", "85 %"], "--l1 --l2: must be given, one for each coil (C1, C2); got 1"),
        (["--l1", "4e-4 H", "--l2", "4e-4 H"], "--l1: must be near the inductance in free space, 2.489e-06 H; the"),
        (["--l1", "5 mm", "--l2", "85 %"], "--l1: must be an inductance"),
    ]:
        assert run(["invert", str(folder), *words]) == 2
        said = capsys.readouterr()
        assert message in said.err and said.err.count("\n") == 1 and said.out == ""
    assert run(["invert", str(folder / "none"), "--l1", "1 uH"]) == 2
    assert "must be the folder of a finished calibration" in capsys.readouterr().err


def test_invert_by_name_and_by_code(sensor: Sensor, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Coils by name in any order, codes of any clock: the same forces, errors and noise, from Python as well."""
    L0, uneven = bench.self_inductances(sensor), by_tracks(sensor)
    ratio = (L0 * relative(np.array(0.4), np.array(1.5)) + uneven) / (L0 + uneven)
    codes = bench.sensor_calibration(sensor, table(sensor)).codes(F_x=0.4, F_z=1.5)
    for words in (
        ["--reading", f"C2={100.0 * ratio[1]:.12g} %", "--l1", f"{100.0 * ratio[0]:.12g} %"],
        ["--code", f"C1={codes[0]:.0f}", "--code", f"C2={codes[1]:.0f}"],
        ["--code", f"C1=0x{round(1.25 * codes[0]):x}", "--code", f"C2={1.25 * codes[1]}", "--clock", "32 MHz"],
    ):
        assert run(["invert", str(folder), *words, "--json"]) == 0
        record = json.loads(capsys.readouterr().out)
        assert record["forces"]["F_x"] == pytest.approx(0.4, abs=1e-3)
        assert record["forces"]["F_z"] == pytest.approx(1.5, abs=1e-3)
        assert 0.0 < record["error_by_noise"]["F_z"] < 5e-4 < record["error_by_model"]["F_z"] < 0.1
        assert ("codes" in record) == (record["unit_L"] == "code") == ("--code" in words)
        read = [*record["codes" if "codes" in record else "L"].values()]
        found = invert(folder, read, codes="codes" in record, clock=32e6 if "--clock" in words else None)
        assert [found.forces.tolist(), found.error.tolist()] == [
            [*record[name].values()] for name in ("forces", "force_error")]
        assert {cause: [*each.values()] for cause, each in record["budget"].items()} == {
            cause: part.tolist() for cause, part in found.parts.items()}
        assert run(["invert", str(folder), *words, "--budget"]) == 0
        assert "N (90 %)" in (said := capsys.readouterr().out) and "by noise of the reading" in said


@pytest.mark.parametrize(("keys", "said"), [([], False), (['elastomer.material={E="60 kPa", nu=0.499}'], True)])
def test_forces_of_constants_without_tests(
    keys: list[str], said: bool, sensor: Sensor, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Their errors hold nothing of the silicone, which is told."""
    typed = changed(sensor, keys)
    save_table(table(typed), tmp_path / "result.nc")
    save_sensor(typed, tmp_path / "scene.toml")
    assert run(["invert", str(tmp_path), "--l1", "85 %", "--l2", "84 %"]) == 0
    assert ("their errors do not hold it" in capsys.readouterr().err) == said


@pytest.mark.parametrize(("part", "said"), [(0.0, False), (0.05, False), (0.08, True)])
def test_what_the_silicone_has_of_an_error(part: float, said: bool) -> None:
    """Beside the one error where it is most of it: what is left without it, squares being added."""
    record: dict[str, Any] = {
        "forces": {"F_z": 1.0}, "force_error": {"F_z": 0.1}, "budget": {"silicone": {"F_z": part}},
        "domain": {"F_z": [0.0, 2.0]}, "L": {"C1": 2e-6}, "unit_L": "H", "residual": 0.0, "no_inverse": [],
    }
    row = str(list(inversion_table(record).columns[1].cells)[0])
    assert row.startswith("1.00 +- 0.10 N (90 %)")
    assert ("; 0.06 N without the silicone's part, which sits-mech adapt finds" in row) == said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--reading", "C1=90 %"], "--reading: must be given, one for each coil (C1, C2); got 1, without C2"),
        (["--l1", "90 %", "--l3", "90 %"], "--l3: must be of one of 2 coils (C1, C2); got number 3"),
        (["--reading", "C9=90 %"], "--reading C9: must be of one of the coils C1, C2; got 'C9'"),
        (["--reading", "90 %"], '--reading: must be COIL=VALUE, such as "C1=..."; got \'90 %\''),
        (["--l1", "90 %", "--reading", "C1=90 %"], "--reading C1: must be the only reading of coil C1; --l1 gives it"),
        (["--l1", "90 %", "--code", "C2=4"], "--code: must be given for every coil, without --l1 or --reading; got"),
        (["--code", "C1=x", "--code", "C2=4"], "--code C1: must be a code of the converter, a whole number; got 'x'"),
        (["--code", "C1=9", "--code", "C2=4"], "--code C1: must be near the calibration's codes, 4"),
        (["--lx", "90 %"], "--lx: must be --l1, --l2, ..., --reading, --code, --clock or --json; got another option"),
        (["--l1", "85 %", "--l2", "85 %", "--clock", "1 MHz"], "--clock: must come with --code"),
        ([], "--l1 --l2: must be given, one for each coil (C1, C2); got none"),
    ],
)
def test_readings_that_are_none(folder: Path, capsys: pytest.CaptureFixture[str], words: list, message: str) -> None:
    """Coils that are not there, missing, twice; kinds mixed; codes that are none: one line each."""
    assert run(["invert", str(folder), *words]) == 2
    said = capsys.readouterr()
    assert message in said.err and said.err.count("\n") == 1 and said.out == ""


def test_codes_without_converter(sensor: Sensor, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line."""
    bare = changed(sensor, ['readout.converter="none"'])
    save_table(table(bare), tmp_path / "result.nc")
    save_sensor(bare, tmp_path / "scene.toml")
    assert run(["invert", str(tmp_path), "--code", "C1=9", "--code", "C2=4"]) == 2
    said = capsys.readouterr().err
    assert 'readout.converter must be a part, such as "LDC1614"; got "none"' in said and said.count("\n") == 1
    assert run(["invert", str(tmp_path), "--l1", "85 %", "--l2", "84 %"]) == 0
    assert "noise" not in capsys.readouterr().out


def test_converter_command(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Settings and registers as JSON and as text."""
    assert run(["converter", str(folder), "--rcount", "4096", "--clock", "40 MHz", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["converter"] == "LDC1614" and record["rcount"] == 4096 and record["warnings"] == []
    assert record["registers"][0] == {"address": 8, "name": "RCOUNT0", "value": 4096}
    assert 5e6 < record["coils"]["C1"]["frequency"][0] < record["coils"]["C1"]["frequency"][1] < 7e6
    assert run(["converter", str(folder)]) == 0
    assert "0x1B = 0x820D  MUX_CONFIG" in capsys.readouterr().out
    assert run(["converter", str(folder), "--rcount", "2"]) == 2


def test_tank_far_from_the_frequency_is_told(sensor: Sensor) -> None:
    """450 pF swing near the scene's 5 MHz; 45 pF some three times higher, where skins and inductances are others."""
    near, far = (changed(sensor, [f'readout.parallel_capacitance="{pF} pF"']) for pF in (450, 45))
    assert bench.sensor_front_end(near, table(near))[1][-1] == "R is taken at 5e+06 Hz"
    assert "and L too, where the tanks swing at some 1.6" in bench.sensor_front_end(far, table(far))[1][-1]


def test_a_loop_goes_to_the_load_farthest_from_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The end of each axis that is larger, the upper one of two alike, whatever its sign."""
    asked = []
    monkeypatch.setattr("sits_mech.analysis.cycle.load_cycle", lambda sensor, peak, *_, **more: asked.append(peak))
    monkeypatch.setattr("sits_mech.analysis.readings.bench.branches", lambda sensor, data: (data, data))
    request = json.dumps({"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1})
    for axis, end in (([-0.4, -0.2, 0.0], -0.4), ([0.0, 0.4], 0.4), ([-0.4, 0.0, 0.4], 0.4), ([-0.5, 0.0, 0.4], -0.5)):
        data = xr.Dataset(coords={"F_x": axis, "F_z": [0.0, 2.0]}, attrs={"request": request})
        _loop(load_sensor("biorob2018"), data, 1.0)
        assert asked[-1] == Wrench(F_x=end, F_z=2.0)
