"""Are the loops of pads that remember those of an independent code: area, peak, residual?

Five pads (layers in plane strain, a round and a square one; four laws, Prony branches, softening, both) along three
histories of their load, one not proportional (common/history_cases.py), against common/reference_histories.json, which
NGSolve made (benchmarks/reference_histories.py). Area is the work that the load has done from the first time to the
last [J], lost where the load ends at none; peak the largest motion of the component that moves most, residual what is
left of it at the end; both sides by the same recorded times. Steps and meshes are the package's own, by its tolerance.
Times are processor time of a whole history, from the scene on.

Run ``python -m benchmarks.loops_against_reference [--coarse] --output DIR``; `--only WORD` takes the rows with that
word in their names, `--tolerance 3e-3` another one. Table and picture.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common.outputs import write_rows

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.histories import LoadHistory, motion_of
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import WRENCH, Array, SolveFailed
from sits_mech.report.pictures.style import COLUMN, new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

STORED = Path(__file__).parents[1] / "common" / "reference_histories.json"
QUICK = ("layer 10 x 5, Yeoh, softened: two triangles",)  # the coarse run
SHORT = 21  # recorded times of the coarse run
SEEN = 0.02  # of the peak: a smaller residual is judged over this


@dataclass(frozen=True)
class History:
    """A pad, its load and its motion over time.

    Attributes
    ----------
    name, model : str
        The model is "block" or "planar".
    changes : tuple of str
        What makes the scene from the catalogue's biorob2018.
    lever, height : float
        Half the target's width, and where the load acts above the target's lower face [m].
    time : ndarray, shape (n,)
        [s].
    load : ndarray, shape (n, 2)
        F_x, F_z down [N].
    moved : ndarray, shape (n, 3)
        d_h, sink, alpha [m, m, rad].
    error : float
        Of the reference, over the largest displacement [-].
    """

    name: str
    model: str
    changes: tuple[str, ...]
    lever: float
    height: float
    time: Array
    load: Array
    moved: Array
    error: float

    @property
    def sensor(self) -> Sensor:
        """The scene."""
        return load_sensor("biorob2018", list(self.changes))

    def first(self, count: int) -> History:
        """Return the history up to so many times."""
        rows = (self.time[:count], self.load[:count], self.moved[:count])
        return History(self.name, self.model, self.changes, self.lever, self.height, *rows, self.error)


@dataclass(frozen=True)
class Loop:
    """Figures of a history: work of the load [J], largest and last motion of the leading component [m]."""

    area: float
    peak: float
    residual: float


def stored_histories(path: Path = STORED) -> list[History]:
    """Return the references."""
    rows: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["rows"]
    return [
        History(row["name"], row["model"], tuple(row["scene"]), row["lever"], row["height"],
                *(np.array(row[name]) for name in ("time", "load", "moved")), row["error"])
        for row in rows
    ]


def loop_of(one: History, moved: Array) -> Loop:
    """Return the figures of a motion (n, 3) under the loads of a history; the load's point moves with the target."""
    d_h, sink, alpha = moved.T
    place = np.stack([d_h + one.height * np.sin(alpha), sink + one.height * (1.0 - np.cos(alpha))], axis=1)
    mean = 0.5 * (one.load[1:] + one.load[:-1])
    lead = moved[:, int(np.argmax(np.abs(one.moved[:, :2]).max(axis=0)))]
    return Loop(float(np.sum(mean * np.diff(place, axis=0))), float(np.abs(lead).max()), float(lead[-1]))


def followed(one: History, tolerance: float) -> tuple[Array, float]:
    """Return the package's motion (n, 3) at the times of a history, and its own error; all that asks the package."""
    wrench = np.zeros((one.time.size, len(WRENCH)))
    wrench[:, [WRENCH.index("F_x"), WRENCH.index("F_z")]] = one.load
    sensor = one.sensor
    layer = (planar_layer if one.model == "planar" else block_pad)(sensor, tolerance)
    motion = motion_of(sensor, layer, LoadHistory(one.time, wrench))
    pose, own = motion.pose.components, motion.given
    pose = pose if pose.shape[0] == own.size else pose.T
    if sensor.elastomer is None:
        raise ValueError(f"{one.name}: must have an elastomer")
    rest = sensor.elastomer.standoff + sensor.elastomer.thickness
    d_h, d_v, alpha = pose[own, :3].T
    return np.stack([d_h, rest - d_v, alpha], axis=1), motion.report.estimated_error


