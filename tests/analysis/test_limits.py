"""Limits of a pad: a spring of known stretch, sink and largest load; a column that buckles; a table by hand."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.limits import AFTER, Capacity, capacity, corners, limits_of
from sits_mech.cli.main import run
from sits_mech.mechanics.equilibrium.outcome import PathEnd
from sits_mech.mechanics.layer import planar_layer
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array, Equilibrium, Pose, SolveFailed, SolveReport, Wrench
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import Sensor, known_stretch, load_sensor
from sits_mech.silicone.history import retardation

MM = 1e-3
LOAD = Wrench(F_x=0.5, F_z=2.0)


@dataclass(frozen=True)
class Spring:
    """Sinks by `sink` and is stretched by `pull` of the load; ends at `most` of it, for a reason, on two meshes."""

    sink: float = 0.0
    pull: float = 0.0
    most: float = np.inf
    reason: PathEnd = PathEnd.TURNED
    error: float | None = 0.01
    note: Note | None = None

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        m = wrench.F_z / LOAD.F_z
        report = SolveReport("spring", 1, 1, 0.0, 0.0, 0.0, min_J=0.9, stretch=1.0 + self.pull * m)
        if self.note and m > 1.0:
            report = replace(report, notes=(self.note,))
        if m > self.most:
            last = self.equilibrium(_times(0.999 * self.most))
            carried = None if self.error is None else (_times(self.most), _times(self.error))
            notes = (Note.of(NoteKind.PATH_END, end=self.reason),)
            raise SolveFailed("ended", replace(report, notes=notes), last, carried=carried)
        return Equilibrium(wrench, Pose(0.0, 2 * MM - self.sink * m), Pose(0.0, 0.0), np.zeros(1), report)


def _times(share: float) -> Wrench:
    """So many times the load."""
    return Wrench(*(share * LOAD.components).tolist())


def carried(layer: Spring, known: float = 2.0) -> Capacity:
    return capacity(load_sensor("biorob2018"), layer, LOAD, known)


@pytest.mark.parametrize("pull", [3.0, 0.7, 0.03])
def test_a_stretch_beyond_the_data_ends_it(pull: float) -> None:
    """1 + pull m = 2, whether below the table's load or far beyond it."""
    found = carried(Spring(pull=pull))
    assert found.multiple == pytest.approx(1.0 / pull, rel=0.02)
    assert found.reason == Note.of(NoteKind.LIMIT_DATA, stretch=2.0)
    none = carried(Spring(pull=pull), np.nan)  # nothing is known of the data
    assert none.multiple == np.inf and none.reason == Note.of(NoteKind.NO_LIMIT, most=64.0)


def test_contact_with_the_coils_ends_it() -> None:
    """2 mm over the coils, 0.3 mm a load; whichever limit comes first."""
    found = carried(Spring(sink=0.3 * MM, pull=0.1))
    assert found.multiple == pytest.approx(2.0 / 0.3, rel=0.01)
    assert found.reason == Note.of(NoteKind.LIMIT_COILS, plates=False)
    assert carried(Spring(sink=0.3 * MM, pull=0.2)).reason.kind is NoteKind.LIMIT_DATA


@pytest.mark.parametrize(("most", "reason"), [(5.3, PathEnd.TURNED), (0.4, PathEnd.BUCKLED)])
def test_a_limit_is_told_with_its_error_and_by_its_kind(most: float, reason: PathEnd) -> None:
    found = carried(Spring(pull=0.01, most=most, reason=reason))
    assert (found.multiple, found.error) == pytest.approx((most, 0.01))
    assert found.reason == Note.of(NoteKind.LIMIT_LOAD, end=reason)
    alone = carried(Spring(most=most, reason=reason, error=None))
    assert alone.multiple == pytest.approx(0.999 * most) and np.isnan(alone.error)


def test_a_stretch_that_comes_before_a_limit_is_the_first() -> None:
    """The path that was followed to 1.9 is beyond the data from 1.6 on."""
    found = carried(Spring(pull=1.0 / 1.6, most=1.9))
    assert found.multiple == pytest.approx(1.6, rel=0.01) and np.isnan(found.error)
    assert found.reason.kind is NoteKind.LIMIT_DATA


def test_a_lost_path_is_no_limit_and_a_fold_is_one() -> None:
    lost = carried(Spring(most=3.0, reason=PathEnd.LOST, error=None))
    assert lost.multiple == pytest.approx(2.997) and lost.reason == Note(NoteKind.LIMIT_LOST)
    fold = carried(Spring(note=Note(NoteKind.FACES_CROSS)))
    assert fold.reason == Note(NoteKind.LIMIT_FOLD) and fold.multiple == pytest.approx(1.0, rel=0.02)


