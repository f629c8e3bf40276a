"""Answer a pose in the three-dimensional model by the coils' potential at some points of the plate, and products.

A coil's potential over the plate is a polynomial (`fields`); a class of currents sees few combinations of its
coefficients c (`modes`). For each coil, with A in the plate's own axes,

    a_c = fields^T c,    Delta Z_cd = sum over classes a_c^T Y(omega) a_d.

What is extrapolated over a plate's divisions (`rungs`) is linear in Delta Z, and so in Y: it is taken of Y, once a
frequency, and a pose costs one product. The differences of levels, from which the error comes, are weak: they are kept
on the few directions U of a class's combinations that show them,

    d_cd = (U^T a_c)^T (U^T dY U) (U^T a_d).

Equal coils have equal fields in their own axes, which are evaluated together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sits_mech.magnetics.coils.straight import CACHED
from sits_mech.magnetics.modes import Reduced
from sits_mech.magnetics.space.far import FieldRequest, biot_savart, few_points, radiated
from sits_mech.magnetics.space.fields import HELD, Basis, Blocks, Box, row_places
from sits_mech.magnetics.space.rungs import ImpedanceLimit
from sits_mech.magnetics.space.sources import Posed
from sits_mech.memory import latest
from sits_mech.quantities import Array, Complex

_SHOWN = 1e-4  # of the strongest answer: weaker directions do not show in differences of levels
_POINT = 1e-2  # of the strongest, of points that make the plate's field: 0.8 % of what it does in tracks from 2e-2

_Forms = tuple[Sequence[Array], Sequence[Array], Sequence[Array]]


@dataclass(frozen=True, eq=False)
class Sheeted:
    """A plate prepared for any pose."""

    box: Box  # of its fields
    bases: tuple[Basis, ...]  # combinations of fields, one a symmetry class
    classes: tuple[Reduced, ...]  # one a symmetry class, seen through its combinations
    unknowns: int  # of the discrete problem
    sheets: int  # of the discrete problem

    @cached_property
    def columns(self) -> list[slice]:
        """Where each class's combinations are among all."""
        return row_places(basis.size for basis in self.bases)

    @latest(2, owned=True)
    def admittance(self, omega: float) -> Blocks:
        """Return Y of all classes' combinations; omega [rad/s]."""
        parts = zip(self.columns, self.classes, strict=True)
        return Blocks(self.columns[-1].stop, tuple((np.r_[own], part.admittance(omega)) for own, part in parts))

    def reactions(
        self, divisions: Sequence[Sheeted], seen: Posed, frequency: float, limit: ImpedanceLimit | None = None,
        asked: FieldRequest | None = None,
    ) -> tuple[list[Complex], Complex | None]:
        """Return Delta Z of a plate for n coils, symmetric arrays (p, n, n) [ohm]; it is the first of the divisions.

        One a division; or, with a limit, its `forms`. With it what is asked of B of the first one's currents. All are
        as prepared together; frequency [Hz].
        """
        omega, found, field = 2 * np.pi * frequency, list[list[Complex]](), list[Complex]()
        for some, drive in _drives(self, seen):
            found.append(_by_forms(self, drive, _forms(self, tuple(divisions[1:]), omega, limit)))
            if asked is not None:
                fields = _fields(self, drive, (seen.turns[some], seen.places[some]), omega, asked.points)
                field += map(asked.of, fields)
        results = [np.concatenate(each) for each in zip(*found, strict=True)]
        return [(Z + np.swapaxes(Z, 1, 2)) / 2 for Z in results], np.concatenate(field, axis=1) if field else None

    def coupled(self, divisions: Sequence[Sheeted], seen: Posed, frequency: float) -> list[Complex]:
        """Return Y of coils and combinations, as `far.Moving`."""
        own, found = np.concatenate([drive for _, drive in _drives(self, seen)]), list[Complex]()
        for plate in divisions:
            Y = plate.admittance(2 * np.pi * frequency)
            answer = (Y @ own.reshape(-1, own.shape[2]).T).T.reshape(own.shape)
            found.append(np.concatenate([answer @ np.swapaxes(own, 1, 2), answer], axis=2))
        return found


