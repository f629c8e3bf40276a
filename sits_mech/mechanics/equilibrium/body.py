"""Describe a layer to be solved: mesh, law, bonds and contacts, which stay from load to load; and its state.

The total potential of a state is ``E(u) + V(q) + sum of the parts``: the elements' energy (element/kernel.py), the dead
load's (element/target.py), and what else stores energy, such as contact. The nodes bonded to the target follow its
motion q. Scales: lengths by the thickness, stresses by the shear modulus.

A body carries which components of q it frees: three in the plane and in the half of a pad that is its own mirror image
in y = 0, six in a whole pad; about an axis three, of which two do not move. What such a symmetry hides, displacements
that are odd in y and the other three components, is solved nowhere; a state at rest must withstand them all the same,
so half a pad carries their pattern, too, and about an axis there is the first harmonic (element/sideways.py).
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, TypeVar

import numpy as np

from sits_mech.mechanics.element.assembly import Part, Pattern, pattern
from sits_mech.mechanics.element.kernel import Deformed, Laws, deformation, deformed
from sits_mech.mechanics.element.mesh import MixedMesh
from sits_mech.mechanics.element.patch import Patch, at_rims, patch_of
from sits_mech.mechanics.element.target import bonded_displacement
from sits_mech.mechanics.faces.contact import Contact
from sits_mech.mechanics.faces.face_contact import FaceContact, Faces, face_contact, faces_press
from sits_mech.mechanics.faces.folds import SelfContact
from sits_mech.mechanics.faces.rigid import Press
from sits_mech.memory import SECONDS
from sits_mech.quantities import Array, Integers, Mask

ROOM = 2**25
"""Bytes of the states that a body remembers: 25 on the finest mesh of a pad, 800 on its second one."""
_ROUNDING = 1e-5  # of K: the least force that a residual is taken over
_Found = TypeVar("_Found", bound=Any)


@dataclass(frozen=True)
class Bonded:
    """A meshed layer with its target and law: all that stays the same from load to load.

    `shared` gives a pattern common to the bodies of one mesh; `hidden` that of displacements hidden by half symmetry,
    if any; `cut` which cells are parts of those at rims of a coarser mesh, None if it has no such parts.
    """

    mesh: MixedMesh
    laws: Laws
    height: float  # of the force above the bonded face [thicknesses]
    free: Integers  # numbers of the unknown displacements
    bonded: Integers  # (n, d), numbers of the bonded nodes' displacements
    X: Array  # (n, 3), bonded nodes from the target's centre [thicknesses]
    faces: Faces
    components: int = 3  # freed components of q, 3 or 6
    parts: tuple[Part, ...] = ()  # stored energy besides the elements
    guarded: bool = False  # a part keeps J > 0 at the elements' nodes: no step may pass it
    shared: Callable[[], Pattern] | None = None
    hidden: Callable[[], Pattern] | None = None
    cut: Callable[[], Mask | None] | None = None
    press: Press | None = None  # on its cover, by all loads; None: loads act on the target

    @cached_property
    def pattern(self) -> Pattern:
        """Assembly pattern of the stiffnesses."""
        if self.shared is not None:
            return self.shared()
        return self._made(self.free)

    @cached_property
    def patch(self) -> Patch | None:
        """The cells at its rims that steps may eliminate; None with contact or a guard, and where these are all."""
        if self.parts or self.press or self.laws.guarded or self.faces.skin is None:
            return None
        cells = self.cut() if self.cut is not None else None
        if cells is None:
            cells = at_rims(self.mesh, self.faces.skin.surface.nodes, self.free)
        return patch_of(self.mesh, self.free, cells)

    @cached_property
    def plain(self) -> Bonded:
        """The body without the motions that symmetry hides."""
        return replace(self, hidden=None, shared=lambda: self.pattern)

    @cached_property
    def rests(self) -> dict[bytes, Any]:
        """What was found from what was asked, the last of it: it depends on that and the limit of time alone."""
        return {}

    def name_of(self, start: State, *asked: object) -> bytes:
        """Return the name of a question from a state among `rests`."""
        return hashlib.sha256(pickle.dumps((SECONDS.get(), replace(start, known=None), asked))).digest()

    def keep(self, name: bytes, found: _Found) -> _Found:
        """Keep and return what was found, but for the deformation of its state, which is large and made again."""
        self.rests[name] = replace(found, state=replace(found.state, known=None))
        while 8 * self.size * len(self.rests) > ROOM:
            del self.rests[next(iter(self.rests))]
        return found

    def _made(self, free: Integers) -> Pattern:
        """Make the pattern with some displacements free."""
        terms = [part(np.zeros(self.mesh.nodes.size), np.zeros(6)) for part in self.parts]
        numbers = (self.mesh.dofs, *(term.numbers for term in terms if len(term.numbers)))
        return pattern(self.mesh, numbers, free, border(self.mesh, self.bonded))

    def with_target(self, q: Array) -> Array:
        """Return the displacements of the bonded nodes at a target's motion, shape (n, d)."""
        return bonded_displacement(self.X, q * self.freed)[:, list(self.mesh.axes)]

    def on_target(self, load: Array) -> Array:
        """Return what of a load acts on the target itself."""
        return load if self.press is None else np.zeros_like(load)

    def near(self, u: Array) -> Bonded:
        """Return the body that holds faces near in a state against each other (faces/folds.py).

        It is the body itself, with its pattern, if it holds these already.
        """
        parts = tuple(part.near(u) if isinstance(part, SelfContact) else part for part in self.parts)
        if all(new is old for new, old in zip(parts, self.parts, strict=True)):
            return self
        found = replace(self, parts=parts)
        if all(part.pairs is None or len(part.pairs) == 0 for part in parts if isinstance(part, SelfContact)):
            return found
        hidden = self.hidden
        odd = None if hidden is None else cache(lambda: found._made(np.sort(hidden().free)))
        return replace(found, shared=cache(lambda: found._made(self.free)), hidden=odd)

    def touching(self, state: State) -> FaceContact:
        """Return what its free faces touch in a state."""
        return face_contact(self.faces, self.mesh, self.parts, state.u, state.q)

    def pressed(self, state: State) -> bool:
        """Whether its free faces press something in a state, so that its meshes show no order."""
        return faces_press(self.mesh, self.parts, state.u, state.q)

    @cached_property
    def freed(self) -> Array:
        """Ones of the components of q that move it, (k,); about an axis that along it alone."""
        return np.array([0.0, 1.0, 0.0]) if self.mesh.hoop else np.ones(self.components)

    @cached_property
    def slips(self) -> bool:
        """Whether friction holds points of its faces in an increment of a path."""
        return any(isinstance(part, Contact) and part.grip is not None for part in self.parts)

    def meets(self, load: Array) -> bool:
        """Whether a rigid shape presses on its cover by a load."""
        return self.press is not None and self.press.meets(load)

    def stands(self, u: Array, load: Array) -> float:
        """Return where a shape stands that presses on its cover by a load, displaced by u; nan without one."""
        return np.nan if self.press is None else self.press.height(u, load)

    def reach(self, thickness: float = 1.0) -> Array:
        """Return the factors from motion components to displacements of the target's edge, shape (6,) [1, m]."""
        x, y = (float(each) for each in np.abs(self.X[:, :2]).max(axis=0) * thickness)
        return np.array([1.0, 1.0, x, 1.0, y or x, max(x, y)])

    @cached_property
    def levers(self) -> Array:
        """Those of its own components, shape (k,) [thicknesses]."""
        return self.reach()[: self.components]

    def sunk(self, q: Array) -> tuple[float, float]:
        """Return how far the target's middle, and the lowest place of its edge, have sunk [thicknesses]."""
        return -q[1], -q[1] + np.abs(self.reach()[: len(q)] * q)[2::2].sum()

    def length(self, step: Array) -> float:
        """Return the displacement of the target's edge in a step (dc, dw) of shape (k,) [thicknesses]."""
        return float(np.linalg.norm(self.levers * step))

    @property
    def rounding(self) -> float:
        """The least force that a residual is taken over."""
        return _ROUNDING * float(self.laws.K.max())

    @property
    def size(self) -> int:
        """Length of a packed state."""
        return int(self.mesh.nodes.size + self.components + np.prod(self.mesh.chi.shape[:2]))


