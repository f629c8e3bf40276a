"""What do discs on the axis of one coil do to it, together? Rings of rectangular section: an independent reference.

Every disc is divided into coaxial rings, with resistances R and mutual inductances L (`coils.loops`), the coil's flux g
through each in closed form; no field is expanded and no symmetry used:

    Delta Z = omega^2 g^T (R + j omega L)^-1 g.

Halving all cells and ``(4 fine - coarse) / 3`` takes the error's leading term away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.geometry.windings import Sections, coil_sections
from sits_mech.magnetics.coils.loops import paired_mutual
from sits_mech.magnetics.modes import skin_depth
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Coil

Disc = tuple[float, float, float, float]  # radius, z of the middle, thickness [m], conductivity [S/m]


def joint_reaction(coil: Coil, discs: Sequence[Disc], frequency: float, *, size: float) -> tuple[complex, complex]:
    """Return Delta Z of coaxial discs [ohm], and the last step of the extrapolation; `size` is the largest cell [m]."""
    coarse, fine = (_reaction(coil, discs, frequency, size, parts) for parts in (1, 2))
    return (4 * fine - coarse) / 3, (fine - coarse) / 3


def _reaction(coil: Coil, discs: Sequence[Disc], frequency: float, size: float, parts: int) -> complex:
    cells = [_divided(disc, frequency, size, parts) for disc in discs]
    rings = _joined(cells)
    omega, sigma = 2 * np.pi * frequency, np.repeat([disc[3] for disc in discs], [part.radius.size for part in cells])
    R = 2 * np.pi * rings.radius / (sigma * rings.width * rings.height)
    L = paired_mutual(_column(rings), rings, (2, 1), (3, 1))
    g = paired_mutual(_column(coil_sections(coil)), rings, (2, 1), (3, 1)).sum(0)
    return complex(omega**2 * g @ np.linalg.solve(np.diag(R) + 0.5j * omega * (L + L.T), g))


def _divided(disc: Disc, frequency: float, size: float, parts: int) -> Sections:
    """Rings of one disc, finest at its faces and rim."""
    radius, middle, thickness, conductivity = disc
    first = 0.7 * skin_depth(frequency, conductivity)
    half = _graded(thickness / 2, first, size, parts)
    z = middle + np.concatenate([-half[:0:-1], half])
    r = _graded(radius, first, size, parts)
    R, Z = np.meshgrid((r[1:] + r[:-1]) / 2, (z[1:] + z[:-1]) / 2)
    W, H = np.meshgrid(np.diff(r), np.diff(z))
    return Sections(R.ravel(), Z.ravel(), W.ravel(), H.ravel())


def _graded(length: float, first: float, largest: float, parts: int) -> Array:
    """Nodes from 0 to a length, finest at the end; each cell in equal parts."""
    nodes, step = [length], min(first, largest, length)
    while nodes[-1] > step / 2:
        nodes.append(nodes[-1] - step)
        step = min(1.6 * step, largest)
    ends = length - (length - np.array(nodes[::-1])) * length / (length - nodes[-1])
    return np.interp(np.arange(parts * (ends.size - 1) + 1) / parts, np.arange(ends.size), ends)


def _joined(parts: Sequence[Sections]) -> Sections:
    return Sections(*(np.concatenate([getattr(part, name) for part in parts])
                      for name in ("radius", "z", "width", "height")))


def _column(rings: Sections) -> Sections:
    return Sections(rings.radius[:, None], rings.z[:, None], rings.width[:, None], rings.height[:, None])
