"""What a pose costs in the three-dimensional model: the coils' potential at some points of the plate, and products.

A polynomial field on the plate's bounding box is known from its values at the box's Chebyshev points; a class of modes
sees few combinations of them (`modes`). For each coil c, with A in the plate's own axes,

    a_c = transform^T A(points),    Delta Z_cd = sum over classes a_c^T Y(omega) a_d.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.magnetics.space.modes import Box, Sheeted
from sits_mech.quantities import Array, Complex
from sits_mech.scene.sensor import Coil

_CHUNK = 200_000  # points held at once


def reactions(
    coils: tuple[Coil, ...], windings: str, plates: Sequence[Sheeted], poses: tuple[Array, Array], frequency: float
) -> list[Complex]:
    """Return what a plate does to the coils' impedance.

    Parameters
    ----------
    coils : tuple of Coil
        n coils.
    windings : str
        "rings" or "spiral".
    plates : sequence of Sheeted
        The plate, divided in one or several ways, as prepared together.
    poses : tuple of ndarray
        Rotations (p, 3, 3) and places (p, 3) of the bottom face's centre [m].
    frequency : float
        [Hz]

    Returns
    -------
    list of ndarray, shapes (p, n, n)
        Delta Z, one array a division, symmetric [ohm].
    """
    admittances = [[part.admittance(2 * np.pi * frequency) for part in plate.classes] for plate in plates]
    results = [np.empty((poses[1].shape[0], len(coils), len(coils)), dtype=complex) for _ in plates]
    for some, drive in drives(coils, windings, plates[0], poses):
        for result, Y in zip(results, admittances, strict=True):
            result[some] = _reaction(Y, drive)
    return results


def drives(
    coils: tuple[Coil, ...], windings: str, plate: Sheeted, poses: tuple[Array, Array]
) -> Iterator[tuple[slice, Array]]:
    """Yield, for some poses after others, what a plate sees of each coil's potential.

    Parameters
    ----------
    coils, windings, poses
        As in `reactions`.
    plate : Sheeted
        Any of its divisions: they see the same combinations.

    Yields
    ------
    slice, ndarray
        Which poses; a_c of all classes side by side, shape (poses, n, sum of r).
    """
    turns, places = poses
    box, nodes = plate.box, box_points(plate.box)
    p, q = places.shape[0], nodes.shape[0]
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * box.half + (0.0, 0.0, box.half[2])
    extremes = _moved(corners, turns, places).reshape(-1, 3)
    fields = [coil_potential(coil, windings, extremes, p * q) for coil in coils]
    step = max(1, _CHUNK // q)
    for start in range(0, p, step):
        some = slice(start, start + step)
        points = _moved(nodes, turns[some], places[some]).reshape(-1, 3)
        A = np.stack([field(points).reshape(-1, q, 3) @ turns[some] for field in fields], axis=1)
        A = np.swapaxes(A, 2, 3).reshape(-1, 3 * q)  # one large product: the transform does not fit the cache
        yield some, (A @ plate.transform).reshape(-1, len(coils), plate.transform.shape[1])


def _reaction(admittances: Sequence[Complex], drives: Array) -> Complex:
    """Sum of the classes' reactions for drives (p, n, all classes' r)."""
    p, n, _ = drives.shape
    total = np.zeros((p, n, n), dtype=complex)
    start = 0
    for Y in admittances:
        drive = drives[..., start : start + Y.shape[0]]
        flat = drive.reshape(p * n, -1)
        answer = (flat @ Y.real + 1j * (flat @ Y.imag)).reshape(p, n, -1)
        total += np.einsum("pcr,pdr->pcd", answer, drive)
        start += Y.shape[0]
    return np.asarray((total + np.swapaxes(total, 1, 2)) / 2)


def box_points(box: Box) -> Array:
    """Return the Chebyshev points of the box (z fastest) from the bottom face's centre, shape (q, 3) [m]."""
    axes = [h * np.cos(np.pi * (np.arange(n) + 0.5) / n) for h, n in zip(box.half, box.order, strict=True)]
    return np.asarray(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) + (0.0, 0.0, box.half[2]))


def _moved(points: Array, turns: Array, places: Array) -> Array:
    """Points (q, 3) of the target in every pose, shape (p, q, 3)."""
    return np.asarray(np.einsum("pij,qj->pqi", turns, points) + places[:, None, :])
