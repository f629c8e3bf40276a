"""From wrench to pose at small strain: one compliance of a layer in plane strain, or of a pad in space (`linear`).

About the undeformed state the target moves by ``q = C f + q_0``, f its forces and moment about the bonded face, q_0 its
displacement without load where the silicone would be larger if nothing held it (`elastomer.free_stretch`). Both are
extrapolated from the meshes of a family (levels/family.py); the change of geometry under load is neglected. The second
step of Newton's method from rest, on the coarsest mesh, estimates it, and later ones add as large a share of it as it
is of q, by component and in all (of the tilt under a press up to 0.3): part of the error. A pad that is its own mirror
image in y = 0 is meshed by half.

Films. Wide layers strain uniformly but for their edges and tilt (uniform.py), at any strain by ``u = (d_h, d_z, 0)``,
by ``u_0`` at small strain. There

    q = C f + u - u_0,        error = s |C f - u_0|,

s the share by which finite strain may change what edges and tilt do. Of both errors of finite strain the smaller one
counts, with the pose that it belongs to. The stretch of a film is that without edges, which the pose hangs on; theirs,
less one, is up to 1.9 times as much.

Range: loads in the plane y = 0 that move the target by a few percent of the thickness, of films by thicknesses; no
contact.

Finite length. Plane strain is compared with a pad by the ratio of their stiffnesses at small strain,

    factor = k_planar / k_3D,    k in shear (tilt locked), in compression and in tilt, about the bonded face's centre.

The planar model spreads a force over the elastomer's length, a target that is shorter or narrower than its pad makes it
too stiff by the factor. Both are extrapolated from families of meshes. What goes on at the ends of a long
pad does not depend on its length: beyond 20 thicknesses and three of the target's widths only the ends are meshed, and
the middle is plane strain. Under a target wider than 30 thicknesses the pad is lubricated: with ``K t^2`` kept the
factors depend on t/w by the edges alone, so that they are found at 1/24 and 1/16 of the width and extrapolated along a
straight line; the step that this adds counts as error as well. Neglected: finite strain, where the factors shrink or
grow with the load; meshes of the user's own. A cover does not scale with its pad, which is meshed as it is then.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from sits_mech.disk_cache import kept
from sits_mech.mechanics.closed_form import finite_strain_model
from sits_mech.mechanics.equilibrium.body import Bonded
from sits_mech.mechanics.equilibrium.control import Scales
from sits_mech.mechanics.equilibrium.newton import correction
from sits_mech.mechanics.equilibrium.newton import small_strain_compliance as undeformed
from sits_mech.mechanics.levels.answer import errors_of, law_notes, relative
from sits_mech.mechanics.levels.family import Levels
from sits_mech.mechanics.levels.gradient import Family, PoseSlopes, equilibrium_slopes
from sits_mech.mechanics.levels.refine import refinements
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.mechanics.pad.planar import Edges, edge_effect, edge_notes, layer_family
from sits_mech.mechanics.pad.section import layer_parts, layer_scales
from sits_mech.mechanics.pad.solid import pad_parts, pad_scales
from sits_mech.mechanics.uniform import uniform_layer
from sits_mech.quantities import (
    Array,
    Equilibrium,
    Pose,
    SolveFailed,
    SolveReport,
    Wrench,
    refuse_infinite,
    refuse_out_of_plane,
)
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.parts.elastomer import Layer
from sits_mech.scene.sensor import Elastomer, Sensor, Target, silicones_of
from sits_mech.silicone.material import silicone_from
from sits_mech.threads import one_thread
from sits_mech.units import checked_tolerance

_LONG = (20.0, 3.0)  # thicknesses, widths of the target
_THIN = 30.0  # thicknesses of a target's smaller side from which on thicker pads stand for a thin one,
_THICKER = (24.0, 16.0)  # those with so many
_STEP = 1e-4  # of a load, for differences


@dataclass(frozen=True)
class SmallStrain:
    """A layer or a pad at small strain; made by `linear_layer`, `linear_pad` or `small_strain`.

    Compliances are d(d_h, d_z, alpha)/d(F_x, F_z downwards, moment about the bonded face).
    """

    sensor: Sensor
    levels: Levels
    scales: Scales
    compliances: tuple[Array, ...]  # (3, 3) of each level, scaled
    unloaded: tuple[Array, ...]  # (3,) of each level, scaled; zero without `elastomer.free_stretch`
    edges: Edges | None = None  # effect of fillets in plane strain

    @one_thread
    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the pose under `wrench` by linear elasticity; `start` is not used.

        The error is that of the mesh, and of finite strain the first Newton correction or what a film's edges and tilt
        do. Raise SolveFailed where it is as large as the displacement: linear elasticity does not hold.
        """
        began = time.process_time()
        refuse_infinite(wrench)
        refuse_out_of_plane("linear", wrench)
        scales, body = self.scales, self.levels.coarse
        load = scales.load(wrench)[:3]
        force = np.array([load[0], -load[1], load[2] + body.height * load[0]])
        lengths, lever = scales.lengths[:3], body.reach(scales.thickness)[:3]
        own = zip(self.compliances, self.unloaded, strict=True)
        limit = self.levels.limit([(C @ force + q) * lengths * lever for C, q in own])
        away, min_J = correction(body, load)
        q, missed, stretch = limit.value / lever / lengths, np.abs(away) * lengths, None
        share = np.maximum(missed / (np.abs(q) * lengths + np.finfo(float).tiny), relative(missed, q * lengths, lever))
        missed *= 1.0 + np.minimum(share, 1.0)
        notes = () if self.edges is None else edge_notes(self.edges, load, scales.thickness)
        film = uniform_layer(self.sensor, wrench, flat=self._flat)
        left = missed if film is None else film.share * np.abs(q * lengths - film.linear)
        if film is not None and np.max(left * lever) < np.max(missed * lever):
            q, missed, min_J = q + (film.moved - film.linear) / lengths, left, film.min_J
            stretch, notes = max(film.each), (*notes, *law_notes(self.sensor, film.each))
        error = errors_of(limit.error / lever + missed, self.levels.share, lever)
        unknowns = len(self.levels.maker(len(self.compliances) - 1).free) + 3
        off = relative(error, q * lengths, lever)
        report = SolveReport(
            "linear", unknowns, 1, 0.0, off, time.process_time() - began, notes=notes, min_J=min_J, stretch=stretch,
            error_stretch=None if stretch is None else stretch - 1.0,
        )
        if not report.estimated_error < 1.0:
            report = replace(report, status="strains too large")
            raise SolveFailed(f"wrench: strains are too large for one compliance, got {wrench}", report)
        shared = np.pad(limit.parts / lever, ((0, 0), (0, 3)))
        return Equilibrium(wrench, scales.pose(q), Pose.of(error), q, report, shared)

    @one_thread
    def slopes(self, found: Equilibrium, parameters: Sequence[Parameter], *, sideways: bool = False) -> PoseSlopes:
        """Return the derivatives of a pose by its load and by scene parameters; raises as `equilibrium_slopes`.

        `sideways` adds those by F_y, M_x and M_z of half a pad.
        """
        scales = layer_scales if self._flat else partial(pad_scales, share=self.scales.share)
        family = Family(self.levels, scales, self.sensor, small=len(self.compliances), sideways=sideways)
        slopes = equilibrium_slopes(family, found, parameters)
        return slopes if found.report.stretch is None else self._of_film(slopes, found.wrench, parameters, scales)

    @property
    def _flat(self) -> bool:
        """Whether it is in plane strain."""
        return len(self.levels.coarse.mesh.axes) == 2

    def _of_film(
        self, slopes: PoseSlopes, load: Wrench, parameters: Sequence[Parameter], scales: Callable[[Sensor], Scales]
    ) -> PoseSlopes:
        """Add what finite strain of a film changes of derivatives, those of its units apart."""

        def more(sensor: Sensor, *, F_x: float = 0.0, F_z: float = 0.0) -> Array:
            """Return what finite strain adds to a scene's motion under the load and a little more, of this size."""
            film = uniform_layer(sensor, replace(load, F_x=load.F_x + F_x, F_z=load.F_z + F_z), flat=self._flat)
            unit = self.scales.lengths[:3] / scales(sensor).lengths[:3]
            return np.zeros(3) if film is None else (film.moved - film.linear) * unit

        pose, compliance = slopes.pose.copy(), slopes.compliance.copy()
        for column, each in enumerate(parameters):
            stencil = each.stencil(lambda sensor: uniform_layer(sensor, load, flat=self._flat) is not None)
            pose[:3, column] += stencil.own * more(self.sensor)
            pose[:3, column] += sum(weight * more(sensor) for sensor, _, weight in stencil.places)
        step = _STEP * math.hypot(load.F_x, load.F_z)
        for column, name in enumerate(("F_x", "F_z")):
            ahead, behind = (more(self.sensor, **{name: way}) for way in (step, -step))
            compliance[:3, column] += (ahead - behind) / (2.0 * step)
        if load.F_x != 0.0:  # across the shear by its secant, as of any isotropic law
            compliance[3, 3] += more(self.sensor)[0] / load.F_x
        return replace(slopes, pose=pose, compliance=compliance)

    @property
    def stiffness(self) -> tuple[Array, float]:
        """Stiffness (3, 3) of the whole pad, or of the layer's length, and its worst relative error on the diagonal.

        Of d_h, d_v and alpha against F_x, an upward force and a moment about the bonded face's centre [N/m, N, N/rad, N
        m/rad].
        """
        found = self.levels.limit([C.ravel() for C in self.compliances])
        best, error = found.value.reshape(3, 3), found.error.reshape(3, 3)
        unit = np.outer(self.scales.loads[:3], 1.0 / self.scales.lengths[:3])
        return np.linalg.inv(best) * unit, float(np.max(np.diag(error) / np.diag(best)))


