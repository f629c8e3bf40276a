"""Pads of layers: cells, laws and lines, beside pads of one silicone."""

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import element_forces
from sits_mech.mechanics.pad.section import SectionFineness, bonded_body
from sits_mech.mechanics.pad.shapes import lines_through
from sits_mech.mechanics.pad.solid import bonded_block
from sits_mech.mechanics.pad.stack import Interface, interfaces, layer_of_cells
from sits_mech.scene.sensor import load_sensor
from tests.mechanics.derivatives import check_elements

STIFF = '{law="neo-hookean", shear_modulus="80 kPa", bulk_modulus="4 MPa"}'
SOFT = '{law="mooney-rivlin", c10="7 kPa", c01="3 kPa", bulk_modulus="1 MPa"}'


def sensor(*layers, size='width="12 mm", length="10 mm"'):
    """A target of 8 mm on a pad of layers, each a silicone, a thickness and what else it has."""
    tables = ", ".join(f'{{material={made}, thickness="{t} mm"{more}}}' for made, t, more in layers)
    return load_sensor("biorob2018", [f"elastomer={{{size}, layers=[{tables}]}}"])


TWO = sensor((STIFF, 1.0, ", free_stretch=1.02"), (SOFT, 1.5, ""))


def test_lines_lie_at_interfaces_and_close_up_where_two_silicones_meet():
    lines = lines_through(4, 2.0, True, 0, (Interface(0.25, True), Interface(0.5, False)))
    steps = np.diff(lines)
    assert {0.0, 0.25, 0.5, 1.0} <= set(lines.tolist()) and np.all(steps > 0.0)
    at = [int(np.flatnonzero(lines == z)[0]) for z in (0.25, 0.5)]
    assert steps[at[0]] == pytest.approx(0.25 / 16) and steps[at[0] - 1] == pytest.approx(0.125 / 16)
    assert steps[at[1]] == pytest.approx(0.5 * (1.0 - 0.75**2)) and steps[-1] == pytest.approx(0.5 / 16)
    assert lines_through(4, 2.0, True, 0, (Interface(0.5, False),)) == pytest.approx(lines_through(4, 2.0, True))


def test_every_cell_lies_in_one_layer():
    assert interfaces(TWO.elastomer) == (Interface(pytest.approx(0.4), True),)
    mesh = bonded_block(TWO, 2, whole=True).body.mesh
    z, of = mesh.nodes[mesh.cells][..., 2], layer_of_cells(TWO, mesh)
    assert np.all(z[of == 0] <= 0.4 + 1e-12) and np.all(z[of == 1] >= 0.4 - 1e-12)
    assert mesh.inside.weights[of == 0].sum() == pytest.approx(0.4 * mesh.inside.weights.sum())


@pytest.mark.parametrize("make", [
    lambda: bonded_block(TWO, 1).body, lambda: bonded_body(TWO, SectionFineness(2, 1.0, fan=True, guard=2.0)),
    lambda: bonded_block(TWO, 1, guard=5.0).body,
])
def test_forces_and_stiffness_are_derivatives_of_the_energy_of_both_laws(make):
    body, rng = make(), np.random.default_rng(3)
    u, v = 2e-3 * rng.normal(size=body.mesh.nodes.size), rng.normal(size=body.mesh.nodes.size)
    check_elements(body.mesh, body.laws, u, v, rtol=1e-4)


def test_energies_are_those_of_each_silicone_in_its_own_cells():
    """Squeezed evenly: K/2 (J - 1)^2 of each by its share of the height, over the moduli in series; the rest is shear.

    1/mu = (0.4/80 + 0.6/20)/kPa = 1/28.571 kPa; free stretches left out.
    """
    two = sensor((STIFF, 1.0, ""), (SOFT, 1.5, ""))
    body, J = bonded_block(two, 1).body, 0.9
    u = ((J ** (1.0 / 3.0) - 1.0) * body.mesh.nodes).ravel()
    found, volume = element_forces(body.mesh, body.laws, u), body.mesh.inside.weights.sum()
    expected = 0.5 * (0.4 * 4000.0 + 0.6 * 1000.0) / (1.0 / (0.4 / 80.0 + 0.6 / 20.0)) * (J - 1.0) ** 2
    assert found.energy == pytest.approx(expected * volume, rel=1e-9)
