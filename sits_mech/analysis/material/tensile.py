"""Read strain and engineering stress of tensile tests, and of tests over time, from a file of a test machine.

Columns are known by their words (`words`) and units, whatever else the file holds. Taken are, of several,

    strain    engineering strain; stretch, less one; true strain, e = exp(e_true) - 1; displacement over the length
    stress    engineering stress; true stress over 1 + e (incompressible); force over the area

of pulls and, by stretches (l, 1, 1/l) with strain l - 1/l and stress P/(1 + l^-2), of simple shear; of compression,
by its words or by strain and stress below zero, whose stretch l^-2 under -P l^3 is biaxial tension l under P;
of specimens side by side (each stress with its strain) or one below the other (names that come again, or a strain that
falls by half of its range from row to row). Sizes of a specimen are asked for, or stand above the names.

Each is kept up to its largest stress, that is without break and unloading, and with rising strain. Where the file shows
a slack specimen (at least `_LEAST` of strain without stress first) its zero is where the stress
begins: the parabola e(s) through the stresses up to a fifth of that at 100 % strain, at s = 0 (as the toe compensation
of ASTM D638 with the tangent's curvature). Where it shows stress at no strain that parabola begins before, with a note.

A test over time is a uniaxial one, tension or compression (negative), with a time; nothing of it is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sits_mech.analysis.material.words import UNITS, Quantity, quantities, specimen_sizes
from sits_mech.analysis.readings.columns import TextTable, names_found, read_tables
from sits_mech.quantities import Array, Mask

_STRAINS = ("strain", "stretch", "true_strain", "displacement")
_STRESSES = ("stress", "true_stress", "force")
_MUST = {"stress": "a pressure", "true_stress": "a pressure", "strain": "a plain number or in %"}
_MOST = 25.0  # of strain, of any silicone: beyond, a column without a unit is in percent
_LEAST, _SURE = 5e-3, 3.0  # slack: of strain, and in its standard errors
_NONE, _TOE = 0.01, 0.2  # of the largest stress up to 100 % strain: none, and where the curve is a parabola
_BEGUN = (
    'the first stress is that of {0} of strain more: of a preload --slack="-{0}" adds it; of a load cell that is not '
    "zeroed take the first stress off",
    "{0} of strain before the stress begins are taken off as slack; --slack 0 keeps it",
)
_NOTES = {
    "shear": "simple shear is taken as the planar tension that it is, turned",
    "compression": "compression is taken as the biaxial tension that it is between plates without friction",
}


@dataclass(frozen=True)
class Sizes:
    """Sizes of a specimen, None where its file says them: free length [m], area [m^2]; and slack, a strain.

    `mode` is that of columns that say none: "uniaxial", "planar", "biaxial", "shear" or "compression". `also` are files
    of other modes, (mode, path) each, that are read with the first.
    """

    length: float | None = None
    area: float | None = None
    slack: float | None = None
    mode: str = "uniaxial"
    also: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class TensileTest:
    """A tensile test, with those of the same silicone: in other modes, of other specimens."""

    strain: Array  # engineering, (n,), increasing
    stress: Array  # engineering, (n,) [Pa]
    source: str  # file
    mode: str = "uniaxial"  # "uniaxial", "planar" or "biaxial"
    others: tuple[TensileTest, ...] = ()
    notes: tuple[str, ...] = ()  # of all
    slack: float = 0.0  # that the strain is without
    left_out: Array | None = None  # (2, m) strain and stress of rows that are not taken
    columns: str = ""  # that it was read from

    @property
    def all(self) -> tuple[TensileTest, ...]:
        """The test itself and its others."""
        return (self, *self.others)


class Pull(NamedTuple):
    """Rows of a specimen: mode, (n,) engineering strain, stress [Pa] (compression above zero), time [s], columns."""

    mode: str
    strain: Array
    stress: Array
    time: Array | None
    columns: str
    notes: tuple[str, ...]


def read_tensile(path: str | Path, given: Sizes | None = None) -> TensileTest:
    """Read tensile tests: headers of any length, rows of names, numbers; specimens and other modes beside each other.

    A uniaxial test comes first, else the first of the file. Raise ValueError if the file cannot be read, columns or
    sizes are missing or of unknown unit, or a test has fewer than 5 usable rows.
    """
    given = given or Sizes()
    files = [(path, given), *((file, replace(given, mode=mode)) for mode, file in given.also)]
    tests = [
        _test(one, str(file), by.slack) for file, by in files
        for pull in read_pulls(file, by, "a readable tensile test") for one in _one_by_one(pull)
    ]
    order = ("uniaxial", "planar", "biaxial")
    first, *others = sorted(tests, key=lambda test: order.index(test.mode))
    notes = list(dict.fromkeys(note for test in tests for note in test.notes))
    notes += [_spread([test for test in tests if test.mode == mode]) for mode in order]
    return replace(first, others=tuple(others), notes=tuple(filter(None, notes)))


def read_pulls(path: str | Path, given: Sizes, what: str, timed: bool = False) -> list[Pull]:
    """Return the specimens of a file, rows as they stand; `timed`: those with a time alone. Raise as `read_tensile`."""
    tables = read_tables(path, what, lambda columns: _whole(quantities(columns)))
    if not tables:
        _refuse(path, what)
    found, above = list[Pull](), dict[str, float]()
    for table, known in tables:
        above |= specimen_sizes(table.above)
        pulls = _pulls(table, known, _sizes(above, given), given.mode)
        found += [pull for pull in pulls if not timed or pull.time is not None]
    if not found:
        names = ", ".join(column.title for column in tables[0][0].columns)
        raise ValueError(f'{path}: must have the column "Time (s)" beside strain and stress; got {names}')
    return found


def _whole(known: list[Quantity]) -> list[Quantity]:
    """Return what is known of columns where a strain and a stress are among them."""
    usable = _usable(known)
    pairs = ([_best(usable, mode, kinds) for kinds in (_STRAINS, _STRESSES)] for mode in {one.mode for one in usable})
    return known if any(map(all, pairs)) else []


def _refuse(path: str | Path, what: str) -> None:
    """Refuse a file without such columns: by a unit that does not fit, else by the names that are there."""
    for table, known in read_tables(path, what, quantities):
        for one in (one for one in known if one.kind != "time"):
            if not np.isfinite(one.factor):
                must = _MUST.get(one.kind, f"in {UNITS[one.kind]} or a unit like it")
                came = f'got "{one.column.unit}"' if one.column.unit else 'got "", no unit'
                raise ValueError(f'{table.source}: column "{one.column.title}" must be {must}; {came}')
    must = "must have columns of strain (or stretch, displacement) and stress (or force), such as"
    raise ValueError(f'{path}: {must} "Strain (%)" and "Stress (MPa)"; got {names_found(path, what)}')


def _pulls(table: TextTable, known: list[Quantity], own: dict[str, float], asked: str) -> list[Pull]:
    """Return the specimens of a table, (strain, stress) by columns, of sizes as by `_sizes`, in the asked mode."""
    found, usable = list[Pull](), _usable(known)
    times = [one for one in usable if one.kind == "time"]
    for mode in dict.fromkeys(one.mode for one in usable):
        strains, stresses = (_best(usable, mode, kinds) for kinds in (_STRAINS, _STRESSES))
        if len(strains) != len(stresses):
            stresses = stresses if strains else []
            strains = [_left_of(stress, strains)[0] for stress in stresses]
        for strain, stress in zip(strains, stresses, strict=True):
            found.append(_pull(table, (strain, stress, *_left_of(stress, times)), own, asked))
    return found


def _usable(known: list[Quantity]) -> list[Quantity]:
    """Return the columns whose unit fits."""
    return [one for one in known if np.isfinite(one.factor)]


def _best(known: list[Quantity], mode: str, kinds: Sequence[str]) -> list[Quantity]:
    """Return the columns of the first of some kinds that there is."""
    each = ([one for one in known if (one.mode, one.kind) == (mode, kind)] for kind in kinds)
    return next((found for found in each if found), [])


def _left_of(stress: Quantity, known: list[Quantity]) -> list[Quantity]:
    """Return the one of some columns that is next to the left of a stress, else the first; none without any."""
    return [one for one in known if one.column.place < stress.column.place][-1:] or known[:1]


def _pull(table: TextTable, taken: Sequence[Quantity], own: dict[str, float], asked: str) -> Pull:
    """Return a specimen by its columns (strain, stress, and time if any): engineering strain and stress [Pa]."""
    rows = table.numbers([one.column.place for one in taken]) * [one.factor for one in taken] + 0.0  # and no -0
    e, s, *t = rows[np.isfinite(rows).all(axis=1)].T
    strain, stress, *_ = taken
    direction = "compression" if strain.pressed or stress.pressed else asked
    mode = direction if strain.mode == "uniaxial" else strain.mode
    if mode == "compression":  # whichever sign it is written by
        e, s = e * (1.0 if strain.kind == "stretch" else -np.sign(e.sum())), -s * np.sign(s.sum())
    e = _engineering_strain(e, strain, table.source, own)
    if stress.kind != "stress":
        s = s / (1.0 + e if stress.kind == "true_stress" else _size(table.source, stress, "area", own))
    made_of = [one.column.title for one in taken[:2] if one.kind not in ("strain", "stress")]
    notes = (f"engineering strain and stress are made of {' and '.join(made_of)}",) * bool(made_of)
    columns = f"{strain.column.title}; {stress.column.title}"
    return _upright(Pull(mode, e, s, t[0] if t else None, columns, notes), table.source)


def _upright(pull: Pull, source: str) -> Pull:
    """Return compression, and what lies below zero without a word of it, as compression above zero."""
    e, s = pull.strain, pull.stress
    below = pull.mode == "uniaxial" and s.sum() < 0.0 and np.max(e, initial=0.0) <= -_NONE * e.sum()
    if not below and pull.mode != "compression":
        return pull
    if not np.min(e, initial=0.0) > -1.0:
        must = f"{pull.columns}: must be of compression below 100 %, with its unit"
        raise ValueError(f"{source}: {must}; got up to {-100.0 * e.min():.4g} %")
    return pull._replace(mode="compression", strain=-e, stress=-s)


def _engineering_strain(e: Array, of: Quantity, source: str, own: dict[str, float]) -> Array:
    """Return the engineering strain of a column's numbers."""
    if of.kind == "displacement":
        return e / _size(source, of, "length", own)
    if not of.column.unit and np.max(np.abs(e), initial=0.0) > _MOST:
        must = f"must come with a unit, such as (%), where it is beyond {_MOST:g}"
        raise ValueError(f'{source}: column "{of.column.title}" {must}; got up to {np.abs(e).max():g}')
    return {"stretch": e - 1.0, "true_strain": np.expm1(e)}.get(of.kind, e)


