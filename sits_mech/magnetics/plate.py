"""The planar target's own eddy currents: a rectangular plate as bars, seen through Chebyshev fields on its mid-line.

Unknowns: the currents i [A] of rectangular bars along y, per metre of depth, graded to the faces and the ends:

    R_i = 1 / (sigma a_i b_i) [ohm/m],    L_ij = -(mu0 / 2 pi) <ln(r / R_b)>_ij [H/m],

closed form in `kernels`. Isolated plate: sum i = 0, and the radius R_b of the return drops out. Plate whose current
returns where A = 0: R_b is that circle's radius; its image of the target's own current is `bars`' business.

The coils' potential is harmonic over the plate. In the plate's own coordinate ``zeta = (xi + j eta) / (w/2)`` (mid-line
on [-1, 1]) it is the real part of an analytic function, and n complex Chebyshev coefficients on the mid-line carry it
through the whole section:

    A = Re sum_n c_n T_n(zeta) = sum_n Re c_n Re T_n - Im c_n Im T_n.

Under the plate's two mirror symmetries Re T_n is even in eta, with the parity of n in xi; Im T_n is odd in eta, with
the opposite parity in xi. The four classes decouple: one quadrant's cells carry each.

Neglected: the plate's ends along y (planar), displacement current.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0

from sits_mech.geometry.section import Cells, graded, quadrant_cells
from sits_mech.magnetics.kernels import mean_log
from sits_mech.magnetics.modes import Modes, eddy_modes
from sits_mech.quantities import Array, SolveFailed, SolveReport

_GAUSS_X, _GAUSS_Z = np.polynomial.legendre.leggauss(4), np.polynomial.legendre.leggauss(2)
_MOST_BARS = 11_200  # under a minute and two gigabytes
PARITIES = ((0, "re"), (1, "re"), (0, "im"), (1, "im"))  # parity of n, part of T_n


@dataclass(frozen=True)
class Resolution:
    """How fine the plate is divided.

    Attributes
    ----------
    skin : float
        First cell at the surface over the skin depth.
    growth : float
        Ratio of neighbouring cells.
    along : float
        Largest cell along the plate over the clearance to the coils, where the induced field shapes the current;
        and largest cell through the plate over its thickness.
    resistive : float
        The same where resistance shapes it (a plate thinner than the skin): its error then wants more cells.
    terms : float
        Digits (natural logarithm) that the Chebyshev series keeps.
    """

    skin: float
    growth: float
    along: float
    resistive: float
    terms: float


@dataclass(frozen=True)
class PreparedPlate:
    """A plate prepared for all poses with at least its clearance and all frequencies up to its skin depth.

    Attributes
    ----------
    half_width : float
        w / 2 [m].
    thickness : float
        t [m].
    order : int
        Number n of complex Chebyshev coefficients.
    modes : tuple of Modes
        One set a symmetry class, in the order of PARITIES.
    cells : Cells
        Bars of the quadrant x, z > 0 about the section's centre.
    """

    half_width: float
    thickness: float
    order: int
    modes: tuple[Modes, ...]
    cells: Cells

    @property
    def bars(self) -> int:
        """Number of bars in the whole section."""
        return 4 * self.cells.x.size

    def admittance(self, omega: float, order: int) -> NDArray[np.complex128]:
        """Return Y(omega) for the first `order` coefficients, (Re c, Im c), so that ``c^T Y c`` is in ohm/m."""
        Y = np.zeros((2 * order, 2 * order), dtype=complex)
        for (parity, part), modes in zip(PARITIES, self.modes, strict=True):
            rows = np.arange(parity, order, 2)
            place = rows + (0 if part == "re" else order)
            Y[np.ix_(place, place)] = modes.admittance(omega)[: rows.size, : rows.size]
        return Y

    def currents(self, omega: float, order: int) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the centres xi + j eta of all bars and their currents for a unit of each coefficient.

        Returns
        -------
        places : ndarray, shape (b,)
            From the centre of the section [m].
        currents : ndarray, shape (b, 2 order)
            [A per V s/m].
        """
        quadrant = self.cells.x + 1j * self.cells.z
        places = np.concatenate([quadrant, -quadrant.conj(), quadrant.conj(), -quadrant])
        currents = np.zeros((places.size, 2 * order), dtype=complex)
        for (parity, part), modes in zip(PARITIES, self.modes, strict=True):
            rows = np.arange(parity, order, 2)
            sign_x, sign_z = _signs(parity, part)
            own = modes.currents(omega)[:, : rows.size] / 2.0  # the coupling counts all four quadrants in its square
            copies = [sign * own for sign in (1.0, sign_x, sign_z, sign_x * sign_z)]
            currents[:, rows + (0 if part == "re" else order)] = np.concatenate(copies)
        return places, currents


