"""Does every kind of note have its sentence, in units that are read easily, and do tables show sentences?"""

import numpy as np
import pytest
import xarray as xr

from sits_mech.mechanics.equilibrium.outcome import REASONS, PathEnd
from sits_mech.mechanics.levels.words import carried_note
from sits_mech.memory import GIB
from sits_mech.notes import Note, NoteKind, packed, unpacked
from sits_mech.quantities import Wrench
from sits_mech.report.notes import joined_words, sentence, sentences, with_words

K = NoteKind
TOO_LARGE = "some 5 GiB, more than the limit of 4 GiB (--memory, or SITS_MECH_MEMORY)"
SAID = [
    (Note.of(K.STATED, text="a friend's model says so"), "a friend's model says so"),
    (
        Note.of(K.LAW_END, silicone="the yeoh law", law="yeoh", mode="planar tension", stretch=1.556, reached=2.4761),
        "the yeoh law is unstable from stretch 1.556 on in planar tension, this solve reached 2.476",
    ),
    (
        Note.of(K.DATA_END, silicone="Ecoflex", stretch=2.0, reached=2.5, F_x=0.0, F_z=10.0, M=0.0),
        "the data of Ecoflex end at stretch 2, this solve reached 2.5, under F_x = 0 N, F_z = 10 N, M = 0 N m on a "
        "coarse mesh",
    ),
    (
        Note(K.NO_HISTORY),
        "the silicone has neither prony nor mullins: its rate and softening are unknown, and left out",
    ),
    (
        Note(K.NO_LOOP),
        "no loop: the silicone has neither prony nor mullins, so it is elastic; widths other than zero are rounding",
    ),
    (Note.of(K.FACE_TOUCHES, surface="ground", friction=0.0), "a free face touches the ground: frictionless contact"),
    (
        Note.of(K.FACE_TOUCHES, surface="target", friction=0.5),
        "a free face touches the target's plane, taken to extend beyond the target: contact with friction 0.5",
    ),
    (
        Note.of(K.FACE_FOLDS, surface="sides"),
        "a free face folds onto the target's sides: this contact is not in the answer, the true layer is stiffer",
    ),
    (Note(K.FACE_RISES), "silicone rises above the target's top face: its sides are taken to extend upwards"),
    (Note(K.FACES_TOUCH), "free faces touch each other: frictionless contact"),
    (
        Note(K.FACES_CROSS),
        "free faces pass through one another: this contact is not in the answer, the true pad is stiffer",
    ),
    (
        Note.of(K.BENT, deflection=1.15e-5, bare=False),
        "the target bends by up to 12 um, which is solved: the pose is that of a rigid one that the coils read alike",
    ),
    (Note(K.CONTACT_LOST), "contact could not be followed to this load: the estimated error is the whole displacement"),
    (
        Note.of(K.BELOW_GROUND, depth=1.2e-4),
        "the target's rim is 0.12 mm below the ground that the layer stands on: it would lie on the substrate there, "
        "which is not solved: the error is the whole displacement",
    ),
    (
        Note.of(K.EDGE_RADIUS, radius=2e-4, d_h=1e-6, d_v=-2e-6, alpha=np.radians(0.5)),
        "edge radius 0.2 mm: moves the target by +1 um along x, +2 um down, +0.5 deg, against sharp edges (small "
        "strain)",
    ),
    (
        Note(K.EDGE_SHARP),
        "the target's edge stays sharp: no side face of the layer ends there that could have a radius",
    ),
    (
        Note(K.EDGE_LEFT_OUT),
        "elastomer.edge_radius is left out: the edges of this model are sharp, or as its mesh has them",
    ),
    (
        Note.of(K.NODES_MERGED, mesh="pad.msh", count=4),
        "pad.msh: 4 duplicated nodes were merged, as elastomer.weld asks",
    ),
    (
        Note.of(K.FACES_FREE, mesh="pad.msh", count=2, of=50, x=1e-3, y=0.0, z=2e-3),
        "pad.msh: 2 of 50 faces of the surface are in no group and taken as free, the first about (1, 0, 2) mm",
    ),
    (
        Note.of(K.TOLERANCE_MISSED, error=0.0123, tolerance=1e-3),
        "estimated error 0.012: the tolerance 0.001 is missed",
    ),
    (
        Note.of(K.TOLERANCE_MISSED, error=0.0123, tolerance=1e-3, better="planar-fem"),
        "estimated error 0.012: the tolerance 0.001 is missed",
    ),
    (
        Note.of(K.SIGNALS_MISSED, pose=0.981, model=0.0272, left_out=0.0, component="d_h", coil="C3"),
        "above the tolerance by errors, of the signals' full scale, of the pose (0.98 %, most by d_h), the magnetic "
        "model (0.027 %) and what is left out (0 %); largest in C3",
    ),
    (
        Note.of(K.MESH_TOO_LARGE, needed=5.0 * GIB, limit=4.0 * GIB),
        f"a finer mesh would take {TOO_LARGE}: raise it for a smaller error",
    ),
    (Note(K.INTERPOLATED), "pose interpolated between solved loads by a smooth map"),
    *((Note.of(K.PATH_END, end=end), words) for end, words in REASONS.items()),
    (Note.of(K.PATH_PART, part=0.225), "reached 22.5% of the path"),
    (
        carried_note((Wrench(F_z=11.0), Wrench(F_z=0.5)), (0.55, 0.025), K.CARRIED),
        "carried up to F_z = 11 +- 0.5 N (55.00% +- 2.50% of the path)",
    ),
    (
        carried_note((Wrench(F_z=11.0), Wrench(F_z=0.5)), (0.55, 0.025), K.WITHIN_DATA),
        "within the silicone's data up to F_z = 11 +- 0.5 N (55.00% +- 2.50% of the path)",
    ),
    (
        Note.of(K.NO_LARGEST, F_x=1.0, sink=2e-3),
        "no largest load was found: a coarse mesh could be followed to F_x = 1 N, sink = 0.002 m",
    ),
    (
        Note.of(K.FRICTION_PATH, legs=1, parts=8, change=0.002),
        "friction: load path straight from zero load, 8 steps per leg; half as many change this by 0.002",
    ),
    (
        Note.of(K.FRICTION_PATH, legs=2, parts=16, change=0.002),
        "friction: load path along the given loads, 16 steps per leg; half as many change this by 0.002",
    ),
    (Note.of(K.TIMES, count=20, meshes=3, error=0.01), "history: 20 times on 3 meshes; error of the time steps 0.01"),
    (Note(K.AS_A_WHOLE), "rate: relaxation of the pad as a whole, component by component"),
    (
        Note(K.SLIP_LEFT_OUT),
        "elastomer.friction: every load comes straight from rest; what slips there and back is not in the loop",
    ),
    (Note.of(K.RINGS, rings=99, levels=3), "disc as 99 rings, extrapolated from 3 levels of division"),
    (Note(K.SPIRALS_AS_RINGS), "spiral windings taken as rings"),
    (Note.of(K.SPIRALS, share=0.0123), "spiral windings: L0 differs from that of rings by up to 1.23%"),
    (
        Note.of(K.FREE_TRACKS, coil="C1", vias=1e-3, back=2e-3),
        "C1: free tracks, without 1 mm of vias and 2 mm of way back",
    ),
    (
        Note.of(K.PERMEABLE, permeability=120.0, depths=17.25, part="conductors.core"),
        "conductors.core: permeable, mu_r = 120, 17.2 skin depths thick: saturation is left out",
    ),
    (
        Note.of(K.FIELD_ON, field=1234.0),
        "permeable: the coils' own field on it is up to 1.2e+03 A/m per ampere; compare it with its saturation",
    ),
    *(
        (
            Note.of(K.SKIN, depths=depths, sheets=5, at_frequency=5e6),
            f"at 5e+06 Hz: {regime} skin regime: thickness is {depths:g} skin depths; 5 sheets joined at the rim",
        )
        for depths, regime in ((0.5, "thin"), (2.0, "intermediate"), (9.0, "thick"))
    ),
    (
        Note.of(K.GAP_SMALL, share=0.02),
        "the gap is small for so wide a plate: 2.0% of the coils' field is not resolved",
    ),
    (
        Note.of(K.PLATE_TOO_LARGE, cells=4000.0, width=0.06, length=0.05, needed=5.0 * GIB, limit=4.0 * GIB),
        f"memory: 4000 cells of the plate of 60 x 50 mm take {TOO_LARGE}: a coarser division is taken, whose error is "
        "the estimated one",
    ),
    (
        Note.of(K.LARGE_LOAD, bound=0.467, held=0.4),
        "a large load for this pad: small strain would be off by 0.47; some pads became unstable in shear from 0.4, in "
        "compression from about 1.5: only a solve can tell, and a refusal says how much holds",
    ),
    (Note.of(K.NOT_CARRIED, text="wrench: why"), "a large load for this pad: wrench: why"),
    (
        Note.of(K.OUT_OF_REACH, tolerance=1e-3, reached=4.2e-3),
        "the tolerance 0.001 cannot be reached at this load, about 0.004 can",
    ),
    (
        Note.of(K.OVERHANG, over=3e-3),
        "the target reaches 3 mm over its elastomer: there it is rigid and bonded to nothing, silicone that bulges "
        "lies on it, the ground does not stop its rim, and the coils see all of it",
    ),
    (Note.of(K.NO_CODES, text="the scene has no converter"), "no codes: the scene has no converter"),
    (Note.of(K.ADAPTED, count=5, source="bench.csv"), "adapted to 5 readings of bench.csv"),
    (
        Note.of(K.PLACED, d_h=1e-4, alpha=4e-3),
        "in the table, not in the scene: d_h 0.0001 m, alpha 0.004 rad",
    ),
    (Note.of(K.LIMIT_DATA, stretch=2.0), "stretch beyond 2, the end of the silicone's data"),
    (Note.of(K.LIMIT_COILS, plates=False), "coil contact"),
    (Note.of(K.LIMIT_COILS, plates=True), "contact with the coils or a fixed plate"),
    (Note.of(K.LIMIT_ERROR, tolerance=0.05), "error of the pose beyond 0.05 of the displacement"),
    (Note(K.LIMIT_FOLD), "folding: free faces pass through one another"),
    (Note.of(K.LIMIT_LOAD, end=PathEnd.BUCKLED), "buckling"),
    (Note.of(K.LIMIT_LOAD, end=PathEnd.SIDEWAYS), "buckling sideways"),
    (Note.of(K.LIMIT_LOAD, end=PathEnd.TURNED), "limit load"),
    (Note.of(K.LIMIT_LOAD, end=PathEnd.NONE), "limit load"),
    (Note.of(K.LIMIT_LOAD, end=PathEnd.INVERTED), "folding: the mesh turns inside out at a corner"),
    (Note(K.LIMIT_LOST), "no equilibrium found beyond: it may carry more"),
    (Note.of(K.NO_LIMIT, most=64.0), "no limit was met up to 64 times"),
]
"""Notes, and what is said of them."""