def _sizes(above: dict[str, float], given: Sizes) -> dict[str, float]:
    """Return length and area of a specimen: given, else as lines above the names have them, or what makes them."""
    found = dict(above)
    if {"width", "thickness"} <= above.keys():
        found.setdefault("area", above["width"] * above["thickness"])
    if "diameter" in above:
        found.setdefault("area", 0.25 * np.pi * above["diameter"] ** 2)
    asked = {"length": given.length, "area": given.area}
    return found | {name: value for name, value in asked.items() if value is not None}


def _size(source: str, of: Quantity, name: str, own: dict[str, float]) -> float:
    """Return a specimen's length or area; refuse one that is not known."""
    if not own.get(name, 0.0) > 0.0:
        asked = '--length "25 mm"' if name == "length" else '--area "24 mm^2"'
        must = f"must come with the {name} of the specimen"
        raise ValueError(f'{source}: column "{of.column.title}" {must}: {asked}, or in a line above; got none')
    return own[name]


def _one_by_one(pull: Pull) -> list[Pull]:
    """Return the tests of rows that hold one below the other: the strain falls at once by half of its range."""
    falls = np.flatnonzero(np.diff(pull.strain) < -0.5 * np.ptp(pull.strain) if len(pull.strain) else []) + 1
    parts = [np.split(column, falls) for column in (pull.strain, pull.stress)]
    return [pull._replace(strain=e, stress=s) for e, s in zip(*parts, strict=True) if len(falls) == 0 or len(e) >= 5]


