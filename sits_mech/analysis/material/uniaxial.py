"""Uniaxial response of silicone with rate and softening while it is pulled, held and let go.

Incompressible, ``C = diag(l^2, 1/l, 1/l)`` of the stretch l, side faces free. P_e(l) is the engineering stress of the
law (silicone/homogeneous.py), W(l) its energy, W_max the largest W so far, eta the softening (silicone/material.py).
The deviatoric second Piola stress of the softened law has the two components

    S_1 = (2/3) eta P_e/l,    S_2 = -(1/3) eta P_e l^2        (S : C = 0)

and each branch of the Prony series adds its convolution, which is made deviatoric at the present stretch again:

    Q_i(t) = g_i int_0^t exp(-(t - s)/tau_i) dS(s),    g_i = w_i/(1 - sum_j w_j)
    P(t) = eta P_e + sum_i (l Q_i1 - Q_i2/l^2)

S is taken as linear between the steps of a path, of which long ones are divided; the exponentials are exact. A path
starts from rest: a first sample that is strained is a sudden one, as is a change between two samples of the same time.

Source: J. C. Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153; R. W. Ogden, D. G. Roxburgh, Proc. R. Soc. A 455
(1999) 2861. Range: uniform states, any strain. Neglected: change of volume, inertia, permanent set, temperature.
"""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Array
from sits_mech.silicone.homogeneous import energy_density, engineering_stress, principal_stretches
from sits_mech.silicone.material import Silicone

_STEP = 5e-3  # of strain, largest: S bends by 3e-6 of itself over it


def uniaxial_stress(silicone: Silicone, time: Array, strain: Array, *, step: float = _STEP) -> Array:
    """Return the engineering stress (n,) [Pa] of a bar, strain > -1 linear between samples.

    `time` (n,) does not descend [s]; `step`: largest strain over which the softened stress is taken as linear. Raise
    ValueError for descending times or lengths that differ.
    """
    time, strain, samples = subdivided(time, strain, step)
    stress = softened_stress(silicone, strain)
    if silicone.prony:
        weights, times = np.array(silicone.prony).T
        stress = stress + branch_stress(times, time, strain, stress) @ weights / (1.0 - weights.sum())
    return np.asarray(stress[samples])


def softened_stress(silicone: Silicone, strain: Array) -> Array:
    """Return eta P_e along a path of engineering strain (n,) [Pa]: the law with softening alone."""
    stress = engineering_stress(silicone.law, silicone.constants, strain)
    if silicone.mullins is None:
        return stress
    energy = energy_density(silicone.law, silicone.constants, principal_stretches("uniaxial", 1.0 + strain))
    return stress * silicone.mullins.factor(energy, np.maximum.accumulate(energy))


def branch_stress(times: Array, time: Array, strain: Array, stress: Array) -> Array:
    """Return the stress (n, j) [Pa] that a branch of each relaxation time (j,) [s] adds, for g = 1.

    The path (n,) has small steps of strain; `stress` is eta P_e along it.
    """
    stretch = 1.0 + strain
    S = np.stack([2.0 * stress / stretch, -stress * stretch**2], axis=1)[..., None] / 3.0
    steps = np.r_[0.0, np.diff(time)][:, None] / times
    kept = np.exp(-steps)
    mean = np.where(steps > 0.0, -np.expm1(-steps) / np.where(steps > 0.0, steps, 1.0), 1.0)
    rise = np.diff(S, axis=0, prepend=0.0) * mean[:, None, :]
    Q, found = np.zeros_like(rise[0]), np.empty_like(rise)
    for k in range(len(time)):
        Q = found[k] = Q * kept[k] + rise[k]
    return found[:, 0] * stretch[:, None] - found[:, 1] / stretch[:, None] ** 2


def subdivided(time: Array, strain: Array, step: float = _STEP) -> tuple[Array, Array, Array]:
    """Divide the long steps of a path: time, strain, and the places of its own samples.

    `step`: largest change of strain between samples returned. Raise ValueError for descending times or lengths that
    differ.
    """
    time, strain = np.asarray(time, dtype=float), np.asarray(strain, dtype=float)
    if time.ndim != 1 or time.shape != strain.shape or not np.all(np.diff(time) >= 0.0):
        raise ValueError(f"time: must not descend, and have a strain each; got {time.shape} and {strain.shape}")
    parts = np.maximum(1, np.ceil(np.abs(np.diff(strain)) / step)).astype(int)
    samples = np.r_[0, np.cumsum(parts)]
    every = np.arange(samples[-1] + 1)
    return np.interp(every, samples, time), np.interp(every, samples, strain), samples
