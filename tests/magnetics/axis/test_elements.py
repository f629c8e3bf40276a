"""The field on the axis: energy, skin, far boundary, the same answer of any order; forms against integrals by hand."""

import numpy as np
import pytest
from scipy.constants import mu_0

from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.axis import lines as axis_lines
from sits_mech.magnetics.axis.elements import _forms, _nodes, solve_axis
from sits_mech.magnetics.axis.lines import CoaxialDisc, divide_axis
from sits_mech.magnetics.coils.ring_field import ring_profile
from sits_mech.magnetics.modes import skin_depth
from sits_mech.scene.sensor import Coil

MM = 1e-3
TEN = Coil(
    name="C", centre=(0.0, 0.0), layers=1, turns=10, inner_diameter=4 * MM, track_width=0.2 * MM, track_gap=0.2 * MM,
    track_thickness=35e-6,
)
STEEL = CoaxialDisc(8 * MM, 1 * MM, 2 * MM, 5e6, 100.0)


def test_forms_are_exact_for_polynomials() -> None:
    """u = r^2: int u^2 r dr = b^6 / 6 over [0, b], int (u' + u/r)^2 r dr = 9 b^4 / 4; over some cells alone, less."""
    edges = np.array([0.0, 0.3, 0.5, 1.2])
    u = _nodes(edges, 3) ** 2
    whole, part = _forms(edges, 3, radial=True), _forms(edges, 3, (0.0, 0.5), radial=True)
    for forms, b in ((whole, 1.2), (part, 0.5)):
        assert u @ forms[1] @ u == pytest.approx(b**6 / 6)
        assert u @ forms[0] @ u == pytest.approx(9 * b**4 / 4)
    along = _forms(edges, 3)
    assert u @ along[1] @ u == pytest.approx(1.2**5 / 5) and u @ along[0] @ u == pytest.approx(4 * 1.2**3 / 3)


def test_loss_is_what_the_current_dissipates() -> None:
    """R of the flux linkage equals the Joule heat of the field, int sigma |E|^2; they share no formula."""
    frequency = 1e5
    omega, lines = 2 * np.pi * frequency, divide_axis([STEEL], coil_sections(TEN), frequency, 0.8)
    found = solve_axis(lines, [STEEL], TEN, omega, 4)
    across, along = _forms(lines.r, 4, (0.0, STEEL.radius), radial=True), _forms(lines.z, 4, (STEEL.bottom, STEEL.top))
    heat = 2 * np.pi * STEEL.conductivity * omega**2 * np.vdot(found.u, across[1] @ found.u @ along[1]).real
    assert -omega * found.flux.imag == pytest.approx(heat, rel=1e-4)
    assert found.residual < 1e-12 and found.unknowns == lines.unknowns(4)


def test_current_decays_in_a_skin() -> None:
    """Over the windings A falls as exp(-(1 + j) s / delta) from the face that sees the coil, and the axis has none."""
    frequency = 3e5
    depth = skin_depth(frequency, STEEL.conductivity, 100.0)
    lines = divide_axis([STEEL], coil_sections(TEN), frequency, 0.8)
    found = solve_axis(lines, [STEEL], TEN, 2 * np.pi * frequency, 4)
    i, inside = int(np.argmin(np.abs(found.r - 4 * MM))), (found.z >= STEEL.bottom) & (found.z < 1 * MM + 4 * depth)
    s, A = found.z[inside] - STEEL.bottom, found.u[i, inside]
    np.testing.assert_allclose(A / A[0], np.exp(-(1 + 1j) * s / depth), atol=0.03)
    assert not found.u[0].any() and 4 * depth < 0.3 * MM


def test_field_bends_into_steel() -> None:
    """Across its face the tangential field nu dA/dz is continuous: B_r in steel is a hundred times that outside."""
    frequency = 1e3
    lines = divide_axis([STEEL], coil_sections(TEN), frequency, 0.7)
    found = solve_axis(lines, [STEEL], TEN, 2 * np.pi * frequency, 4)
    i, j = int(np.argmin(np.abs(found.r - 4 * MM))), int(np.flatnonzero(found.z == STEEL.bottom)[0])
    below, above = slice(j - 4, j + 1), slice(j, j + 5)

    def slope(at: slice, value: np.ndarray) -> complex:
        """Return dA/dz at the face of the polynomial through a cell's nodes."""
        z = found.z[at] - STEEL.bottom
        scale = np.abs(z).max()
        return complex(np.linalg.solve(np.vander(z / scale, increasing=True), value)[1] / scale)

    outer = found.r[i] * ring_profile(TEN, np.array(found.r[i]), found.z[below], 0.9 * MM, 1e-9) + found.u[i, below]
    outer[-1] -= found.g[i, j]  # at the face u is A already
    assert slope(above, found.u[i, above]) / 100.0 == pytest.approx(slope(below, outer), rel=2e-3)


@pytest.mark.slow
def test_far_boundary_is_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four times as far the answer is the same to what the module says; without the dipole's condition it is not."""
    disc, frequency = CoaxialDisc(4 * MM, 1 * MM, 1.2 * MM, 1e7, 200.0), 1e6

    def flux(far: float) -> complex:
        """Return Phi with a boundary so far."""
        monkeypatch.setattr(axis_lines, "_FAR", far)
        return solve_axis(divide_axis([disc], coil_sections(TEN), frequency, 0.8), [disc], TEN, 2e6 * np.pi, 4).flux

    exact, usual, near = flux(80.0), flux(20.0), flux(4.0)
    assert abs(usual - exact) < 1e-7 * abs(exact)
    assert 1e-7 * abs(exact) < abs(near - exact) < 1e-4 * abs(exact)


def test_no_disc_no_reaction() -> None:
    """What is neither permeable nor conducts to speak of does nothing; twice as little, half as much."""
    flux = [
        solve_axis(divide_axis([disc], coil_sections(TEN), 1e3, 1.0), [disc], TEN, 2e3 * np.pi, 3).flux
        for disc in (CoaxialDisc(8 * MM, 1 * MM, 2 * MM, sigma, 1.0) for sigma in (1e-3, 2e-3))
    ]
    assert abs(flux[0]) < 1e-9 * mu_0 and flux[1] == pytest.approx(2 * flux[0], rel=1e-6)
