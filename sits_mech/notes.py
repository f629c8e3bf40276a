"""Values for what is to be said of an answer: notes, and omissions with their sizes. Sentences are made in report/.

Inside the package a note is a kind with numbers: decisions read these, never a text. An omission is something that the
answer's model leaves out of the question: its size is relative to what `relative_to` names, an upper bound or an estimate, zero
where it changes nothing, NaN where no size is known. What counts is in the answer's error, or bounds nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

Number = float | int | str | bool
"""What a note holds by name: a number, or the name of a part of the scene."""


class NoteKind(StrEnum):
    """Kinds of notes."""

    STATED = "stated"  # words of a model that is not of this package: text


class OmissionKind(StrEnum):
    """Kinds of omissions."""

    STATED = "stated"  # of a model that is not of this package: text


class Relative(StrEnum):
    """What the size of an omission is relative to."""

    CHANGE = "change"  # of inductance that the target causes
    FREE = "L0"  # inductance without target
    DISPLACEMENT = "displacement"  # of the target


@dataclass(frozen=True)
class Note:
    """Something to be said of an answer."""

    kind: NoteKind
    numbers: tuple[tuple[str, Number], ...] = ()

    @classmethod
    def of(cls, kind: NoteKind, **numbers: Number) -> Note:
        """Return a note by its kind and its numbers, by name."""
        return cls(kind, tuple(numbers.items()))

    @property
    def known(self) -> dict[str, Number]:
        """The numbers by name."""
        return dict(self.numbers)


@dataclass(frozen=True)
class Omission:
    """Something that an answer leaves out."""

    kind: OmissionKind
    size: float = 0.0  # largest relative change of the answer; 0 where exact, NaN where no size is known
    relative_to: Relative = Relative.CHANGE
    bound: bool = False  # an upper bound; else an estimate
    counts: bool = True  # an error of the question; False for what another request would ask
    numbers: tuple[tuple[str, Number], ...] = ()

    @property
    def known(self) -> dict[str, Number]:
        """The numbers by name."""
        return dict(self.numbers)

    @property
    def unbounded(self) -> bool:
        """Whether it counts and has no size."""
        return self.counts and math.isnan(self.size)


def packed(notes: Iterable[Note]) -> str:
    """Return notes as one text for a file, from which `unpacked` reads them."""
    return json.dumps([{"kind": note.kind, **note.known} for note in notes])


def unpacked(text: str) -> tuple[Note, ...]:
    """Return the notes of a text that `packed` wrote; none of an empty one."""
    return tuple(map(_note, json.loads(text or "[]")))


def _note(row: Mapping[str, Number]) -> Note:
    """Return a note from its entries."""
    return Note(NoteKind(row["kind"]), tuple((name, value) for name, value in row.items() if name != "kind"))
