"""Describe the mechanical models: what each holds, what it leaves out with sizes, what it costs.

Small strain. A bonded pad of sides w and L, the target's or the layer's, whichever is narrower, of thickness t and area
A under the load

    sink/t = F_z/(E_c A),   shear = F_x/(mu A),   edge = alpha w/(2 t) = 6 M_o/(E_b A w),

with E_c and E_b of `closed_form.pad_moduli`, M_o the moment about the layer's middle. One linear compliance then misses
the displacement by less than

    3 sink/t + (min(1, 7.5 t/w) shear + edge)/2,

where finite elements show 1.6 to 2.8 times sink/t under pure compression, and up to 0.4 times the larger of shear and
edge under combined loads (w/t from 1.3 to 7.5); slender layers, which buckle, are excluded. Away from its edges a layer
shears uniformly, with the law's secant modulus: what shear changes goes with t/w (flush strips under shear of 0.3 and
0.6: 1e-3 to 7e-3 of it at w/t = 8, 0.3e-3 to 0.5e-3 at 128). Of layers the bound is the largest of any silicone i,
strained by mu/mu_i more than the pad, mu that in series. Of films it is the share of edges and tilt that finite strain
may change, if that is less, as `linear` strains a layer without them at any strain (uniform.py): 2.4 t (1/w + 1/L) of
the shear, 1 - E_c/(K + 4/3 mu) of the sink and all of the edge.

Ends. Plane strain makes a pad too stiff by the factors of `linear.finite_length_factor` in shear, compression and tilt:
it leaves (factor - 1) times a displacement out. Beforehand, and of pads that a strip does not stand for at all, the
factors are those of the closed forms: the force is spread over the layer's length, not the target's, and a strip's E_c
and E_b stand for the pad's. From half a displacement on they leave out 1.04 to 1.8 times as much as in space.

Rate and history. A sudden load meets 1/(1 - sum w) times the stiffness that a Prony series with the weights w has under
a slow one, so that it moves the target by sum w less; below a larger load of the past Mullins' softening leaves at
least 1 - erf(1/beta)/r of it. Neither is an error of the answer to a slow first load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from sits_mech.description import Description, Question, Refusal, Rung
from sits_mech.mechanics.closed_form import (
    HAIR,
    coaxial_refusal,
    edges_share,
    finite_strain_model,
    flush_refusal,
    is_film,
    pad_moduli,
    plain_pad,
    small_strain_bound,
    thin_share,
)
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.notes import Omission, OmissionKind, Relative
from sits_mech.quantities import Array, Wrench
from sits_mech.scene.sensor import Elastomer, Sensor, Target, shape_on_cover, silicones_of
from sits_mech.silicone.history import history_share
from sits_mech.units import SLACK
from sits_mech.units import millimetres as mm

if TYPE_CHECKING:
    from sits_mech.mechanics.linear import FiniteLength

_HOPELESS = 0.5  # displacements that are left out, from which on the closed forms will do
_SLENDER = 0.5  # shape factor below which no layer counts as one of small strain
_RIM = 2.4  # thicknesses by which two edges widen or shorten a layer in shear: 2.3 seen within a pad, 0.23 flush
_OF_LAW = 0.1  # finite strain's share of a displacement from which on laws of one modulus differ by percents
_UNIFORM = 7.5  # thicknesses of a layer's width beyond which its middle is sheared uniformly


def strain_bound(sensor: Sensor, loads: Sequence[Wrench]) -> float:
    """Return an upper bound of the relative error of one linear compliance under any of the loads [-].

    Infinite for slender layers, and where the scene has no layer that a strip stands for.
    """
    plain = plain_pad(sensor)
    if plain is None:
        return math.inf
    target, elastomer = plain
    thin = elastomer.thickness / min(map(min, target.extent, elastomer.extent))
    if thin * 2.0 * _SLENDER > 1.0:
        return math.inf
    _, E_c, E_b = pad_moduli(target, elastomer)
    free = 3.0 * max(abs(layer.free_stretch - 1.0) for layer in elastomer.stack)  # without load
    strains, even = [strains_of(*plain, load) for load in (Wrench(), *loads)], min(1.0, _UNIFORM * thin)
    more = [elastomer.shear_modulus / layer.silicone.shear_modulus for layer in elastomer.stack]  # strained than it

    def of_load(sink: float, shear: float, edge: float) -> float:
        """Return the bound of one load: of a compliance, or of a film."""
        compliance = max(
            small_strain_bound(
                layer.silicone, (E_c / own, E_b / own), own * (sink + free), own * shear, own * edge, even
            )
            for layer, own in zip(elastomer.stack, more, strict=True)
        )
        return min(compliance, _film_bound(*plain, (sink, shear, edge))) if is_film(*plain) else compliance

    return max(of_load(*each) for each in strains)


def _film_bound(target: Target, elastomer: Elastomer, strains: tuple[float, float, float]) -> float:
    """Bound the relative error of a layer strained as without edges, by what these and the tilt do at small strain."""
    sink, shear, edge = strains
    t, M = elastomer.thickness, elastomer.bulk_modulus + 4.0 / 3.0 * elastomer.shear_modulus
    around = _RIM * sum(t / min(sides) for sides in zip(target.extent, elastomer.extent, strict=True))
    missed = max(around * shear, max(1.0 - pad_moduli(target, elastomer)[1] / M, 0.0) * sink, edge)
    return edges_share(target, elastomer) * missed / max(shear, sink, edge, SLACK)


def strains_of(target: Target, elastomer: Elastomer, load: Wrench) -> tuple[float, float, float]:
    """Return sink, shear and displacement of the ends by tilt of a plain pad at small strain, in thicknesses."""
    (w, length), (area, E_c, E_b) = map(min, target.extent, elastomer.extent), pad_moduli(target, elastomer)
    lever, mu = target.load_height + 0.5 * elastomer.thickness, elastomer.shear_modulus
    along, across = (abs(M) + abs(F) * lever for M, F in ((load.M, load.F_x), (load.M_x, load.F_y)))
    edge = 6.0 * math.hypot(along / w, across / length) / (E_b * area)
    return abs(load.F_z) / (E_c * area), math.hypot(load.F_x, load.F_y) / (mu * area), edge


def ends_of_pad(sensor: Sensor) -> FiniteLength | None:
    """Return the factors by which plane strain is too stiff for a pad; None where no planar layer stands for it."""
    if plain_pad(sensor) is None and sensor.cover is None:
        return None
    from sits_mech.mechanics.linear import finite_length_factor  # the whole mechanics, for who asks for its size

    return finite_length_factor(sensor)


def _is_flat(sensor: Sensor) -> bool:
    """Return whether small strain takes a pad in plane strain: long ones, and outlines."""
    target, elastomer = sensor.target, sensor.elastomer
    flat = elastomer is not None and elastomer.mesh is None and finite_strain_model(elastomer) == "planar"
    return flat or (target is not None and bool(target.loops))


def _ends(sensor: Sensor, question: Question) -> Omission:
    """Return what plane strain leaves out of a pad, or a target on it, that has ends along y."""
    target, elastomer = sensor.target, sensor.elastomer
    lengths = [math.nan if part is None else part.extent[1] for part in (elastomer, target)]
    parts = _factors_beforehand(sensor)
    if question.closely and max(parts, default=0.0) < _HOPELESS:
        parts = _factors_closely(sensor)
    numbers = (("pad", lengths[0]), ("target", lengths[1]))
    size = max(parts, default=math.nan)
    return Omission(OmissionKind.PAD_ENDS, size, Relative.DISPLACEMENT, numbers=numbers, parts=parts)


def _factors_closely(sensor: Sensor) -> tuple[float, ...]:
    """Return displacements less those in plane strain over these, by component of the pose; empty where not known."""
    factor = ends_of_pad(sensor)
    if factor is None:
        return ()
    more = np.array([max(factor.shear, factor.tilt), factor.compression, factor.tilt]) - 1.0
    return _by_component(np.maximum(more, 0.0) + factor.error)


def _factors_beforehand(sensor: Sensor) -> tuple[float, ...]:
    """Return the same by closed forms."""
    plain = plain_pad(sensor)
    if plain is None:
        return ()
    target, elastomer = plain
    (area, E_c, E_b), mu, K = pad_moduli(*plain), elastomer.shear_modulus, elastomer.bulk_modulus
    width = min(target.extent[0], elastomer.extent[0])
    S2, spread = (0.5 * width / elastomer.thickness) ** 2, width * elastomer.extent[1] / area
    thin = thin_share(elastomer)
    strip = [1.0 / (1.0 / (mu * (4.0 + thin * form * S2)) + 1.0 / K) for form in (4.0, 0.8)]
    tilt = spread * strip[1] / E_b
    return _by_component(np.array([max(spread, tilt), spread * strip[0] / E_c, tilt]) - 1.0)


def _by_component(plane: Array) -> tuple[float, ...]:
    """Return shares of d_h, d_v and alpha as shares of all six components."""
    return (*np.maximum(plane, 0.0).tolist(), 0.0, 0.0, 0.0)


def _layered(model: str, sensor: Sensor, question: Question, *, rough: bool = True) -> Refusal | None:
    """Return why a model of strips does not hold a scene; `rough` tells whether it holds friction."""
    elastomer = sensor.elastomer
    if others := question.out_of_plane:
        return Refusal(", ".join(others), f"be zero for {model}, which is plane", "other values")
    if elastomer is None:
        return None
    if (touch := shape_on_cover(sensor)) is not None:
        return Refusal("touch", f"be on a bare target for {model}", f"a {touch.words} on a cover")
    if not rough and elastomer.friction > 0.0:
        return Refusal("elastomer.friction", f"be 0 for {model}", f"{elastomer.friction:g}")
    if elastomer.mesh is not None or elastomer.kind == "pillars":
        got = "pillars" if elastomer.mesh is None else "elastomer.mesh"
        return Refusal("elastomer", f"be in one piece without a mesh of its own for {model}", got)
    return None


def _linear(sensor: Sensor, question: Question) -> Refusal | None:
    """Return why one compliance does not hold."""
    refusal = _layered("linear", sensor, question, rough=False)
    return refusal if refusal is not None or _is_flat(sensor) else _hair(sensor, "linear")


def _closed_form(sensor: Sensor, question: Question) -> Refusal | None:
    """Return why no formula holds."""
    return _layered("closed-form", sensor, question, rough=False) or flush_refusal(sensor)


def _axisymmetric(sensor: Sensor, question: Question) -> Refusal | None:
    """Return why a half meridian does not hold."""
    if refusal := coaxial_refusal(sensor):
        return refusal
    others = {name for load in question.loads for name, value in vars(load).items() if value and name != "F_z"}
    touch = shape_on_cover(sensor)
    if touch is not None and not touch.is_round:
        return Refusal("touch", "be round for axisymmetric", f"a {touch.words}")
    if others or not question.loads:
        return Refusal("loads", "be F_z alone for axisymmetric", ", ".join(sorted(others)) or "none")
    return _hair(sensor, "axisymmetric")


def _block(sensor: Sensor, question: Question) -> Refusal | None:
    """Return why a pad in space does not hold."""
    if sensor.target is not None and sensor.target.loops:
        return Refusal("target.shape", "be rectangle or disc for block", sensor.target.shape)
    return _hair(sensor, "block")


def _hair(sensor: Sensor, model: str) -> Refusal | None:
    """Refuse hairs, whose faces' triangles all overlap."""
    elastomer = sensor.elastomer
    if elastomer is None:
        return None
    thin = elastomer.diameter if elastomer.diameter is not None else min(elastomer.extent)
    if elastomer.thickness <= HAIR * thin:
        return None
    must = f"be at most {HAIR:g} times its smallest width ({mm(thin)}) for {model}"
    return Refusal("elastomer.thickness", must, mm(elastomer.thickness))


