"""Solve many loads, each from those that are solved near it.

The walk goes outward from the smallest load: in the plane and without shear first, so that a symmetric layer stays
symmetric, then with more and more of it. Of all images of a load (symmetry.py) one is solved; the others are taken from
it, and of a load that is its own image the components of the pose that it cannot cause are zero.

States of meshes are smooth in the load: a start is their sum with the weights c of least sum of c^2 d^3, d the distance
of their loads, that give polynomials of the second degree, or the first, as they are; where that would go far beyond
what is known, where rims crease, and in contact, the nearest one. It saves a fifth of the factorisations of a table.

Source: P. Lancaster, K. Salkauskas, Math. Comp. 37 (1981) 141, moving least squares.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from sits_mech.cases import Progress, attempt, no_progress
from sits_mech.mechanics.levels.family import PAIR
from sits_mech.mechanics.levels.words import wrench_words
from sits_mech.mechanics.symmetry import Symmetry, image_of_rest, symmetrised
from sits_mech.notes import packed, unpacked
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, MechanicalModel, Pose, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor, scene_hash
from sits_mech.status import OK
from sits_mech.store import Row, case_path, finish, read_case
from sits_mech.version import __version__

_KEPT_OF_REPORT = ("model", "unknowns", "iterations", "estimated_error", "notes", "min_J", "stretch", "creased")
_FAR, _CREASED = 8.0, 0.5  # sum of weights, 7 for the next of three; J below which rims rest in more than one way
_ORDER = ("M_z", "M_x", "F_y", "M", "F_x", "F_z")  # of a load's components in the walk, the last running fastest


@dataclass(frozen=True)
class Settled:
    """What came of a load: where the target rests, or why nowhere."""

    rest: Equilibrium | None  # whose `state` is empty where no load starts from it
    seconds: float = 0.0
    status: str = OK
    reason: str = ""


@runtime_checkable
class RefinedModel(Protocol):
    """A mechanical model that can be restricted to its first meshes, for many loads, and refined to a goal, for few."""

    @property
    def rough(self) -> MechanicalModel:
        """The model on the first meshes."""

    def towards(self, goal: Array | None, tolerance: float, deepest: int = 99) -> MechanicalModel:
        """Return the model refined until the error of a goal, or of the pose, is within tolerance.

        A goal is (s, 6) derivatives of what is asked by the pose. At most `deepest` meshes, where finer ones are dear.
        """


def settle(
    layer: MechanicalModel,
    loads: Iterable[Wrench],
    *,
    symmetry: Symmetry,
    keep: tuple[Path | None, str] = (None, ""),
    known: Mapping[Wrench, Settled] | None = None,
    progress: Progress = no_progress,
    begun: Mapping[Wrench, Settled] | None = None,
) -> dict[Wrench, Settled]:
    """Return what comes of every load, and of loads solved in place of their images.

    `keep`: folder of finished loads, and a key of everything a rest depends on besides the load. `known`: returned
    before; `begun`: solved before, used as starts only from their turn on. `progress`: loads done, and all.
    """
    found: dict[Wrench, Settled] = dict(known or {})
    asked, smooth = outward(loads), isinstance(layer, RefinedModel)
    for done, load in enumerate(asked, 1):
        if load not in found:
            solved, back = symmetry.standard(load)
            if solved not in found:
                own = (begun or {}).get(solved) or _settled(layer, solved, keep, partial(_start, found, solved, smooth))
                found[solved] = allowed_by_symmetry(own, symmetry, solved)
            if load != solved:
                found[load] = _image(found[solved], solved, load, back)
        progress(done, len(asked))
    return found


def settled_again(
    layer: MechanicalModel, found: Mapping[Wrench, Settled], load: Wrench, keep: tuple[Path | None, str] = (None, "")
) -> Settled:
    """Solve a settled load again by another model on the same meshes, from its state."""
    return _settled(layer, load, keep, lambda: found[load].rest)


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
    return next((_read(wrench, row).rest for row in rows if row is not None and row["status"] == OK), None)


def allowed_by_symmetry(settled: Settled, symmetry: Symmetry, load: Wrench) -> Settled:
    """Return what came of a load without what its symmetry forbids."""
    return settled if settled.rest is None else replace(settled, rest=symmetrised(settled.rest, symmetry, load))


def outward(loads: Iterable[Wrench]) -> list[Wrench]:
    """Sort loads from the smallest outwards: in the plane first, by shear, then by normal force."""
    values = operator.attrgetter(*_ORDER)
    return sorted(loads, key=lambda load: [part for value in values(load) for part in (abs(value), -value)])


def _image(settled: Settled, solved: Wrench, load: Wrench, back: Array) -> Settled:
    """Return what comes of a load by its solved image, without cost."""
    if settled.rest is None:
        return replace(settled, seconds=0.0, reason=f"{wrench_words(vars(solved))}: {settled.reason}")
    return Settled(image_of_rest(settled.rest, back, load))


def _path(load: Wrench, keep: tuple[Path | None, str]) -> Path | None:
    """Return the file of a kept load."""
    return case_path(*keep, dict(zip(WRENCH, load.components.tolist(), strict=True)))


def _settled(
    layer: MechanicalModel, load: Wrench, keep: tuple[Path | None, str], start: Callable[[], Equilibrium | None]
) -> Settled:
    """Return what comes of a load: read from disk, or solved from a start and kept."""
    path = _path(load, keep)
    kept = read_case(path)
    if kept is None:
        begin = start()
        kept = finish(path, attempt(lambda: _row(layer.equilibrium(load, start=begin)), {}))
    return _read(load, kept)


def _row(found: Equilibrium) -> Row:
    """Return what is kept of an equilibrium."""
    report = {name: getattr(found.report, name) for name in _KEPT_OF_REPORT} | {"notes": packed(found.report.notes)}
    numbers = {"pose": found.pose.components, "error": found.error.components}
    acting = None if found.acting is None else found.acting.components
    more = {name: getattr(found, name) for name in ("state", "shared", "slopes", "sunk")}
    return report | numbers | more | {"acting": acting}


def _read(load: Wrench, row: Row) -> Settled:
    """Return what came of a load from what is kept of it."""
    if row["status"] != OK:
        return Settled(None, row["seconds"], row["status"], row["reason"])
    pose, error = (Pose.of(np.asarray(row[name], dtype=float)) for name in ("pose", "error"))
    shared, slopes = (np.asarray(row[name], dtype=float).reshape(-1, len(POSE)) for name in ("shared", "slopes"))
    report: dict[str, Any] = {key: row.get(key, False) for key in _KEPT_OF_REPORT} | {"notes": unpacked(row["notes"])}
    own, state = SolveReport(residual=0.0, seconds=0.0, **report), np.asarray(row["state"], dtype=float)
    kept = Equilibrium(load, pose, error, state, own, shared, slopes=slopes)
    if row["acting"] is not None:
        kept = replace(kept, acting=Wrench(*map(float, row["acting"])))
    return Settled(kept if row["sunk"] is None else replace(kept, sunk=tuple(row["sunk"])), row["seconds"])


def _start(found: Mapping[Wrench, Settled], load: Wrench, smooth: bool) -> Equilibrium | None:
    """Return what to start from: the nearest settled load, each component over its largest value so far.

    Where states are smooth, with that of all that are near.
    """
    rests = [settled.rest for settled in found.values() if settled.rest is not None and settled.rest.state.size]
    if not rests:
        return None
    places = np.array([*(rest.wrench.components for rest in rests), load.components])
    size = np.max(np.abs(places), axis=0)
    away = (places[:-1] - places[-1]) / np.where(size > 0.0, size, 1.0)
    nearest = rests[int(np.argmin(np.sum(away**2, axis=1)))]
    return _led(rests, away, nearest) if smooth else nearest


def _led(rests: Sequence[Equilibrium], away: Array, nearest: Equilibrium) -> Equilibrium:
    """Return the nearest equilibrium with the state that those of its family lead to, `away` (m, 6) from the load."""
    number, J = nearest.state[0], nearest.report.min_J
    if number >= PAIR or J is None or J <= _CREASED:
        return nearest
    alike = [k for k, rest in enumerate(rests) if rest.state.size == nearest.state.size and rest.state[0] == number]
    for degree in (2, 1):
        weights = _weights(away[alike], degree)
        if weights is not None:
            states = np.stack([rests[k].state for k in alike])
            return replace(nearest, state=np.append(number, weights @ states[:, 1:]))
    return nearest


def _weights(away: Array, degree: int) -> Array | None:
    """Return weights of places (m, d) from one that give polynomials of a degree there; None where they are large."""
    pairs = itertools.chain.from_iterable(
        itertools.combinations_with_replacement(range(away.shape[1]), k) for k in range(degree + 1)
    )
    powers = np.array([away[:, list(pair)].prod(axis=1) for pair in pairs])
    near, there = np.sum(away**2, axis=1) ** -1.5, np.eye(len(powers))[0]
    weights = near * (powers.T @ np.linalg.lstsq((powers * near) @ powers.T, there, rcond=1e-10)[0])
    given = np.allclose(powers @ weights, there, atol=1e-6)
    return np.asarray(weights) if given and np.abs(weights).sum() < _FAR else None
