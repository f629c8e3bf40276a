"""What is a layer to be solved? Mesh, law, bonds and contacts, all that stays from load to load; and its state.

The total potential of a state is ``E(u) + V(q) + sum of the parts``: the elements' energy (forms.py), the dead load's
(target.py), and what else stores energy, such as contact (contact.py). The nodes bonded to the target follow
q = (d_h, d_z, alpha). Scales: lengths by the thickness, stresses by the shear modulus.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sits_mech.mechanics.assembly import Pattern, pattern
from sits_mech.mechanics.block_energy import SolidEnergy
from sits_mech.mechanics.energy import PlaneEnergy
from sits_mech.mechanics.forms import (
    Indices,
    Section,
    Tangent,
    deformation,
    node_volumes,
    plane_cofactor,
    tangent,
)
from sits_mech.quantities import Array


class Term(NamedTuple):
    """A part of the energy, its forces (n + 3,) on the n displacements and q, its stiffness as triplets of these.

    Their rows and columns are the same in every state.
    """

    energy: float
    forces: Array
    rows: Indices
    columns: Indices
    values: Array


Part = Callable[[Array, Array], Term]
"""Displacements and q in, a part of the energy with two derivatives out."""


class Element(NamedTuple):
    """What elements of one kind answer: linearisation, ``F`` and ``J``, ``H = dJ/dF`` of F, and J at their nodes."""

    tangent: Callable[..., Tangent]
    deformation: Callable[[Section, Array], tuple[Array, Array]]
    cofactor: Callable[[Array], Array]
    pointwise: Callable[[Section, Array], Array] | None = None


PLANE = Element(tangent, deformation, plane_cofactor, node_volumes)
"""Plane strain, forms.py."""


@dataclass(frozen=True)
class Bonded:
    """A meshed layer with its target and its law: all that stays the same from load to load.

    Attributes
    ----------
    mesh : Section
    law : callable
        Isochoric energy.
    K : float
        Bulk modulus [shear moduli].
    height : float
        Where the force acts above the bonded face [thicknesses].
    free : ndarray
        Numbers of the displacements that are unknown.
    bonded : ndarray, shape (n, 2)
        Numbers of the bonded nodes' displacements along x and z.
    X : ndarray, shape (n,)
        Their distances from the target's centre [thicknesses].
    rows, columns : ndarray
        Sparsity of the element stiffnesses; that of the parts they tell themselves, the same in every state.
    element : Element
        What the mesh is made of.
    parts : tuple of callable
        What stores energy besides the elements.
    guarded : bool
        Whether one of the parts keeps J above zero at the elements' nodes, so that no step may pass it.
    shared : callable or None
        Gives the pattern where bodies of one mesh share it.
    """

    mesh: Section
    law: PlaneEnergy | SolidEnergy
    K: float
    height: float
    free: Indices
    bonded: Indices
    X: Array
    rows: Indices
    columns: Indices
    element: Element = PLANE
    parts: tuple[Part, ...] = ()
    guarded: bool = False
    shared: Callable[[], Pattern] | None = None

    @cached_property
    def pattern(self) -> Pattern:
        """Where the entries of the stiffnesses go."""
        if self.shared is not None:
            return self.shared()
        n = self.mesh.nodes.size
        terms = [part(np.zeros(n), np.zeros(3)) for part in self.parts]
        rows, columns = (
            np.concatenate([own, *others])
            for own, others in (
                (self.rows, [term.rows for term in terms]), (self.columns, [term.columns for term in terms])
            )
        )
        return pattern(rows, columns, self.free, np.concatenate([self.bonded.ravel(), n + np.arange(3)]))


@dataclass(frozen=True)
class State:
    """A layer in a deformed state, not necessarily at rest.

    Attributes
    ----------
    u : ndarray, shape (d n,)
        Nodal displacements [thicknesses].
    q : ndarray, shape (3,)
        Shear, upward displacement [thicknesses], clockwise rotation [rad].
    p : ndarray, shape (e, d + 1)
        Pressures [shear moduli].
    residual : float
        Norm of the gradient over the size of the load.
    iterations : int
        Linear solves spent.
    min_J : float
        Smallest volume ratio at a quadrature point; of a state at rest, at the elements' nodes too.
    load : ndarray, shape (3,)
        F_x, F_z, M on the target, scaled: given, or what holds it.
    """

    u: Array
    q: Array
    p: Array
    residual: float = 0.0
    iterations: int = 0
    min_J: float = 1.0
    load: Array = field(default_factory=lambda: np.zeros(3))


def rest(body: Bonded) -> State:
    """Return the undeformed state."""
    return State(np.zeros(body.mesh.nodes.size), np.zeros(3), np.zeros(body.mesh.chi.shape[:2]))


def packed(state: State) -> Array:
    """Return a state's displacements, q and pressures as one array."""
    return np.concatenate([state.u, state.q, state.p.ravel()])


def smallest_volume(body: Bonded, u: Array, *, everywhere: bool) -> float:
    """Return the smallest J at the quadrature points and, everywhere or where guarded, at the elements' nodes."""
    least = float(body.element.deformation(body.mesh, u)[1].min())
    pointwise = body.element.pointwise
    if pointwise is not None and (everywhere or body.guarded):
        least = min(least, float(pointwise(body.mesh, u).min()))
    return least
