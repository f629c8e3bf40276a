"""Values for the notes on an answer, and omissions with their sizes. Sentences are made in report/.

Inside the package a note is a kind with numbers: decisions read these, never a text. An omission is something that the
answer's model leaves out of the question: its size is relative to what `relative_to` names, an upper bound or an
estimate, zero where it changes nothing, NaN where no size is known. What counts is in the answer's error, or bounds
nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

Number = float | int | str | bool
"""What a note holds by name: a number, or the name of a part of the scene."""


class NoteKind(StrEnum):
    """Kinds of notes."""

    STATED = "stated"  # words of a model that is not of this package: text

    # silicone
    LAW_END = "law end"  # a law is no longer stable or elliptic: silicone, law, stretch, mode, reached
    DATA_END = "data end"  # silicone, stretch, reached
    NO_HISTORY = "no history"  # a silicone without data over time, taken as under slow load
    NO_LOOP = "no loop"  # a silicone without data over time in a load cycle

    # free faces of a layer
    FACE_TOUCHES = "face touches"  # contact is solved: surface, friction
    FACE_FOLDS = "face folds"  # onto a surface, without contact: surface
    FACE_RISES = "face rises"  # above the target's top face
    FACES_TOUCH = "faces touch"  # each other
    FACES_CROSS = "faces cross"  # each other, without contact
    CONTACT_LOST = "contact lost"  # contact could not be followed: the error is the whole displacement
    BELOW_GROUND = "below ground"  # the target's rim: depth [m]

    BENT = "bent"  # the target, which is solved: deflection [m], whether it is bare

    # meshes and their errors
    EDGE_RADIUS = "edge radius"  # radius, d_h, d_v [m], alpha [rad]: what fillets move
    EDGE_SHARP = "edge sharp"  # the target's edge has no side face that could have a radius
    EDGE_LEFT_OUT = "edge left out"  # the radius is not in this model
    NODES_MERGED = "nodes merged"  # of a mesh: mesh, count
    FACES_FREE = "faces free"  # of a mesh, in no group: mesh, count, of, x, y, z of the first [m]
    TOLERANCE_MISSED = "tolerance missed"  # error, tolerance
    SIGNALS_MISSED = "signals missed"  # a tolerance: pose, model, left_out [% of full scale], component, coil
    MESH_TOO_LARGE = "mesh too large"  # a finer one: needed, limit [bytes]
    INTERPOLATED = "interpolated"  # a pose between solved loads

    # paths and histories of loads
    PATH_END = "path end"  # end: a word of `PathEnd` (mechanics/equilibrium/outcome.py)
    PATH_PART = "path part"  # part of a path that was followed
    CARRIED = "carried"  # largest load: components, error_ of each [N, N m], part, error_part
    WITHIN_DATA = "within data"  # largest load within the data of the silicone: as of CARRIED
    NO_LARGEST = "no largest load"  # components of forces and places that a coarse mesh was followed to
    FRICTION_PATH = "friction path"  # legs, parts of each, change by half as many
    TIMES = "times"  # of a history: count, meshes, error
    AS_A_WHOLE = "as a whole"  # relaxation of a pad, not of its points
    SLIP_LEFT_OUT = "slip left out"  # there and back, in a load cycle

    # magnetics
    RINGS = "rings"  # that a disc is taken as: rings, levels
    SPIRALS_AS_RINGS = "spirals as rings"
    SPIRALS = "spirals"  # difference of L0 from that of rings: share
    FREE_TRACKS = "free tracks"  # coil, vias, back [m]
    PERMEABLE = "permeable"  # permeability, depths
    FIELD_ON = "field on what is permeable"  # field [A/m] for 1 A
    SKIN = "skin"  # thickness in skin depths: depths, sheets
    GAP_SMALL = "gap small"  # for so wide a plate: share of the field that is not resolved
    PLATE_TOO_LARGE = "plate too large"  # for a finer division: cells, width, length [m], needed, limit [bytes]

    # tables
    NO_CODES = "no codes"  # of a converter: text, the words of what refused
    ADAPTED = "adapted"  # to readings: count, source
    PLACED = "placed"  # in the table, not in the scene: components of a pose by name [m, rad]

    # what speaks against a request
    LARGE_LOAD = "large load"  # for a pad: small strain's bound, and held, from which on pads were seen to give way
    NOT_CARRIED = "not carried"  # a load, by the first meshes: text, the words of the failure
    OUT_OF_REACH = "out of reach"  # a tolerance: tolerance, reached
    OVERHANG = "overhang"  # of the target over its elastomer: over [m]

    # limits of a pad
    LIMIT_DATA = "limit data"  # end of the silicone's data: stretch
    LIMIT_COILS = "limit coils"  # contact with them: plates, whether there are fixed ones
    LIMIT_ERROR = "limit error"  # of the pose: tolerance
    LIMIT_FOLD = "limit fold"  # free faces pass through one another
    LIMIT_LOAD = "limit load"  # a load path ended: end, as of PATH_END
    LIMIT_LOST = "limit lost"  # a load path was lost: no limit
    NO_LIMIT = "no limit"  # up to a multiple of the load: most


class OmissionKind(StrEnum):
    """Kinds of omissions."""

    POSE_GIVEN = "pose given"  # no mechanics: the pose is given
    FINITE_STRAIN = "finite strain"
    PAD_ENDS = "ends of pad and target along y"  # length of pad and target [m]
    HISTORY = "rate and history of the silicone"
    LAW = "other laws of the silicone"  # that fit its tests as well: share of the load
    BENDING = "bending of the target"  # stiffness [N m] and deflection [m], where known
    SYMMETRY = "out-of-plane displacement and rotation"
    IMAGES = "mirrored loads"  # loads that are solved, and all of them
    BETWEEN = "loads between solved ones"  # loads that are solved, and all of them
    NO_TARGET = "eddy currents"
    PLATE_ENDS = "ends along y"  # whether a disc, whether round coils are taken as endless
    RETURN_CURRENT = "net current of the target"
    NOT_CUT = "fixed part that the section misses"  # its name
    AIR = "mesh of the air"
    PITCH = "pitch of the spiral windings"
    TRACKS = "metal's field in the tracks"  # frequency [Hz]
    AROUND = "current around a hole"  # name of the permeable part
    IDLE = "current in the idle coil"  # whether it is open
    FAR = "conductors far away"  # name, centre [m]
    STATED = "stated"  # of a model that is not of this package: text


class Relative(StrEnum):
    """What the size of an omission is relative to."""

    CHANGE = "change"  # of inductance that the target causes
    FREE = "L0"  # inductance without target
    IMPEDANCE = "change of impedance"  # that the target causes
    DISPLACEMENT = "displacement"  # of the target


@dataclass(frozen=True)
class Note:
    """A remark on an answer."""

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

    def with_numbers(self, **numbers: Number) -> Note:
        """Return the note with more numbers, such as `at_frequency` [Hz] or the `part` of the scene it is of."""
        return Note.of(self.kind, **self.known, **numbers)


@dataclass(frozen=True)
class Omission:
    """Something that an answer leaves out."""

    kind: OmissionKind
    size: float = 0.0  # largest relative change of the answer; 0 where exact, NaN where no size is known
    relative_to: Relative = Relative.CHANGE
    bound: bool = False  # an upper bound; else an estimate
    counts: bool = True  # an error of the question; False for what another request would ask
    included: bool = False  # in the model's own error; else the chain adds it
    parts: tuple[float, ...] = ()  # of a displacement: by component of the pose where they differ; `size` the largest
    numbers: tuple[tuple[str, Number], ...] = ()

    @property
    def known(self) -> dict[str, Number]:
        """The numbers by name."""
        return dict(self.numbers)

    @property
    def half(self) -> str:
        """The half of the chain that leaves it out: "mechanics" or "magnetics"."""
        return "mechanics" if self.relative_to == Relative.DISPLACEMENT else "magnetics"

    @property
    def weighs(self) -> bool:
        """Whether it counts and changes something, or may."""
        return self.counts and self.size != 0.0

    @property
    def unbounded(self) -> bool:
        """Whether it counts and has no size."""
        return self.counts and math.isnan(self.size)


def packed(notes: Iterable[Note]) -> str:
    """Return notes as one text for a file, from which `unpacked` reads them; none as an empty one."""
    rows = [{"kind": note.kind, **note.known} for note in notes]
    return json.dumps(rows) if rows else ""


def unpacked(text: str) -> tuple[Note, ...]:
    """Return the notes of a text that `packed` wrote; none of an empty one."""
    return tuple(Note.of(NoteKind(row.pop("kind")), **row) for row in json.loads(text or "[]"))


def packed_omissions(left_out: Iterable[Omission]) -> str:
    """Return omissions as one text for a file, from which `unpacked_omissions` reads them."""
    rows = [asdict(item) for item in left_out]
    return json.dumps([{"held": row.pop("included"), **row, "numbers": dict(row["numbers"])} for row in rows])


def unpacked_omissions(text: str) -> tuple[Omission, ...]:
    """Return the omissions of a text that `packed_omissions` wrote; none of an empty one."""
    return tuple(map(_omission, json.loads(text or "[]")))


def _omission(row: Mapping[str, Any]) -> Omission:
    """Return an omission from its entries."""
    kinds = {"kind": OmissionKind(row["kind"]), "relative_to": Relative(row["relative_to"])}
    row = {**row, **kinds, "numbers": tuple(row["numbers"].items()), "parts": tuple(row["parts"])}
    return Omission(included=row.pop("held"), **row)
