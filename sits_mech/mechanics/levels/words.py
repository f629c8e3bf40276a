"""Say of a load path that ended where it stands, why, and how much of the load is carried: for messages and reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sits_mech.mechanics.equilibrium.control import PLACES
from sits_mech.mechanics.equilibrium.outcome import REASONS, PathEnd
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import WRENCH, Wrench
from sits_mech.silicone.stability import layer_words


def wrench_words(load: Mapping[str, float]) -> str:
    """Format a load [N, N m]; out-of-plane components only where they are not zero."""
    shown = {name: value for name, value in load.items() if name in WRENCH[:3] or value != 0.0}
    return ", ".join(f"{name} = {value:.6g} N{' m' * name.startswith('M')}" for name, value in shown.items())


def given_words(given: Mapping[str, Any]) -> str:
    """Format forces and places among some numbers by name."""
    forces = wrench_words({name: value for name, value in given.items() if name in WRENCH})
    units = {name: "rad" if name.startswith("alpha") else "m" for name in given if name in PLACES}
    return ", ".join([*([forces] * bool(forces)), *(f"{name} = {given[name]:.6g} {units[name]}" for name in units)])


def carried_note(carried: tuple[Wrench, Wrench], limit: tuple[float, float], kind: NoteKind) -> Note:
    """Return the note on a largest load and its error, and on the share of what was asked with its error."""
    load, error = (vars(each) for each in carried)
    errors = {f"error_{name}": value for name, value in error.items()}
    return Note.of(kind, **load, **errors, part=float(limit[0]), error_part=float(limit[1]))


def carried_words(found: Mapping[str, Any]) -> str:
    """Format a largest load and its error: the non-zero components, and the share of what was asked."""
    known = bool(np.isfinite(found["error_part"]))
    loads = {name: (found[name], found[f"error_{name}"]) for name in WRENCH if found[name] != 0.0}
    parts = [
        f"{name} = {value:.4g}{f' +- {error:.2g}' * known} N{' m' * name.startswith('M')}"
        for name, (value, error) in loads.items()
    ]
    share = f"{found['part']:.2%} +- {found['error_part']:.2%} of the path"
    return f"{', '.join(parts)} ({share if known else 'on a coarse mesh, its error is not known'})"


def _law_words(note: Note) -> str:
    """Say what a law lacks at the stretch reached, and under which load a coarse mesh was there, if one was."""
    there = given_words(note.known)
    return layer_words(note) + f", under {there} on a coarse mesh" * bool(there)


WORDS: Mapping[NoteKind, Callable[[Note], str]] = {
    NoteKind.LAW_END: _law_words,
    NoteKind.DATA_END: _law_words,
    NoteKind.CARRIED: lambda note: f"carried up to {carried_words(note.known)}",
    NoteKind.WITHIN_DATA: lambda note: f"within the silicone's data up to {carried_words(note.known)}",
    NoteKind.NO_LARGEST: lambda note: (
        f"no largest load was found: a coarse mesh could be followed to {given_words(note.known)}"
    ),
    NoteKind.PATH_END: lambda note: REASONS[PathEnd(str(note.known["end"]))],
}
"""The words of each kind of note that the message of a failure holds, too."""