def undeformed_pad(sensor: Sensor) -> tuple[Bonded, Scales]:
    """Return the first mesh of a pad, or of a layer in plane strain where small strain takes it so, and its scales."""
    if _in_space(sensor):
        levels, share = pad_family(sensor)
        return levels.coarse, pad_scales(sensor, share)
    return layer_family(sensor).coarse, layer_scales(sensor)


@one_thread
def linear_layer(sensor: Sensor, tolerance: float = 1e-2) -> SmallStrain:
    """Return the small-strain model of a sensor's layer in plane strain; raises as `planar_layer`."""
    layer_parts(sensor)
    return _compliant(sensor, layer_family(sensor), layer_scales(sensor), tolerance, edge_effect(sensor))


@one_thread
def linear_pad(sensor: Sensor, tolerance: float = 1e-2) -> SmallStrain:
    """Return the small-strain model of a sensor's pad in space; raises as `block_pad`."""
    levels, share = pad_family(sensor)
    return _compliant(sensor, levels, pad_scales(sensor, share), tolerance)


def small_strain(sensor: Sensor, tolerance: float = 1e-2) -> SmallStrain:
    """Return the small-strain model: in space where plane strain does not represent the pad."""
    return (linear_pad if _in_space(sensor) else linear_layer)(sensor, tolerance)


