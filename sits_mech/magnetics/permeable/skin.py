"""What a permeable plate, conducting or not, takes up of a potential on its surface: the flux that its skin carries.

With u and K of `shells`, gamma = (1 + j)/delta, thickness t and mu = mu_r (1 - j tan delta_m), u has classes even (+)
and odd (-) in z. In a wide plate, of waves k along it and g = sqrt(k^2 + gamma^2),

    K = mu k^2/g tanh(g t/2) (+),    mu k^2/g coth(g t/2) (-).

Where delta is small to the waves' length (thick or thin to t), g is gamma, and k^2 the surface's own Laplacian,

    <K u, v> = mu/gamma [int_faces (tanh | coth)(gamma t/2) grad u . grad v + int_rim tanh(gamma t/2) grad u . grad v]
             + mu (tanh(gamma t/2)/gamma)^2 [int_edge (d_n u d_n v on both sides) - d_s u d_s v]                    (1)

The last is the corner between face and rim. A quarter space with the same H_s, along the edge, on both faces holds
H_s [1 - (1 - e^(-gamma x))(1 - e^(-gamma y))]: mu H_s/gamma^2 less than both half spaces. Flux across, of which none
leaves, falls like 1 - e^(-gamma x) at the corner and saves 1/gamma of its way on each side. Where delta is large to t,
S_i, with no current, is in series with what the current takes,

    K^-1 = [S_i^-1 + Z (grad . grad)^-1]/mu,    Z = gamma coth(gamma t/2) - 2/t (+),  gamma tanh(gamma t/2) (-),    (2)

exact for k t small, and for sigma = 0 everywhere; losses are up to a fifth too large in thick small discs. From t = 0.7
to 2.5 delta one goes over into the other, as s = x^2 (3 - 2 x).

Estimated errors are parts of what (1) and (2) differ by and of the corner's term, in any phase. Beside `axis_fem`,
discs of 1e-2 to 300 skin depths, errors of omega Delta L are up to 4e-3 of |Delta Z| where mu_r is 100 or more, or
t below 0.5 delta, and up to 0.15 of it between (mu_r 4 to 20, t from 0.6 to 5 delta). Range: mu_r constant, no
saturation.
Source: S. Yuferev, N. Ida, Surface Impedance Boundary Conditions (2010), of (1) without its corners.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from sits_mech.magnetics.permeable.shells import ShellClass, gauged
from sits_mech.quantities import Complex

_SWITCH = 0.7, 2.5  # thickness over the skin depth between which (2) goes over into (1)
_SMALL = 1e-3  # |gamma t| below which there is no skin
_CORNER, _WEAK, _SOME = 0.3, 2.5, 0.25  # of the corners; of losses by (1) less (2) below delta, or by (2)
_BETWEEN = 2.0, 5.0  # of (1) less (2), at most; that times delta / thickness


@dataclass(frozen=True)
class PlateMetal:
    """What a plate is made of, and how thick it is."""

    permeability: complex  # mu_r (1 - j tan delta)
    conductivity: float  # [S/m]
    thickness: float  # [m]

    def responses(self, part: ShellClass, omega: float) -> tuple[Complex, Complex]:
        """Return X of a class (`ShellClass.response`) by the answer, and the error of the equations; omega [rad/s]."""
        mu, t, even = self.permeability, self.thickness, part.mirror > 0
        gamma = np.sqrt(1j * omega * mu_0 * mu * self.conductivity)
        x, tanh, small = abs(gamma) * t / math.sqrt(2.0), np.tanh(gamma * t / 2.0), abs(gamma * t) < _SMALL
        faces, rim, along, across = part.stiffness
        Z = (gamma**2 * t / 6.0 if small else gamma / tanh - 2.0 / t) if even else gamma * tanh
        whole = gauged(faces + rim, part.net)
        series = part.response(mu * part.inner @ np.linalg.solve(whole + Z * part.inner, whole))
        if small:
            return series, _SOME * (series - part.response(mu * part.inner))
        flat = mu / gamma * ((tanh if even else 1.0 / tanh) * faces + tanh * rim)
        skin = part.response(flat + mu * (tanh / gamma) ** 2 * (across - along))
        s = float(np.clip((x - _SWITCH[0]) / (_SWITCH[1] - _SWITCH[0]), 0.0, 1.0))
        s = s * s * (3.0 - 2.0 * s)
        gone = skin - series
        error = min(x * x, _BETWEEN[0], _BETWEEN[1] / x) * gone + _CORNER * s * (skin - part.response(flat))
        return series + s * gone, error + _WEAK * (1.0 - s) * (gone - gone.conj().T) / 2.0
