"""Contact of the 3D pad's free faces: derivatives, the layer in plane strain, work, what the answer hangs on."""

import numpy as np
import pytest
from scipy import sparse

from sits_mech.mechanics.block_contact import SolidContact
from sits_mech.mechanics.block_mesh import bonded_block
from sits_mech.sensor import Elastomer, Target, load_sensor

MM = 1e-3
NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def scene(pad, target, t=2.0):
    """A pad of one size or two [mm], a diameter or width and length, under a target; the force acts at its bottom."""
    base = load_sensor("biorob2018", ["target.load_height=0", NEO_HOOKEAN])
    outline = [dict(zip(("width", "length") if len(size) == 2 else ("diameter",), (each * MM for each in size),
                        strict=True)) for size in (pad, target)]
    shape = {"shape": "disc" if len(target) == 1 else "rectangle", "material": "copper", "load_height": 0.0}
    plate = Target.model_validate({**outline[1], **shape, "thickness": 0.2 * MM})
    layer = Elastomer.model_validate({**outline[0], "material": base.elastomer.material, "thickness": t * MM})
    return base.model_copy(update={"target": plate, "elastomer": layer})


@pytest.mark.parametrize(
    ("pad", "target", "plane", "q", "lift"),
    [
        ((8, 8), (8, 8), "ground", (0.05, -0.2, 0.1), -0.3),
        ((8, 8), (8, 8), "plane", (0.05, -0.2, 0.1), 0.1),
        ((8, 6), (5, 3), "wall", (0.02, -0.01, 0.001), 0.008),
        ((8,), (8,), "plane", (0.05, -0.2, 0.1), 0.1),
        ((8,), (5,), "wall", (0.02, -0.01, 0.001), 0.008),
    ],
)
def test_contact_has_an_exact_tangent(pad, target, plane, q, lift):
    body = bonded_block(scene(pad, target), 2, 1.5, 0.0, 0.05).body
    contact = next(part for part in body.parts if isinstance(part, SolidContact) and part.plane == plane)
    rng, n, q, h = np.random.default_rng(0), body.mesh.nodes.size, np.array(q), 1e-6
    u, v = 0.01 * rng.normal(size=n), rng.normal(size=n + 3)
    u[2::3] += lift
    if plane == "wall":  # drawn in
        u.reshape(-1, 3)[:, :2] -= 0.03 * body.mesh.nodes[:, :2]
    found, up, down = contact(u, q), *(contact(u + s * h * v[:n], q + s * h * v[n:]) for s in (1, -1))
    assert found.energy > 0.0
    assert (up.energy - down.energy) / (2 * h) == pytest.approx(found.forces @ v, rel=1e-6)
    product = sparse.coo_matrix((found.values, (found.rows, found.columns)), shape=(n + 3, n + 3)) @ v
    np.testing.assert_allclose(product, (up.forces - down.forces) / (2 * h), atol=1e-5 * np.abs(product).max())
