"""What is the impedance of a coil whose every turn is solid, under a coaxial disc? NGSolve, A_phi over (r, z).

    curl(1/mu0 curl A) + j omega sigma A = sigma V_t / (2 pi r) in turn t,
    I_t = int sigma [V_t / (2 pi r) - j omega A].

A unit voltage around each turn in turn gives the turns' admittance; the coil is the sum over its inverse. A = 0 on a
cylinder of radius and half height `_FAR`. NGSolve is no dependency: it is imported where it is asked.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

MM = 1e-3
_FAR = 150.0 * MM
_COPPER, _MU0 = 5.8e7, 4e-7 * np.pi


def solid_turns(
    coil: Mapping[str, float], gap: float | None, frequency: float, order: int = 4, bow: float = 0.0
) -> tuple[float, float]:
    """Return R [ohm] and L [H] of the whole coil; sizes of `coil`, `gap` and `bow` in mm, as of solid_turns.json.

    The disc stands off by the gap in its middle, and by gap + bow at its rim, as a bowl: gap + bow (r/R)^2.
    """
    import ngsolve as ng
    from netgen.geom2d import SplineGeometry

    omega = 2.0 * np.pi * frequency
    depth = np.sqrt(2.0 / (omega * _MU0 * _COPPER))
    shape = SplineGeometry()
    shape.AddRectangle((0.0, -_FAR), (_FAR, _FAR), bcs=["far", "far", "far", "axis"], leftdomain=1, rightdomain=0)
    shape.SetMaterial(1, "air")
    w, h = coil["width"] * MM, coil["thickness"] * MM
    places = [
        (coil["inner"] * MM / 2 + w / 2 + i * (coil["width"] + coil["gap"]) * MM, -h / 2 - k * coil["pitch"] * MM)
        for k in range(int(coil["layers"])) for i in range(int(coil["turns"]))
    ]
    parts = [((r - w / 2, z - h / 2), (r + w / 2, z + h / 2), min(0.7 * depth, w / 3)) for r, z in places]
    for number, (low, high, size) in enumerate(parts, start=2):
        shape.AddRectangle(low, high, leftdomain=number, rightdomain=1, bc="copper")
        shape.SetMaterial(number, f"part{number}")
        shape.SetDomainMaxH(number, size)
    if gap is not None:  # from a hair beside the axis on, where no two lines may meet
        number, r = 2 + len(parts), np.linspace(0.02, 4.0, 25)
        low = np.column_stack([r, gap + bow * (r / r[-1]) ** 2])
        around = [shape.AppendPoint(*point) for point in MM * np.concatenate([low, low[::-1] + (0.0, 0.2)])]
        for here, there in zip(around, np.roll(around, -1).tolist(), strict=True):
            shape.Append(["line", here, there], leftdomain=number, rightdomain=1, bc="copper")
        shape.SetMaterial(number, f"part{number}")
        shape.SetDomainMaxH(number, min(1.2 * depth, 0.1 * MM))
    mesh = ng.Mesh(shape.GenerateMesh(maxh=_FAR / 8, grading=0.2))
    space = ng.H1(mesh, order=order, complex=True, dirichlet="far|axis")
    (u, v), r = space.TnT(), ng.x
    metal = mesh.MaterialCF({f"part{number}": _COPPER for number in range(2, 3 + len(parts))}, default=0)
    up = [ng.grad(each)[0] + each / (r + 1e-15) for each in (u, v)]
    form = ng.BilinearForm(space, symmetric=True)
    form += (ng.grad(u)[1] * ng.grad(v)[1] + up[0] * up[1]) * r / _MU0 * ng.dx(bonus_intorder=2)
    form += 1j * omega * metal * u * v * r * ng.dx
    form.Assemble()
    inverse, solved = form.mat.Inverse(space.FreeDofs()), []
    for number in range(2, 2 + len(places)):
        load, found = ng.LinearForm(space), ng.GridFunction(space)
        load += mesh.MaterialCF({f"part{number}": _COPPER}, default=0) / (2.0 * np.pi) * v * ng.dx
        load.Assemble()
        found.vec.data = inverse * load.vec
        solved.append((load.vec, found.vec))
    flux = [[ng.InnerProduct(load, found, conjugate=False) for _, found in solved] for load, _ in solved]
    alone = [
        _COPPER / (2.0 * np.pi) * ng.Integrate(mesh.MaterialCF({f"part{n}": 1.0}, default=0) / r, mesh, order=10)
        for n in range(2, 2 + len(places))
    ]
    Z = complex(np.linalg.inv(np.diag(alone) - 2j * np.pi * omega * np.array(flux)).sum())
    return Z.real, Z.imag / omega
