"""Permeable plates in space, steel, ferrite or filled rubber: divided, answering coils in poses and other plates.

The potential on a plate's surface (`shells`) meets what the plate takes up (`skin`). The coils' own potential puts
fluxes on the surface, in each pose or once at rest, that of other plates by a few combinations of polynomials. Two
divisions, of cells halved, are extrapolated by the second order; a part of that, and the error of the equations, are
the estimated ones. Combinations that a plate hardly sees are those of the finer division.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from sits_mech.magnetics.permeable.shell_plans import divided_surfaces
from sits_mech.magnetics.permeable.shells import HalfSurface, ShellClass, shell_classes
from sits_mech.magnetics.permeable.skin import PlateMetal
from sits_mech.magnetics.space.divisions import field_box
from sits_mech.magnetics.space.far import FieldRequest
from sits_mech.magnetics.space.fields import (
    HELD,
    Basis,
    Blocks,
    Box,
    chebyshev_values,
    decay_scale,
    row_places,
    without_gradients,
)
from sits_mech.magnetics.space.rungs import ImpedanceLimit, PlateRung
from sits_mech.magnetics.space.sources import Posed, Sources
from sits_mech.memory import latest
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Target

_KEEP = 1e-4  # weaker combinations of fields are left out: their energy, to the strongest, is the square
_STRONG = 1e-3  # of the strongest energy, from which combinations are extrapolated
PARTS = 4
"""A plate's answer; off by the error of its divisions; by that of the equations, in phase and in quadrature."""


@dataclass(frozen=True, eq=False)
class _Level:
    """A division: its surface, its classes, and what combinations of fields, then coils at rest, put on each (f, r)."""

    surface: HalfSurface
    classes: list[ShellClass]
    loads: list[Complex]


@dataclass(frozen=True, eq=False)
class _Prepared:
    """A plate, ready to answer."""

    metal: PlateMetal
    levels: tuple[_Level, ...]  # the finer first
    added: float  # of what the finer level changes, to the limit
    box: Box  # of others' fields; of a plate alone it only says where that is
    bases: tuple[Basis, ...]  # combinations of these, one a class
    clearance: float  # from the coils [m]
    left: float  # error of what is extrapolated, over it

    @latest(2, owned=True)
    def matrices(self, omega: float) -> list[list[Complex]]:
        """Return X of all parts by levels and classes, each (`PARTS`, f, f); their sums over levels are the parts."""
        found = []
        for weight, off, level in zip((1.0 + self.added, -self.added), (1.0, -1.0), self.levels, strict=True):
            each, error = [], off < 0.0  # the equations' errors are those of few cells
            for part in level.classes:
                X, wrong = self.metal.responses(part, omega)
                less = weight * X + error * np.array([0.0, 0.0, 1.0, 1j])[:, None, None] * wrong
                less[1] -= self.left * off * self.added * X
                each.append(less)
            found.append(each)
        return found