def _test(pull: Pull, source: str, slack: float | None) -> TensileTest:
    """Return the rows of a specimen up to the largest stress, in rising strain, without slack."""
    strain, stress, notes = pull.strain, pull.stress, list(pull.notes)
    end = int(np.argmax(np.r_[stress, -np.inf])) + 1
    taken = (np.arange(len(strain)) < end) & (strain > np.maximum.accumulate(np.r_[-1.0, strain])[:-1])
    if slack is None and (begins := _begin(strain[taken], stress[taken])):
        slack = max(begins, 0.0)
        notes.append(_BEGUN[begins > 0.0].format(f"{100.0 * abs(begins):.3g} %"))
    slack = slack or 0.0
    taken &= strain >= slack if slack > 0.0 else taken
    if (count := np.count_nonzero(taken)) < 5:
        raise ValueError(f"{source}: must hold at least 5 rows of rising strain in the {pull.mode} test; got {count}")
    back = strain[:end].max() - strain[end:] if end < len(strain) else np.zeros(1)
    if back.max() > 0.1 * strain[:end].max():
        what = f"{len(strain) - np.count_nonzero(taken)} of {len(strain)} rows are left out: strain goes back"
        notes.append(f"{what}; unloading after rising peaks gives softening by --cyclic")
    if pull.mode in _NOTES:
        notes.append(_NOTES[pull.mode])
    (mode, e, s), (_, *rest) = (_as_tension(pull.mode, strain[k] - slack, stress[k]) for k in (taken, ~taken))
    return TensileTest(e, s, source, mode, (), tuple(notes), slack, np.stack(rest), pull.columns)


