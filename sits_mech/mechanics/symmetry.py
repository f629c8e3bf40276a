"""Identify loads that are images of each other: mirrors and turns of pad and target, and their action on a load.

A turn or a mirror image Q of the plane z = 0 takes forces and shifts as vectors, moments and rotations as axial ones,

    (F_x, F_y), (d_h, d_y)  ->  Q (...),         (M_x, M), (alpha_x, alpha)  ->  det Q  Q (...),
    F_z, d_v  as they are,                       M_z, alpha_z  ->  det Q (...),

one matrix for loads and poses. A pad that is its own image answers the image of a load with the image of the pose: of
all images of a load one, the `standard` one, is solved. It lies in the plane y = 0 where any of them does, for half the
pad carries that. A rectangle has two mirrors, a square four and quarter turns, of a disc on a disc all turns are there:
shear in one direction without other moments than its own is a load in the plane, turned.

Coils play no part. A mesh of a square pad is its own image, that of a disc for quarter turns alone: the difference
between other directions is discretisation error, within the stated one.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from sits_mech.quantities import POSE, Array, Equilibrium, Pose, Wrench
from sits_mech.scene.sensor import Sensor, shape_on_cover

_POLAR, _AXIAL = np.array([0, 3]), np.array([4, 2])  # places of x and y in a wrench and a pose
_LEFT = 1e-12  # of a turned load: what is less is rounding


@dataclass(frozen=True)
class Symmetry:
    """Symmetry of a pad with its target."""

    kind: Literal["none", "rectangle", "square", "disc"] = "none"

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image in x, and in y."""
        return self.kind != "none"

    @cached_property
    def images(self) -> tuple[Array, ...]:
        """Matrices of its mirrors and quarter turns, the identity first, shape (6, 6) each."""
        if self.kind == "none":
            return (np.eye(6),)
        mirrors = [np.diag(signs) for signs in itertools.product((1.0, -1.0), repeat=2)]
        swaps = [] if self.kind == "rectangle" else [Q[::-1] for Q in mirrors]
        return tuple(_matrix(Q) for Q in (*mirrors, *swaps))

    def standard(self, load: Wrench) -> tuple[Wrench, Array]:
        """Return the image of a load that is solved, and the matrix from it, and its pose, back to the load."""
        found, back = self._foremost(load)
        turned = self._turned(found) if self.kind == "disc" else None
        if turned is None:
            return found, back
        nearer, turn = turned
        found, more = self._foremost(nearer)
        return found, back @ turn @ more

    def without_images(self, loads: Iterable[Wrench]) -> list[Wrench]:
        """Return the loads to be solved, without those that are images of others."""
        return list(dict.fromkeys(self.standard(load)[0] for load in loads))

    def projection(self, *loads: Wrench) -> Array:
        """Return the projection of a pose on the symmetries that all the loads have."""
        each = np.array([load.components for load in loads])
        return np.asarray(np.mean([image for image in self.images if np.array_equal(each @ image.T, each)], axis=0))

    def _foremost(self, load: Wrench) -> tuple[Wrench, Array]:
        """Return the image by `images` that comes first: in the plane, then by F_x, M, F_y, M_x, M_z, the largest."""
        found = [(Wrench(*(float(part) + 0.0 for part in image @ load.components)), image) for image in self.images]
        first = max(found, key=lambda pair: (not pair[0].out_of_plane, *pair[0].components[[0, 2, 3, 4, 5]]))
        return first[0], first[1].T

    def _turned(self, load: Wrench) -> tuple[Wrench, Array] | None:
        """Return a load turned until its shear, or else its tilting moment, is along the axis, and the way back.

        None if it is already. Rounded to twelve digits, so that loads of one size in any direction become the same
        load.
        """
        shear, tilt = load.components[_POLAR], load.components[_AXIAL]
        along, across = shear if np.any(shear != 0.0) else (tilt[1], -tilt[0])
        if across == 0.0:
            return None
        size = np.hypot(along, across)
        back = _matrix(np.array([[along, -across], [across, along]]) / size)
        found = back.T @ load.components
        for places in (_POLAR, _AXIAL):
            small = np.abs(found[places]) < _LEFT * np.hypot(*found[places])
            found[places] = np.where(small, 0.0, found[places])
        return Wrench(*(float(f"{part:.12g}") + 0.0 for part in found)), back


def symmetry_of(sensor: Sensor) -> Symmetry:
    """Return the symmetry of pad and target; none is known of a user's mesh, an outline or a touch off the middle."""
    target, elastomer = sensor.target, sensor.elastomer
    if sensor.touch is not None and sensor.touch.place != (0.0, 0.0):
        return Symmetry()
    if target is None or target.loops or (elastomer is not None and elastomer.mesh is not None):
        return Symmetry()
    parts = [(target.extent, target.is_round)]
    parts += [] if elastomer is None else [(elastomer.extent, elastomer.is_round)]
    if (touch := shape_on_cover(sensor)) is not None and not touch.is_round:
        parts.append((np.ptp(touch.border, axis=0).tolist(), False))
    if all(is_round for _, is_round in parts):
        return Symmetry("disc")
    return Symmetry("square" if all(size[0] == size[1] for size, _ in parts) else "rectangle")


def image_of(matrix: Array, components: ArrayLike) -> Array:
    """Return the image of a load or a pose (6,); inf and nan spread only where the matrix is not zero."""
    return np.asarray((matrix * np.where(matrix == 0.0, 0.0, components)).sum(axis=1) + 0.0)


def image_of_rest(found: Equilibrium, matrix: Array, wrench: Wrench) -> Equilibrium:
    """Return the image of an equilibrium by a matrix, (6, 6), without state; errors have no sign."""
    pose, error = image_of(matrix, found.pose.components), image_of(np.abs(matrix), found.error.components)
    shared = np.array([image_of(matrix, part) for part in found.shared]).reshape(-1, len(POSE))
    acting = found.acting and Wrench(*image_of(matrix, found.acting.components).tolist())
    return replace(
        found, wrench=wrench, pose=Pose.of(pose), error=Pose.of(error), state=np.zeros(0), finer=(), shared=shared,
        slopes=found.slopes @ matrix.T, acting=acting,
    )


def symmetrised(found: Equilibrium, symmetry: Symmetry, *loads: Wrench) -> Equilibrium:
    """Return an equilibrium without what the symmetry of pad and loads forbids."""
    kept = symmetry.projection(*loads)
    if np.array_equal(kept, np.eye(len(kept))):
        return found
    return replace(image_of_rest(found, kept, found.wrench), state=found.state, finer=found.finer)


def _matrix(Q: Array) -> Array:
    """Return the action of a turn or mirror (2, 2) of the plane z = 0 on a wrench or a pose, shape (6, 6)."""
    handed = round(float(np.linalg.det(Q)))
    found = np.diag([0.0, 1.0, 0.0, 0.0, 0.0, float(handed)])
    found[np.ix_(_POLAR, _POLAR)], found[np.ix_(_AXIAL, _AXIAL)] = Q, handed * Q
    return found
