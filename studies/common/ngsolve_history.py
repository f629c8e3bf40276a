"""How does a pad with a rate and a softening follow a history of its load, by an independent code? NGSolve's elements.

    int S : sym(F^T grad v) + p cof F : grad v + (J - 1 - p/K) q = work of the load on the rigid target
    S = J^(-2/3) DEV[S'],   S' = S'_0 + sum_i g_i (S'_0 - A_i),   S'_0 = eta(W, W_max) DEV[2 dW/dCbar]
    A_i' = (S'_0 - A_i)/tau_i   trapezoidal rule,   g_i = w_i/(1 - sum w)

The convolution by parts: ``int exp(-(t - s)/tau) dS'_0 = S'_0 - A``, with A the past S'_0 that fades. The stress itself
is put into the weak form, W differentiated by NGSolve, and the form once more for Newton's method: no incremental
potential, no exponential step, no tangent of the package's. Elements, meshes, pressures and the rigid target are those
of ngsolve_pad.py; A_i, S'_0 and W_max live at the points of the elements' own rule. Steps end at the load's corners.

Lengths in mm, stresses in initial shear moduli, times in s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from common.ngsolve_pad import Pad

from sits_mech.quantities import Array

_LEAST_DEPTH = 1e-9  # of the energy by which a fall below W_max is measured [shear moduli]
_LEAST = 1e-2  # of the pad's thickness: motion by which the last step of a smaller one is measured
_HALVINGS = 6  # of a step that does not converge


class PadHistory:
    """A pad of ngsolve_pad.py that remembers; load after load is put on it.

    Parameters
    ----------
    pad : Pad
        At rest; its form is replaced.
    prony : sequence of (float, float)
        Share of the instantaneous stiffness [-] and time [s] of each branch.
    mullins : mapping or None
        r [-], m [shear moduli], beta [-].
    """

    def __init__(self, pad: Pad, prony: Sequence[tuple[float, float]], mullins: Mapping[str, float] | None) -> None:
        """Make the form, and the past at the points of its rule."""
        import ngsolve as ng
        from ngsolve.comp import IntegrationRuleSpace

        self.pad, self.prony, self.soft = pad, prony, mullins
        pad.least = _LEAST * float(np.ptp([point.p[pad.mesh.dim - 1] for point in pad.mesh.ngmesh.Points()]))
        slow = 1.0 - sum(weight for weight, _ in prony)
        self.shares = [weight / slow for weight, _ in prony]
        self.count = 6 if pad.kind == "solid" else 4
        scalar = IntegrationRuleSpace(pad.mesh, order=2 * pad.order + 2)
        rules = scalar.GetIntegrationRules()
        self.largest = ng.GridFunction(scalar)
        tensors = scalar**self.count
        self.before = ng.GridFunction(tensors)
        self.faded = [ng.GridFunction(tensors) for _ in prony]
        self.keep = [ng.Parameter(0.0) for _ in prony]  # (1 - h)/(1 + h), h = dt/(2 tau)
        self.take = [ng.Parameter(0.0) for _ in prony]  # h/(1 + h)
        form = ng.BilinearForm(pad.space, symmetric=True, condense=True)
        (u, p), (v, r) = pad.space.TnT()
        form += self._weak(ng, u, p, v, r).Compile() * ng.dx(intrules=rules)
        pad.form = form
        now = self._softened(ng, *self._strain(ng, pad.state.components[0])[:2])
        self.now, self.energy = now[0].Compile(), now[1].Compile()
        self.work = (ng.GridFunction(tensors), ng.GridFunction(scalar))

    def _strain(self, ng: Any, u: Any) -> tuple[Any, Any, Any, Any]:
        """C and its inverse as components, J, and F in the plane or in space."""
        pad = self.pad
        F = ng.Id(pad.mesh.dim) + ng.Grad(u)
        C, J = F.trans * F, pad.volume(ng, u)
        inverse = ng.Inv(C)
        if pad.kind == "solid":
            pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
            return tuple(C[i, j] for i, j in pairs), tuple(inverse[i, j] for i, j in pairs), J, F
        around = (1.0 + u[0] / ng.x) ** 2 if pad.kind == "axisymmetric" else ng.CF(1.0)
        flat = tuple(C[i, j] for i, j in ((0, 0), (1, 1), (0, 1)))
        back = tuple(inverse[i, j] for i, j in ((0, 0), (1, 1), (0, 1)))
        return (flat[0], flat[1], around, flat[2]), (back[0], back[1], 1.0 / around, back[2]), J, F

    def _dot(self, A: Any, B: Any) -> Any:
        """Product of two symmetric tensors by their components, those off the diagonal last."""
        return sum((1.0 if k < 3 else 2.0) * A[k] * B[k] for k in range(self.count))

    def _softened(self, ng: Any, C: Any, inverse: Any) -> tuple[Any, Any]:
        """S'_0 as a vector, and W."""
        det = C[0] * C[1] * C[2] - C[3] ** 2 * C[2]
        if self.count == 6:
            det = C[0] * C[1] * C[2] + 2.0 * C[3] * C[4] * C[5]
            det = det - C[0] * C[5] ** 2 - C[1] * C[4] ** 2 - C[2] * C[3] ** 2
        scale = det ** (-1.0 / 3.0)
        bar = [scale * one for one in C]
        I1 = bar[0] + bar[1] + bar[2]
        first = I1.MakeVariable()
        second = (0.5 * (I1 * I1 - self._dot(bar, bar))).MakeVariable()
        W = self.pad.law.energy(first, second)
        w_1, w_2 = W.Diff(first), W.Diff(second)
        slope = [2.0 * (w_1 + w_2 * first) * (1.0 if k < 3 else 0.0) - 2.0 * w_2 * bar[k] for k in range(self.count)]
        excess = self._dot(slope, C) / 3.0
        eta = self._eta(ng, W)
        return ng.CF(tuple(eta * (slope[k] - excess * inverse[k]) for k in range(self.count))), W

    def _eta(self, ng: Any, W: Any) -> Any:
        """Softening at an energy."""
        if not self.soft:
            return ng.CF(1.0)
        depth = self.soft.get("m", 0.0) + self.soft.get("beta", 1.0) * self.largest + _LEAST_DEPTH
        return 1.0 - ng.IfPos(W - self.largest, 0.0, ng.erf((self.largest - W) / depth)) / self.soft["r"]

    def _weak(self, ng: Any, u: Any, p: Any, v: Any, r: Any) -> Any:
        """The integrand."""
        pad = self.pad
        C, inverse, J, F = self._strain(ng, u)
        S_0, _ = self._softened(ng, C, inverse)
        total = S_0
        for k, g in enumerate(self.shares):
            A = self.keep[k] * self.faded[k] + self.take[k] * (self.before + S_0)
            total = total + g * (S_0 - A)
        excess = self._dot(total, C) / 3.0
        own = pad._own()
        push = J * (p + own * (J - 1.0))
        S = [J ** (-2.0 / 3.0) * (total[k] - excess * inverse[k]) + push * inverse[k] for k in range(self.count)]
        E = F.trans * ng.Grad(v)  # its symmetric part is the variation of C over two
        if pad.kind == "solid":
            dE = [E[0, 0], E[1, 1], E[2, 2], *(0.5 * (E[i, j] + E[j, i]) for i, j in ((0, 1), (0, 2), (1, 2)))]
        else:
            ring = (1.0 + u[0] / ng.x) * v[0] / ng.x if pad.kind == "axisymmetric" else ng.CF(0.0)
            dE = [E[0, 0], E[1, 1], ring, 0.5 * (E[0, 1] + E[1, 0])]
        density = self._dot(S, dE) + (J - 1.0 - p / (pad.law.K - own)) * r
        return density * ng.x if pad.kind == "axisymmetric" else density

    def follow(self, times: Array, loads: Array) -> Array:
        """Return the motion (d_h, d_z, alpha) of the target at `times` [s], shape (n, 3), the load linear between.

        Parameters
        ----------
        times : ndarray, shape (n,)
            From 0, where the pad is at rest.
        loads : ndarray, shape (n, 3)
            F_x, F_z down, M [shear moduli mm^2, of the moment mm^3].

        Raises
        ------
        ArithmeticError
            Where a step does not converge, however short.
        """
        found, past = [np.zeros(3)], None
        for k in range(1, len(times)):
            whole = self.pad.copied(self.pad.state.vec)
            q = self.pad.q.copy()
            ahead = (times[k] - times[k - 1]) / (times[k - 1] - times[k - 2]) if k > 1 else 0.0
            if past is not None and np.allclose(loads[k] - loads[k - 1], ahead * (loads[k - 1] - loads[k - 2])):
                self.pad.state.vec.data = whole + ahead * (whole - past[0])
                self.pad.q = q + ahead * (q - past[1])
                self.pad._bond(self.pad.q)
            self._step(times[k - 1], times[k], loads[k - 1], loads[k], (whole, q), _HALVINGS)
            past = whole, q
            found.append(self.pad.q.copy())
        return np.array(found)

    def _step(self, a: float, b: float, first: Array, last: Array, rest: tuple[Any, Array], left: int) -> None:
        """Go from a to b; in halves where Newton's method does not get there, from `rest` on."""
        for k, (_, tau) in enumerate(self.prony):
            h = 0.5 * (b - a) / tau
            self.keep[k].Set((1.0 - h) / (1.0 + h))
            self.take[k].Set(h / (1.0 + h))
        if self.pad._newton(last):
            self._remember()
            return
        if left == 0:
            raise ArithmeticError(f"no equilibrium at {b:g} s")
        self.pad.state.vec.data, self.pad.q = rest[0], rest[1].copy()
        middle, half = 0.5 * (a + b), 0.5 * (first + last)
        self._step(a, middle, first, half, rest, left - 1)
        self._step(middle, b, half, last, (self.pad.copied(self.pad.state.vec), self.pad.q.copy()), left - 1)

    def _remember(self) -> None:
        """Bring the past at the points up to the present state."""
        new, W = self.work
        new.Interpolate(self.now)
        W.Interpolate(self.energy)
        for k in range(len(self.prony)):
            values = self.faded[k].vec.FV().NumPy()
            both = self.before.vec.FV().NumPy() + new.vec.FV().NumPy()
            values[:] = self.keep[k].Get() * values + self.take[k].Get() * both
        self.before.vec.data = new.vec
        peak = self.largest.vec.FV().NumPy()
        peak[:] = np.maximum(peak, W.vec.FV().NumPy())
