"""Where does the target rest under a grid of loads? Each load starts from the nearest one that is settled.

The walk goes outward from the smallest load: without shear first, so that a symmetric layer stays symmetric, then with
more and more of it. A layer that is its own mirror image answers ``-F_x`` with the mirrored pose

    (d_h, d_v, alpha)(-F_x, F_z) = (-d_h, d_v, -alpha)(F_x, F_z),

which is taken, not solved again; without shear it is its own image, d_h = alpha = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from sits_mech.cases import DONE, Progress, Row, attempt, case_path, finish, read_case
from sits_mech.quantities import Equilibrium, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.sensor import Sensor, scene_hash
from sits_mech.version import __version__

Load = tuple[float, float]
_UPRIGHT = dict.fromkeys(("d_h", "alpha", "error_d_h", "error_alpha"), 0.0)  # of a symmetric load


def settle(
    layer: MechanicalModel,
    grid: Mapping[str, Sequence[float]],
    *,
    symmetric: bool,
    keep: tuple[Path | None, str] = (None, ""),
    known: Mapping[Load, Row] | None = None,
    progress: Progress | None = None,
) -> dict[Load, Row]:
    """Return a row for every load of a grid.

    Parameters
    ----------
    layer : MechanicalModel
        Wrench in, pose out.
    grid : mapping
        ``F_x`` and ``F_z``, the forces [N].
    symmetric : bool
        Whether the layer with its target is its own mirror image.
    keep : tuple of Path or None, and str
        Folder of finished loads, and what stands for everything besides the load that a row depends on.
    known : mapping, optional
        Rows of loads that are settled already.
    progress : callable, optional
        Called with the number of loads done and of all.

    Returns
    -------
    dict
        Rows by (F_x, F_z), as from `attempt`: pose with errors, min_J, notes, state.
    """
    rows: dict[Load, Row] = dict(known or {})
    loads = outward(grid["F_x"], grid["F_z"])
    for load in [load for load in loads if load not in rows]:
        twin = rows.get((-load[0], load[1])) if symmetric and load[0] != 0.0 else None
        row = _row(layer, rows, load, keep) if twin is None else _mirrored(twin)
        rows[load] = upright(row) if symmetric and load[0] == 0.0 else row
        if progress is not None:
            progress(len(rows), len(loads))
    return rows


def kept_key(sensor: Sensor, mechanics: str, tolerance: float) -> str:
    """Return what stands, in the names of kept loads, for everything besides the load that their rest depends on."""
    return f"{__version__} {scene_hash(sensor)} {mechanics} {tolerance}"


def kept_rest(keep: tuple[Path | None, str], wrench: Wrench) -> Equilibrium | None:
    """Return the equilibrium of a load that was settled in a folder, `keep` as of `settle`; None where it has none."""
    row = read_case(_path((wrench.F_x, wrench.F_z), keep))
    return None if row is None or row["status"] != DONE or "state" not in row else _equilibrium(wrench, row)


def upright(row: Row) -> Row:
    """Return the row of a load without shear on a layer that is its own mirror image: exactly straight."""
    return row | _UPRIGHT if row["status"] == DONE else row


def outward(F_x: Sequence[float], F_z: Sequence[float]) -> list[Load]:
    """Return the loads of a grid from the smallest outwards, by the size of the shear, then of the normal force."""
    loads = [(x, z) for x in F_x for z in F_z]
    return sorted(loads, key=lambda load: (abs(load[0]), -load[0], abs(load[1]), -load[1]))


def _path(load: Load, keep: tuple[Path | None, str]) -> Path | None:
    """Where a load is kept."""
    return case_path(*keep, {"F_x": load[0], "F_z": load[1]})


def _row(layer: MechanicalModel, rows: Mapping[Load, Row], load: Load, keep: tuple[Path | None, str]) -> Row:
    """Return the row of one load: kept on disk, or solved and kept."""
    path = _path(load, keep)
    kept = read_case(path)
    if kept is not None:
        return kept
    start = _nearest(rows, load)
    return finish(path, attempt(lambda **_: _settled(layer, Wrench(*load), start), {}))


def _settled(layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None) -> Row:
    """Return the equilibrium under a wrench as a row."""
    found = layer.equilibrium(wrench, start=start)
    row: Row = {name: float(getattr(found.pose, name)) for name in ("d_h", "d_v", "alpha")}
    row |= {f"error_{name}": float(getattr(found.error, name)) for name in ("d_h", "d_v", "alpha")}
    row |= {"min_J": np.nan if found.report.min_J is None else found.report.min_J}
    row |= {"error_mechanics": found.report.estimated_error, "iterations": found.report.iterations}
    return row | {"notes": "; ".join(found.report.notes), "state": ("unknown", found.state)}


def _nearest(rows: Mapping[Load, Row], load: Load) -> Equilibrium | None:
    """Return the settled load nearest to a new one, each force measured by its largest value so far."""
    settled = [near for near, row in rows.items() if row["status"] == DONE and "state" in row]
    if not settled:
        return None
    size = np.max(np.abs([*settled, load]), axis=0)
    away = (np.array(settled) - load) / np.where(size > 0.0, size, 1.0)
    near = settled[int(np.argmin(np.sum(away**2, axis=1)))]
    return _equilibrium(Wrench(*near), rows[near])


def _equilibrium(wrench: Wrench, row: Row) -> Equilibrium:
    """Return what a row was made of, as a start."""
    pose = Pose(row["d_h"], row["d_v"], row["alpha"])
    error = Pose(row["error_d_h"], row["error_d_v"], row["error_alpha"])
    report = SolveReport("kept", len(row["state"][1]), 0, 0.0, row["error_mechanics"], 0.0, min_J=row["min_J"])
    return Equilibrium(wrench, pose, error, np.asarray(row["state"][1], dtype=float), report)


def _mirrored(row: Row) -> Row:
    """Return the row of the mirrored load; it costs nothing and starts no other."""
    turned = {name: -row[name] for name in ("d_h", "alpha") if name in row}
    return {name: item for name, item in row.items() if name != "state"} | turned | {"seconds": 0.0}
