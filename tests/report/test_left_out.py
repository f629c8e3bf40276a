"""What is said of omissions: a line, an entry for a program, one line for the cases of a sweep."""

import math

import pytest

from sits_mech.notes import Omission, OmissionKind, Relative, packed_omissions, unpacked_omissions
from sits_mech.report.left_out import RELATIVE, entry, kept_lines, line, reason, size_text

K = OmissionKind
SAID = [
    (
        Omission(K.TRACKS, 0.0147, numbers=(("frequency", 5e6),)),
        "metal's field in the tracks: uneven current in the tracks is that without metal, at 5e+06 Hz (about 0.015 of "
        "the change)",
    ),
    (Omission(K.POSE_GIVEN, relative_to=Relative.DISPLACEMENT), "pose given: the pose is given"),
    (
        Omission(K.FINITE_STRAIN, 0.0123, Relative.DISPLACEMENT, bound=True, included=True),
        "finite strain: strains are so small, or so even, that one constant compliance is enough (at most 0.012 of the "
        "displacement)",
    ),
    (
        Omission(K.PAD_ENDS, 3.41, Relative.DISPLACEMENT, numbers=(("pad", 0.02), ("target", 0.008))),
        "ends of pad and target along y: plane strain spreads the force over 20 mm of pad, the target covers 8 mm "
        "(about 3.4 of the displacement)",
    ),
    (
        Omission(K.HISTORY, 0.3, Relative.DISPLACEMENT, counts=False),
        "rate and history of the silicone: slow load on virgin material; ask for simulate --history, or cycle (about "
        "0.3 of the displacement)",
    ),
    (
        Omission(K.LAW, 0.29, Relative.DISPLACEMENT, bound=True, counts=False, numbers=(("percent", "29"),)),
        "other laws of the silicone: by its tests the load is known within 29 % only, pressed and sheared (at most "
        "0.29 of the displacement)",
    ),
    (
        Omission(K.BENDING, 0.025, Relative.DISPLACEMENT, numbers=(
            ("deflection", 4.8e-5), ("stiffness", 0.098), ("known", True), ("bare", True)
        )),
        "bending of the target: it is solved as rigid; with a bending stiffness of 0.098 N m it bends by up to "
        "48 um; bare: give target.backing_thickness of what it is glued on (about 0.025 of the displacement)",
    ),
    (
        Omission(K.BENDING, math.nan, Relative.DISPLACEMENT),
        "bending of the target: what is no metal has no modulus here: give target.youngs_modulus (not known of the "
        "displacement)",
    ),
    (
        Omission(K.SYMMETRY, relative_to=Relative.DISPLACEMENT),
        "out-of-plane displacement and rotation: scene and load are symmetric",
    ),
    (
        Omission(K.IMAGES, numbers=(("solved", 1), ("all", 2))),
        "mirrored loads: pad and target are symmetric: 1 of 2 loads are solved, the others mirrored",
    ),
    (
        Omission(K.BETWEEN, 1e-2, numbers=(("solved", 19), ("all", 81))),
        "loads between solved ones: interpolated between about 19 of 81 solved loads, within the tolerance (about 0.01 "
        "of the change)",
    ),
    (Omission(K.NO_TARGET), "eddy currents: no target: the coils in free space"),
    (
        Omission(K.PLATE_ENDS, math.nan, numbers=(("disc", True), ("round", True))),
        "ends along y: coils and plates are taken as endless along y, a disc as a strip of its diameter, round coils "
        "as straight tracks (not known of the change)",
    ),
    (
        Omission(K.PLATE_ENDS, 0.06, numbers=(("disc", False), ("round", False))),
        "ends along y: coils and plates are taken as endless along y (about 0.06 of the change)",
    ),
    (
        Omission(K.RETURN_CURRENT, math.nan),
        "net current of the target: net_current is free, a plate in space is isolated (not known of the change)",
    ),
    (
        Omission(K.NOT_CUT, math.nan, numbers=(("name", "nut"),)),
        "fixed part that the section misses: the section y = 0 does not cut nut (not known of the change)",
    ),
    (Omission(K.AIR), "mesh of the air: no permeable parts: integral model"),
    (
        Omission(K.PITCH, 4.2e-3),
        "pitch of the spiral windings: this model replaces spirals by rings (about 0.0042 of the change)",
    ),
    (
        Omission(K.AROUND, 0.02, Relative.IMPEDANCE, included=True, numbers=(("name", "target"),)),
        "current around a hole: losses around the hole of target are known to a half (about 0.02 of the change of "
        "impedance)",
    ),
    (Omission(K.IDLE, numbers=(("open", True),)), "current in the idle coil: it is open"),
    (
        Omission(K.IDLE, 4.4e-4, Relative.FREE, bound=True, counts=False, numbers=(("open", False),)),
        "current in the idle coil: each coil is driven alone; mutual inductances in L allow adding it (at most 0.00044 "
        "of L0)",
    ),
    (
        Omission(K.FAR, 1e-4, bound=True, numbers=(("name", "nut"), ("x", 0.2), ("y", 0.0), ("z", -1e-3))),
        "conductors far away: nut is far away, at (200, 0, -1) mm (at most 0.0001 of the change)",
    ),
    (Omission(K.STATED, math.nan, numbers=(("text", "said"),)), "stated: said (not known of the change)"),
]
"""Omissions, and what is said of them."""


