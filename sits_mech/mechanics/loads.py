"""Settle many loads, each from the nearest one that is settled.

The walk goes outward from the smallest load: in the plane and without shear first, so that a symmetric layer stays
symmetric, then with more and more of it. Of all images of a load (symmetry.py) one is solved; the others are taken from
it, and of a load that is its own image the components of the pose that it cannot cause are zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np

from sits_mech.cases import Progress, Row, attempt, case_path, finish, read_case
from sits_mech.mechanics.levels.answer import load_words
from sits_mech.mechanics.symmetry import Symmetry, image_of
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, scene_hash
from sits_mech.status import OK
from sits_mech.version import __version__

_ORDER = ("M_z", "M_x", "F_y", "M", "F_x", "F_z")  # of a load's components in the walk, the last running fastest
ERRORS = tuple(f"error_{name}" for name in POSE)
"""Names of the errors of a pose's components in a row."""


@runtime_checkable
class RefinedModel(Protocol):
    """A mechanical model that can be restricted to its first meshes.

    Many loads are solved by the rough model, and a few to a goal, which give the errors of all.
    """

    @property
    def rough(self) -> MechanicalModel:
        """The model on the first meshes."""

    def towards(self, goal: Array | None, tolerance: float, deepest: int = 99) -> MechanicalModel:
        """Return the model refined until the error of a goal (`by_goal`), or of the pose, is within tolerance.

        At most `deepest` meshes, where finer ones are expensive.
        """


def settle(
    layer: MechanicalModel,
    loads: Iterable[Wrench],
    *,
    symmetry: Symmetry,
    keep: tuple[Path | None, str] = (None, ""),
    known: Mapping[Wrench, Row] | None = None,
    progress: Progress | None = None,
    begun: Mapping[Wrench, Row] | None = None,
) -> dict[Wrench, Row]:
    """Return a row (as `attempt`) for every load, and for loads solved in place of their images.

    `keep`: folder of finished loads, and a key of everything a row depends on besides the load. `known`: rows returned
    before; `begun`: rows solved before, used as starts only from their turn on. `progress`: loads done, and all. Rows
    that were solved hold their state.
    """
    rows: dict[Wrench, Row] = dict(known or {})
    asked = outward(loads)
    for done, load in enumerate(asked, 1):
        if load not in rows:
            solved, back = symmetry.standard(load)
            if solved not in rows:
                own = (begun or {}).get(solved) or _row(layer, solved, keep, partial(_nearest, rows, solved))
                rows[solved] = upright(own, solved, symmetry)
            if load != solved:
                rows[load] = _image(rows[solved], solved, back)
        if progress is not None:
            progress(done, len(asked))
    return rows


def settled_again(
    layer: MechanicalModel, rows: Mapping[Wrench, Row], load: Wrench, keep: tuple[Path | None, str] = (None, "")
) -> Row:
    """Solve a settled load again by another model on the same meshes, from its state."""
    return _row(layer, load, keep, lambda: rest_of(load, rows[load]))


def kept_key(sensor: Sensor, mechanics: str, tolerance: float, *, drift: bool = False) -> str:
    """Return the key of kept loads for everything that their rest depends on besides the load.

    `drift`: rests that include derivatives by temperature.
    """
    return f"{__version__} {scene_hash(sensor)} {mechanics} {tolerance}{' by temperature' if drift else ''}"


def first_key(key: str) -> str:
    """Return the key for rests on a model's first meshes alone."""
    return f"{key} rough"


def kept_rest(keep: tuple[Path | None, str], wrench: Wrench) -> Equilibrium | None:
    """Return the equilibrium of a load kept in a folder, None if there is none; `keep` as in `settle`."""
    rows = (read_case(_path(wrench, (keep[0], key))) for key in (keep[1], first_key(keep[1])))
    found = (row for row in rows if row is not None and row["status"] == OK and "state" in row)
    return next((rest_of(wrench, row) for row in found), None)


def upright(row: Row, load: Wrench, symmetry: Symmetry) -> Row:
    """Zero what symmetry forbids in a row, and its errors."""
    return _moved(row, symmetry.projection(load))


def outward(loads: Iterable[Wrench]) -> list[Wrench]:
    """Sort loads from the smallest outwards: in the plane first, by shear, then by normal force."""
    found = list(loads)
    each = [[float(getattr(load, name)) for name in _ORDER] for load in found]
    sizes = [[part for value in values for part in (abs(value), -value)] for values in each]
    return [found[k] for k in sorted(range(len(found)), key=sizes.__getitem__)]


