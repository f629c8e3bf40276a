"""How does a metal foil bend on its pad that is pressed, on a spot or evenly? Another code's answer, the foil meshed.

NGSolve. A foil of E, nu and thickness h, by displacements, lies on silicone of mu and K = 1000 mu, by displacements
u of order n and a continuous pressure p of order n - 1 that ends with it (one that goes on into the foil, whose stress
is larger by E/mu, softens it by a fifth and more). Lengths in mm, forces in N.

    box    small strain, a quarter of a rectangle on a box of 20 x 20 mm, n = 3;
    disc   half a meridian of a disc of 12 mm on a cylinder of 20 mm, n = 4, at finite strain: mu/2 (J^(-2/3) I_1 - 3) +
           p (J - 1) - p^2/(2 K), the foil Saint Venant's and Kirchhoff's, the pressure a dead load, in steps of 0.5 N.

Prints heights of the foil's middle plane over that of a rigid foil on the same mesh, less one; one ten thousand times
as stiff stands for it, which bends by 2e-4 and less of what it moves, of boxes its mean. Edges of a box's bond that are
meshed three times as fine lower the pad by 1 % more and move these shares by 0.001. NGSolve is no dependency of the
package; the numbers stand in tests/mechanics/foil/test_bending.py.

Run ``python studies/common/ngsolve_foil.py`` (five minutes).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

THICKNESS, MODULUS, POISSON, SPOT = 2.0, 1.3e5, 0.343, 1.0  # mm, MPa, mm
RIGID = 1e4  # times as stiff
BOXES = ((15.0, 0.1), (15.0, 0.2), (15.0, 0.4), (8.0, 0.2))  # width, of 8 mm length, and thickness of foils
DISCS, LOADS = (0.1, 0.2, 0.4), (1.0, 6.0)  # thicknesses; N


def box(width: float, h: float, E: float, mu: float = 0.014943, *, even: bool = False) -> list[float]:
    """Return the heights in the middle, at the ends along x and y and in a corner, and the mean [mm]."""
    from netgen.occ import Box, Glue, OCCGeometry
    from ngsolve import (
        H1,
        BilinearForm,
        Compress,
        Grad,
        GridFunction,
        Id,
        IfPos,
        InnerProduct,
        Integrate,
        LinearForm,
        Mesh,
        Trace,
        VectorH1,
        div,
        ds,
        dx,
        x,
        y,
    )

    a, b, t = width / 2, 4.0, THICKNESS
    pad, foil = Box((0, 0, 0), (10, 10, t)), Box((0, 0, t), (a, b, t + h))
    for solid in (pad, foil):
        solid.faces.Min((1, 0, 0)).name, solid.faces.Min((0, 1, 0)).name = "sx", "sy"
    pad.faces.Min((0, 0, 1)).name, foil.faces.Max((0, 0, 1)).name = "ground", "top"
    pad.mat("pad"), foil.mat("foil")
    foil.maxh = 0.6
    mesh = Mesh(OCCGeometry(Glue([pad, foil])).GenerateMesh(maxh=1.2))
    V = VectorH1(mesh, order=3, dirichletx="sx|ground", dirichlety="sy|ground", dirichletz="ground")
    X = V * Compress(H1(mesh, order=2, definedon="pad"))
    (u, p), (v, q) = X.TnT()

    def eps(w: Any) -> Any:
        return (Grad(w) + Grad(w).trans) / 2

    def dev(w: Any) -> Any:
        return eps(w) - Trace(eps(w)) / 3 * Id(3)

    G, K = E / 2 / (1 + POISSON), E / 3 / (1 - 2 * POISSON)
    A = BilinearForm(X, symmetric=True)
    A += (2 * mu * InnerProduct(dev(u), dev(v)) + p * div(v) + q * div(u) - p * q / (1000 * mu)) * dx("pad")
    A += (2 * G * InnerProduct(dev(u), dev(v)) + K * div(u) * div(v)) * dx("foil")
    spot = IfPos(SPOT**2 - x * x - y * y, 1.0, 1.0 if even else 0.0)
    top = mesh.Boundaries("top")
    f = LinearForm(X)
    f += -0.25 / Integrate(spot, mesh, definedon=top, order=20) * spot * v[2] * ds("top", bonus_intorder=16)
    A.Assemble()
    f.Assemble()
    found = GridFunction(X)
    found.vec.data = A.mat.Inverse(X.FreeDofs(), inverse="umfpack") * f.vec
    w, e = found.components[0], 1e-2
    places = [(e, e), (a - e, e), (e, b - e), (a - e, b - e)]
    mean = Integrate(w[2], mesh, definedon=top) / (a * b)
    return [*(float(w(mesh(*place, t + h / 2))[2]) for place in places), float(mean)]


def disc(h: float, E: float, loads: Sequence[float], mu: float = 0.02) -> list[list[float]]:
    """Return the heights in the middle, half-way to the rim and at the rim [mm], load by load."""
    import numpy as np
    from netgen.occ import Glue, MoveTo, OCCGeometry
    from ngsolve import (
        CF,
        H1,
        BilinearForm,
        Det,
        Grad,
        GridFunction,
        Id,
        InnerProduct,
        Mesh,
        Parameter,
        Trace,
        Variation,
        VectorH1,
        ds,
        dx,
        x,
    )

    a, t = 6.0, THICKNESS
    pad, inner = MoveTo(0, 0).Rectangle(10, t).Face(), MoveTo(0, t).Rectangle(SPOT, h).Face()
    outer = MoveTo(SPOT, t).Rectangle(a - SPOT, h).Face()
    pad.faces.name, inner.faces.name, outer.faces.name = "pad", "foil", "foil"
    pad.edges.Min((0, 1, 0)).name, inner.edges.Max((0, 1, 0)).name = "ground", "spot"
    for face in (pad, inner):
        face.edges.Min((1, 0, 0)).name = "axis"
    inner.maxh = outer.maxh = 0.25
    shape = Glue([pad, inner, outer])
    for vertex in shape.vertices:
        if abs(vertex.p[0] - a) + abs(vertex.p[1] - t) < 1e-6:
            vertex.maxh = 0.02
    mesh = Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=0.3))
    V = VectorH1(mesh, order=4, dirichletx="ground|axis", dirichlety="ground")
    X = V * H1(mesh, order=3, definedon="pad")
    u, p = X.TrialFunction()
    slope = Grad(u)
    around = 1 + u[0] / (x + 1e-14)
    F = CF((1 + slope[0, 0], slope[0, 1], 0, slope[1, 0], 1 + slope[1, 1], 0, 0, 0, around), dims=(3, 3))
    J, C = Det(F), F.trans * F
    green, K = (C - Id(3)) / 2, 1000 * mu
    lame, G = E * POISSON / (1 + POISSON) / (1 - 2 * POISSON), E / 2 / (1 + POISSON)
    pressure, ring = Parameter(0.0), 2 * np.pi * x
    A = BilinearForm(X, symmetric=True)
    A += Variation(ring * (mu / 2 * (Trace(C) * J ** (-2 / 3) - 3) + p * (J - 1) - p * p / (2 * K)) * dx("pad"))
    A += Variation(ring * (lame / 2 * Trace(green) ** 2 + G * InnerProduct(green, green)) * dx("foil"))
    A += Variation(ring * pressure / (np.pi * SPOT**2) * u[1] * ds("spot"))
    found, heights, before = GridFunction(X), [], 0.0
    for load in loads:
        for step in np.linspace(before, load, 1 + max(1, round((load - before) / 0.5)))[1:]:
            pressure.Set(step)
            left = np.inf
            while left > 1e-16:
                residual, way = found.vec.CreateVector(), found.vec.CreateVector()
                A.Apply(found.vec, residual)
                A.AssembleLinearization(found.vec)
                way.data = A.mat.Inverse(X.FreeDofs(), inverse="umfpack") * residual
                left = abs(InnerProduct(way, residual))
                found.vec.data -= way
        before = load
        heights.append([float(found.components[0](mesh(r, t + h / 2))[1]) for r in (1e-3, a / 2, a - 1e-3)])
    return heights


def main() -> None:
    """Print all cases."""
    for width, h in BOXES:
        own, flat = (box(width, h, E) for E in (MODULUS, RIGID * MODULUS))
        _say(f"{width:g} x 8 mm, foil {h} mm: middle, ends, corner, mean", own, flat[-1])
    own, flat = (box(15.0, 0.2, E, even=True) for E in (MODULUS, RIGID * MODULUS))
    _say("15 x 8 mm, foil 0.2 mm, even: middle, ends, corner, mean", own, flat[-1])
    for h in DISCS:
        for load, own, flat in zip(LOADS, *(disc(h, E, LOADS) for E in (MODULUS, RIGID * MODULUS)), strict=True):
            _say(f"disc, foil {h} mm, {load:g} N: middle, half-way, rim", own, flat[0])


def _say(case: str, heights: Sequence[float], rigid: float) -> None:
    """Print heights [mm] over a rigid foil's, less one."""
    shares = ", ".join(f"{height / rigid - 1:.4f}" for height in heights)
    sys.stdout.write(f"{case} {shares} of {rigid:.5f} mm\n")


if __name__ == "__main__":
    main()
