"""Kinematics of a point of the silicone, in space and in plane strain alike.

The deformation gradient F has k free components: nine in space, ``F_ij`` at ``3 i + j``; four in plane strain,
``(F_xx, F_xz, F_zx, F_zz)``, with ``F_yy = 1`` and no other one out of the plane. By these k components

    s = F : F           ds = 2 F                 d2s = 2 1
    J = det F           dJ = H = cof F           d2J = L
    r = cof F : cof F   dr                       d2r

where s and r are those of all nine components (in the plane ``s = 1 + F : F`` and ``r = F : F + J^2`` of the four).
With ``C = F^T F`` and ``B = F F^T``,

    space   L_ijkl = eps_ikm eps_jln F_mn,   dr = 2 (s F - B F),
            d2r_ijkl = 2 s d_ik d_jl + 2 F_ij F_kl + 2 L(H)_ijkl - 2 (d_ik C_jl + B_ik d_jl)
    plane   L constant,                      dr = 2 F + 2 J H,      d2r = 2 1 + 2 H x H + 2 J L

from ``r = ((tr C)^2 - tr C^2)/2``. L is nearly empty: 36 of its 81 entries in space, 4 of 16 in the plane, and so it is
added where it belongs rather than stored. Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), sections 2.4 and
6.6. Range: ``J > 0``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sits_mech.quantities import Array

_PLANE_L = np.array([[0.0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]])


POINTS = 1024
"""Points at a time, so that their tangents stay in the processor's cache."""

_Entries = tuple[tuple[int, int, int], ...]  # row, column, and which term stands there


def _space_L() -> _Entries:
    """Return the entries of L in space, of the terms (F, -F)."""
    even = [(i, (i + 1) % 3, (i + 2) % 3) for i in range(3)]
    turns = [(i, k, m, 0) for i, k, m in even] + [(k, i, m, 9) for i, k, m in even]
    return tuple(
        (3 * i + j, 3 * k + n, 3 * m + o + abs(sign - other)) for i, k, m, sign in turns for j, n, o, other in turns
    )


def _space_shears() -> _Entries:
    """Return the entries of ``d_ik C_jl + B_ik d_jl`` in space, of the terms (C, B)."""
    each = [(i, j, k) for i in range(3) for j in range(3) for k in range(3)]
    return (
        *((3 * i + j, 3 * i + k, 3 * j + k) for i, j, k in each),
        *((3 * j + i, 3 * k + i, 9 + 3 * j + k) for i, j, k in each),
    )


_SPACE_L, _SPACE_SHEARS = _space_L(), _space_shears()


class Principal(NamedTuple):
    """``F = U diag(stretch) V``, all three stretches (..., 3), rotations (..., d, d) of those in `within`."""

    stretch: Array
    U: Array
    V: Array
    within: tuple[int, ...]


