"""Studies that solve as few cases as predict the others: what stands between them, and what is asked again."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.batch import requests
from sits_mech.batch.adaptive import refinement_summary
from sits_mech.batch.forecast import forecast
from sits_mech.batch.run import open_sweep, run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.cli.main import run as command
from sits_mech.units import SceneError

TEXT = """scene = "biorob2018"
request = "pose"
combine = "adaptive"
[vary]
fz = { from = "0 N", to = "2 N", count = 17 }
fx = { from = "-1 N", to = "1 N", count = 17 }
[adaptive]
of = "d_v"
within = 1e-3
[fixed]
model = "linear"
"""
Answer = Callable[[float, float], dict[str, Any]]


def smooth(fx: float, fz: float) -> dict[str, Any]:
    """A number and an array, analytic, no polynomials, that are known everywhere."""
    both = np.array([np.sin(fx + fz), 1e-9 * np.exp(fx - fz)])
    flags = "above tolerance" if fx > 0.3 else "ok"
    row = {"d_v": np.exp(0.7 * fx - 0.4 * fz), "error_d_v": 1e-6 * (2.0 + fx), "both": (("part",), both)}
    return row | {"status": flags, "flags": flags, "other": 1.0}


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> Callable[[Answer], list[dict[str, Any]]]:
    """Put a known answer in the place of poses; the list is of the cases that were asked for."""

    def known(answer: Answer) -> list[dict[str, Any]]:
        asked: list[dict[str, Any]] = []

        def pose(variant: requests.Variant, point: dict[str, Any]) -> dict[str, Any]:
            asked.append(point)
            if point["model"] == "planar" and point["fz"] == 1.0:
                raise ValueError("no")
            return answer(point.get("fx", 0.0), point["fz"])

        request = replace(requests.REQUESTS["pose"], answer=pose)
        monkeypatch.setitem(requests.REQUESTS, "pose", request)  # type: ignore[arg-type]
        return asked

    return known


def swept(folder: Path, text: str) -> xr.Dataset:
    """Run a study of a text."""
    (folder / "study.toml").write_text(text)
    return run_study(read_study(folder / "study.toml"), folder / "out")


def missed(data: xr.Dataset, answer: Answer, name: str) -> np.ndarray:
    """How far a variable is from its known values, over the error that is stated of the map, where it is not solved."""
    fz, fx = data["fz"].to_numpy(), data["fx"].to_numpy()
    truth = np.array([[_value(answer(x, z)[name]) for x in fx] for z in fz])
    between = np.isnan(data["seconds"].to_numpy())
    np.testing.assert_allclose(data[name].to_numpy()[~between], truth[~between], rtol=1e-12)
    assert not data[f"error_map_{name}"].to_numpy()[~between].any()
    return np.asarray(np.abs(data[name].to_numpy() - truth)[between] / data[f"error_map_{name}"].to_numpy()[between])


def _value(item: Any) -> Any:
    """The values of an entry of a row."""
    return item[1] if isinstance(item, tuple) else item


def test_what_is_not_solved_is_known_within_its_error(
    tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]
) -> None:
    """That of the map, in the right place, also of an array whose parts are of other sizes; flags as beside."""
    asked = solved(smooth)
    data = swept(tmp_path, TEXT.replace('"d_v"', '["d_v", "both"]'))
    assert len(asked) < 0.4 * 17**2
    for name in ("d_v", "both"):
        assert np.mean(missed(data, smooth, name) <= 1.0) >= 0.95
        ranges = np.ptp(data[name].to_numpy().reshape(17**2, -1), axis=0).max()
        assert data[f"error_map_{name}"].max() <= 1e-3 * ranges
    between = np.isnan(data["seconds"].to_numpy())
    assert np.count_nonzero(~between) == len(asked) and np.isnan(data["other"].to_numpy()[between]).all()
    own = 1e-6 * (2.0 + data["fx"]).broadcast_like(data["d_v"].T).T + data["error_map_d_v"]
    np.testing.assert_allclose(data["error_d_v"], own, rtol=1e-9)
    words = data["status"].to_numpy()
    assert set(words[:, :8][between[:, :8]]) == {"interpolated"} and set(words[:, -1]) == {"above tolerance"}
    assert set(data["flags"].to_numpy()[:, -1][between[:, -1]]) == {"above tolerance; interpolated"}
    assert data["error_map_d_v"].attrs["units"] == "m" and json.loads(data.attrs["adaptive"])["within"] == 1e-3
    assert data.attrs["combine"] == "adaptive" and open_sweep(tmp_path / "out").identical(data)


def test_a_finer_one_solves_what_is_new(tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]) -> None:
    """And one that was killed what is left; the result is that of a run without a stop."""
    asked = solved(smooth)
    swept(tmp_path, TEXT.replace("1e-3", "1e-2"))
    first = len(asked)
    finer = swept(tmp_path, TEXT)
    assert len({(point["fx"], point["fz"]) for point in asked}) == len(asked) > first
    assert np.isfinite(finer["seconds"]).sum() == len(asked)
    count = len(asked)

    def end(done: int, of: int) -> None:
        if done == 9:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(read_study(tmp_path / "study.toml"), tmp_path / "other", progress=end)
    again = run_study(read_study(tmp_path / "study.toml"), tmp_path / "other")
    assert len(asked) == 2 * count and again.drop_vars("seconds").identical(finer.drop_vars("seconds"))
    whole = swept(tmp_path, re.sub(r"combine.*\n|\[adaptive\]\n.*\n.*\n", "", TEXT))
    assert len(asked) == count + 17**2 and set(whole["status"].to_numpy().ravel()) == {"ok", "above tolerance"}


def test_a_limit_needs_fewer_cases(tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]) -> None:
    """Than the same tolerance everywhere; every case is on the side where it is."""

    def bent(fx: float, fz: float) -> dict[str, Any]:
        return {"d_v": np.tanh(2.0 * (fx + 0.5 * fz) - 0.5), "status": "ok"}

    asked = solved(bent)
    text = TEXT.replace("17", "33").replace("1e-3", "1e-4")
    everywhere = swept(tmp_path, text)
    count, limit = len(asked), 0.1
    data = run_study(read_limited(tmp_path, text, "'0.1 m'"), tmp_path / "limit")
    assert len(asked) - count < 0.8 * count
    side = everywhere["d_v"].to_numpy() > limit
    np.testing.assert_array_equal(data["d_v"].to_numpy() > limit, side)
    known = np.abs(data["d_v"] - limit) > data["error_map_d_v"]
    assert known.all() and np.mean(missed(data, bent, "d_v") <= 1.0) >= 0.95


def test_where_a_limit_is_met_is_said_with_what_the_place_is_known_to(
    tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]
) -> None:
    """Of one key, at the root of the function; errors of cases and map over the slope are in that of the place.

    Also of few cases, which are all solved: what a straight line between them misses is in it.
    """

    def bent(fx: float, fz: float) -> dict[str, Any]:
        return {"d_v": np.tanh(2.0 * fz - 0.5), "error_d_v": 0.01, "status": "ok"}

    solved(bent)
    text = re.sub(r"fx = .*\n", "", TEXT).replace("17", "33")
    study = read_limited(tmp_path, text, "'0.1 m'")
    assert study.adaptive is not None
    line = refinement_summary(run_study(study, tmp_path / "limit"), study.adaptive)
    found = re.search(r"; d_v is 0.1 at fz = ([\d.]+) N \+- ([\d.]+) N$", line)
    assert found is not None, line
    place, error = map(float, found.groups())
    root = (0.5 + np.arctanh(0.1)) / 2.0
    assert place == pytest.approx(root, abs=1e-3) and 0.005 <= error < 0.01  # the map's is in it
    coarse = read_limited(tmp_path, text.replace("33", "4"), "'0.1 m'")
    assert coarse.adaptive is not None
    line = refinement_summary(run_study(coarse, tmp_path / "few"), coarse.adaptive)
    found = re.search(r"^solved: all .*; d_v is 0.1 at fz = ([\d.]+) N \+- ([\d.]+) N$", line)
    assert found is not None, line
    place, error = map(float, found.groups())
    assert 0.01 < abs(place - root) < error < 10.0 * abs(place - root)


def read_limited(folder: Path, text: str, limit: str) -> Any:
    """A study of a text with a limit."""
    (folder / "limit.toml").write_text(text.replace("[fixed]", f"limit = {limit}\n[fixed]"))
    return read_study(folder / "limit.toml")


def test_words_are_refined_each_alone(tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]) -> None:
    """Lists in any order; where a case of one word fails, its cases are all solved."""
    asked = solved(smooth)
    text = TEXT.replace("[vary]", '[vary]\nmodel = ["planar", "linear"]').replace('[fixed]\nmodel = "linear"\n', "")
    text = text.replace('{ from = "0 N", to = "2 N", count = 17 }', '["2 N", "0 N", "0.5 N", "1.5 N", "1 N"]')
    data = swept(tmp_path, text)
    assert data["d_v"].dims == ("model", "fz", "fx") and len(asked) < 1.6 * 5 * 17
    assert (data["status"][0, 4] == "failed").all() and not (data["status"][0] == "interpolated").any()
    assert not data["error_map_d_v"][0, :4].any() and (data["status"][1] == "interpolated").any()
    assert np.mean(missed(data.isel(model=1), smooth, "d_v") <= 1.0) >= 0.95


REFUSED = {
    TEXT.replace('"d_v"', "3"): "adaptive.of: must be a variable of the table",
    TEXT.replace('"d_v"', '["d_v", "d_v"]'): "adaptive.of: must be .* different ones",
    TEXT.replace("1e-3", "2"): "adaptive.within: must be a share .* between 0 and 1; got 2",
    TEXT.replace("of =", "off ="): r'adaptive.off: the key must be .*, within, limit; got "off" .did you mean "of"',
    TEXT.replace("[fixed]", 'limit = "1 floop"\n[fixed]'): "adaptive.limit: must be a number, or a quantity",
    TEXT.replace('"adaptive"', '"product"'): 'beside combine = "adaptive"',
    TEXT.replace('{ from = "0 N", to = "2 N", count = 17 }', '["1 N", "1000 mN"]'): "fz: must be a list of different",
    re.sub(r"f[xz] = .*\n", "", TEXT).replace("[vary]", '[vary]\nmodel = ["auto"]').replace('model = "linear"', ""):
        "vary: must have a key with numbers, for adaptive; got model",
}


@pytest.mark.parametrize("text", REFUSED, ids=list(REFUSED.values()))
def test_what_cannot_be_refined(text: str, tmp_path: Path) -> None:
    """One line: the key, what it must be, what came."""
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(SceneError, match=REFUSED[text]):
        read_study(tmp_path / "study.toml")


def test_variables_that_are_none_are_refused_with_the_first_case(
    tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]], capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line with the nearest; the case is kept."""
    asked = solved(smooth)
    (tmp_path / "study.toml").write_text(TEXT.replace('"d_v"', '"d_w"'))
    words = ["sweep", str(tmp_path / "study.toml"), "-o", str(tmp_path / "out")]
    assert command(words) == 2 and len(asked) == 1
    assert re.search(r'adaptive.of: must be one of d_v.*; got "?d_w"? .did you mean "d_v"', capsys.readouterr().err)
    (tmp_path / "study.toml").write_text(TEXT)
    assert command([*words, "--accept"]) == 0
    count = len(asked)
    assert f"solved: {count} of 289 cases; between them d_v within" in capsys.readouterr().err
    assert len({(point["fx"], point["fz"]) for point in asked}) == count


def test_planned_are_the_cases_that_usually_suffice(
    tmp_path: Path, solved: Callable[[Answer], list[dict[str, Any]]]
) -> None:
    """Not the whole grid."""
    solved(smooth)
    (tmp_path / "study.toml").write_text(TEXT)
    assert 15 < forecast(read_study(tmp_path / "study.toml")).cases < 100
