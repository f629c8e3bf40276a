"""Energy of a layer at rest, which the work of the target's forces must be."""

from __future__ import annotations

import numpy as np

from sits_mech.mechanics.element.kernel import element_forces
from sits_mech.mechanics.equilibrium.body import unpack_state
from sits_mech.mechanics.layer import PlanarLayer
from sits_mech.quantities import Equilibrium


def stored(model: PlanarLayer, equilibrium: Equilibrium, *, limit: bool = False) -> float:
    """Return the energy of a layer at rest [J], contacts included: the work of the target's forces.

    On the mesh whose state is kept; with `limit` extrapolated from the first two levels as the pose is.
    """
    levels, scales = model.line[int(equilibrium.state[0])], model.line.scales
    fine, coarse = levels.fine, levels.coarse
    halves = np.split(equilibrium.state[1:], [fine.size])
    energies = []
    for body, half in zip((coarse, fine), reversed(halves), strict=True):
        state = unpack_state(body, half, scales.load(equilibrium.wrench)[:3])
        parts = sum(part(state.u, state.q).energy for part in body.parts)
        own = element_forces(body.mesh, body.laws, state.u).energy
        energies.append(np.array([own + parts]))
    found = levels.limit(energies).value if limit else energies[-1]
    return scales.force * scales.thickness * float(found[0])
