"""What pose does a rigid target take on a pad, by an independent code? NGSolve's high-order elements at finite strain.

Saddle point of   E(u, p) = int w(F) + p (J - 1) - p^2/(2 K),    F = 1 + grad u, J = det F,

u in Q_k, continuous, p in Q_(k-2), not continuous: a stable pair on bricks (C. Bernardi, Y. Maday, Math. Models Methods
Appl. Sci. 9 (1999) 395); Q_3 takes Q_2, which is a little too stiff next to singular edges and far better elsewhere.
Or p in P_(k-1), complete polynomials of one order less: the pair of the package for k = 2, stable for every k.
Inner unknowns and pressures are eliminated element by element. Energies w(I1, I2) are differentiated by NGSolve:
nothing of this package's elements, laws or Newton's method is used. Sections in plane strain have F_yy = 1, of round
pads F_tt = 1 + u_r/r. Part of the bulk modulus may act at every point instead, ``k (J - 1)^2/2`` with ``p/(K - k)``:
the same material, whose small elements at an edge turn over later.

The target is exactly rigid: its motion q = (d_h, d_z, alpha) moves the bonded nodes, and is eliminated last, by the
stiffness that it feels. Lengths in mm, forces in shear moduli times mm^2 (times mm in plane strain).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from sits_mech.quantities import Array

_TIGHT = 1e-6  # size of the last step of q over q [-]
_LEAST = 2.0**-8  # share of the load below which a path is given up


class Law(NamedTuple):
    """A law over the initial shear modulus: energy of the isochoric (I1, I2); bulk over shear modulus."""

    energy: Callable[[Any, Any], Any]
    K: float


class Linearised(NamedTuple):
    """Step of all unknowns with the target at rest, what its motions take along, its forces and its stiffness."""

    step: Any
    ways: list[Any]
    force: Array
    stiffness: Array


def complete_polynomials(mesh: Any, order: int) -> Any:
    """Return the space of complete polynomials of each quadrilateral or brick, not continuous.

    NGSolve's own takes every product of Legendre polynomials: those of a higher total order are left out.
    """
    import ngsolve as ng

    products = ng.L2(mesh, order=order)
    low = [sum(powers) <= order for powers in np.ndindex(*(order + 1,) * mesh.dim)]
    kept = ng.BitArray(products.ndof)
    kept.Clear()
    for element in products.Elements(ng.VOL):
        for number, is_low in zip(element.dofs, low, strict=True):
            kept[number] = is_low
    return ng.Compress(products, active_dofs=kept)


@dataclass
class Pad:
    """A discrete pad that NGSolve moves.

    Attributes
    ----------
    kind : str
        "plane", "axisymmetric" or "solid".
    mesh : ngsolve.Mesh
    order : int
        Of the displacements.
    law : Law
    share : float
        Of the pad that is meshed: 1/2 or 1/4 by symmetry; of the axisymmetric one 1/(2 pi).
    motion : tuple of int
        Components of q that are free: of 0 d_h, 1 d_z, 2 alpha.
    height : float
        At which the force acts above the target's lower face [mm].
    odd : bool
        Whether the quarter is that of a load that a mirror at x = 0 turns round: small shear and moments.
    pointwise : float
        Part of the bulk modulus that acts at every point [shear moduli].
    seconds : float
        Processor time after which a load path is given up.
    complete : bool
        Whether pressures are complete polynomials of one order less.
    least : float
        Size of q down to which the last step is measured by q [mm]: of a load that goes back to none.
    """

    kind: str
    mesh: Any
    order: int
    law: Law
    share: float
    motion: tuple[int, ...]
    height: float
    odd: bool = False
    pointwise: float = 0.0
    seconds: float = 60.0
    complete: bool = False
    least: float = 0.0
    q: Array = field(init=False)

    def __post_init__(self) -> None:
        """Make the spaces, the energy and the motions of the bonded nodes."""
        import ngsolve as ng

        self.q = np.zeros(3)
        fixed = {"dirichlet": "ground|target", "dirichletx": "mirror_x"}
        if self.kind == "solid":
            fixed["dirichlety"] = "mirror_y"
        if self.odd:
            fixed |= {"dirichletx": "", "dirichlety": "mirror_y|mirror_x", "dirichletz": "mirror_x"}
        Q = complete_polynomials(self.mesh, self.order - 1) if self.complete else ng.L2(
            self.mesh, order=max(2, self.order - 2)
        )
        self.space = ng.VectorH1(self.mesh, order=self.order, **fixed) * Q
        u, p = self.space.TrialFunction()
        self.form, self.state = ng.BilinearForm(self.space, symmetric=True, condense=True), ng.GridFunction(self.space)
        self.form += ng.Variation(self._energy(ng, u, p).Compile() * ng.dx(bonus_intorder=2))
        up = (0.0, 1.0) if self.kind != "solid" else (0.0, 0.0, 1.0)
        along = (1.0, 0.0) if self.kind != "solid" else (1.0, 0.0, 0.0)
        ways = [ng.CF(along), ng.CF(up), ng.x * ng.CF(along), ng.x * ng.CF(up)]
        self.ways = []
        for way in ways:
            moved = ng.GridFunction(self.space)
            moved.components[0].Set(way, definedon=self.mesh.Boundaries("target"))
            self.ways.append(moved.vec)

    def _own(self) -> float:
        """Part of the bulk modulus that acts at every point: it keeps small elements at an edge from turning over."""
        return min(self.pointwise, 0.9 * self.law.K)

    def volume(self, ng: Any, u: Any) -> Any:
        """Volume ratio of a displacement."""
        J = ng.Det(ng.Id(self.mesh.dim) + ng.Grad(u))
        return J * (1.0 + u[0] / ng.x) if self.kind == "axisymmetric" else J

    def _energy(self, ng: Any, u: Any, p: Any) -> Any:
        """Energy density of displacement and pressure."""
        F = ng.Id(self.mesh.dim) + ng.Grad(u)
        hoop = 1.0 + u[0] / ng.x if self.kind == "axisymmetric" else 1.0
        J, C = self.volume(ng, u), F.trans * F
        if self.kind == "solid":
            trace, square = ng.Trace(C), ng.InnerProduct(C, C)
        else:
            trace, square = ng.Trace(C) + hoop**2, ng.InnerProduct(C, C) + hoop**4
        I1, I2 = J ** (-2 / 3) * trace, 0.5 * J ** (-4 / 3) * (trace * trace - square)
        own = self._own()
        energy = self.law.energy(I1, I2) + 0.5 * own * (J - 1) ** 2 + p * (J - 1) - p * p / (2 * (self.law.K - own))
        return energy * ng.x if self.kind == "axisymmetric" else energy

    def least_J(self) -> float:
        """Return the smallest volume ratio at the points of a rule on every element."""
        import ngsolve as ng

        J = self.volume(ng, self.state.components[0])
        kind = ng.ET.HEX if self.mesh.dim == 3 else ng.ET.QUAD
        at = self.mesh.MapToAllElements(ng.IntegrationRule(kind, 2 * self.order + 2), ng.VOL)
        return float(np.min(J(at)))

    def at_rest(self) -> Array:
        """Return the stiffness that the target feels at rest, for `motion`."""
        return self._linearised().stiffness / self.share

    def solve(self, load: Array, parts: int = 1) -> Array:
        """Return q under a load (F_x, F_z down, M), in steps that shrink where one does not converge."""
        done, step, began = 0.0, 1.0 / parts, time.process_time()
        kept, q = self.state.vec.CreateVector(), self.q.copy()
        kept.data = self.state.vec
        past: list[tuple[float, Any, Array]] = [(0.0, self.copied(kept), q.copy())]
        while done < 1.0 - 1e-12:
            goal = min(1.0, done + step)
            self._predict(past, goal)
            if self._newton(goal * load):
                done = goal
                kept.data, q = self.state.vec, self.q.copy()
                past = [*past[-1:], (done, self.copied(kept), q.copy())]
                step *= 2.0
            else:
                self.state.vec.data, self.q, step = kept, q.copy(), 0.4 * step
                past = past[-1:]
            if step < _LEAST or (done < 1.0 and time.process_time() - began > self.seconds):
                raise ArithmeticError(f"reached {done:.1%} of the load")
        return self.q.copy()

    @staticmethod
    def copied(vector: Any) -> Any:
        """Return a copy of a vector of NGSolve's."""
        found = vector.CreateVector()
        found.data = vector
        return found

    def _predict(self, past: list[tuple[float, Any, Array]], goal: float) -> None:
        """Go on along the line through the last two states, if there are two."""
        if len(past) == 2:
            (a, first, q), (b, second, r) = past
            ahead = (goal - b) / (b - a)
            self.state.vec.data = second + ahead * (second - first)
            self.q = r + ahead * (r - q)
            self._bond(self.q)

    def _bond(self, q: Array) -> None:
        """Move the bonded nodes rigidly to q."""
        bonded = self.space.components[0].GetDofs(self.mesh.Boundaries("target"))
        own, both = self.state.components[0].vec, np.asarray(bonded)
        values = q[0] * self._flat(0) + q[1] * self._flat(1)
        values += (np.cos(q[2]) - 1.0) * self._flat(2) - np.sin(q[2]) * self._flat(3)
        view = own.FV().NumPy()
        view[both] = values[: len(view)][both]

    def _flat(self, number: int) -> Array:
        """Values of a motion of the bonded nodes."""
        return np.asarray(self.ways[number].FV().NumPy())

    def _tangents(self) -> tuple[list[Any], Any]:
        """Derivatives of the bonded displacement by the free components of q, and the second one by alpha."""
        one, two, three, four = self.ways
        c, s = float(np.cos(self.q[2])), float(np.sin(self.q[2]))
        turn, bend = one.CreateVector(), one.CreateVector()
        turn.data = -s * three - c * four
        bend.data = -c * three + s * four
        each = [one, two, turn]
        return [each[k] for k in self.motion], bend

    def _newton(self, load: Array) -> bool:
        """Newton's method from the present state; whether it converged with volumes above zero."""
        last = 1.0
        for _ in range(10):
            try:
                at = self._linearised()
            except Exception:  # a singular element: its own type is not public
                return False
            wanted, second = self._load(load)
            if 2 in self.motion:
                k = self.motion.index(2)
                at.stiffness[k, k] -= second
            dq = np.linalg.solve(at.stiffness, wanted * self.share - at.force)
            self.state.vec.data += at.step
            for way, part in zip(at.ways, dq, strict=True):
                self.state.vec.data += float(part) * way
            self.q[list(self.motion)] += dq
            self._bond(self.q)
            size = float(np.abs(dq).max()) / max(float(np.abs(self.q).max()), self.least, 1e-300)
            if not np.isfinite(size) or size > 30.0 * last:
                return False
            if size < _TIGHT:
                return self.least_J() > 0.0
            last = min(last, size)
        return False

    def _linearised(self) -> Linearised:
        """Present state linearised: inner unknowns, then free nodes eliminated, for the motion of the target."""
        form, residual = self.form, self.state.vec.CreateVector()
        form.Apply(self.state.vec, residual)
        form.AssembleLinearization(self.state.vec)
        inverse = form.mat.Inverse(self.space.FreeDofs(True), inverse="sparsecholesky")
        outer, down, step = (residual.CreateVector() for _ in range(3))
        outer.data = residual
        outer.data += form.harmonic_extension_trans * residual
        down.data = inverse * outer
        step.data = form.inner_solve * residual
        step.data += down
        step.data += form.harmonic_extension * down
        step.data *= -1.0
        tangents, bend = self._tangents()
        ways, stiffness = [], np.zeros((len(tangents), len(tangents)))
        for k, T in enumerate(tangents):
            image = T.CreateVector()
            image.data = form.mat * T
            held = self.copied(T)
            held.data -= inverse * image
            image.data = form.mat * held
            stiffness[k] = [image.InnerProduct(other) for other in tangents]
            ways.append(self.copied(held))
            ways[-1].data += form.harmonic_extension * held
        if 2 in self.motion:
            k = self.motion.index(2)
            stiffness[k, k] += bend.InnerProduct(outer)
        return Linearised(step, ways, np.array([way.InnerProduct(residual) for way in ways]), stiffness)

    def _load(self, load: Array) -> tuple[Array, float]:
        """Forces on the free components of q, and the second derivative of the work by alpha."""
        F_x, F_z, M = load
        c, s = np.cos(self.q[2]), np.sin(self.q[2])
        each = np.array([F_x, -F_z, M + self.height * (F_x * c + F_z * s)])
        return each[list(self.motion)], float(self.share * self.height * (-F_x * s + F_z * c))
