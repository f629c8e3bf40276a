"""The coils' field on the plate's mid-line: what a pose costs in the planar integral model.

A coil's bars carry s_k = +-1 A per ampere of the coil and have the complex potential f with A = Re f,

    f'(p) = -(mu0 / 2 pi) sum_k s_k [1 / (p - p_k) + conj(p_k) / (R_b^2 - p conj(p_k))],    p = x + j z;

the second term is the image in a circle of radius R_b about the origin where A = 0 (absent for R_b = infinity).
Each bar is a grid of Gauss filaments, as many as its distance asks for. On the mid-line of a plate of width w and
thickness t, with zeta its own coordinate on [-1, 1],

    p(zeta) = d_h + j d_v + exp(-j alpha) (zeta w/2 + j t/2),    df/dzeta = f'(p) exp(-j alpha) w/2,

and n values of df/dzeta at Chebyshev points give n + 1 coefficients of f, the constant apart: only a plate with a
free net current feels that one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0

from sits_mech.geometry.windings import Bars
from sits_mech.quantities import Array, Pose

Complex = NDArray[np.complex128]
_PAIRS = 30_000  # pairs of points and filaments held at once, so that they stay in the cache


@dataclass(frozen=True)
class Filaments:
    """All coils' currents as line currents.

    Attributes
    ----------
    x, z : ndarray, shape (k,)
        [m].
    current : ndarray, shape (k, n)
        Current of each filament per ampere in each coil.
    radius : float or None
        R_b of the grounded circle; None for free space [m].
    """

    x: Array
    z: Array
    current: Array
    radius: float | None


def filaments(coils: tuple[Bars, ...], clearance: float, error: float, radius: float | None) -> Filaments:
    """Replace bars by Gauss filaments that are right to `error` from `clearance` above the uppermost bars' faces on."""
    x, z, columns = [], [], []
    for number, bars in enumerate(coils):
        (gx, wx), (gz, wz) = (_gauss(side, clearance, error) for side in (bars.width, bars.thickness))
        x.append((bars.x[:, None, None] + bars.width / 2 * gx[:, None] + 0 * gz).ravel())
        z.append((bars.z[:, None, None] + 0 * gx[:, None] + bars.thickness / 2 * gz).ravel())
        current = np.zeros((x[-1].size, len(coils)))
        current[:, number] = (bars.sign[:, None, None] * wx[:, None] * wz / 4).ravel()
        columns.append(current)
    return Filaments(np.concatenate(x), np.concatenate(z), np.concatenate(columns), radius)


def _gauss(side: float, clearance: float, error: float) -> tuple[Array, Array]:
    """Gauss rule for 1/(p - p_k) over a side of a bar, from its own ellipse of convergence."""
    rate = np.arcsinh(2 * (clearance + side / 2) / side)
    count = max(1, int(np.ceil(-np.log(error) / (2 * rate))))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def coefficients(source: Filaments, pose: Pose, size: tuple[float, float], order: int) -> Complex:
    """Return the Chebyshev coefficients of the coils' complex potential on the plate's mid-line.

    Parameters
    ----------
    source : Filaments
    pose : Pose
        Fields of shape (p,).
    size : tuple of float
        Width and thickness of the plate [m].
    order : int
        Number of coefficients.

    Returns
    -------
    ndarray, shape (p, n_coils, order)
        [V s/m per A]; the constant's real part is right only where the source has a radius, its imaginary part is 0.
    """
    angle = _chebyshev_angles(order - 1)
    middle, turn = _middle(pose, size[1])
    points = middle + turn * (np.cos(angle) * size[0] / 2)
    slope = _slope(source, points.ravel()).reshape(*points.shape, -1) * (turn * size[0] / 2)[..., None]
    matrix = _integration(angle, order)
    result = np.swapaxes(matrix @ slope.real + 1j * (matrix @ slope.imag), 1, 2)
    if source.radius is not None:  # at zeta = 0, T_n is cos(n pi / 2)
        others = (result @ np.cos(np.pi / 2 * np.arange(order))).real
        result[:, :, 0] = _potential(source, middle.ravel(), source.radius) - others
    return result


def circle_powers(pose: Pose, size: tuple[float, float], order: int, radius: float, terms: int) -> Complex:
    """Return the Chebyshev coefficients of ``(p / R_b)^m, m = 1 ... terms``; shape (p, terms, order)."""
    angle = _chebyshev_angles(order)
    middle, turn = _middle(pose, size[1])
    points = (middle + turn * (np.cos(angle) * size[0] / 2)) / radius
    powers = points[:, None, :] ** np.arange(1, terms + 1)[:, None]
    transform = 2.0 / order * np.cos(np.arange(order)[:, None] * angle)
    transform[0] /= 2
    return np.asarray(powers @ transform.T)


def _chebyshev_angles(count: int) -> Array:
    """Angles of the Chebyshev points of the first kind."""
    return np.asarray(np.pi * (np.arange(count) + 0.5) / count)


def _middle(pose: Pose, thickness: float) -> tuple[Complex, Complex]:
    """Centre of the section and the factor exp(-j alpha), both of shape (p, 1)."""
    turn = np.exp(-1j * np.atleast_1d(pose.alpha))[:, None]
    centre = (np.atleast_1d(pose.d_h) + 1j * np.atleast_1d(pose.d_v))[:, None]
    return centre + 0.5j * thickness * turn, turn


def _integration(angle: Array, order: int) -> Array:
    """Matrix from values of df/dzeta at Chebyshev points to the coefficients of f; shape (order, count)."""
    count = angle.size
    n = np.arange(order + 1)
    values = 2.0 / count * np.cos(n[:, None] * angle)
    values[0] /= 2
    values[count:] = 0.0
    matrix = np.zeros((order, count))
    matrix[1:] = (values[:-2] - values[2:]) / (2 * n[1:-1, None])
    matrix[1] = values[0] - values[2] / 2
    return matrix


def _slope(source: Filaments, points: Complex) -> Complex:
    """f' of every coil at points, shape (points, coils)."""
    result = np.empty((points.size, source.current.shape[1]), dtype=complex)
    step = max(1, _PAIRS // source.x.size)
    for start in range(0, points.size, step):
        part = slice(start, start + step)
        dx = points.real[part, None] - source.x
        dz = points.imag[part, None] - source.z
        inverse = 1.0 / (dx * dx + dz * dz)
        dx *= inverse
        dz *= inverse
        result[part] = dx @ source.current - 1j * (dz @ source.current)
        if source.radius is not None:
            mirror = source.x - 1j * source.z
            result[part] += (mirror / (source.radius**2 - points[part, None] * mirror)) @ source.current
    return np.asarray(-mu_0 / (2 * np.pi) * result)


def _potential(source: Filaments, points: Complex, radius: float) -> Array:
    """Re f of every coil at points inside the grounded circle, shape (points, coils)."""
    places = source.x + 1j * source.z
    image = radius - points[:, None] * places.conj() / radius
    logs = np.log(np.abs(points[:, None] - places)) - np.log(np.abs(image))
    return np.asarray(-mu_0 / (2 * np.pi) * logs @ source.current)