@dataclass(frozen=True)
class State:
    """A layer in a deformed state, not necessarily at rest."""

    u: Array  # (d n,), nodal displacements [thicknesses]
    q: Array  # (3,) or (6,): d_h, d_z, alpha, d_y, alpha_x, alpha_z [thicknesses, rad]
    p: Array  # (e, m), pressures [shear moduli]
    load: Array = field(repr=False)  # (k,): F_x, F_z, M, F_y, M_x, M_z, given or found, scaled
    residual: float = 0.0  # norm of the gradient over the size of the load
    iterations: int = 0  # linear solves
    min_J: float = 1.0  # smallest J at quadrature points; at rest, at the elements' nodes too
    known: Deformed | None = field(default=None, repr=False)  # cached deformation; see `deformed_state`
    height: float = np.nan  # of a shape that presses on its cover, from where it touches at rest [thicknesses]
    grip: tuple[Array, ...] = field(default=(), repr=False)  # friction tractions (m, 3) of each contact, in its frame


def border(mesh: MixedMesh, bonded: Integers) -> Integers:
    """Return the numbers of the bonded displacements, of the six components of q, and of a shape's height."""
    return np.concatenate([bonded.ravel(), mesh.nodes.size + np.arange(7)])


def rest(body: Bonded) -> State:
    """Return the undeformed state; at rest unless the silicone swells."""
    zero = np.zeros(body.components)
    return State(np.zeros(body.mesh.nodes.size), zero, np.zeros(body.mesh.chi.shape[:2]), zero)


def deformed_state(body: Bonded, state: State) -> Deformed:
    """Return a state's deformation at the quadrature points, cached or computed."""
    known = state.known
    return known if known is not None and known.u is state.u else deformed(body.mesh, state.u)


def pack_state(state: State) -> Array:
    """Pack displacements, q and pressures into one array."""
    return np.concatenate([state.u, state.q, state.p.ravel()])


def unpack_state(body: Bonded, array: Array, load: Array) -> State:
    """Unpack the state under a load from the beginning of an array."""
    n, k = body.mesh.nodes.size, body.components
    u, q, p, _ = np.split(array, [n, n + k, body.size])
    least = float(deformation(body.mesh, u)[1].min())
    return State(u, q, p.reshape(body.mesh.chi.shape[:2]), load, min_J=least)


def smallest_volume(body: Bonded, u: Array, *, everywhere: bool, known: Deformed | None = None) -> float:
    """Return the smallest J at the quadrature points and, if `everywhere` or guarded, at the elements' nodes."""
    least = float((known or deformed(body.mesh, u)).J.min())
    if body.mesh.nodal is None or not (everywhere or body.guarded):
        return least
    return min(least, float(deformation(body.mesh, u, body.mesh.nodal)[1].min()))
