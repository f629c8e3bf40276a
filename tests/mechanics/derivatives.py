"""Forces and stiffness as derivatives of an energy, by differences."""

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import element_forces, element_stiffness, summed

H = 1e-6


def check_elements(mesh, laws, u, v, rtol=1e-5):
    """The elements' forces and their stiffness, which is returned, along v at u."""
    found = element_forces(mesh, laws, u)
    stiffness = element_stiffness(mesh, laws, u, found.pressure)
    up, down = (element_forces(mesh, laws, u + s * H * v) for s in (1, -1))
    assert (up.energy - down.energy) / (2 * H) == pytest.approx(found.forces @ v, rel=1e-6)
    product = np.zeros(u.size)
    np.add.at(product, mesh.dofs, np.einsum("eij,ej->ei", stiffness, v[mesh.dofs]))
    difference = (up.forces - down.forces) / (2 * H)
    np.testing.assert_allclose(product, difference, rtol=rtol, atol=0.1 * rtol * np.abs(difference).max())
    return stiffness


def check_faces(contact, u, q, v, moved, rel=1e-6):
    """What free faces push with along v, of the nodes and the target, which `moved` carries from q."""
    n = u.size
    found, up, down = (contact(u + step * v[:n], moved(q, step * v[n:])) for step in (0.0, H, -H))
    assert found.energy > 0.0
    assert (up.energy - down.energy) / (2 * H) == pytest.approx(found.forces @ v, rel=rel)
    product = summed(found.numbers, found.stiffness @ v[found.numbers][..., None], n + 6)
    np.testing.assert_allclose(product, (up.forces - down.forces) / (2 * H), atol=1e-5 * np.abs(product).max())
    return found


def shaken(body, plane, lift):
    """Displacements of a body at which a plane's faces touch, and a way of its nodes and the target."""
    rng, n = np.random.default_rng(0), body.mesh.nodes.size
    u, v = 0.01 * rng.normal(size=n), rng.normal(size=n + 6)
    u[2::3] += lift
    if plane == "wall":  # drawn in
        u.reshape(-1, 3)[:, :2] -= 0.03 * body.mesh.nodes[:, :2]
    return u, v