def _left_out(sensor: Sensor, question: Question, *, small: bool, flat: bool | None) -> tuple[Omission, ...]:
    """Return what a model leaves out: of `small` strain the finite one, which its own error holds; `flat` the ends.

    Without `flat` the pad decides. Of finite strain as much more as its share is, as in the error of `linear`.
    """
    found = list[Omission]()
    if small:
        bound = strain_bound(sensor, question.loads) if question.loads else math.inf  # of loads that are not known
        bound *= 1.0 + min(bound, 1.0)
        found.append(Omission(OmissionKind.FINITE_STRAIN, bound, Relative.DISPLACEMENT, bound=True, included=True))
    if _is_flat(sensor) if flat is None else flat:
        found.append(_ends(sensor, question))
    return (*found, *_of_loads(sensor, question))


def _of_loads(sensor: Sensor, question: Question) -> tuple[Omission, ...]:
    """Return what loads spare by their symmetry, and what history and other laws would change."""
    made, loads, found = silicones_of(sensor), question.loads, list[Omission]()
    if loads and (shares := [history_share(each) for each in made if each.has_history]):
        found.append(Omission(OmissionKind.HISTORY, max(shares), Relative.DISPLACEMENT, counts=False))
    size = max((each.mode_spread or 0.0 for each in made), default=0.0)
    if loads and size:  # a pad stiffens: of the displacement at most as much
        known = (("percent", f"{100.0 * size:.2g}"),)
        found.append(Omission(OmissionKind.LAW, size, Relative.DISPLACEMENT, bound=True, counts=False, numbers=known))
    elif loads and any(each.is_untested for each in made) and strain_bound(sensor, loads) > _OF_LAW:
        found.append(Omission(OmissionKind.LAW, math.nan, Relative.DISPLACEMENT, counts=False))
    symmetry, different = symmetry_of(sensor), len(set(loads))
    if loads and symmetry.mirrored and all(load == Wrench(F_z=load.F_z) for load in loads):
        return (*found, Omission(OmissionKind.SYMMETRY, 0.0, Relative.DISPLACEMENT))
    own = len(symmetry.without_images(loads))
    if own < different:
        numbers = (("solved", own), ("all", different))
        found.append(Omission(OmissionKind.IMAGES, 0.0, Relative.DISPLACEMENT, numbers=numbers))
    return tuple(found)


