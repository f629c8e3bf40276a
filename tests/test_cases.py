"""A grid becomes a table: values in place, failures as rows, resumed runs, other executors."""

import math
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.cases import Solve, solve_cases
from sits_mech.quantities import SolveFailed, SolveReport
from sits_mech.store import opened
from sits_mech.units import SceneError

GRID = {"a": [1.0, 2.0, 3.0], "b": [10.0, 20.0]}


def product(a: float, b: float) -> dict[str, object]:
    """A number, a text and a vector."""
    return {"c": a * b, "name": f"{a:g}", "both": (("part",), np.array([a, b]))}


def root(a: float, b: float) -> dict[str, object]:
    """Fails in three ways."""
    if a == 2.0:
        raise SolveFailed("gave up", SolveReport("root", 1, 1, 1.0, 1.0, 0.0, status="stalled"))
    if (a, b) == (3.0, 20.0):
        raise OSError("disk full")
    return {"c": math.sqrt(a - 1.5)}


def kept(folder: Path) -> set[str]:
    """Return the names of the points that are kept in a folder."""
    with opened(folder) as cases:
        return cases.names


def test_values_stand_at_their_place() -> None:
    """Dimensions by the grid's order, inner dimensions behind them."""
    found = solve_cases(product, GRID)
    assert found["c"].dims == ("a", "b") and found["both"].dims == ("a", "b", "part")
    assert float(found["c"].sel(a=3.0, b=20.0)) == 60.0
    np.testing.assert_array_equal(found["both"].sel(a=2.0, b=10.0), [2.0, 10.0])
    assert str(found["name"].sel(a=2.0, b=10.0).item()) == "2"
    assert np.all(found["status"] == "ok") and np.all(found["seconds"] >= 0.0)


def test_a_failure_is_a_row() -> None:
    """Status and reason say why; the others are untouched."""
    found = solve_cases(root, GRID)
    assert found["status"].sel(b=20.0).to_numpy().tolist() == ["failed", "failed", "failed"]
    assert found["reason"].sel(a=2.0, b=10.0).item() == "gave up"
    assert found["reason"].sel(a=3.0, b=20.0).item().startswith("OSError: ")
    assert np.isnan(found["c"].sel(a=2.0)).all() and float(found["c"].sel(a=3.0, b=10.0)) == math.sqrt(1.5)


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_any_executor_gives_the_same(pool: type) -> None:
    """Whatever order the points are finished in."""
    with pool(2) as executor:
        found = solve_cases(product, GRID, executor=executor)
    np.testing.assert_array_equal(found["c"], solve_cases(product, GRID)["c"])


class Losing(ThreadPoolExecutor):
    """An executor that loses every call with some point in it."""

    def submit(self, call, /, *arguments):  # noqa: ANN001, ANN002, ANN201
        """Call, or fail as where a worker was lost."""
        if {"a": 2.0, "b": 10.0} in arguments[1]:
            return super().submit(divmod, 1, 0)
        return super().submit(call, *arguments)


def test_points_that_an_executor_loses_are_rows(tmp_path: Path) -> None:
    """That one alone which does it, though others went with it; it is not kept, and is tried again."""
    with Losing(1) as executor:
        found = solve_cases(product, GRID, executor=executor, chunk=3, folder=tmp_path)
    assert found["status"].values.tolist() == [["ok", "ok"], ["failed", "ok"], ["ok", "ok"]]
    assert found["reason"].sel(a=2.0, b=10.0).item().startswith("ZeroDivisionError") and len(kept(tmp_path)) == 5
    assert np.all(solve_cases(product, GRID, folder=tmp_path)["status"] == "ok")


def fatal(a: float, b: float) -> dict[str, object]:
    """End the process at a point."""
    if (a, b) == (2.0, 20.0):
        os._exit(1)
    return product(a, b)


def test_a_pool_that_breaks_ends_the_run(tmp_path: Path) -> None:
    """In one line, with what it finished; the same run goes on."""
    with ProcessPoolExecutor(1) as pool, pytest.raises(SceneError, match="executor: must live until .* got BrokenProc"):
        solve_cases(fatal, GRID, executor=pool, folder=tmp_path)
    assert len(kept(tmp_path)) == 3
    assert np.all(solve_cases(product, GRID, folder=tmp_path)["status"] == "ok")


def test_a_stopped_run_goes_on(tmp_path: Path) -> None:
    """Ctrl-C leaves finished points; the next run computes the others only, and gives the same table."""
    calls = []

    def stopped(a: float, b: float) -> dict[str, object]:
        calls.append((a, b))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return product(a, b)

    with pytest.raises(KeyboardInterrupt):
        solve_cases(stopped, GRID, folder=tmp_path, key="k")
    assert len(kept(tmp_path)) == 3 and os.listdir(tmp_path) == ["cases.sqlite"]
    found = solve_cases(stopped, GRID, folder=tmp_path, key="k")
    assert len(calls) == 4 + 3
    np.testing.assert_array_equal(found["both"], solve_cases(product, GRID)["both"])
    solve_cases(stopped, GRID, folder=tmp_path, key="another")
    assert len(calls) == 4 + 3 + 6


def test_point_that_was_edited_is_solved_anew(tmp_path: Path) -> None:
    """A digit of a kept point is changed: the checksum no longer holds, and the table does not take it."""
    solve_cases(product, GRID, folder=tmp_path)
    with opened(tmp_path) as cases, cases.file:
        cases.file.execute("UPDATE cases SET row = replace(row, '60.0', '61.0')")
    found = solve_cases(product, GRID, folder=tmp_path)
    assert float(found["c"].sel(a=3.0, b=20.0)) == 60.0
    with opened(tmp_path) as cases:
        assert any('"c": 60.0' in row for (row,) in cases.file.execute("SELECT row FROM cases"))