def _drives(plate: Sheeted, seen: Posed) -> Iterator[tuple[slice, Array]]:
    """Yield which poses, some after others, and a_c of all classes (poses, n, sum of r); that of any division."""
    box, width, n = plate.box, plate.columns[-1].stop, len(seen.coils)
    points = box.points()
    step = max(1, min(HELD // (n * width), CACHED // len(points)))
    for start in range(0, len(seen.places), step):
        some = slice(start, start + step)
        posed = seen.some(some)
        p = len(posed.places)
        c, drive = np.empty((p, n, 3, len(points))), np.empty((p * n, width))
        for k, A in enumerate(posed.potentials(points, box.clearance)):
            c[:, k] = np.swapaxes(posed.turns[:, : A.shape[1]], 1, 2) @ box.coefficients(A)
        for basis, own in zip(plate.bases, plate.columns, strict=True):
            drive[:, own] = c.reshape(p * n, -1)[:, basis.rows] @ basis.fields
        yield some, drive.reshape(p, n, width)


def _fields(
    plate: Sheeted, drive: Array, poses: tuple[Array, Array], omega: float, points: Array
) -> Iterator[Complex]:
    """Yield B of what drives (p, n, r) cause, some poses after others, (p, k, 3, n) [T/A]."""
    at, moments = _moments(plate, omega)
    turned = np.swapaxes(poses[0], 1, 2)
    answer: Complex = (drive.reshape(-1, drive.shape[2]) @ moments).view(complex)
    each, places = answer.reshape(*drive.shape[:2], -1, 3) @ turned[:, None], at @ turned + poses[1][:, None]
    step = max(1, CACHED // (len(points) * len(at)))
    for k in range(0, len(places), step):
        yield biot_savart(places[k : k + step], each[k : k + step], points)


@latest(4, owned=True)
def _moments(plate: Sheeted, omega: float) -> tuple[Array, Array]:
    """Return points of a plate (q, 3) whose moments make its field below, and these by drives, (r, 6 q), complex."""
    few, carried = few_points(plate, plate.box.clearance, _POINT)
    each = np.tensordot(carried, radiated(plate, np.eye(plate.columns[-1].stop)), axes=1)
    moments = plate.admittance(omega) @ each.reshape(-1, each.shape[2]).T / (1j * omega)
    return plate.box.points()[few], np.ascontiguousarray(moments).view(float)


@latest(4, owned=True)
def _forms(plate: Sheeted, others: tuple[Sheeted, ...], omega: float, limit: ImpedanceLimit | None) -> _Forms:
    """Return class by class the first ones of a limit's forms of Y, or Y of each division; U; and other forms on U.

    Forms of Y are (r, f, 2, r), real and imaginary part apart.
    """
    first, each = 1 + len(others) if limit is None else 1, (plate, *others)
    answers = [[part.admittance(omega) for part in parts] for parts in zip(*(p.classes for p in each), strict=True)]
    by_class = answers if limit is None else list(map(limit.forms, answers))
    whole = [_apart(found[:first]) for found in by_class]
    strongest = np.max([np.abs(Y[:, 0]).max(axis=(0, 2)) for Y in whole], axis=0)
    few, steps = zip(*(_shown(_apart(found[first:], len(found[0])), strongest) for found in by_class), strict=True)
    return whole, few, steps


def _apart(forms: Sequence[Complex], size: int = 0) -> Array:
    """Return the real and the imaginary parts of f forms (r, r), (r, f, 2, r)."""
    each = [np.stack([Y.real, Y.imag], axis=1) for Y in forms]
    return np.stack(each, axis=1) if each else np.zeros((size, 0, 2, size))


def _shown(forms: Array, strongest: Array) -> tuple[Array, Array]:
    """Return the directions U (r, s) in which forms are not weak beside the strongest of each part, and U^T . U."""
    flat = (forms / strongest[:, None]).reshape(len(forms), -1)
    values, V = np.linalg.eigh(flat @ flat.T)
    U = V[:, values > _SHOWN**2]
    return U, np.ascontiguousarray(np.einsum("is,ifkj,jt->sfkt", U, forms, U, optimize=True))


def _by_forms(plate: Sheeted, drive: Array, forms: _Forms) -> list[Complex]:
    """Return the forms of Delta Z (p, n, n) for drives."""
    total: list[Complex] = []
    parts = [drive[..., own] for own in plate.columns]
    for each, seen in ((forms[0], parts), (forms[2], [a @ U for a, U in zip(parts, forms[1], strict=True)])):
        f = each[0].shape[1]
        found = np.sum([_products(a, Y) for a, Y in zip(seen, each, strict=True)], axis=0)
        total += [np.asarray(found[:, :, k, 0] + 1j * found[:, :, k, 1]) for k in range(f)]
    return total


def _products(a: Array, Y: Array) -> Array:
    """Return a^T Y a of drives (p, n, r) and forms (r, f, 2, r), shape (p, n, f, 2, n)."""
    (p, n, r), (f, parts) = a.shape, Y.shape[1:3]
    answer = (a.reshape(p * n, r) @ Y.reshape(r, f * parts * r)).reshape(p, n * f * parts, r)
    return (answer @ np.swapaxes(a, 1, 2)).reshape(p, n, f, parts, n)