def _in_space(sensor: Sensor) -> bool:
    """Return whether plane strain does not represent a pad."""
    target, elastomer = layer_parts(sensor)
    return not target.loops and (elastomer.mesh is not None or finite_strain_model(elastomer) == "block")


def _compliant(
    sensor: Sensor, levels: Levels, scales: Scales, tolerance: float, edges: Edges | None = None
) -> SmallStrain:
    """Return the model with as many levels as the tolerance asks for."""
    asked = checked_tolerance(tolerance)
    for found in refinements(levels, (undeformed(levels.maker(level)) for level in range(len(levels))), len(levels)):
        limit = levels.limit([C[:3, :3].ravel() for C, _ in found])
        if np.max(np.diag(limit.error.reshape(3, 3)) / np.diag(limit.value.reshape(3, 3))) <= asked:
            break
    compliances, unloaded = (tuple(part) for part in zip(*((C[:3, :3], q[:3]) for C, q in found), strict=True))
    return SmallStrain(sensor, levels, scales, compliances, unloaded, edges)


@dataclass(frozen=True)
class FiniteLength:
    """Planar stiffness over stiffness in three dimensions, at small strain."""

    shear: float
    compression: float
    tilt: float
    error: float  # estimated relative error of the factors
    seconds: float  # wall time