@pytest.mark.parametrize(("note", "words"), SAID)
def test_a_note_has_its_sentence_also_from_a_file(note: Note, words: str) -> None:
    assert sentence(note) == words
    (again,) = unpacked(packed([note]))
    assert again == note and sentence(again) == words


def test_every_kind_has_a_sentence() -> None:
    assert {note.kind for note, _ in SAID} == set(NoteKind)


def test_a_largest_load_without_a_known_error_says_so() -> None:
    note = carried_note((Wrench(M=0.02), Wrench()), (0.4, np.nan), K.CARRIED)
    assert sentence(note) == "carried up to M = 0.02 N m (on a coarse mesh, its error is not known)"
    assert sentence(unpacked(packed([note]))[0]) == sentence(note)


def test_tables_keep_kinds_and_show_sentences() -> None:
    """None is an empty text, which a table shows as such."""
    notes = Note(K.INTERPOLATED), Note.of(K.STATED, text="a; b")
    assert packed([]) == "" and unpacked("") == () and joined_words("") == ""
    assert sentences(notes) == [sentence(notes[0]), "a; b"]
    data = xr.Dataset({"notes": ("F_z", np.array([packed(notes), ""], dtype=object)), "d_v": ("F_z", [1.0, 2.0])})
    assert with_words(data)["notes"].to_numpy().tolist() == [f"{sentence(notes[0])}; a; b", ""]
    scalar = xr.Dataset({"notes_mechanics": ((), packed(notes[1:]))})
    assert with_words(scalar)["notes_mechanics"].item() == "a; b"
