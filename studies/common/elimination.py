"""Memory of a solution by the very order of elimination of its mesh, in place of that of a box of as many cells."""

from __future__ import annotations

from sits_mech.mechanics.element.assembly import Pattern
from sits_mech.mechanics.element.memory import NUMBER, FrontSize, Memory, front, per_element


def memory_of(pattern: Pattern) -> Memory:
    """The memory of a layer, without allocating it."""
    mesh, found = pattern.mesh, list[FrontSize]()
    e, q, d, k = mesh.inside.slope.shape
    for piece in pattern.dissection.fronts:
        found.append(front(piece.pivots, len(piece.border), [found[half.front] for half in piece.halves]))
    blocks = sum(numbers.shape[0] * numbers.shape[1] ** 2 for numbers in pattern.numbers)
    per_mesh = e * per_element(q, d, k, mesh.chi.shape[1], mesh.nodal is not None)
    return Memory(*(NUMBER * size for size in (per_mesh, blocks, found[-1].factor, found[-1].peak)))
