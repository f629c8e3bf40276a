"""Where does the target rest under a grid of loads? Each load starts from the nearest one that is settled.

A grid has values of any components of a wrench. The walk goes outward from the smallest load: in the plane and without
shear first, so that a symmetric layer stays symmetric, then with more and more of it. A layer that is its own mirror
image in the planes x = 0 and y = 0 answers the mirrored load with the mirrored pose,

    x -> -x:    F_x, M, M_z and d_h, alpha, alpha_z change sign,
    y -> -y:    F_y, M_x, M_z and d_y, alpha_x, alpha_z change sign        (forces and shifts are vectors, moments and
                                                                            rotations axial ones),

which is taken, not solved again; of a load that is its own image the components of the pose that would change sign are
zero.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from sits_mech.cases import DONE, Progress, Row, attempt, case_path, finish, read_case
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, scene_hash
from sits_mech.version import __version__

_IN_X, _IN_Y = np.array([-1, 1, -1, 1, 1, -1]), np.array([1, 1, 1, -1, -1, -1])
_MIRRORS = (_IN_X, _IN_Y, _IN_X * _IN_Y)  # signs of the components of a wrench or a pose
_ORDER = ("M_z", "M_x", "F_y", "M", "F_x", "F_z")  # of a load's components in the walk, the last running fastest


def settle(
    layer: MechanicalModel,
    grid: Mapping[str, Sequence[float]],
    *,
    symmetric: bool,
    keep: tuple[Path | None, str] = (None, ""),
    known: Mapping[Wrench, Row] | None = None,
    progress: Progress | None = None,
) -> dict[Wrench, Row]:
    """Return a row for every load of a grid.

    Parameters
    ----------
    layer : MechanicalModel
        Wrench in, pose out.
    grid : mapping
        Values of components of the wrench, by the names of `WRENCH` [N, N m]; others are zero.
    symmetric : bool
        Whether the layer with its target is its own mirror image, in x and in y.
    keep : tuple of Path or None, and str
        Folder of finished loads, and what stands for everything besides the load that a row depends on.
    known : mapping, optional
        Rows of loads that are settled already.
    progress : callable, optional
        Called with the number of loads done and of all.

    Returns
    -------
    dict
        Rows by load, as from `attempt`: pose with errors, min_J, notes, state.
    """
    rows: dict[Wrench, Row] = dict(known or {})
    loads = outward(grid)
    for load in [load for load in loads if load not in rows]:
        twin = _twin(rows, load) if symmetric else None
        row = _row(layer, rows, load, keep) if twin is None else twin
        rows[load] = upright(row, load) if symmetric else row
        if progress is not None:
            progress(len(rows), len(loads))
    return rows


def kept_key(sensor: Sensor, mechanics: str, tolerance: float) -> str:
    """Return what stands, in the names of kept loads, for everything besides the load that their rest depends on."""
    return f"{__version__} {scene_hash(sensor)} {mechanics} {tolerance}"


def kept_rest(keep: tuple[Path | None, str], wrench: Wrench) -> Equilibrium | None:
    """Return the equilibrium of a load that was settled in a folder, `keep` as of `settle`; None where it has none."""
    row = read_case(_path(wrench, keep))
    return None if row is None or row["status"] != DONE or "state" not in row else _equilibrium(wrench, row)


def upright(row: Row, load: Wrench) -> Row:
    """Return the row of a load on a layer that is its own mirror image: zero what changes sign where the load does not.

    Its errors as well.
    """
    odd = [signs < 0 for signs in _MIRRORS[:2] if _mirrored(load, signs) == load]
    if row["status"] != DONE or not odd:
        return row
    names = [name for name, turns in zip(POSE, np.any(odd, axis=0), strict=True) if turns]
    return row | dict.fromkeys((*names, *(f"error_{name}" for name in names)), 0.0)


def outward(grid: Mapping[str, Sequence[float]]) -> list[Wrench]:
    """Return the loads of a grid from the smallest outwards: in the plane first, by shear, then by normal force."""
    loads = [Wrench(**dict(zip(grid, load, strict=True))) for load in itertools.product(*grid.values())]
    each = [[float(getattr(load, name)) for name in _ORDER] for load in loads]
    sizes = [[part for value in values for part in (abs(value), -value)] for values in each]
    return [loads[k] for k in sorted(range(len(loads)), key=sizes.__getitem__)]


def without_images(loads: Iterable[Wrench]) -> list[Wrench]:
    """Return loads without those that are mirror images of others before them."""
    found: dict[Wrench, None] = {}
    for load in loads:
        if not any(_mirrored(load, signs) in found for signs in _MIRRORS):
            found[load] = None
    return list(found)


def _mirrored(load: Wrench, signs: Array) -> Wrench:
    """Return the mirror image of a load."""
    return Wrench(*(float(value) for value in load.components * signs))


def _twin(rows: Mapping[Wrench, Row], load: Wrench) -> Row | None:
    """Return the row of a load whose mirror image is settled; it costs nothing and starts no other."""
    for signs in _MIRRORS:
        row = rows.get(_mirrored(load, signs))
        if row is not None:
            turned = {name: float(sign) * row[name] for name, sign in zip(POSE, signs, strict=True) if name in row}
            return {name: item for name, item in row.items() if name != "state"} | turned | {"seconds": 0.0}
    return None


def _path(load: Wrench, keep: tuple[Path | None, str]) -> Path | None:
    """Where a load is kept."""
    return case_path(*keep, {name: float(getattr(load, name)) for name in WRENCH})


def _row(layer: MechanicalModel, rows: Mapping[Wrench, Row], load: Wrench, keep: tuple[Path | None, str]) -> Row:
    """Return the row of one load: kept on disk, or solved and kept."""
    path = _path(load, keep)
    kept = read_case(path)
    if kept is not None:
        return kept
    start = _nearest(rows, load)
    return finish(path, attempt(lambda **_: _settled(layer, load, start), {}))


def _settled(layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None) -> Row:
    """Return the equilibrium under a wrench as a row."""
    found = layer.equilibrium(wrench, start=start)
    row: Row = {name: float(getattr(found.pose, name)) for name in POSE}
    row |= {f"error_{name}": float(getattr(found.error, name)) for name in POSE}
    row |= {"min_J": np.nan if found.report.min_J is None else found.report.min_J}
    row |= {"error_mechanics": found.report.estimated_error, "iterations": found.report.iterations}
    return row | {"notes": "; ".join(found.report.notes), "state": ("unknown", found.state)}


def _nearest(rows: Mapping[Wrench, Row], load: Wrench) -> Equilibrium | None:
    """Return the settled load nearest to a new one, each component measured by its largest value so far."""
    settled = [near for near, row in rows.items() if row["status"] == DONE and "state" in row and len(row["state"][1])]
    if not settled:
        return None
    places = np.array([near.components for near in (*settled, load)])
    size = np.max(np.abs(places), axis=0)
    away = (places[:-1] - places[-1]) / np.where(size > 0.0, size, 1.0)
    near = settled[int(np.argmin(np.sum(away**2, axis=1)))]
    return _equilibrium(near, rows[near])


def _equilibrium(wrench: Wrench, row: Row) -> Equilibrium:
    """Return what a row was made of, as a start."""
    pose, error = (Pose(*(float(row[f"{prefix}{name}"]) for name in POSE)) for prefix in ("", "error_"))
    report = SolveReport("kept", len(row["state"][1]), 0, 0.0, row["error_mechanics"], 0.0, min_J=row["min_J"])
    return Equilibrium(wrench, pose, error, np.asarray(row["state"][1], dtype=float), report)