CLOSED_FORM = Description(
    "closed-form", "sits_mech.mechanics.closed_form:strip_layer", _closed_form,
    partial(_left_out, small=True, flat=True), (Rung(0.0, 0, 0, 0.0, 1e-5),), 6e-2,
)
LINEAR = Description(
    "linear", "sits_mech.mechanics.linear:small_strain", _linear, partial(_left_out, small=True, flat=None),
    (Rung(1e-2, 3700, 2, 0.1, 0.005), Rung(0.0, 9600, 3, 0.5, 0.02)), 5e-4, power=2.0, fresh=False,
)
PLANAR = Description(
    "planar", "sits_mech.mechanics.layer:planar_layer", partial(_layered, "planar"),
    partial(_left_out, small=False, flat=True),
    (Rung(1e-2, 1600, 15, 0.05, 0.05), Rung(0.0, 6000, 30, 0.1, 0.6)), 2e-4, power=2.0,
)
BLOCK = Description(
    "block", "sits_mech.mechanics.block:block_pad", _block, _of_loads,
    (
        Rung(1e-1, 3700, 15, 0.1, 0.2), Rung(1e-2, 9600, 20, 0.2, 0.7), Rung(1e-3, 28_600, 22, 0.3, 2.2),
        Rung(0.0, 48_000, 24, 0.3, 2.5),
    ),
    5e-4, power=2.0, bends=True,
)
AXISYMMETRIC = Description(
    "axisymmetric", "sits_mech.mechanics.layer:axisymmetric_pad", _axisymmetric, _of_loads,
    (Rung(1e-2, 600, 15, 0.05, 0.1), Rung(0.0, 3600, 30, 0.1, 0.5)), 5e-4, power=2.0, bends=True,
)
MODELS = (CLOSED_FORM, LINEAR, PLANAR, AXISYMMETRIC, BLOCK)
