"""Forces that are borne: images of rays, the limits along them, default ranges, and where `pose` leaves the data."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sits_mech as sm
from sits_mech.analysis.envelope import Envelope, Ray, borne_share, envelope
from sits_mech.analysis.limits import Capacity, capacity
from sits_mech.cli.main import run
from sits_mech.cli.options import LoadGrid
from sits_mech.mechanics.layer import planar_layer
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Wrench
from sits_mech.report.envelope import envelope_figure, envelope_record, envelope_table
from sits_mech.report.notes import sentence
from sits_mech.scene.sensor import load_sensor

Capture = pytest.CaptureFixture[str]


@pytest.mark.slow
def test_axes_of_an_envelope_are_capacities(capsys: Capture, tmp_path: Path) -> None:
    """In plane strain, whose meshes agree: each force alone ends where the layer does; shear both ways is one ray."""
    words = ["envelope", "biorob2018", "--mechanics", "planar", "--rays", "4", "-o", str(tmp_path), "--json"]
    assert run(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json.loads((tmp_path / "envelope.json").read_text()) and (tmp_path / "envelope.png").is_file()
    sensor = load_sensor("biorob2018")
    layer = planar_layer(sensor)
    right, up, left, down = (ray["force"] for ray in found["rays"])
    for force in (right, up, down):
        end = capacity(sensor, layer.rough, Wrench(**force), 2.0)
        assert end.multiple == pytest.approx(1.0, abs=0.05) and sentence(end.reason) == found["rays"][0]["limit"]
    assert left["F_x"] == pytest.approx(-right["F_x"]) and up["F_x"] == 0.0 and up["F_z"] > 0.0 > down["F_z"]
    assert found["known_stretch"] == 2.0 and found["model"] == "planar"


@pytest.mark.slow
def test_an_error_beyond_the_tolerance_is_a_limit() -> None:
    """No force is borne to a tolerance that two meshes do not reach."""
    found = envelope(load_sensor("biorob2018"), mechanics="planar", rays=4, tolerance=1e-5)
    off = Note.of(NoteKind.LIMIT_ERROR, tolerance=1e-5)
    assert all(ray.limit == off and not ray.force.components.any() for ray in found.rays)


def test_rays_are_quarters() -> None:
    with pytest.raises(ValueError, match="rays: must be a multiple of four, such as 8; got 6"):
        envelope(load_sensor("biorob2018"), rays=6)
    assert run(["envelope", "biorob2018", "--rays", "2"]) == 2


def test_record_table_and_picture_of_two_planes() -> None:
    """A force without a limit is null in JSON, and in no picture; limits of other kinds are other marks."""
    ends = (Wrench(F_x=1.0), Wrench(F_z=3.0), Wrench(F_x=-1.0), Wrench(F_z=-math.inf))
    limits = Note.of(NoteKind.LIMIT_DATA, stretch=2.0), Note.of(NoteKind.LIMIT_COILS, plates=False)
    rays = [Ray(("F_x", "F_z"), 0.5 * np.pi * k, force, 0.05, limits[k % 2]) for k, force in enumerate(ends)]
    turned = [replace(ray, plane=("F_y", "F_z"), force=Wrench(F_y=ray.force.F_x, F_z=ray.force.F_z)) for ray in rays]
    found = Envelope((*rays, *turned), "block", 2.0, 0.05)
    record = envelope_record(found)
    assert record["rays"][1] == {
        "plane": ["F_x", "F_z"], "angle": 0.5 * np.pi, "force": {"F_x": 0.0, "F_z": 3.0},
        "error": pytest.approx(0.15), "limit": "coil contact",
    }
    said = list(envelope_table(found).columns[0].cells)
    assert said[:3] == ["F_x = 1.000 +- 0.050 N", "F_z = 3.00 +- 0.15 N", "F_z = -inf N"]  # no mirror image
    assert said[3:] == ["F_y = 1.000 +- 0.050 N", "F_z = -inf N"]
    words = list(envelope_table(found).columns[1].cells)
    assert words[:2] == ["stretch beyond 2, the end of the silicone's data", "coil contact"]
    axes = envelope_figure(found, "a sensor").axes
    assert [each.get_xlabel() for each in axes] == ["shear force $F_x$ [N]", "shear force $F_y$ [N]"]


@pytest.mark.slow
def test_default_ranges_are_borne() -> None:
    """Round numbers below what two meshes bear; a model without stretch says nothing; written ranges stay."""
    sensor = load_sensor("biorob2018")
    assert borne_share(sensor, Wrench(F_x=0.1, F_z=0.4), "planar") == 1.0
    assert borne_share(sensor, Wrench(F_z=10.0), "planar") == 0.7
    assert borne_share(sensor, Wrench(F_z=10.0), "linear") == 1.0
    grid = LoadGrid(fz="0 N:8 N:2")
    written = {"F_x": np.linspace(-1, 1, 9).tolist(), "F_z": [0, 8]}
    assert grid.borne(sensor, grid.components(sensor), "auto") == written


def test_a_pad_without_any_limit_bears_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    """No limit up to many times the load: the multiple is infinite, the share is one."""
    none = Capacity(Wrench(), math.inf, 0.0, Note.of(NoteKind.NO_LIMIT, most=64.0))
    monkeypatch.setattr("sits_mech.analysis.envelope.capacity", lambda *_, **__: none)
    assert borne_share(load_sensor("biorob2018"), Wrench(F_z=4.0), "planar") == 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("biorob2018-w15", (0.7, 2.8)),
        pytest.param("biorob2018", (0.4, 1.6), marks=pytest.mark.slow),
        pytest.param("square-4", (None, 1.6), marks=pytest.mark.slow),
    ],
)
def test_default_ranges_of_the_catalogue(name: str, most: tuple[float | None, float]) -> None:
    """One digit of what is borne by the stretch of two meshes, which is too large; one coil resolves F_z alone."""
    sensor = load_sensor(name)
    found = LoadGrid().borne(sensor, LoadGrid().components(sensor), "auto")
    assert (max(found["F_x"]) if "F_x" in found else None, max(found["F_z"])) == most


@pytest.mark.slow
def test_the_envelope_is_where_pose_leaves_the_data() -> None:
    """Within 5 % of the load, pressed, pressed aside, and pulled: by the meshes that `sits-mech pose` takes."""
    sensor = load_sensor("biorob2018-w15")
    rays = envelope(sensor).rays
    layer, _ = sm.mechanical_model(sensor, "auto", 1e-2, [rays[2].force])
    for ray in (rays[1], rays[2], rays[6]):
        inside, beyond = (
            layer.equilibrium(Wrench(*(share * ray.force.components).tolist())).report for share in (0.95, 1.05)
        )
        assert inside.stretch is not None and beyond.stretch is not None
        assert inside.stretch < 2.0 < beyond.stretch
