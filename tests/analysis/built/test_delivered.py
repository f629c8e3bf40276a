"""What the next unit is delivered with, in closed form where errors are normal; what is known of it, kept and read."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.bench.load_plan import plan_loads
from sits_mech.analysis.bench.unknowns import PriorParameter
from sits_mech.analysis.built.delivered import delivered, known_by, lot_record, spread_of
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.built.production import Production
from sits_mech.scene.sensor import SceneError


def test_yield_grows_with_what_is_read(prior: Prior) -> None:
    """Errors fall and yields grow from none to two loads; without a limit that counts all units are good."""
    alone, plan = Production.alone(prior), plan_loads(prior, 2)
    rows = delivered(alone, plan, 0.02)
    assert [row.after for row in rows] == ["as computed", "tared", "and 1 load", "and 2 loads"]
    errors, yields = np.array([row.error for row in rows]), [row.good for row in rows]
    assert np.all(np.diff(errors.max(axis=1)) < 0.0) and np.all(np.diff(yields) >= 0.0)
    assert [row.good for row in delivered(alone, plan, 1e6)] == [1.0] * 4
    # ninety percent of the loads of ninety percent of the units is more than ninety percent of all
    assert np.all(errors[1:] > plan.errors)
    # lots whose units are all alike are good or bad as a whole, with the same errors over all lots
    same = delivered(replace(alone, within=0.0 * alone.within), plan, float(errors[2].max()))
    other = delivered(alone, plan, float(errors[2].max()))
    assert same[2].error == pytest.approx(other[2].error, rel=0.3)
    assert np.diff(same[1].lots) >= np.diff(other[1].lots)


def test_what_is_known_is_kept(prior: Prior, tmp_path: Path) -> None:
    """Values, deviations and correlation come back; other unknowns and other files are refused."""
    count = len(prior.known)
    alike = np.eye(count)
    alike[0, 1] = alike[1, 0] = -0.6
    known = prior.known_together(list(prior.known), alike)
    path = tmp_path / "lot.json"
    path.write_text(json.dumps(lot_record(known)))
    again = known_by(prior, path)
    assert again.covariance == pytest.approx(known.covariance) and again.start == pytest.approx(prior.start)
    sizes = prior.deviations
    assert again.covariance / np.outer(sizes, sizes) == pytest.approx(alike)
    for text, why in (("{}", "must be a lot.json"), ("[1]", "must be a lot.json"),
                      (path.read_text().replace('"gap"', '"gab"'), "must be of the same unknowns")):
        path.write_text(text)
        with pytest.raises(SceneError, match=why):
            known_by(prior, path)


def test_a_lot_that_cannot_be_is_refused(prior: Prior, tmp_path: Path) -> None:
    """Of another sensor, with deviations or correlations that no unknowns have: in one line."""
    good, path = json.dumps(lot_record(prior)), tmp_path / "lot.json"
    for place, value, why in (
        (("sensor",), "another", "must be of the sensor"), (("unknowns", "gap", "deviation"), 0.0, "above zero"),
        (("unknowns", "gap", "value"), np.nan, "above zero"), (("correlation", 0, 1), 0.9, "correlations that can be"),
        (("correlation", 0, 0), np.nan, "that can be"), (("correlation", 1, 1), -1.0, "that can be"),
        (("correlation", slice(0, 2)), [[1.0, 1.0, *[0.0] * (len(prior.known) - 2)]] * 2, "that can be"),
    ):
        record = part = json.loads(good)
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = value
        path.write_text(json.dumps(record))
        with pytest.raises(SceneError, match=why):
            known_by(prior, path)


def test_spread_is_read(prior: Prior) -> None:
    """In percent and micrometres; anything else is one line."""
    assert spread_of(prior, ["modulus=2 %", " gap = 20 um"]) == pytest.approx({"modulus": 0.02, "gap": 2e-5})
    width = replace(prior.setup, parameters=(PriorParameter("target.width", 0.015, 1e-4), *prior.setup.parameters))
    other = replace(prior, setup=width)
    for text, size in (("1 %", 1.5e-4), ("10 um", 1e-5), ("1e-5", 1e-5)):
        assert spread_of(other, [f"target.width={text}"]) == pytest.approx({"target.width": size})
    for text, why in (
        ("gap", "must be name=deviation"), ("colour=1", "got colour=1"), ("gap=-1 um", "zero or more"),
        ("gap=1 %", "gap: must be a length"), ("target.width=1 N", "target.width: must be a length"),
    ):
        with pytest.raises(SceneError, match=why):
            spread_of(other, [text])