def _moved(row: Row, matrix: Array) -> Row:
    """Return a row with the image of its pose; errors have no sign."""
    if row["status"] != OK or np.array_equal(matrix, np.eye(len(POSE))):
        return row
    moved = with_shared({}, np.array([image_of(matrix, part) for part in shared_of(row)]))
    moved |= with_slopes({}, slopes_of(row) @ matrix.T)
    for names, signed in ((POSE, matrix), (ERRORS, np.abs(matrix))):
        moved |= dict(zip(names, image_of(signed, [row[name] for name in names]).tolist(), strict=True))
    return row | moved


def shared_of(row: Row) -> Array:
    """Return the parts of a row's error in common with its neighbours, as in `Equilibrium`, (m, 6)."""
    return np.asarray(row["shared"][1] if "shared" in row else [], dtype=float).reshape(-1, len(POSE))


def with_shared(row: Row, shared: Array) -> Row:
    """Return a row with the parts of its error in common with its neighbours."""
    return row | {"shared": (("part", "component"), shared.reshape(-1, len(POSE)))}


def slopes_of(row: Row) -> Array:
    """Return the derivatives of a row's pose by scene parameters, as in `Equilibrium`, (n, 6)."""
    return np.asarray(row["slopes"][1] if "slopes" in row else [], dtype=float).reshape(-1, len(POSE))


def with_slopes(row: Row, slopes: Array) -> Row:
    """Return a row with derivatives of its pose; unchanged if there are none."""
    return row | {"slopes": (("number", "component"), slopes)} if slopes.size else row


def _image(row: Row, solved: Wrench, back: Array) -> Row:
    """Return the row of a load from its solved image, without cost; no other load starts from it."""
    found = {name: item for name, item in _moved(row, back).items() if name != "state"} | {"seconds": 0.0}
    return found if row["status"] == OK else found | {"reason": f"{load_words(vars(solved))}: {row['reason']}"}


def _path(load: Wrench, keep: tuple[Path | None, str]) -> Path | None:
    """Return the file of a kept load."""
    return case_path(*keep, {name: float(getattr(load, name)) for name in WRENCH})


def _row(
    layer: MechanicalModel, load: Wrench, keep: tuple[Path | None, str], start: Callable[[], Equilibrium | None]
) -> Row:
    """Return the row of one load: read from disk, or solved from a start and kept."""
    path = _path(load, keep)
    kept = read_case(path)
    if kept is not None:
        return kept
    begin = start()
    return finish(path, attempt(lambda **_: _settled(layer, load, begin), {}))


def _settled(layer: MechanicalModel, wrench: Wrench, start: Equilibrium | None) -> Row:
    """Return the equilibrium under a wrench as a row."""
    found = layer.equilibrium(wrench, start=start)
    row: Row = {name: float(getattr(found.pose, name)) for name in POSE}
    row |= {f"error_{name}": float(getattr(found.error, name)) for name in POSE}
    own = {"min_J": found.report.min_J, "stretch": found.report.stretch}
    row |= {name: np.nan if value is None else value for name, value in own.items()}
    row |= {"error_mechanics": found.report.estimated_error, "iterations": found.report.iterations}
    row |= {"unknowns": found.report.unknowns}
    row = with_slopes(with_shared(row, found.shared), found.slopes)
    return row | {"notes": "; ".join(found.report.notes), "state": ("unknown", found.state)}


def _nearest(rows: Mapping[Wrench, Row], load: Wrench) -> Equilibrium | None:
    """Return the nearest settled load, each component over its largest value so far."""
    settled = [near for near, row in rows.items() if row["status"] == OK and "state" in row and len(row["state"][1])]
    if not settled:
        return None
    places = np.array([near.components for near in (*settled, load)])
    size = np.max(np.abs(places), axis=0)
    away = (places[:-1] - places[-1]) / np.where(size > 0.0, size, 1.0)
    near = settled[int(np.argmin(np.sum(away**2, axis=1)))]
    return rest_of(near, rows[near])


def rest_of(wrench: Wrench, row: Row, model: str = "kept") -> Equilibrium:
    """Return a row's equilibrium, as a start or for notes; `model` names its model."""
    pose, error = (Pose(*(float(row[f"{prefix}{name}"]) for name in POSE)) for prefix in ("", "error_"))
    report = SolveReport(
        model, row["unknowns"], row["iterations"], 0.0, row["error_mechanics"], 0.0, notes=(row["notes"],),
        min_J=row["min_J"], stretch=row["stretch"],
    )
    return Equilibrium(wrench, pose, error, np.asarray(row["state"][1], dtype=float), report, shared_of(row))
