"""Estimate the effect of `elastomer.edge_radius` (fillet.py) on the pose at small strain.

The layer's compliance at rest, with fillets and with sharp edges, each extrapolated from its first three meshes
(ladder.py), applied to one load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.pad.planar import layer_family
from sits_mech.mechanics.rest.body import rest
from sits_mech.mechanics.rest.newton import compliance
from sits_mech.quantities import Array
from sits_mech.scene.sensor import Elastomer, Sensor

_LEVELS = 3  # meshes of each


class Edges(NamedTuple):
    """Scaled compliances with fillets and with sharp edges, (3, 3)."""

    rounded: Array
    sharp: Array
    height: float  # of the force above the bonded face
    flush: bool  # the layer ends with its target
    radius: float  # from the scene [m]


def edge_effect(sensor: Sensor) -> Edges | None:
    """Return the effect of the fillets of a sensor's layer; None for sharp edges."""
    elastomer, target = sensor.elastomer, sensor.target
    if elastomer is None or target is None or elastomer.edge_radius is None:
        return None
    plain = Elastomer.model_validate(elastomer.model_dump() | {"edge_radius": None})
    rounded, sharp = (_compliance(scene) for scene in (sensor, sensor.model_copy(update={"elastomer": plain})))
    flush = elastomer.extent[0] - target.extent[0] < 1e-9 * elastomer.thickness
    return Edges(rounded, sharp, target.load_height / elastomer.thickness, flush, elastomer.edge_radius)


def _compliance(sensor: Sensor) -> Array:
    """Return the compliance of a layer at rest, scaled, shape (3, 3)."""
    levels = layer_family(sensor)
    bodies = [levels.maker(level) for level in range(_LEVELS)]
    found = [compliance(body, rest(body), np.zeros(3)).ravel() for body in bodies]
    return levels.limit(found).value.reshape(3, 3)


def edge_notes(edges: Edges, load: Array, thickness: float) -> tuple[str, ...]:
    """Return notes on the fillets under a load F_x, F_z, M, scaled; thickness in m."""
    force = np.array([load[0], -load[1], load[2] + edges.height * load[0]])
    d_h, d_z, alpha = (edges.rounded - edges.sharp) @ force * [thickness, thickness, 1.0]
    told = (
        f"edge radius {1e3 * edges.radius:.3g} mm: moves the target by {1e6 * d_h:+.3g} um along x, "
        f"{-1e6 * d_z:+.3g} um down, {np.degrees(alpha):+.3g} deg, against sharp edges (small strain)"
    )
    if edges.flush:
        return (told,)
    return told, "the target's edge stays sharp: no side face of the layer ends there that could have a radius"
