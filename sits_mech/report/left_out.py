"""Say what an answer leaves out: in a line, as an entry for a program."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from itertools import chain
from typing import Any

from sits_mech.notes import Number, Omission, OmissionKind, Relative, unpacked_omissions
from sits_mech.units import millimetres as mm

_Reason = str | Callable[[Mapping[str, Number]], str]


def _ends_of_plates(numbers: Mapping[str, Number]) -> str:
    """Say what a section takes as endless."""
    also = ", a disc as a strip of its diameter" * bool(numbers.get("disc"))
    also += ", round coils as straight tracks" * bool(numbers.get("round"))
    return f"coils and plates are taken as endless along y{also}"


def _ends_of_pads(numbers: Mapping[str, Number]) -> str:
    """Say over what plane strain spreads a force."""
    pad, target = float(numbers["pad"]), float(numbers["target"])
    return f"plane strain spreads the force over {mm(pad)} of pad, the target covers {mm(target)}"


def _idle(numbers: Mapping[str, Number]) -> str:
    """Say what idle coils are."""
    return "it is open" if numbers["open"] else "each coil is driven alone; mutual inductances in L allow adding it"


def _far(numbers: Mapping[str, Number]) -> str:
    """Say where a far part is."""
    place = ", ".join(f"{1e3 * float(numbers[axis]):.4g}" for axis in "xyz")
    return f"{numbers['name']} is far away, at ({place}) mm"


def bare_words(bare: object) -> str:
    """Say what stiffens a target without a backing."""
    return "; bare: give target.backing_thickness of what it is glued on" if bare else ""


def _law(numbers: Mapping[str, Number]) -> str:
    """Say what tests tell of a law."""
    if "percent" in numbers:
        return f"by its tests the load is known within {numbers['percent']} % only, pressed and sheared"
    return "its constants are given without tests, which laws fit as well is not known: sits-mech fit finds mode_spread"


def _bends(numbers: Mapping[str, Number]) -> str:
    """Say how far a target bends."""
    if "stiffness" not in numbers:
        return "what is no metal has no modulus here: give target.youngs_modulus"
    if "deflection" not in numbers:
        return "its pad has no mesh on which it could bend"
    deflection, stiffness = (float(numbers[name]) for name in ("deflection", "stiffness"))
    least = "" if numbers["known"] else "; as soft as lead: give target.youngs_modulus"
    how_far = f"with a bending stiffness of {stiffness:.2g} N m it bends by up to {1e6 * deflection:.2g} um"
    return f"it is solved as rigid; {how_far}{least}{bare_words(numbers.get('bare'))}"


_REASONS: Mapping[OmissionKind, _Reason] = {
    OmissionKind.POSE_GIVEN: "the pose is given",
    OmissionKind.FINITE_STRAIN: "strains are so small, or so even, that one constant compliance is enough",
    OmissionKind.PAD_ENDS: _ends_of_pads,
    OmissionKind.HISTORY: "slow load on virgin material; ask for simulate --history, or cycle",
    OmissionKind.LAW: _law,
    OmissionKind.BENDING: _bends,
    OmissionKind.SYMMETRY: "scene and load are symmetric",
    OmissionKind.IMAGES: "pad and target are symmetric: {solved} of {all} loads are solved, the others mirrored",
    OmissionKind.BETWEEN: "interpolated between about {solved} of {all} solved loads, within the tolerance",
    OmissionKind.NO_TARGET: "no target: the coils in free space",
    OmissionKind.PLATE_ENDS: _ends_of_plates,
    OmissionKind.RETURN_CURRENT: "net_current is free, a plate in space is isolated",
    OmissionKind.NOT_CUT: "the section y = 0 does not cut {name}",
    OmissionKind.AIR: "no permeable parts: integral model",
    OmissionKind.PITCH: "this model replaces spirals by rings",
    OmissionKind.TRACKS: "uneven current in the tracks is that without metal, at {frequency:.3g} Hz",
    OmissionKind.AROUND: "losses around the hole of {name} are known to a half",
    OmissionKind.IDLE: _idle,
    OmissionKind.FAR: _far,
    OmissionKind.STATED: "{text}",
}
RELATIVE = {
    Relative.CHANGE: "the change", Relative.FREE: "L0", Relative.DISPLACEMENT: "the displacement",
    Relative.IMPEDANCE: "the change of impedance",
}
"""What sizes are relative to, in words."""


def reason(item: Omission) -> str:
    """Return why something is left out."""
    words = _REASONS[item.kind]
    return words.format(**item.known) if isinstance(words, str) else words(item.known)


def relative_words(item: Omission) -> str:
    """Return what the size of an omission is relative to."""
    return RELATIVE[item.relative_to] + ", by component" * (len({*item.parts}) > 1)


def size_text(item: Omission) -> str:
    """Return the size of an omission, as far as it is known."""
    if not math.isfinite(item.size):
        return "not known"
    if item.size == 0.0:
        return "none"
    return f"{'at most' if item.bound else 'about'} {item.size:.2g}"


def line(item: Omission) -> str:
    """Return an omission as one line."""
    size = "" if item.size == 0.0 else f" ({size_text(item)} of {relative_words(item)})"
    return f"{item.kind}: {reason(item)}{size}"


def entry(item: Omission) -> dict[str, Any]:
    """Return an omission for a program; its size is null where not known."""
    return {
        "what": str(item.kind), "reason": reason(item), "size": item.size, "relative_to": str(item.relative_to),
        "bound": item.bound, "counts": item.counts, "in_error": item.counts and not math.isnan(item.size),
    }


def kept_lines(texts: Iterable[str]) -> list[str]:
    """Return a line for each kind of what cases leave out, from texts that `notes.packed_omissions` wrote.

    The largest of each kind, or one without a size, with the number of cases.
    """
    worst, counts = dict[OmissionKind, Omission](), Counter[OmissionKind]()
    cases = list(map(unpacked_omissions, texts))
    for item in chain.from_iterable(cases):
        counts[item.kind] += 1
        before = worst.get(item.kind)
        if before is None or not (math.isnan(before.size) or item.size <= before.size):
            worst[item.kind] = item
    many = "" if len(cases) == 1 else "{} of {} cases, at most: "
    return [f"left out: {many.format(counts[kind], len(cases))}{line(item)}" for kind, item in worst.items()]