def test_passing_failures_are_tried_again(tmp_path: Path) -> None:
    """A full disk may be emptied; a load that is too large stays so."""
    solve_cases(root, GRID, folder=tmp_path)
    assert len(kept(tmp_path)) == 5
    done = []
    solve_cases(root, GRID, folder=tmp_path, progress=lambda n, of: done.append((n, of)))
    assert done == [(n, 6) for n in range(1, 7)] and len(kept(tmp_path)) == 5


def test_a_snapshot_is_the_table_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points that are to come are unfinished, their numbers NaN; the next is due in fifty times what one took."""
    monkeypatch.setattr("sits_mech.cases._FIRST", 0.0)
    monkeypatch.setattr("sits_mech.cases._APART", 0.0)
    seen = []
    found = solve_cases(product, GRID, snapshot=lambda data: seen.append(data.copy(deep=True)))
    assert [int((data["status"] == "unfinished").sum()) for data in seen] == [5, 4, 3, 2, 1, 0]
    assert np.isnan(seen[2]["c"]).sum() == 3 and seen[2]["reason"].to_numpy().ravel().tolist() == [""] * 6
    xr.testing.assert_identical(seen[-1], found)
    np.testing.assert_array_equal(seen[2]["both"].to_numpy().reshape(6, 2)[:3], [[1, 10], [1, 20], [2, 10]])
    seen.clear()
    monkeypatch.setattr("sits_mech.cases._APART", 1e6)
    solve_cases(product, GRID, snapshot=seen.append)
    assert len(seen) == 1


@pytest.mark.parametrize("folder", [True, False], ids=["kept", "not kept"])
def test_points_may_be_chosen_by_what_came(folder: bool, tmp_path: Path) -> None:
    """In rounds; a row may be put in the place of another; what is neither called nor put is unfinished."""
    calls, done = list[tuple[float, float]](), list[tuple[int, int]]()

    def noted(a: float, b: float) -> dict[str, object]:
        calls.append((a, b))
        return product(a, b)

    def choose(solve: Solve, put: Callable[[int, dict[str, object]], None]) -> None:
        first = dict(solve([0, 5]))
        then = dict(solve([2] if first[5]["c"] == 60.0 else [3]))
        put(1, {"c": first[0]["c"] + then[2]["c"], "status": "interpolated"})

    more = {"folder": tmp_path} if folder else {}
    table = solve_cases(noted, GRID, choose=choose, progress=lambda *each: done.append(each), **more)
    assert calls == [(1.0, 10.0), (3.0, 20.0), (2.0, 10.0)] and done == [(1, 6), (2, 6), (3, 6), (6, 6)]
    np.testing.assert_array_equal(table["c"], [[10.0, 30.0], [20.0, np.nan], [np.nan, 60.0]])
    states = [["ok", "interpolated"], ["ok", "unfinished"], ["unfinished", "ok"]]
    assert table["status"].to_numpy().tolist() == states
    again = solve_cases(noted, GRID, choose=choose, **more)
    assert again.identical(table.assign(seconds=again["seconds"])) and len(calls) == (3 if folder else 6)


def test_points_that_share_something_are_neighbours() -> None:
    """The largest group first, in the order of the grid within; the table is the same."""
    asked = []

    def told(a: float, b: float) -> dict[str, object]:
        asked.append((a, b))
        return product(a, b)

    grid = GRID | {"b": [10.0, 20.0, 30.0, 40.0]}
    grouped = solve_cases(told, grid, group=lambda point: (point["b"] > 15.0, point["a"]))
    assert [b > 15.0 for _, b in asked] == [True] * 9 + [False] * 3
    assert asked[:4] == [(1.0, 20.0), (1.0, 30.0), (1.0, 40.0), (2.0, 20.0)]
    assert grouped.drop_vars("seconds").equals(solve_cases(product, dict(grouped.indexes)).drop_vars("seconds"))


def test_arrays_of_different_lengths_are_filled_up() -> None:
    """With NaN, numbers and their other dimensions as they are."""
    data = solve_cases(lambda n: {"parts": (("part", "coil"), np.full((n, 2), float(n)))}, {"n": [2, 3, 1]})
    assert data["parts"].shape == (3, 3, 2) and not (data["status"] != "ok").any()
    np.testing.assert_array_equal(np.isfinite(data["parts"]).sum("part"), [[2, 2], [3, 3], [1, 1]])
    np.testing.assert_array_equal(data["parts"].isel(n=0, part=slice(2)), np.full((2, 2), 2.0))


@pytest.mark.parametrize("kept", [True, False])
def test_equal_points_are_called_once_where_they_are_kept(tmp_path: Path, kept: bool) -> None:
    """Each has its row; without a folder the function may be one of chance, and is called for each."""
    calls = []

    def square(x: float) -> dict[str, float]:
        """Return a square, and remember the call."""
        calls.append(x)
        return {"square": x * x}

    data = solve_cases(square, {"x": [2.0, 3.0, 2.0, 2.0]}, combine="zip", folder=tmp_path if kept else None)
    assert data["square"].values.tolist() == [4.0, 9.0, 4.0, 4.0]
    assert calls == ([2.0, 3.0] if kept else [2.0, 3.0, 2.0, 2.0])
