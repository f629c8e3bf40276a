"""Quality as printed and as JSON: three forces by three coils, a moment that no coil answers."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from sits_mech.analysis.limits import Capacity, Limits
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Wrench
from sits_mech.readout.calibration import calibration_of
from sits_mech.readout.quality import quality
from sits_mech.readout.signals import SIGNALS, signals, weights_of
from sits_mech.report.records import json_text
from sits_mech.report.tables.quality import limits_record, limits_table, modulus_words, quality_record, quality_tables

ENDS = {"F_x": (-0.5, 0.5), "F_z": (0.0, 2.0), "F_y": (-0.5, 0.5), "M_z": (-1e-3, 1e-3)}
SHEAR, PRESS, FREE = 1e-8, -4e-9, 2.1e-6  # [H/N], [H/N], [H]


def record_of(error: float, forces: tuple[str, ...] = ("F_x", "F_z", "F_y")) -> dict:
    """Quality of three coils around the centre whose inductances are all off by an error [H].

    Each answers the shear towards it, and F_z the more the larger F_x is.
    """
    angle = 0.2 + 2.0 * np.pi / 3.0 * np.arange(3)
    axes = {name: np.linspace(*ENDS[name], 5) for name in forces}
    F = dict(zip(forces, np.meshgrid(*axes.values(), indexing="ij"), strict=True))
    along = F["F_x"][..., None] * np.cos(angle) + F.get("F_y", 0.0 * F["F_x"])[..., None] * np.sin(angle)
    L = 2e-6 + SHEAR * along + PRESS * (F["F_z"] * (1.0 + 0.2 * F["F_x"]))[..., None]
    weights = weights_of(4e-3 * np.column_stack([np.cos(angle), np.sin(angle)]), 3e-3)
    shown = signals(L, np.full(3, FREE), weights, error * np.abs(weights).sum(axis=1))
    data = xr.Dataset({name: (forces, getattr(shown, name)) for name in SIGNALS}, axes)
    for name in SIGNALS:
        data[f"error_{name}"] = (forces, np.broadcast_to(getattr(shown, f"error_{name}"), L.shape[:-1]))
    table = xr.Dataset({"L": ((*forces, "coil"), L), "error_L": ((*forces, "coil"), np.full(L.shape, error))}, axes)
    table["weights"] = (("signal", "coil"), weights)
    loads = np.stack([*F.values()], -1).reshape(-1, len(forces))
    coils = ("C1", "C2", "C3")
    cal = calibration_of(loads, L.reshape(-1, 3), forces=forces, coils=coils, free=("H", np.full(3, FREE)))
    return quality_record(quality(cal, np.full(3, 1e-15), table=table), data)


def text_of(record: dict) -> str:
    """Return what is printed."""
    console = Console(file=io.StringIO(), width=80, markup=False)
    for table in quality_tables(record):
        console.print(table)
    return console.file.getvalue()


def test_three_forces_by_three_coils() -> None:
    """F_z = 2 N at F_x = 0.5 N moves each coil by a fifth more of a half: 10 % of the full scale of dL_v."""
    record = record_of(1e-13)
    assert record["own_signal"] == {"F_x": "dL_x", "F_z": "dL_v", "F_y": "dL_y"}
    assert [record["crosstalk_before"]["F_z"][name] for name in ("F_x", "F_y")] == pytest.approx([0.1, 0.0], abs=1e-9)
    assert [record["crosstalk_before"]["F_x"][name] for name in ("F_z", "F_y")] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert record["crosstalk"]["F_z"]["F_x"] > 0.04 > 1e-6 > record["crosstalk_after"]["F_z"]["F_x"]
    assert record["signals"]["largest_dL_v_from_F_x"] == pytest.approx(10.0)
    assert record["forces_seen"]["resolved"] == ["F_x", "F_z", "F_y"] and record["forces_seen"]["unseen"] == []
    # of each load alone: 1e-13 of each coil is worth as much of F_z as all coils together move by
    assert record["error_by_model"]["F_z"][1] == pytest.approx(1e-13 / abs(PRESS), rel=1e-6)
    assert record["error_by_model"]["F_z"][0] == pytest.approx(1e-13 / abs(PRESS) / 1.1, rel=1e-6)
    text = text_of(record)  # 1e-13 H is 0.025 mN of a coil alone, two deviations; 10 %: 2e-13 H of 8e-9 H
    assert max(len(line) for line in text.splitlines()) <= 80
    for word in ("its signal dL_x", "the inverse", "0.012 mN", "10.0000 +- 0.0028", "F_x, F_z, F_y; for all six"):
        assert word in text, word


def test_no_figure_below_its_error_is_printed() -> None:
    """Loads that are off by as much as F_z moves a coil: no crosstalk, no slope by it, but the errors."""
    record = record_of(5e-9)
    text = text_of(record)
    assert record["crosstalk_before"]["F_z"]["F_x"] == pytest.approx(0.1)
    assert "10.0" not in text and "?" in text and "599 mN" in text and "< " in text
    line = next(line for line in text.splitlines() if "best linear sum" in line)
    assert "+-" not in line and line.count("<") == 3


def test_a_force_that_no_coil_resolves_is_printed_by_name() -> None:
    """Its column and its row stay; there is no inverse; the others are what they are."""
    record = record_of(1e-13, ("F_x", "F_z", "M_z"))
    text = text_of(record)
    assert record["forces_seen"]["unseen"] == ["M_z"] and np.isinf(record["resolution"]["M_z"]).all()
    assert json.loads(json_text(record))["resolution"]["M_z"] == [None] * 3
    assert record["valid_share"] == 0.0 and "not resolved" in text and "M_z: moves the coils by less" in text
    assert "by M_z [ppm/(N" in text and "its best sum" in text and "F_y" not in record["own_signal"]


def limits_text(found: Limits) -> str:
    """Return what is printed of limits, and check that they are JSON."""
    record = limits_record(found)
    assert json.loads(json_text(record)) == record
    console = Console(file=io.StringIO(), width=160, markup=False)
    console.print(limits_table(record))
    return console.file.getvalue()


def test_limits_that_are_known() -> None:
    """Stretch against the data, loops in percent, what a factor of two between sources makes of a newton."""
    turned, lost = Note.of(NoteKind.LIMIT_LOAD, end="turned"), Note(NoteKind.LIMIT_LOST)
    carried = Capacity(Wrench(F_x=1.0, F_z=2.0), 2.345, 0.12, turned), Capacity(Wrench(F_z=2.0), 1.5, np.nan, lost)
    found = Limits(2.6, 2.0, "F_z = 4 N", 1.5e-3, 1e-5, "F_z = 2 N", 0.031, 0.05, 2.0, carried)
    text = limits_text(found)
    for words in (
        "2.6 under F_z = 4 N; BEYOND the silicone",
        "1.500 +- 0.010 mm over the coils, under F_z = 2 N", "3.1 %, load up",
        "5 %, of the displacement left 1 s after", "1 N means 0.5 to 2 N",
        "1.5 times F_z = 2 N; then no equilibrium found beyond: it may carry more",
        "2.35 +- 0.12 times F_x = 1 N, F_z = 2 N; then limit load",
    ):
        assert words in text, words
    assert limits_record(found)["force_factor"] == [0.5, 2.0] and limits_record(found)["capacity"][1]["error"] is None
    within = Limits(1.5, 2.0, "F_z = 4 N", 1.5e-3, 1e-5, "F_z = 2 N", 0.031, 0.05, 2.0)
    assert "; within the silicone" in limits_text(within) and "carries" not in limits_text(within)


def test_limits_that_are_not_known_are_called_so() -> None:
    nothing = Limits(np.nan, np.nan, "", 1.5e-3, np.nan, "F_z = 2 N", np.nan, np.nan, np.nan)
    none = Note.of(NoteKind.NO_LIMIT, most=64.0)
    nothing = replace(nothing, capacity=(Capacity(Wrench(F_z=2.0), np.inf, np.nan, none),))
    text = limits_text(nothing)
    assert text.count("unknown") == 5 and "any multiple of F_z = 2 N; then no limit was met up to 64 times" in text
    assert limits_record(nothing)["hysteresis"] is None and modulus_words(None) == "spread between sources unknown"