def prepare_plate(
    size: tuple[float, float], conductivity: float, resolution: Resolution, *, clearance: float, skin_depth: float,
    return_radius: float | None = None,
) -> PreparedPlate:
    """Divide a plate and find its modes.

    Parameters
    ----------
    size : tuple of float
        Width w and thickness t [m].
    conductivity : float
        [S/m].
    resolution : Resolution
    clearance : float
        Smallest distance of the plate to a coil that has to be resolved [m].
    skin_depth : float
        Smallest skin depth that has to be resolved [m].
    return_radius : float, optional
        Radius R_b where A = 0 for a plate with free net current; None for an isolated plate [m].

    Raises
    ------
    SolveFailed
        If the plate is so wide for its clearance that its bars do not fit.
    """
    width, thickness = size
    order = series_order(width, thickness, clearance, resolution.terms)
    cells = divide(width, thickness, resolution, clearance=clearance, skin_depth=skin_depth)
    _check_size(cells, width, clearance)
    R = 1.0 / (conductivity * cells.width * cells.height)
    logs = _image_logs(cells, 1.0 if return_radius is None else return_radius)
    modes = []
    for parity, part in PARITIES:
        sign_x, sign_z = _signs(parity, part)
        L = -mu_0 / (2 * np.pi) * (logs[0] + sign_x * logs[1] + sign_z * logs[2] + sign_x * sign_z * logs[3])
        B = 2.0 * _means(cells, width / 2, np.arange(parity, order, 2), part)
        isolated = sign_x > 0 and sign_z > 0 and return_radius is None
        modes.append(eddy_modes(L, R, B, constraint=np.ones(R.size) if isolated else None))
    return PreparedPlate(width / 2, thickness, order, tuple(modes), cells)


def _signs(parity: int, part: str) -> tuple[float, float]:
    """Parities in xi and in eta of one class, as signs."""
    even_x = parity == (0 if part == "re" else 1)
    return (1.0 if even_x else -1.0), (1.0 if part == "re" else -1.0)


def _check_size(cells: Cells, width: float, clearance: float) -> None:
    """Refuse more bars than fit in memory and a minute."""
    bars = 4 * cells.x.size
    if bars > _MOST_BARS:
        raise SolveFailed(
            f"planar: a plate of {width * 1e3:.4g} mm at a clearance down to {clearance * 1e3:.3g} mm needs {bars} "
            f"bars for this tolerance, {_MOST_BARS} fit; ask for a larger tolerance, or for 'planar-fem'",
            SolveReport("planar", bars, 0, 0.0, 1.0, 0.0, "too many bars"),
        )


def divide(width: float, thickness: float, resolution: Resolution, *, clearance: float, skin_depth: float) -> Cells:
    """Return one quadrant's cells, graded to the surfaces."""
    inductive = thickness > 2 * skin_depth or skin_depth**2 / thickness < clearance / 25
    along = resolution.along if inductive else resolution.resistive
    largest = min(along * (clearance + thickness / 2), along * width / 4)
    first = resolution.skin * skin_depth
    nodes_x = graded(width / 2, min(first, largest), largest, resolution.growth)
    through = resolution.along * thickness
    nodes_z = graded(thickness / 2, min(first, through), through, resolution.growth)
    return quadrant_cells(nodes_x, nodes_z)


def series_order(width: float, thickness: float, clearance: float, terms: float) -> int:
    """Return how many Chebyshev coefficients a field singular `clearance` below the plate needs.

    The coefficients fall like rho^-n on the ellipse through the singularity, their effect on an energy like rho^-2n.
    """
    y = (clearance + thickness / 2) / (width / 2)
    return int(np.ceil(terms / (2 * np.arcsinh(y)))) + 3


def _image_logs(cells: Cells, unit: float) -> tuple[Array, Array, Array, Array]:
    """Mean ln(r / unit) from each cell to each cell's own place and its images in x, in z and in both."""
    x, z = cells.x, cells.z
    first = (cells.width[:, None], cells.height[:, None])
    second = (cells.width, cells.height)

    def logs(mirror_x: float, mirror_z: float) -> Array:
        dx, dz = mirror_x * x - x[:, None], mirror_z * z - z[:, None]
        return np.asarray(mean_log(dx, dz, first, second) - np.log(unit))

    return logs(1, 1), logs(-1, 1), logs(1, -1), logs(-1, -1)


def _means(cells: Cells, half_width: float, n: NDArray[np.int_], part: str) -> Array:
    """Mean of Re or -Im T_n over each cell, shape (len(n), cells)."""
    (gx, wx), (gz, wz) = _GAUSS_X, _GAUSS_Z
    x = cells.x[:, None, None] + cells.width[:, None, None] / 2 * gx[:, None]
    z = cells.z[:, None, None] + cells.height[:, None, None] / 2 * gz
    theta = np.arccos((x + 1j * z) / half_width)
    means = np.einsum("ncij,i,j->nc", np.cos(n[:, None, None, None] * theta), wx, wz) / 4
    return np.asarray(means.real if part == "re" else -means.imag)
