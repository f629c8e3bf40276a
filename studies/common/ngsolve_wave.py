"""How stiff is a round pad sideways and in tilt, at small strain? One wave around the axis, by NGSolve.

    u_r = a(r, z) cos,    u_t = b(r, z) sin,    u_z = c(r, z) cos      of the angle from x

in the energy of linear elasticity, the angle integrated by hand: a section instead of a solid. The target moves by d_h:
(a, b, c) = (1, -1, 0), and turns by alpha: (0, 0, -r). Pressures as in ngsolve_pad.py, order by order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sits_mech.quantities import Array


def wave_stiffness(mesh: Any, order: int, K: float) -> Array:
    """Return the stiffness (2, 2) for (d_h, alpha) in shear moduli and mm, about the centre of the bonded face."""
    import ngsolve as ng

    sides = ng.H1(mesh, order=order, dirichlet="ground|target")
    space = sides * sides * ng.H1(mesh, order=order, dirichlet="ground|target|mirror_x") * ng.L2(mesh, order=order - 2)
    a, b, c, p = space.TrialFunction()
    r = ng.x
    d_a, d_b, d_c = (ng.grad(item) for item in (a, b, c))
    normal = (d_a[0], (a + b) / r, d_c[1])
    shear = (0.5 * (d_a[1] + d_c[0]), 0.5 * (d_b[0] - (a + b) / r), 0.5 * (d_b[1] - c / r))
    trace = normal[0] + normal[1] + normal[2]
    energy = sum(item * item for item in normal) + 2.0 * sum(item * item for item in shear) - trace * trace / 3.0
    form = ng.BilinearForm(space, symmetric=True)
    form += ng.Variation(np.pi * r * (energy + p * trace - p * p / (2.0 * K)) * ng.dx(bonus_intorder=2))
    start = ng.GridFunction(space)
    form.AssembleLinearization(start.vec)
    inverse = form.mat.Inverse(space.FreeDofs(), inverse="umfpack")
    moves = []
    for ways in ((1.0, -1.0, 0.0), (0.0, 0.0, -r)):
        moved = ng.GridFunction(space)
        for component, way in zip(moved.components[:3], ways, strict=True):
            component.Set(ng.CF(way), definedon=mesh.Boundaries("target"))
        full = moved.vec.CreateVector()
        full.data = moved.vec - inverse * (form.mat * moved.vec).Evaluate()
        moves.append((moved.vec, full))
    k = np.zeros((2, 2))
    for i, (_, full) in enumerate(moves):
        image = full.CreateVector()
        image.data = form.mat * full
        for j, (own, _) in enumerate(moves):
            k[i, j] = image.InnerProduct(own)
    return k