@dataclass(frozen=True, eq=False)
class Permeable:
    """A part of a plate's answer, as `far.Moving` is asked; all parts see the same of the coils."""

    whole: _Prepared
    part: int  # of `PARTS`
    coils: int = 0  # that it sees at rest, after the combinations

    @property
    def box(self) -> Box:
        """Where others' fields are taken."""
        return self.whole.box

    @property
    def bases(self) -> tuple[Basis, ...]:
        """Combinations of others' fields."""
        return self.whole.bases

    @property
    def unknowns(self) -> int:
        """Nodes of the whole surface, on the finer division."""
        return int(sum(len(p.S) * np.real(p.weight) / p.character.size for p in self.whole.levels[0].classes))

    @latest(2, owned=True)
    def admittance(self, omega: float) -> Blocks:
        """Return Y of the combinations, and of coils at rest after them; omega [rad/s]."""
        *each, last = row_places([*(basis.size for basis in self.bases), self.coils])
        parts = []
        for k, own in enumerate(each):
            Y: Any = 0.0
            for X, level in zip(self.whole.matrices(omega), self.whole.levels, strict=True):
                Y = Y + level.loads[k].conj().T @ X[k][self.part] @ level.loads[k]
            parts.append((np.r_[own, last], 0.5j * omega * (Y + Y.T)))
        return Blocks(last.stop, tuple(parts))

    def reactions(
        self, divisions: Sequence[Permeable], seen: Posed, frequency: float, limit: ImpedanceLimit | None = None,
        asked: FieldRequest | None = None,
    ) -> tuple[list[Complex], None]:
        """Return what parts of the plate do to the coils' impedance, (p, n, n) each [ohm], or a limit's `forms`."""
        values = [Z[..., : len(seen.coils)] for Z in self.coupled(divisions, seen, frequency)]
        return (values if limit is None else limit.forms(values)), None

    def coupled(self, divisions: Sequence[Permeable], seen: Posed, frequency: float) -> list[Complex]:
        """Return Y of coils and combinations by parts, as `far.Moving`."""
        found = _answers(self.whole, seen, frequency)
        return [found[each.part] for each in divisions]


