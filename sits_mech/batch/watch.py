"""Tell how far the sweep in a folder is, from its table, which the run writes anew now and then.

The file of cases belongs to the run alone while it lasts; that it is taken says that there is a run. The rate is that
of the cases between the first table that was looked at and the last one. Groups are the cases of one scene, which a run
takes one after the other.
"""

from __future__ import annotations

import sqlite3
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import xarray as xr

from sits_mech.batch.run import TABLE, open_sweep
from sits_mech.batch.studies.written import SCENE
from sits_mech.readout.loads import each_of
from sits_mech.status import ANSWERED, UNFINISHED, failure_kind
from sits_mech.store import STORE
from sits_mech.units import SceneError

_SHOWN = 5  # groups under way: some processes, and what they left


def watched(folder: Path, pause: float = 2.0) -> Iterator[str]:
    """Yield lines on a sweep as its table changes, until no run has its folder; raise SceneError for no sweep."""
    if not (folder / STORE).exists():
        raise SceneError(f"{folder}: must be the folder of a sweep, for --watch; it has no {STORE}")
    first, last, known, idle, done, count = None, 0.0, set[str](), True, 0, 1
    if not _written(folder / TABLE):
        yield "no table yet: the first one comes some ten seconds after the first case"
    while True:
        runs = is_taken(folder)
        written = _written(folder / TABLE)
        if written > last:
            done, count, failed, words = _look(folder)
            first, last = first or (written, done), written
            yield _progress(done, count, failed, (written - first[0], done - first[1]), runs)
            yield from (line for line in words if line not in known)
            known = set(words)
        if idle and not runs:  # for a pause, after which a run has written its last table
            yield "all cases are done" if done == count else "no run has this folder: its command goes on from here"
            return
        idle = not runs
        time.sleep(pause)


def is_taken(folder: Path) -> bool:
    """Tell whether a run has the folder of a sweep."""
    with closing(sqlite3.connect(f"{(folder / STORE).absolute().as_uri()}?mode=rw", uri=True, timeout=0.0)) as file:
        try:
            file.execute("SELECT count(*) FROM sqlite_master").fetchone()
        except sqlite3.Error as error:
            return "locked" in str(error)
    return False


def _written(path: Path) -> float:
    """Return when a table was last written, in seconds of the epoch; 0 for none yet."""
    return path.stat().st_mtime if path.exists() else 0.0


def _look(folder: Path) -> tuple[int, int, int, list[str]]:
    """Return how many cases are done, how many there are, how many failed, lines on groups and kinds of failures."""
    with open_sweep(folder) as data:
        states, reasons = each_of(data), each_of(data, "reason")
        groups = _groups(data["status"])
    failures = Counter(
        failure_kind(state, reason) for state, reason in zip(states, reasons, strict=True)
        if state not in (*ANSWERED, UNFINISHED)
    )
    words = [*groups, *(f"{number} {kind}" for kind, number in failures.items())]
    return len(states) - states.count(UNFINISHED), len(states), failures.total(), [f"  {line}" for line in words]


def _groups(status: xr.DataArray) -> list[str]:
    """Return how many groups are done, and how far each is that is under way; none where each case is a scene."""
    keys = [str(name) for name in status.coords if "." in str(name) or name == SCENE]
    values = [status[name].broadcast_like(status).to_numpy().ravel().tolist() for name in keys]
    scenes, states = list(zip(*values, strict=True)), status.to_numpy().ravel().tolist()
    whole = Counter(scenes)
    left = Counter(scene for scene, state in zip(scenes, states, strict=False) if state == UNFINISHED)
    begun = [scene for scene, count in left.items() if count < whole[scene]]
    if not begun or not 1 < len(whole) < len(states):
        return []
    shown = [f"{', '.join(map(str, scene))}: {whole[scene] - left[scene]} of {whole[scene]}" for scene in begun]
    more = [f"and {len(shown) - _SHOWN} more"] if len(shown) > _SHOWN else []
    return [f"{', '.join(keys)}: {len(whole) - len(left)} of {len(whole)} done", *shown[:_SHOWN], *more]


def _progress(done: int, count: int, failed: int, since: tuple[float, int], runs: bool) -> str:
    """Return a line on progress; the rate is of cases `since` some seconds ago."""
    seconds, more = since
    text = f"{done} of {count} cases"
    if runs and more > 0 and seconds > 0.0:
        left = timedelta(seconds=round((count - done) * seconds / more))
        text += f", {more / seconds:.3g} a second, some {left} left"
    return f"{text}; {failed} failed" if failed else text