def _as_tension(mode: str, strain: Array, stress: Array) -> tuple[str, Array, Array]:
    """Return shear as the planar, compression as the biaxial tension of the same states; other modes as they are."""
    if mode == "shear":
        stretch = 0.5 * (strain + np.hypot(strain, 2.0))  # turned, silicone/homogeneous.py
        return "planar", stretch - 1.0, stress * (1.0 + stretch**-2)
    if mode == "compression":
        stretch = 1.0 / np.sqrt(1.0 - strain)
        return "biaxial", stretch - 1.0, stress * stretch**-3
    return mode, strain, stress


def _begin(strain: Array, stress: Array) -> float:
    """Return the strain at which the stress of a pull begins, where it first shows none, or more; else zero."""
    most = np.max(stress[strain < np.min(strain, initial=0.0) + 1.0], initial=0.0)
    some: Mask = stress > _NONE * most
    flat, toe = int(np.argmax(np.r_[some, True])), some & (stress < _TOE * most)
    slack = flat > 0 and strain[flat - 1] - strain[0] > _LEAST
    if np.count_nonzero(toe) < 4 or not (slack or flat == 0 and strain[0] < _LEAST):
        return 0.0
    (*_, begins), covariance = np.polyfit(stress[toe], strain[toe], 2, cov=True)
    least = max(_LEAST, _SURE * np.sqrt(covariance[-1, -1]))
    return float(begins) if (begins if slack else -begins) > least else 0.0


def _spread(tests: list[TensileTest]) -> str:
    """Return in words how much specimens differ; nothing of one alone."""
    if len(tests) < 2:
        return ""
    at = 0.5 * min(float(test.strain[-1]) for test in tests)
    each = np.array([np.interp(at, test.strain, test.stress) for test in tests])
    share = each / each.mean()
    return (
        f"{len(tests)} {tests[0].mode} specimens are fitted together; at {100.0 * at:.3g} % strain their stresses are "
        f"{share.min():.3g} to {share.max():.3g} of the mean (standard deviation {100.0 * share.std(ddof=1):.2g} %)"
    )


_ROWS = 8  # of a test over time, at least


@dataclass(frozen=True)
class Record:
    """A uniaxial test over time."""

    time: Array  # (n,), not descending [s]; row number if the file has none
    strain: Array  # engineering, (n,)
    stress: Array  # engineering, (n,) [Pa]
    source: str  # file
    timed: bool = True  # the file has a time


def read_record(path: str | Path, given: Sizes | None = None, *, timed: bool = True) -> Record:
    """Read a test over time by content; `timed`: a column of time is required.

    Raise ValueError if the file cannot be read, columns are missing or of unknown unit, fewer than 8 rows are numbers,
    a stretch is not positive, or time stands still or runs back.
    """
    pulls = read_pulls(path, given or Sizes(), "a readable test over time", timed)
    if len(pulls) > 1:
        raise ValueError(f"{path}: must hold one specimen; got {len(pulls)}")
    mode, strain, stress, time, *_ = pulls[0]
    sign = {"uniaxial": 1.0, "compression": -1.0}.get(mode)
    if sign is None:
        raise ValueError(f"{path}: must be a uniaxial test, a pull or compression; got {mode}")
    if len(strain) < _ROWS:
        raise ValueError(f"{path}: must hold at least {_ROWS} rows of numbers; got {len(strain)}")
    timed, time = time is not None, np.arange(float(len(strain))) if time is None else time
    if not np.all(np.diff(time) > 0.0):
        back = int(np.argmin(np.diff(time) > 0.0))
        raise ValueError(f"{path}: time must rise; got {time[back]:g} s and then {time[back + 1]:g} s")
    if not np.all(sign * strain > -1.0):
        raise ValueError(f"{path}: strain must be above -1; got {strain.min():g}")
    slack = (given or Sizes()).slack or 0.0
    return Record(time, sign * (strain - slack), sign * stress, str(path), timed)
