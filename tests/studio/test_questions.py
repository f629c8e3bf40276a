"""What is asked of the solving process: told apart, kept between runs."""

from pathlib import Path

import pytest
import xarray as xr

from sits_mech.scene.sensor import load_sensor
from sits_mech.studio.questions import Borne, SlopesQuestion, TableQuestion, grid_of

LOADS = (("F_x", grid_of(-0.4, 0.4)), ("F_z", grid_of(0.0, 1.0)))
MODELS = ("linear", "planar", 0.1)


def test_questions_are_told_apart() -> None:
    """By their kind, scene, loads, models and numbers."""
    sensor, other = load_sensor("biorob2018"), load_sensor("biorob2018-w15")
    numbers = [("elastomer.thickness",), ("target.width",)]
    each = [TableQuestion(sensor, LOADS, MODELS), TableQuestion(other, LOADS, MODELS),
            TableQuestion(sensor, LOADS[1:], MODELS), TableQuestion(sensor, LOADS, ("linear", "planar", 0.2)),
            Borne(sensor, (), MODELS),
            *(SlopesQuestion(sensor, LOADS, MODELS, own) for own in numbers)]
    assert len({question.key for question in each}) == len(each)
    assert TableQuestion(sensor, LOADS, MODELS).key == each[0].key


@pytest.mark.slow
def test_a_table_is_kept_where_preparations_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Asked again, after a restart, it is read with all its digits and nothing is solved."""
    monkeypatch.setenv("SITS_MECH_CACHE", str(tmp_path))
    question = TableQuestion(load_sensor("biorob2018"), LOADS, MODELS)
    first = question.answer(lambda *_: None)
    monkeypatch.setattr("sits_mech.chain.calibrate.calibrate", None)
    again = question.answer(lambda *_: None)
    xr.testing.assert_identical(first, again)
