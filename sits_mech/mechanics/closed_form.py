"""Closed forms of a bonded layer: thin limits, edge corrections, a model of a flush layer.

A strip of width w and thickness t between two rigid plates, plane strain, small strain, shape factor ``S = w/(2 t)``.
Where the layer is thin (S large) the pressure follows the lubrication equation of a slightly compressible solid,

    p/K - t**2/(12 mu) p'' = e(x),        p = 0 at x = +-w/2,

with the local compression ``e = sink/t`` or ``e = theta x/t``. With ``y = sqrt(12 mu/K) S`` its solutions give

    E_c = K (1 - tanh(y)/y)                      -> 4 mu S**2      for K -> infinity
    E_b = 3 K (1/3 - coth(y)/y + 1/y**2)         -> 4/5 mu S**2
    k_x = mu (w - 0.2308 t)/t

E_c is force over (w sink/t), E_b moment over (w**3/12 theta/t), k_x force over shear displacement with the tilt held,
all per depth. Neglected in E_c and E_b: terms of relative order 1/S from the edges, and mu beside K.

Sources: A. N. Gent, P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111; J. M. Kelly, Earthquake-Resistant Design with
Rubber (1997), chapters 4 and 5. The length 0.2308 t of the shear edges comes from graded P2-P1 finite elements.

The model of a flush layer (`strip_layer`) is the cheapest: no mesh, microseconds a load. A strip of length L has rigid
plates as wide or wider. About the layer's mid-height the three stiffnesses are uncoupled. The thin limits E_c, E_b are
those of ``M = K + 4/3 mu`` in place of K, as a wide layer is in uniaxial strain; beside them is what a long column has:

    k_z = E_1 w L/t,        k_x = mu (w - 0.2308 t) L/t,    k_a = (E_b + c (1 - E_b/M)) w^3 L/(12 t)
    E_1 = E_c + c (1 - E_c/M),    c = 4 mu (K + mu/3)/M

    sink = F_z/k_z,    alpha = (M + F_x (h + t/2))/k_a,    d_h = F_x/k_x + alpha t/2,

h the height of the force above the bonded face. Silicone that would be larger by e in each length if nothing held it
(`elastomer.free_stretch`) lifts the target: by Betti's theorem, with the pressure p that a sink of its own gives,

    rise = 3 e int p dV / F,    int p dV = (E_c + 2 mu (1 - E_c/M)) K/M w L sink,    F = E_1 w L sink/t,

which is (1 + nu) e t of a column in plane strain, and (1 + nu)/(1 - nu) e t of a wide layer. Against graded P2-P1
finite elements from S = w/(2 t) = 1 to 40 and K/mu = 0.5 to 1e6: k_z within 3.1 %, k_a 5.6 %, the rise 0.5 %, k_x 0.1 %
and 0.28 t/w mu/K, its edges being softer. To that the error adds `small_strain_bound`: what is of first order in the
strain, and how far the law's secant modulus in simple shear is from mu at the silicone's shear g. By the linear work

    mu <g**2> = E_c (sink/t)**2 + mu (d_h/t)**2 + E_b (edge/t)**2/3,        edge = alpha w/2,

and where pressure drives it, ``g ~ x z`` if pressed, ``(1 - 3 x**2) z`` if tilted (x and z from -1 to 1), forces follow
the secant at ``<g**4>/<g**2>``, 3.2 and 3.9 times the mean square, taken as 4.

Refused: targets narrower than their layer, whose overhang stiffens it by up to a half; S below 1.

How stiff a pad of any sides is (`pad_moduli`), for bounds: its pressure, ``laplace(p) = -12 mu sink/t**3`` and zero on
the free sides, is Prandtl's function of torsion, so that with the torsion constant J and the area A

    E_c = 3 mu J/(A t**2) + (4 - a/b) mu,        J = a**3 b (1/3 - 0.21 a/b (1 - a**4/(12 b**4))),  a <= b,

J of a disc pi d**4/32. The last term is what a column has, 4 mu in plane strain, 3 mu where the sides are alike; K is
in series. Against the 3D model from S = a/(2 t) = 0.5 to 15: within 8 %, 10 % where K rules. Of tilt the least about
either axis, ``(0.8 - 0.3 a/b) S**2 + 4 - a/b`` times mu: the 3D model tilts by 0.36 to 0.99 of what it says. J: W. C.
Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), table 10.1.

Layers are sheared in series, ``t/mu = sum t_i/mu_i``, as columns are, and compressed in series, ``t/K = sum t_i/K_i``.
Pressed out of a thin pad they flow sideways by u(z) with ``mu(z) u' = p' (z - z_0)``, and u = 0 at both plates: what
is t**3/(12 mu) of one silicone is of them

    D = int (z - z_0)**2/mu(z) dz,        z_0 = int z/mu(z) dz / int 1/mu(z) dz,

so that the thin terms have ``mu_thin = t**3/(12 D)`` in place of mu. Edges as of one silicone.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from sits_mech.description import Refusal
from sits_mech.quantities import (
    Equilibrium,
    Pose,
    SolveFailed,
    SolveReport,
    Wrench,
    refuse_infinite,
    refuse_out_of_plane,
)
from sits_mech.scene.sensor import Elastomer, SceneError, Sensor, Target
from sits_mech.silicone.homogeneous import shear_secant
from sits_mech.silicone.material import Silicone
from sits_mech.threads import one_thread
from sits_mech.units import SLACK
from sits_mech.units import millimetres as mm

_EDGES = (0.2308, 0.28)  # thicknesses by which free edges shorten an incompressible strip in shear; times mu/K, more
LONG = 10.0
"""Least length over width of a pad that small strain takes in plane strain."""
HAIR = 1e3
"""Times as high as thin: what stands beyond is a hair, whose faces' triangles all overlap."""
_MISSED = (1e-3, 3.2e-2, 6e-2)  # relative error of k_x, k_z, k_a
_LEAST = 1.0  # shape factor w/(2 t)
_FILM = 30.0  # thicknesses of the smaller side, from which on a layer is a film
_SHARES = (1.0, 0.6)  # of what a film's edges do: how far finite strain may change it, flush and within a pad
_FLUSH = 1e-6  # difference of the widths, relative