@pytest.mark.parametrize(("item", "words"), SAID, ids=[str(k) for k in range(len(SAID))])
def test_an_omission_is_a_line_also_from_a_file(item: Omission, words: str) -> None:
    (again,) = unpacked_omissions(packed_omissions([item]))
    assert line(item) == line(again) == words
    assert (again.kind, again.relative_to, again.numbers, again.parts) == (
        item.kind, item.relative_to, item.numbers, item.parts,
    )


def test_every_kind_has_words() -> None:
    assert {item.kind for item, _ in SAID} == set(OmissionKind) and set(RELATIVE) == set(Relative)


def test_sizes_are_bounds_or_estimates_or_not_known() -> None:
    sizes = (0.0, 0.023, math.nan)
    assert [size_text(Omission(K.AIR, size)) for size in sizes] == ["none", "about 0.023", "not known"]
    assert size_text(Omission(K.AIR, 0.023, bound=True)) == "at most 0.023"
    assert size_text(Omission(K.AIR, math.inf, bound=True)) == "not known"  # a bound that holds nothing


def test_an_entry_says_whether_the_error_holds_it() -> None:
    """What counts and has a size."""
    items = (Omission(K.AIR), Omission(K.AIR, math.nan), Omission(K.AIR, 0.1, counts=False))
    assert [entry(item)["in_error"] for item in items] == [True, False, False]
    found = entry(SAID[3][0])
    assert found["what"] == "ends of pad and target along y" and found["relative_to"] == "displacement"
    assert found["reason"] == reason(SAID[3][0]) and set(found) == {
        "what", "reason", "size", "relative_to", "bound", "counts", "in_error",
    }


def test_cases_are_one_line_for_each_kind() -> None:
    """The largest, or one without a size, with the number of cases; of one case no number; of none nothing."""
    ends = [Omission(K.PLATE_ENDS, size, numbers=(("disc", False), ("round", False))) for size in (0.1, 0.3, math.nan)]
    pitch = Omission(K.PITCH, 0.01)
    texts = [packed_omissions(items) for items in ([ends[0], pitch], [ends[1]], [])]
    assert kept_lines(texts) == [
        f"left out: 2 of 3 cases, at most: {line(ends[1])}", f"left out: 1 of 3 cases, at most: {line(pitch)}",
    ]
    for order in (texts, texts[::-1]):
        for worst in ([*order, packed_omissions([ends[2]])], [packed_omissions([ends[2]]), *order]):
            (own,) = (each for each in kept_lines(worst) if "ends along y" in each)
            assert own.endswith("(not known of the change)")
    assert kept_lines([packed_omissions([pitch])]) == [f"left out: {line(pitch)}"] and kept_lines(["", "[]"]) == []