def test_a_column_carries_its_buckling_load() -> None:
    """The same newtons whatever the table's load is, within their error of a cantilever's: J. A. Haringx (1948),
    P = S/2 (sqrt(1 + 4 P_E/S) - 1), S = mu w, P_E = pi^2 E I/(2 t)^2, E = 4 mu.

    What is bonded cannot widen, which adds some five percent (tests/mechanics/equilibrium/test_limit_point.py).
    """
    law = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
    sizes = ['elastomer.width="2 mm"', 'elastomer.thickness="12 mm"', 'target.width="2 mm"', "elastomer.length=1.0"]
    sensor = load_sensor("biorob2018", [law, *sizes, 'target.load_height="0 mm"', 'elastomer.contact="never"'])
    euler, shear = np.pi**2 * 4 * 3e4 * (2 * MM) ** 3 / 12 / (24 * MM) ** 2, 3e4 * 2 * MM
    true = 1.048 * shear / 2 * (np.sqrt(1 + 4 * euler / shear) - 1)
    layer, parts = planar_layer(sensor, 2e-2), (0.3, 3.0)
    found = [capacity(sensor, layer, Wrench(F_z=part), np.nan) for part in parts]
    loads, off = (np.multiply(parts, [getattr(each, name) for each in found]) for name in ("multiple", "error"))
    assert all(each.reason == Note.of(NoteKind.LIMIT_LOAD, end=PathEnd.BUCKLED) for each in found)
    assert np.ptp(loads) < 0.005 * true and np.all(np.abs(loads - true) < 1.5 * off) and np.all(off < 0.2 * true)


def table(sensor: Sensor, stretch: Array) -> xr.Dataset:
    """Nine loads: the target sinks by 0.1 mm/N, shears, and tilts by 0.01 rad under the largest of both."""
    F_x, F_z = np.array([-1.0, 0.0, 1.0]), np.array([0.0, 1.0, 2.0])
    x, z = np.meshgrid(F_x, F_z, indexing="ij")
    poses = {"d_h": 1e-3 * x, "d_v": 2 * MM - 0.1 * MM * z, "alpha": 0.01 * x * z / 2.0}
    errors = {"error_d_h": 0.0 * x, "error_d_v": 1e-6 + 0.0 * x, "error_alpha": 1e-4 + 0.0 * x}
    columns = {name: (("F_x", "F_z"), each) for name, each in (poses | errors | {"stretch": stretch}).items()}
    status = np.full((3, 3), "ok", dtype=object)
    return xr.Dataset(columns | {"status": (("F_x", "F_z"), status)}, {"F_x": F_x, "F_z": F_z})


def test_limits_of_a_table() -> None:
    """Lowest is an edge of the tilted plate, half its width of 8 mm from the middle: 4 mm sin(0.01) below it."""
    sensor = load_sensor("biorob2018")
    stretch = 1.0 + 0.1 * np.arange(9.0).reshape(3, 3)
    stretch[2, 2] = np.nan  # a load that was not solved
    found = limits_of(sensor, table(sensor, stretch))
    assert found.stretch == pytest.approx(1.7) and found.stretch_under == "F_x = 1 N, F_z = 1 N"
    assert found.clearance == pytest.approx(1.8 * MM - 4 * MM * np.sin(0.01)) and "F_z = 2 N" in found.clearance_under
    assert found.error_clearance == pytest.approx(1e-6 + 4 * MM * 1e-4)
    # biorob2018's silicone: data to 100 % strain; 68.9 kPa by one source, 29.7 kPa by another (silicones.toml)
    assert found.known_stretch == 2.0 and found.spread == pytest.approx(68.9 / 29.7, abs=0.005)
    assert np.isnan(found.hysteresis) and np.isnan(found.left) and found.capacity == ()


def test_what_silicone_and_model_do_not_tell_is_not_known() -> None:
    law = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7, prony=[{weight=0.1, time=1.0}]}'
    sensor = load_sensor("biorob2018", [law])
    found = limits_of(sensor, table(sensor, np.full((3, 3), np.nan)))
    assert np.isnan(known_stretch(sensor)) and known_stretch(load_sensor("biorob2018")) == 2.0
    assert np.isnan([found.stretch, found.known_stretch, found.spread]).all() and found.stretch_under == ""
    assert sensor.elastomer is not None and 0.0 < found.hysteresis < 0.1
    weights, times = retardation(sensor.elastomer.silicone.prony)
    assert found.left == pytest.approx(weights @ np.exp(-AFTER / times))


def test_corner_loads_are_those_of_no_image() -> None:
    """Of a mirrored pad F_x = -1 N is an image of 1 N; each force alone is a corner, none at all is not."""
    sensor = load_sensor("biorob2018")
    ranges = {"F_x": (-1.0, 1.0), "F_z": (0.0, 2.0)}
    found = corners(sensor, ranges)
    assert sorted((load.F_x, load.F_z) for load in found) == [(0.0, 2.0), (1.0, 0.0), (1.0, 2.0)]
    assert corners(sensor, {"F_x": (-1.0, 1.0), "F_z": (0.5, 2.0)}) == [  # what does not go to zero has a third end
        *(Wrench(F_x=1.0, F_z=value) for value in (0.0, 0.5, 2.0)),
        *(Wrench(F_z=value) for value in (0.5, 2.0)),
    ]
    assert {abs(load.M) for load in corners(sensor, ranges, {"M": 1e-3})} == {1e-3}


@pytest.mark.slow
def test_the_capacity_of_a_calibrated_pad(calibrated: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its pad is at the end of the silicone's data, or past its largest load, where quality says."""
    assert run(["quality", str(calibrated), "--capacity", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["limits"]
    assert [each["load"] for each in found["capacity"]] == [{"F_x": 1.0}, {"F_x": 1.0, "F_z": 3.0}, {"F_z": 3.0}]
    sensor, _ = read_calibration(calibrated)
    layer = planar_layer(sensor, 1e-2).rough
    for each in found["capacity"]:
        assert each["multiple"] > 0.0 and each["reason"].startswith("stretch beyond 2")
        load = Wrench(**{name: each["multiple"] * value for name, value in each["load"].items()})
        assert layer.equilibrium(load).report.stretch == pytest.approx(found["known_stretch"], rel=0.01)
