"""The coils in the section y = 0 without metal: bars, their potential, inductance and resistance, per metre of depth.

A bar of width a and thickness b carries 1 A along y, uniformly. With p = x + j z from its centre in its own axes, its
potential is

    A = -(mu0 / 2 pi) <ln|p - p'|>,    <ln> = [G(x', z')] / (a b) - 3/2 over the corners x' = x +- a/2, z' = z +- b/2,
    G = 1/2 [x z ln(x^2 + z^2) + x^2 atan(z/x) + z^2 atan(x/z)],

the double difference of G; beyond twenty of its longest sides, where that loses digits, nine Gauss filaments stand
for it. Bars and bars of flat coils: `kernels`, in closed form.
A coil is the sum of its bars with their signs, there and back. On a curved substrate (a cylinder of radius r_s below,
axis along y) a flat place (x, z) goes to

    x -> (r_s + z) sin(x / r_s),    z -> (r_s + z) cos(x / r_s) - r_s,

and the bars tilt clockwise by x / r_s. Where A = 0 on a circle of radius R_b about the origin (the return of a target's
free net current), each bar at p_k has the image ``+(mu0 / 2 pi) ln|R_b - p conj(p_k) / R_b|`` with the field of a line.

Neglected: skin and proximity effect in the tracks (uniform current), the ends along y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import product

import numpy as np
from scipy.constants import mu_0

from sits_mech.geometry.plates import return_radius
from sits_mech.geometry.tracks import coil_bars
from sits_mech.geometry.windings import Bars
from sits_mech.magnetics.answer import Kind, Reaction, answer
from sits_mech.magnetics.coils.resistance import coils_alone, track_conductivity
from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.quantities import Array, Complex, Impedance, Pose
from sits_mech.scene.sensor import Sensor

_FAR = 20.0  # in the longest side of a bar
_GAUSS = np.polynomial.legendre.leggauss(3)
_GAUSS_FINE = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True)
class CoilBars:
    """One coil's bars in the section y = 0, all of one size, in series."""

    place: Complex  # (n,) centres x + j z [m]
    tilt: Array  # (n,) clockwise rotation of each bar [rad]
    sign: Array  # (n,) +1 where a positive coil current runs along +y
    width: float  # [m]
    thickness: float  # [m]


def tracks(sensor: Sensor) -> tuple[CoilBars, ...]:
    """Return every coil's bars, on the curved substrate if there is one."""
    found, radius = list[CoilBars](), sensor.substrate_radius
    for bars in map(coil_bars, sensor.coils):
        place, angle = bars.x + 1j * bars.z, np.zeros_like(bars.x)
        if radius is not None:
            angle = bars.x / radius
            place = 1j * ((radius + bars.z) * np.exp(-1j * angle) - radius)
        found.append(CoilBars(place, angle, bars.sign, bars.width, bars.thickness))
    return tuple(found)


def coil_potentials(coils: tuple[CoilBars, ...], points: Complex, radius: float | None = None) -> Array:
    """Return the vector potential of every coil at places x + j z (p,) [m], shape (p, n_coils) [V s/m per A].

    `radius` is R_b of a circle about the origin where A = 0; None for free space [m].
    """
    columns = [sum(_bar_logs(coil, k, points, radius) * coil.sign[k] for k in range(coil.sign.size)) for coil in coils]
    return -mu_0 / (2 * np.pi) * np.column_stack(columns)


def _bar_logs(coil: CoilBars, k: int, points: Complex, radius: float | None) -> Array:
    """Return the mean ln r from bar k to points; less its image's."""
    offset = (points - coil.place[k]) * np.exp(1j * coil.tilt[k])
    logs = mean_log_at(offset.real, offset.imag, coil.width, coil.thickness)
    if radius is not None:
        logs = logs - np.log(np.abs(radius - points * np.conj(coil.place[k]) / radius))
    return logs


def mean_log_at(x: Array, z: Array, width: float, thickness: float) -> Array:
    """Return the mean of ln r between points and a rectangle centred at the origin; shape of x."""
    result = np.zeros(x.shape)
    far = x * x + z * z > (_FAR * max(width, thickness)) ** 2
    for (s, ws), (q, wq) in product(zip(*_GAUSS, strict=True), repeat=2):  # nine filaments
        square = (x[far] - s * width / 2) ** 2 + (z[far] - q * thickness / 2) ** 2
        result[far] += ws * wq / 8 * np.log(square)
    near = ~far
    total = np.zeros(np.count_nonzero(near))
    for side_x in (-1.0, 1.0):
        for side_z in (-1.0, 1.0):
            corner = _corner(x[near] + side_x * width / 2, z[near] + side_z * thickness / 2)
            total += side_x * side_z * corner
    result[near] = total / (width * thickness) - 1.5
    return result