@lru_cache(maxsize=8)
@one_thread
def finite_length_factor(sensor: Sensor) -> FiniteLength:
    """Return the factors by which plane strain is too stiff for a sensor's pad.

    Raise ValueError for a scene without target or elastomer, or shapes other than a rectangle or disc on a box or
    cylinder.
    """
    target, elastomer = pad_parts(sensor)
    if elastomer.mesh is not None:  # a file's name does not tell what is in it
        return _finite_length(sensor)
    cover = () if sensor.cover is None else (sensor.cover,)
    asked = "finite length", target, elastomer, *cover, *map(repr, silicones_of(sensor))
    pack, unpack = (lambda found: {"each": astuple(found)}), (lambda made: FiniteLength(*made["each"].tolist()))
    found: FiniteLength = kept(asked, partial(_finite_length, sensor), pack, unpack, __name__)
    return found


def _finite_length(sensor: Sensor) -> FiniteLength:
    """Return the factors, found."""
    began = time.process_time()
    target, elastomer = pad_parts(sensor)
    width, t = min(*target.extent, *elastomer.extent), elastomer.thickness
    if width <= _THIN * t or sensor.cover is not None:
        factors, error = _factors(sensor)
    else:
        near, far = (width / count for count in _THICKER)
        (first, error), (second, _) = (_factors(_thicker(sensor, each)) for each in (near, far))
        factors = first + (first - second) * (t - near) / (near - far)
        error += float(np.abs(factors / first - 1.0).max())
    shear, compression, tilt = (float(factor) for factor in factors)
    return FiniteLength(shear, compression, tilt, error, time.process_time() - began)


def _factors(sensor: Sensor) -> tuple[Array, float]:
    """Return the factors in shear, compression and tilt, and their error."""
    _, elastomer = pad_parts(sensor)
    sharp = Elastomer.model_validate(elastomer.model_dump() | {"edge_radius": None})
    long, _ = linear_layer(sensor.model_copy(update={"elastomer": sharp})).stiffness
    short, cut = _shortened(sensor)
    solid, error = linear_pad(short).stiffness
    solid = solid + long * (cut / elastomer.extent[1])
    return np.diag(long) / np.diag(solid), error


def _thicker(sensor: Sensor, thickness: float) -> Sensor:
    """Return a scene with a thicker pad of the same ``K t^2`` and shear modulus."""
    _, elastomer = pad_parts(sensor)
    ratio = elastomer.thickness / thickness

    def made(layer: Layer) -> dict[str, Any]:
        """Return the silicone of a layer with as much of K t^2."""
        mu, K = layer.silicone.shear_modulus, layer.silicone.bulk_modulus * ratio**2
        return {"material": silicone_from({"law": "neo-hookean", "shear_modulus": mu, "bulk_modulus": K})}

    pad = elastomer.of_thickness(thickness).remade(made, edge_radius=None)
    return sensor.model_copy(update={"elastomer": pad})


def _shortened(sensor: Sensor) -> tuple[Sensor, float]:
    """Cut the irrelevant middle out of pad and target alike; return the scene and the length cut [m]."""
    target, elastomer = pad_parts(sensor)
    (width, length), t = map(min, target.extent, elastomer.extent), elastomer.thickness
    cut = length - max(_LONG[0] * t, _LONG[1] * width)
    if target.length is None or elastomer.length is None or cut <= 0.0:
        return sensor, 0.0
    plate = Target.model_validate(target.model_dump() | {"length": target.length - cut})
    pad = Elastomer.model_validate(elastomer.model_dump() | {"length": elastomer.length - cut})
    return sensor.model_copy(update={"target": plate, "elastomer": pad}), cut