def row_of(one: History, tolerance: float) -> tuple[dict[str, object], Array]:
    """Return a history as a row of the table, and the package's motion, which is not a number where it fails."""
    began, status, estimated = time.process_time(), "", np.nan
    try:
        found, estimated = followed(one, tolerance)
    except SolveFailed as failure:
        found, status = np.full(one.moved.shape, np.nan), str(failure).partition("\n")[0][:60]
    spent = time.process_time() - began
    ours, theirs, lever = loop_of(one, found), loop_of(one, one.moved), np.array([1.0, 1.0, one.lever])
    left = max(abs(theirs.residual), SEEN * theirs.peak)
    away = np.max(np.abs(found - one.moved) * lever) / np.max(np.abs(one.moved) * lever)
    row: dict[str, object] = {
        "pad and history": one.name, "area J": theirs.area, "area off": ours.area / theirs.area - 1.0,
        "peak m": theirs.peak, "peak off": ours.peak / theirs.peak - 1.0,
        "residual m": theirs.residual, "residual off": (ours.residual - theirs.residual) / left,
        "pose off": float(away), "estimated": estimated, "reference's own": one.error,
        "processor s": spent, "times": one.time.size, "status": status,
    }
    return row, found


def draw(every: Sequence[tuple[History, Array]], path: Path) -> None:
    """Write the loops of the leading force over its displacement: the package's as lines, the reference as dots."""
    names = list(dict.fromkeys(one.name.partition(":")[0] for one, _ in every))
    with new_figure(height=0.75 * len(names), width=1.3 * COLUMN, columns=1, rows=len(names)) as (figure, spots):
        for spot, name in zip(spots, names, strict=True):
            for number, (one, found) in enumerate(each for each in every if each[0].name.startswith(name)):
                sheared = bool(np.any(one.load[:, 0]))
                across = 0 if sheared else 1
                label = one.name.partition(": ")[2] + (" ($F_x$)" if sheared else "")
                spot.plot(1e3 * found[:, across], one.load[:, across], f"C{number}-", lw=0.7, label=label)
                spot.plot(1e3 * one.moved[:, across], one.load[:, across], f"C{number}o", ms=2, mfc="none")
            spot.set(xlabel="displacement [mm]", ylabel="force [N]")
            spot.set_title(name, fontsize=7)
            spot.legend(fontsize=5)
        save_figure(figure, path)


def main() -> None:
    """Follow, judge, write table and picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarse", action="store_true", help="half of one history: does it still run?")
    parser.add_argument("--output", type=Path, required=True, help="folder of table and picture")
    parser.add_argument("--only", action="append", help="histories whose names have this in them; may be repeated")
    parser.add_argument("--tolerance", type=float, default=1e-2, help="asked error")
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    chosen = [one for one in stored_histories() if not asked.only or any(word in one.name for word in asked.only)]
    if asked.coarse:
        chosen = [one.first(SHORT) for one in stored_histories() if one.name in QUICK]
    rows, every = [], []
    for one in chosen:
        row, found = row_of(one, asked.tolerance)
        print(" | ".join(f"{x:.3g}" if isinstance(x, float) else str(x) for x in row.values()), flush=True)
        rows.append(row)
        every.append((one, found))
    write_rows(rows, asked.output / "loops_against_reference.csv")
    worst = [max(abs(float(str(row[f"{name} off"]))) for name in ("area", "peak", "residual")) for row in rows]
    print(f"area, peak and residual within 2 %: {sum(x <= 0.02 for x in worst)} of {len(worst)}")
    draw(every, asked.output / "loops_against_reference.png")


if __name__ == "__main__":
    main()