def _corner(x: Array, z: Array) -> Array:
    """Return G of the module docstring: odd in x and in z."""
    square = x * x + z * z
    u, v = np.abs(x), np.abs(z)
    angle = np.arctan2(v, u)
    size = u * v * np.log(np.where(square > 0.0, square, 1.0)) + u * u * angle + v * v * (np.pi / 2 - angle)
    return np.asarray(0.5 * np.sign(x) * np.sign(z) * size)


def _linkage(coil: CoilBars, driven: tuple[CoilBars, ...], radius: float | None) -> float:
    """Return the mean potential over each bar of `coil`, summed with signs."""
    nodes, weights = _GAUSS_FINE
    s, q = np.meshgrid(nodes * coil.width / 2, nodes * coil.thickness / 2, indexing="ij")
    inside = (s + 1j * q).ravel() * np.exp(-1j * coil.tilt)[:, None]
    A = coil_potentials(driven, (coil.place[:, None] + inside).ravel(), radius).reshape(coil.place.size, -1)
    return float(coil.sign @ (A @ np.outer(weights, weights).ravel() / 4))


def section_alone(sensor: Sensor, absolute: bool) -> tuple[Array, Array]:
    """Return inductances and direct-current resistances of the coils without metal, shapes (n, n) and (n,).

    Per metre of depth; `absolute` asks for those of the whole coils [H, ohm].
    """
    if absolute:
        return coils_alone(sensor.coils)
    sizes = [(track_conductivity(coil), coil_bars(coil)) for coil in sensor.coils]
    resistances = [bars.x.size / (sigma * bars.width * bars.thickness) for sigma, bars in sizes]
    return free_space_inductance(sensor), np.array(resistances)


def section_answer(
    kind: Kind, sensor: Sensor, pose: Pose, frequency: float, react: Callable[[Pose, float], Reaction]
) -> Impedance:
    """Return L and R of coils in the section, per metre of depth or whole as the kind says; as `answer`."""
    return answer(kind, sensor, pose, frequency, partial(section_alone, sensor, kind.unit_L == "H"), react)[0]


def depth(sensor: Sensor, absolute: bool) -> Array:
    """Return what turns changes per metre of depth into those of whole coils, relative to their inductances [m]."""
    if not absolute:
        return np.ones((len(sensor.coils),) * 2)
    whole, section = (np.sqrt(np.diag(section_alone(sensor, each)[0])) for each in (True, False))
    return np.outer(whole / section, whole / section)


def bars_of_coils(sensor: Sensor) -> tuple[Bars, ...]:
    """Return every coil's bars in the section y = 0."""
    return tuple(coil_bars(coil) for coil in sensor.coils)


def coil_box(bars: Bars) -> Complex:
    """Return corners x + j z of the rectangle around a coil's bars, counter-clockwise [m]."""
    low = complex(bars.x.min() - bars.width / 2, bars.z.min() - bars.thickness / 2)
    high = complex(bars.x.max() + bars.width / 2, bars.z.max() + bars.thickness / 2)
    return np.array([low, complex(high.real, low.imag), high, complex(low.real, high.imag)])


@lru_cache(maxsize=64)
def free_space_inductance(sensor: Sensor) -> Array:
    """Return the coils' inductance matrix without target, shape (n, n) [H/m].

    Of flat coils in closed form. Of curved ones the potential of each bar at 6 x 6 Gauss points of each, its own
    included: 4e-8 of the double mean on the published coils, 4e-3 where tracks are 40 times as wide as they are apart.
    """
    radius = return_radius(sensor)
    if sensor.substrate_radius is None:
        sections = bars_of_coils(sensor)
        L0 = np.array([[_mutual(first, second, radius) for second in sections] for first in sections])
    else:
        L0 = np.array([[_linkage(coil, (driven,), radius) for driven in tracks(sensor)] for coil in tracks(sensor)])
    return np.asarray((L0 + L0.T) / 2)


def _mutual(first: Bars, second: Bars, radius: float | None) -> float:
    """Return the mutual inductance per metre of two coils' bars; within a circle where A = 0 if there is one."""
    logs = mean_log(
        second.x - first.x[:, None], second.z - first.z[:, None],
        (np.array(first.width), np.array(first.thickness)), (np.array(second.width), np.array(second.thickness)),
    )
    if radius is not None:
        p, q = first.x + 1j * first.z, second.x + 1j * second.z
        logs = logs - np.log(np.abs(radius - p[:, None] * q.conj() / radius))
    return float(-mu_0 / (2 * np.pi) * first.sign @ logs @ second.sign)
