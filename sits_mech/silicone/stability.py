"""Find the stretch up to which a law is stable and elliptic, and the test in which it fails first.

Drucker's condition for an incompressible law: an increment of logarithmic strain ``de`` does positive work on the
increment of Kirchhoff stress that it causes,

    de . D de > 0    for every de with de_1 + de_2 + de_3 = 0,      D = d2W/de2 (homogeneous.py),

that is, D is positive definite on that plane. And strong ellipticity, without which strain localises in shear bands and
no mesh converges: every band in a principal plane is stiff (homogeneous.py). In simple shear g, a planar test turned,
that is W''(g) > 0: of Yeoh's law with c30 = 0, ``g^2 < -c10/(6 c20)``.

Both are looked at along the uniaxial, planar and biaxial tests, in tension and in compression. Which laws pass at every
strain, and where others end, each law's file says. A law without a state from a stretch on, such as Gent's, has its
limit there. A falling engineering stress (necking) alone does not count.

Range: uniform strain; a limit is found where it is wider than one of the 400 steps of ln(stretch). Source: the
condition is D. C. Drucker's, J. Appl. Mech. 26 (1959) 101, for small increments about a finite strain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import MODES, principal_stretches, shear_band_stiffness, tangent
from sits_mech.silicone.laws import known_law
from sits_mech.silicone.material import Silicone

_OF_STRETCH = NoteKind.LAW_END, NoteKind.DATA_END  # kinds of notes that hang on the stretch reached
_STEPS = 400  # stretches that are tried, from 1 to the end


@dataclass(frozen=True)
class Stability:
    """Stability or ellipticity of a law over a range of stretches."""

    stable: bool  # in all the tests examined
    first_unstable: float | None = None  # limit stretch in the test `mode`
    mode: str | None = None  # failing test of smallest largest principal strain: "uniaxial tension", ...
    limits: tuple[tuple[str, float], ...] = ()  # failing tests with stretches, by largest principal strain


def stability(silicone: Silicone, stretch_range: tuple[float, float], modes: Sequence[str] = tuple(MODES)) -> Stability:
    """Find where a law loses stability in uniform tests over a range of stretches; K is not used.

    `modes`: keys of `homogeneous.MODES`. Raise ValueError for an unknown test, or a range that is not positive and
    finite or does not hold 1.
    """
    return _first(silicone, stretch_range, modes, _smallest)


def ellipticity(
    silicone: Silicone, stretch_range: tuple[float, float], modes: Sequence[str] = tuple(MODES)
) -> Stability:
    """Find where shear bands lose stiffness in uniform tests over a range of stretches; as `stability`."""
    return _first(silicone, stretch_range, modes, _bands)


def _first(
    silicone: Silicone, stretch_range: tuple[float, float], modes: Sequence[str],
    measure: Callable[[Silicone, str, Array], Array],
) -> Stability:
    """Find where a measure of stiffness first vanishes in uniform tests."""
    low, high = stretch_range
    if not 0.0 < low <= 1.0 <= high < np.inf:
        raise ValueError(f"stretch_range: must be positive, finite, with 1 between its ends; got {low:g} to {high:g}")
    found: list[tuple[float, str, float]] = []
    for mode in modes:
        for way, end in (("tension", high), ("compression", low)):
            limit = _limit(measure, silicone, mode, end)
            if limit is not None:
                strain = float(np.abs(np.log(principal_stretches(mode, np.array([limit])))).max())
                found.append((round(strain, 6), f"{mode} {way}", limit))
    found.sort(key=lambda item: item[0])  # stable: of two names for one state, the first in the order of MODES
    if not found:
        return Stability(True)
    return Stability(False, found[0][2], found[0][1], tuple((name, limit) for _, name, limit in found))


def layer_notes(silicone: Silicone, largest_stretch: float) -> tuple[Note, ...]:
    """Return notes on a law in a solve that reached a principal stretch, or reciprocal, of `largest_stretch`.

    Uniaxial and planar states of principal stretches within 1/largest_stretch..largest_stretch are examined (biaxial
    ones are among the uniaxial). Empty where the law is stable and its data reach as far. Raise ValueError below 1 or
    if not finite.
    """
    if not 1.0 <= largest_stretch < np.inf:
        raise ValueError(f"largest_stretch: must be finite and at least 1; got {largest_stretch:g}")
    name = silicone.name or f"the {silicone.law} law"
    ends, tests = (1.0 / largest_stretch, largest_stretch), ("planar", "uniaxial")
    notes = list[Note]()
    found = stability(silicone, ends, tests), ellipticity(silicone, ends, tests)
    failed = [each for each in found if each.first_unstable is not None]
    if first := min(failed, key=lambda each: round(abs(np.log(each.first_unstable or 1.0)), 6), default=None):
        stretch, mode = first.first_unstable or 1.0, first.mode or ""
        law = {"silicone": name, "law": silicone.law, "mode": mode}
        notes.append(Note.of(NoteKind.LAW_END, **law, stretch=stretch, reached=largest_stretch))
    if largest_stretch > silicone.known_stretch:
        notes.append(
            Note.of(NoteKind.DATA_END, silicone=name, stretch=silicone.known_stretch, reached=largest_stretch)
        )
    return tuple(notes)


def end_words(note: Note) -> str:
    """Say where the law or the data end that a note of `layer_notes` is on."""
    known = note.known
    end = f"stretch {known['stretch']:.4g}"
    if note.kind is NoteKind.DATA_END:
        return f"the data of {known['silicone']} end at {end}"
    return f"{known['silicone']} {known_law(str(known['law'])).fails} from {end} on in {known['mode']}"


def layer_words(note: Note) -> str:
    """Say a note of `layer_notes`, for the message of a load path that ended and for reports."""
    return f"{end_words(note)}, this solve reached {note.known['reached']:.4g}"


def renewed_notes(notes: Sequence[Note], silicone: Silicone, largest_stretch: float) -> tuple[Note, ...]:
    """Replace notes of `layer_notes` by those of another stretch."""
    kept = tuple(note for note in notes if note.kind not in _OF_STRETCH)
    if len(kept) == len(notes) and not largest_stretch > silicone.known_stretch:
        return tuple(notes)
    return (*kept, *layer_notes(silicone, largest_stretch))


def _bands(silicone: Silicone, mode: str, stretch: Array) -> Array:
    """Return the smallest stiffness of a shear band over the absolute initial shear modulus."""
    size = abs(silicone.shear_modulus) or 1.0
    with np.errstate(invalid="ignore", over="ignore"):  # a law that locks has no state beyond
        return shear_band_stiffness(silicone.law, silicone.constants, principal_stretches(mode, stretch)) / size


def _smallest(silicone: Silicone, mode: str, stretch: Array) -> Array:
    """Return the smaller eigenvalue of the tangent over the absolute initial shear modulus."""
    size = abs(silicone.shear_modulus) or 1.0
    stiffness = tangent(silicone.law, silicone.constants, principal_stretches(mode, stretch))
    return np.asarray(np.linalg.eigvalsh(stiffness / size)[:, 0])


def _limit(measure: Callable[[Silicone, str, Array], Array], silicone: Silicone, mode: str, end: float) -> float | None:
    """Return the first stretch between 1 and `end` that is not stable."""
    from scipy.optimize import brentq

    stretch = np.geomspace(1.0, end, _STEPS + 1)
    bad = ~(measure(silicone, mode, stretch) > 0.0)
    if not bad.any():
        return None
    first = int(np.argmax(bad))
    if first == 0:
        return 1.0

    def left(x: float) -> float:
        """Return the stiffness left at a stretch."""
        return float(measure(silicone, mode, np.array([x]))[0])

    return float(brentq(left, stretch[first - 1], stretch[first], xtol=1e-12))