@dataclass(frozen=True)
class Kinematics:
    """A deformation, and the derivatives of s, r and J by its k free components, computed when asked for."""

    F: Array  # (..., k)
    H: Array  # dJ/dF, (..., k)
    J: Array  # (...), positive

    @property
    def plane(self) -> bool:
        """Whether this is plane strain."""
        return bool(self.F.shape[-1] == 4)

    def part(self, some: slice) -> Kinematics:
        """Return some of the points, all counted along one axis."""
        k = self.F.shape[-1]
        return Kinematics(self.F.reshape(-1, k)[some], self.H.reshape(-1, k)[some], self.J.reshape(-1)[some])

    @cached_property
    def s(self) -> Array:
        """``F : F`` of all nine components, shape (...)."""
        found: Array = np.einsum("...i,...i->...", self.F, self.F)
        return found + 1.0 if self.plane else found

    @cached_property
    def r(self) -> Array:
        """``cof F : cof F`` of all nine components, shape (...)."""
        found: Array = np.einsum("...i,...i->...", self.H, self.H)
        return found + self.J**2 if self.plane else found

    @cached_property
    def dr(self) -> Array:
        """``dr/dF``, shape (..., k)."""
        if self.plane:
            return 2.0 * (self.F + self.J[..., None] * self.H)
        F = self.F.reshape(*self.J.shape, 3, 3)
        turned: Array = (F @ (F.swapaxes(-1, -2) @ F)).reshape(self.F.shape)
        return 2.0 * (self.s[..., None] * self.F - turned)

    def add_L(self, A: Array, factor: Array) -> None:
        """Add ``factor L``, factor (...), to contiguous tangents (..., k, k), in place."""
        if self.plane:
            A += factor[..., None, None] * _PLANE_L
        else:
            terms = factor[..., None] * self.F
            _add_entries(A, (terms, -terms), _SPACE_L)

    def add_d2r(self, A: Array, factor: Array) -> None:
        """Add ``factor d2r``, factor (...), to contiguous tangents (..., k, k), in place."""
        twice = 2.0 * factor[..., None]
        if self.plane:
            A += (twice * self.H)[..., :, None] * self.H[..., None, :]
            diagonal(A)[...] += twice
            self.add_L(A, 2.0 * factor * self.J)
            return
        F = self.F.reshape(*self.J.shape, 3, 3)
        C, B = F.swapaxes(-1, -2) @ F, F @ F.swapaxes(-1, -2)
        A += (twice * self.F)[..., :, None] * self.F[..., None, :]
        diagonal(A)[...] += twice * self.s[..., None]
        _add_entries(A, (twice * self.H, -twice * self.H), _SPACE_L)
        _add_entries(A, (-twice * C.reshape(self.F.shape), -twice * B.reshape(self.F.shape)), _SPACE_SHEARS)

    def principal(self) -> Principal:
        """Return the principal stretches, that along y second in the plane, and the rotations to them."""
        if not self.plane:
            U, stretch, V = np.linalg.svd(self.F.reshape(*self.J.shape, 3, 3))
            return Principal(stretch, U, V, (0, 1, 2))
        xx, xz, zx, zz = np.moveaxis(self.F, -1, 0)
        large = 0.5 * (np.hypot(xx + zz, zx - xz) + np.hypot(xx - zz, zx + xz))
        turn, strain = np.arctan2(zx - xz, xx + zz), np.arctan2(zx + xz, xx - zz)
        stretch = np.stack([large, np.ones_like(large), self.J / large], axis=-1)
        return Principal(stretch, _turn(0.5 * (turn + strain)), _turn(0.5 * (turn - strain)), (0, 2))


def in_space(F: Array) -> Kinematics:
    """Return the kinematics of F in space, shape (..., 9), components ``3 i + j``."""
    H = np.empty_like(F, order="C")
    for i in range(3):
        b, c = 3 * ((i + 1) % 3), 3 * ((i + 2) % 3)
        for j in range(3):
            m, n = (j + 1) % 3, (j + 2) % 3
            np.multiply(F[..., b + m], F[..., c + n], out=H[..., 3 * i + j])
            H[..., 3 * i + j] -= F[..., b + n] * F[..., c + m]
    J: Array = np.einsum("...i,...i->...", F[..., :3], H[..., :3])
    return Kinematics(F, H, J)


def in_plane(F: Array) -> Kinematics:
    """Return the kinematics of F in plane strain, shape (..., 4): ``F_xx, F_xz, F_zx, F_zz``."""
    H: Array = F[..., ::-1] * np.array([1.0, -1.0, -1.0, 1.0])
    J: Array = np.asarray(F[..., 0] * F[..., 3] - F[..., 1] * F[..., 2])
    return Kinematics(F, H, J)


def diagonal(A: Array) -> Array:
    """Return the diagonals of tangents as a view to write to, shape (..., k)."""
    return np.asarray(np.einsum("...ii->...i", A))


def _turn(angle: Array) -> Array:
    """Return rotations by an angle in the plane, shape (..., 2, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c, -s, s, c], axis=-1).reshape(*angle.shape, 2, 2)


def _add_entries(A: Array, terms: tuple[Array, Array], entries: _Entries) -> None:
    """Add terms, two of shape (..., 9), to entries of tangents in space, in place."""
    flat, (first, second) = A.reshape(-1, 9, 9), (part.reshape(-1, 9) for part in terms)
    for start in range(0, len(flat), POINTS):
        part = slice(start, start + POINTS)
        block, rows = flat[part], np.concatenate([first[part].T, second[part].T])
        for row, column, term in entries:
            block[:, row, column] += rows[term]