def compression_modulus(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the apparent modulus of a thin bonded strip in compression, force over ``w sink/t`` [Pa].

    `bulk_modulus` may be infinite; off by terms of relative order 1/shape_factor, thickness over half the width.
    """
    y = _decay(shear_modulus, bulk_modulus, shape_factor)
    if y < 1e-2:
        return 4.0 * shear_modulus * shape_factor**2 * (1.0 - 0.4 * y**2)
    return bulk_modulus * (1.0 - float(np.tanh(y)) / y)


def thin_share(layer: Elastomer) -> float:
    """Return the modulus mu_thin by which layers are pressed out of a thin pad, over theirs in series."""
    stack = layer.stack
    if len(stack) == 1:
        return 1.0
    z = np.cumsum([0.0, *(each.thickness for each in stack)])
    soft = [1.0 / each.silicone.shear_modulus for each in stack]
    middle = float(np.diff(z**2) @ soft) / 2.0 / float(np.diff(z) @ soft)
    D = float(np.diff((z - middle) ** 3) @ soft) / 3.0
    return layer.thickness**3 / (12.0 * D) / layer.shear_modulus


def pad_moduli(target: Target, layer: Elastomer) -> tuple[float, float, float]:
    """Return a pad's area [m^2], force over ``area sink/t``, least moment over ``area w/6 theta w/(2 t)`` [Pa]."""
    a, b = sorted(map(min, target.extent, layer.extent))
    S2, r, is_round = (0.5 * a / layer.thickness) ** 2, a / b, target.is_round or layer.is_round
    twist = 0.125 if is_round else 1.0 / 3.0 - 0.21 * r * (1.0 - r**4 / 12.0)
    forms, mu, thin = (12.0 * twist, 0.8 - 0.3 * r), layer.shear_modulus, thin_share(layer)
    E_c, E_b = (1.0 / (1.0 / (mu * (4.0 - r + thin * form * S2)) + 1.0 / layer.bulk_modulus) for form in forms)
    return (0.25 * np.pi * a * b, E_c, 0.75 * E_b) if is_round else (a * b, E_c, E_b)


def free_rise(sensor: Sensor) -> float:
    """Return how far silicone lifts its target without load [m], by Betti's theorem; of layers not plain their growth.

    Of what the 3D model has: 0.98 to 1 of flush pads, 0.92 of tall ones, from 0.81 on where silicone reaches beyond.
    """
    plain, pad = plain_pad(sensor), sensor.elastomer
    if pad is None or plain is None:
        return 0.0 if pad is None else sum((each.free_stretch - 1.0) * each.thickness for each in pad.stack)
    mu, E_c = pad.shear_modulus, pad_moduli(*plain)[1]
    return sum(3.0 * (each.free_stretch - 1.0) * each.thickness * (1.0 - 2.0 * mu / E_c) for each in pad.stack)


def tilt_modulus(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the apparent modulus of a thin strip in tilt about mid-height, moment over ``w**3/12 theta/t`` [Pa].

    `bulk_modulus` may be infinite; off by terms of relative order 1/shape_factor, thickness over half the width.
    """
    y = _decay(shear_modulus, bulk_modulus, shape_factor)
    if y < 3e-2:
        return 0.8 * shear_modulus * shape_factor**2 * (1.0 - 2.0 / 21.0 * y**2)
    return 3.0 * bulk_modulus * (1.0 / 3.0 - 1.0 / (y * float(np.tanh(y))) + 1.0 / y**2)


def shear_stiffness(shear_modulus: float, width: float, thickness: float) -> float:
    """Return the shear stiffness of an incompressible bonded strip, tilt held, per depth [Pa]; width >= thickness."""
    return shear_modulus * (width / thickness - _EDGES[0])


def small_strain_bound(
    silicone: Silicone, moduli: tuple[float, float], sink: float, shear: float, edge: float, uneven: float = 1.0
) -> float:
    """Bound the relative error of one linear compliance; E_c and E_b [Pa], displacements over the layer's thickness.

    `edge` is the displacement of the target's ends by its tilt, `uneven` the part of the layer that is not sheared
    uniformly. The factors are checked against finite strain by the plan's test.
    """
    mu, (E_c, E_b) = silicone.shear_modulus, moduli
    strain = math.sqrt(4.0 * (E_c * sink**2 + E_b * edge**2 / 3.0) / mu + shear**2)
    secant = shear_secant(silicone.law, silicone.constants, max(strain, SLACK))
    return 3.0 * abs(sink) + 0.5 * (uneven * abs(shear) + abs(edge)) + abs(secant / mu - 1.0)


def _decay(shear_modulus: float, bulk_modulus: float, shape_factor: float) -> float:
    """Return the half width over the decay length of the pressure in a thin layer."""
    if not shear_modulus > 0.0 or not bulk_modulus > 0.0 or not shape_factor > 0.0:
        raise ValueError(
            "strip: moduli and shape factor must be positive, "
            f"got mu = {shear_modulus}, K = {bulk_modulus}, S = {shape_factor}"
        )
    return float(np.sqrt(12.0 * shear_modulus / bulk_modulus) * shape_factor)


def finite_strain_model(elastomer: Elastomer | None) -> str:
    """Return the model for finite strains: "planar" for a long pad, "block" for any other."""
    return "planar" if elastomer is None or elastomer.extent[1] >= LONG * elastomer.extent[0] else "block"


def plain_pad(sensor: Sensor) -> tuple[Target, Elastomer] | None:
    """Return target and layer where both are boxes or round, the layer in one piece and bare; None for others."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or target.loops or sensor.cover is not None:
        return None
    return None if elastomer.mesh is not None or elastomer.kind == "pillars" else (target, elastomer)


def is_film(target: Target, elastomer: Elastomer) -> bool:
    """Whether a pad is so wide that what its edges do is a small share, and fills its place without load."""
    wide = min(map(min, target.extent, elastomer.extent)) >= _FILM * elastomer.thickness
    return wide and all(layer.free_stretch == 1.0 for layer in elastomer.stack)


def edges_share(target: Target, elastomer: Elastomer) -> float:
    """Return the share of what edges do at small strain by which finite strain may change it."""
    sides = zip(target.extent, elastomer.extent, strict=True)
    return _SHARES[all(pad - own >= 2.0 * elastomer.thickness for own, pad in sides)]


@dataclass(frozen=True)
class Strip:
    """A flush layer by formula; made by `strip_layer`."""

    target: Target
    elastomer: Elastomer
    stiffness: tuple[float, float, float]  # k_x [N/m], k_z [N/m], k_a [N m/rad] about mid-height
    rise: float = 0.0  # without load [m]

    @one_thread
    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose under `wrench` [N, N m]; `start` is not used.

        Raise SolveFailed where the error is as large as the displacement.
        """
        began = time.process_time()
        refuse_infinite(wrench)
        refuse_out_of_plane("closed-form", wrench)
        target, elastomer = self.target, self.elastomer
        t, half = elastomer.thickness, 0.5 * target.extent[0]
        k_x, k_z, k_a = self.stiffness
        alpha = (wrench.M + wrench.F_x * (target.load_height + 0.5 * t)) / k_a
        sheared, sink = wrench.F_x / k_x, wrench.F_z / k_z - self.rise
        d_h = sheared + 0.5 * alpha * t
        silicone, (w, length) = elastomer.silicone, elastomer.extent
        moduli = k_z * t / (w * length), 12.0 * k_a * t / (w**3 * length)
        bound = small_strain_bound(silicone, moduli, sink / t, d_h / t, alpha * half / t)
        size = max(abs(d_h), abs(sink), abs(alpha) * half)
        missed = _MISSED[0] + _EDGES[1] * t / w * silicone.shear_modulus / silicone.bulk_modulus
        error = bound * size + np.array([
            missed * abs(sheared) + 0.5 * _MISSED[2] * abs(alpha) * t,
            _MISSED[1] * (abs(sink + self.rise) + abs(self.rise)),
            _MISSED[2] * abs(alpha) * half,
        ])
        worst = float(error.max()) / size if size > 0.0 else 0.0
        report = SolveReport("closed-form", 0, 0, 0.0, worst, time.process_time() - began)
        if not worst < 1.0:
            report = replace(report, status="strains too large")
            raise SolveFailed(f"wrench: strains are too large for a formula, got {wrench}", report)
        pose = Pose(d_h, elastomer.standoff + t - sink, alpha)
        return Equilibrium(wrench, pose, Pose(*(error / [1.0, 1.0, half]).tolist()), np.zeros(0), report)


def strip_layer(sensor: Sensor, tolerance: float = 0.1) -> Strip:
    """Return the closed-form model of a sensor's layer; `tolerance` is not used.

    Raise SceneError unless the target is a rectangle at least as wide as its layer, and w/(2 t) at least one.
    """
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        raise SceneError(f"{sensor.name}: target and elastomer must be given for a force to move the target")
    if refusal := flush_refusal(sensor):
        raise SceneError(f"{sensor.name}: {refusal}")
    (w, length), t = elastomer.extent, elastomer.thickness
    mu, K, S = elastomer.silicone.shear_modulus, elastomer.silicone.bulk_modulus, w / (2.0 * t)
    M = K + 4.0 / 3.0 * mu
    E_c, E_b, column = compression_modulus(mu, M, S), tilt_modulus(mu, M, S), 4.0 * mu * (K + mu / 3.0) / M
    E_1, pressure = E_c + column * (1.0 - E_c / M), (E_c + 2.0 * mu * (1.0 - E_c / M)) * K / M
    k_a = (E_b + column * (1.0 - E_b / M)) * w**3 * length / (12.0 * t)
    rise = 3.0 * (elastomer.free_stretch - 1.0) * pressure / E_1 * t
    return Strip(target, elastomer, (shear_stiffness(mu, w, t) * length, E_1 * w * length / t, k_a), rise)


def coaxial_refusal(sensor: Sensor) -> Refusal | None:
    """Return why a scene is not that of a cylinder under a coaxial disc; None where it is, or a part is missing."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        return None
    if target.shape == "disc" and elastomer.is_round and elastomer.mesh is None:
        return None
    got = "elastomer.mesh" if elastomer.mesh is not None else f"a {elastomer.kind} under a {target.shape}"
    return Refusal("elastomer", "be a cylinder under a disc for axisymmetric", got)


def flush_refusal(sensor: Sensor) -> Refusal | None:
    """Return why no strip by formula stands for a layer; None where one does, or a part is missing."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None:
        return None
    if sensor.cover is not None:
        return Refusal("cover", "be left out for closed-form", f"one {sensor.cover.thickness:g} m thick")
    w, t = elastomer.extent[0], elastomer.thickness
    if elastomer.mesh is not None or elastomer.kind != "box" or target.shape != "rectangle":
        got = f"a {elastomer.kind} under a {target.shape}"
        return Refusal("elastomer", "be a box under a rectangle for closed-form", got)
    if len(elastomer.layers) > 1:
        got = f"{len(elastomer.layers)} layers"
        return Refusal("elastomer.layers", "be of one silicone for closed-form", got)
    if w - target.extent[0] > _FLUSH * w:
        got = f"a layer {mm(w)} wide under a target {mm(target.extent[0])} wide"
        return Refusal("target.width", "cover the layer along x for closed-form", got)
    if w < 2.0 * _LEAST * t:
        got = f"{mm(w)} wide and {mm(t)} thick"
        return Refusal("elastomer.width", "be at least twice the thickness for closed-form", got)
    return None