def _answers(whole: _Prepared, seen: Posed, frequency: float) -> Complex:
    """Return Y of the coils' fields in p poses and, to its right, of combinations, by parts (`PARTS`, p, n, n + r)."""
    n, columns = len(seen.coils), row_places([*(basis.size for basis in whole.bases)])
    omega, r = 2 * np.pi * frequency, columns[-1].stop if columns else 0
    found = np.zeros((PARTS, len(seen.places), n, n + r), dtype=complex)
    step = max(1, HELD // (whole.levels[0].surface.points[0].size * n))
    for matrices, level in zip(whole.matrices(omega), whole.levels, strict=True):
        for first in range(0, len(seen.places), step):
            some = slice(first, first + step)
            loads = level.surface.loads(_potentials(whole, level.surface, seen.some(some)))
            for k, (part, X) in enumerate(zip(level.classes, matrices, strict=True)):
                b = part.projected(loads).reshape(len(part.S), -1, n).transpose(1, 0, 2)
                back = np.swapaxes(b.conj(), 1, 2)
                own = back @ X[:, None] @ b
                found[:, some, :, :n] += 0.5j * omega * (own + np.swapaxes(own, 2, 3))
                if r:
                    others = level.loads[k]
                    both = back @ (X @ others)[:, None] + np.swapaxes((others.conj().T @ X)[:, None] @ b, 2, 3)
                    found[:, some, :, n:][..., columns[k]] += 0.5j * omega * both
    return found


def _potentials(whole: _Prepared, part: HalfSurface, seen: Posed) -> Array:
    """Return A of n coils in p poses at a surface's `points`, (2 g, e, 2, 3, p times n), in the plate's own axes."""
    points = part.points[0]
    flat = points.reshape(-1, 3) + (0.0, 0.0, whole.metal.thickness / 2)
    found = np.empty((len(flat), 3, len(seen.places), len(seen.coils)))
    for c, A in enumerate(seen.potentials(flat, whole.clearance)):
        found[..., c] = np.moveaxis(seen.turned_back(A), 0, 2).swapaxes(0, 1)
    return found.reshape(*points.shape, -1)


@latest(24)
def prepared_permeable(
    plate: Target, susceptibility: complex, rung: PlateRung,
    scale: tuple[float, tuple[float, float], float], seen: tuple[float, Sources | None],
) -> tuple[Permeable, ...]:
    """Return all parts of a permeable plate's answer.

    The rung gives the digits that fields keep; `scale` the clearance from the coils, how far from the middle these call
    for small cells, and the length on which their field changes [m]; `seen` the clearance from other plates, 0 without,
    and the coils of a plate at rest. TooLarge before the first large array.
    """
    clearance, (others, sources) = scale[0], seen
    box = field_box(plate, others or clearance, rung)
    surfaces, counts, left = divided_surfaces(plate, rung, scale, sources)
    added = 1.0 / ((counts[0] / counts[1]) ** 2 - 1.0)
    classes, found = [shell_classes(each) for each in surfaces], list[tuple[Basis, int]]()
    levels = list[_Level]()
    for part, own in zip(surfaces, classes, strict=True):
        loads: list[Any] = [np.zeros((len(each.S), 0)) for each in own]
        if others > 0.0 or sources is not None:
            fields = _polynomials(part, own, box)
            found = found or [_strongest(each, B, box) for each, B in zip(own, fields, strict=True)]
            size = decay_scale(box)[:, None]
            share = (1.0 / (1.0 + added), 0.0)[len(levels)]
            for k, (B, (basis, weak)) in enumerate(zip(fields, found, strict=True)):
                loads[k] = B[:, basis.rows] @ (basis.fields * size[basis.rows])
                loads[k][:, :weak] *= share
        if sources is not None:
            points = part.points[0]
            b = part.loads(sources.potential(points.reshape(-1, 3)).reshape(*points.shape, -1))
            loads = [np.hstack([B, each.projected(b)]) for B, each in zip(loads, own, strict=True)]
        levels.append(_Level(part, own, loads))
    metal = PlateMetal(1.0 + susceptibility, plate.conductivity or 0.0, plate.thickness)
    bases = tuple(basis for basis, _ in found)
    whole = _Prepared(metal, tuple(levels), added, box, bases, clearance, left)
    return tuple(Permeable(whole, k, len(sources.coils) if sources else 0) for k in range(PARTS))


def _polynomials(part: HalfSurface, classes: Sequence[ShellClass], box: Box) -> list[Complex]:
    """Return what each T_i T_j T_k e_a, of its size and less gradients, puts on the classes' nodes, (f, 3 q) each."""
    found: list[Any] = [0.0] * len(classes)
    for k, (points, way) in enumerate(zip(*part.points, strict=True)):
        x, y, z = (chebyshev_values(points[..., i] / box.half[i], box.order[i]) for i in range(3))
        T = np.einsum("eki,ekj,ekl->eijl", x, y, z, optimize=True).reshape(len(way), -1) / 2.0
        turn = np.round(np.linalg.det(part.images[k]))
        loads = np.hstack([part.edges[1] @ (T * (turn * way[:, a, None])) for a in range(3)])
        for c, each in enumerate(classes):
            chi = each.character[k].conj() if np.iscomplexobj(each.S) else each.character[k].real
            found[c] = found[c] + chi / each.character.size * (each.free.conj().T @ loads)
    size, rows = decay_scale(box), np.arange(decay_scale(box).size)
    return [np.asarray(without_gradients(box, rows, (B * size).T).T, dtype=B.dtype) for B in found]


def _strongest(part: ShellClass, B: Complex, box: Box) -> tuple[Basis, int]:
    """Return a few combinations of fields in which a class sees nearly all, by their energy in the plate.

    So many of the first are weak, as is returned: the coarser division, which may mistake them, does not count in them.
    """
    size = decay_scale(box)
    values, vectors = eigh(part.inverse)
    seen = B.T @ (vectors.conj() * np.sqrt(np.maximum(values, 0.0)))
    seen = np.hstack([seen.real, seen.imag]) if np.iscomplexobj(seen) else seen
    strength, own = eigh(seen.T @ seen)
    some = strength > _KEEP**2 * strength[-1]
    rows = np.flatnonzero(np.abs(seen).max(axis=1) > 1e-9 * np.abs(seen).max())
    fields = (seen @ own[:, some] / np.sqrt(strength[some]))[rows] / size[rows, None]
    return Basis(rows, fields), int(np.count_nonzero(strength[some] < _STRONG * strength[-1]))
