"""Permeable plates in space: infinite slabs, images, demagnetising factors, reciprocity, energy, losses."""

import numpy as np
import pytest
from common.infinite_plate import Layer, coil_change

from sits_mech.geometry.collision import as_plate
from sits_mech.geometry.windings import coil_sections
from sits_mech.magnetics.coils.loops import mutual_loops
from sits_mech.magnetics.coils.ring_field import coil_potential
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space.far import seen
from sits_mech.magnetics.space.ferrite import Core, prepare_core, prepared_core
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.rungs import LADDER
from sits_mech.magnetics.space.sources import Sources
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import Coil, Conductor, load_sensor

MM = 1e-3
COIL = load_sensor("biorob2018").coils[0].model_copy(update={"centre": (0.0, 0.0)})
AXES = (np.linspace(0, 4, 5) * MM, np.linspace(0, 3, 4) * MM, np.linspace(0, 0.5, 2) * MM)
BOX = Box(np.array([4.0004, 3.0003, 0.50005]) * MM, (16, 14, 5), (1.8, 2.0, 8.0))


def sheet(mu: float, width: float, thickness: float, depth: float = 0.3, **changes: float) -> Conductor:
    """A square behind the coils, its face `depth` below their lowest layer [mm]."""
    return Conductor(
        name="ferrite", material="ferrite", relative_permeability=mu, shape="rectangle", width=width * MM,
        length=width * MM, thickness=thickness * MM, centre=(0.0, 0.0, -COIL.height - (depth + thickness / 2) * MM),
        **changes,
    )


def answers(coil: Coil, plate: Conductor, depth: float) -> tuple[float, float]:
    """Delta L of a coil in front of a plate [H] and its error."""
    seen = Sources((coil,), "rings", plate.centre, depth * MM)
    two = prepared_core(as_plate(plate), plate.metal.susceptibility, LADDER[1][1], 3 * MM, seen)
    found, off = (core.response[-1, -1].real for core in two)
    return float(found), float(abs(found - off))


# 10 x 10 mm, its face 0.5 mm below the coil's lowest layer: NGSolve 6.2, scalar potential with H_coil = -grad of its
# own projection, hexahedra of order 3 graded to edges, rings as three filaments; orders 2 and 3 differ by 1e-3.
SLOW = pytest.mark.slow
SHEETS = [  # thickness [mm], mu_r, Delta L [H]
    pytest.param(0.5, 10.0, 6.51730e-7, marks=SLOW), pytest.param(0.5, 100.0, 1.016819e-6, marks=SLOW),
    pytest.param(0.5, 2000.0, 1.079921e-6, marks=SLOW),
    pytest.param(2.0, 10.0, 8.686026e-7, marks=SLOW), pytest.param(2.0, 100.0, 1.072511e-6, marks=SLOW),
    pytest.param(2.0, 2000.0, 1.097584e-6, marks=SLOW),
]


@pytest.mark.parametrize("thickness, mu, exact", SHEETS)
def test_sheets_behind_a_coil_equal_finite_elements(thickness: float, mu: float, exact: float) -> None:
    """Within the tolerance of the rung, and the estimate is one: sheets of one box across missed 9e-3, with 1e-4."""
    found, error = answers(COIL, sheet(mu, 10.0, thickness, 0.5), 0.5)
    assert error < 5e-3 * exact
    assert found == pytest.approx(exact, rel=5e-3)
    assert abs(found - exact) < 3 * error


@pytest.mark.slow
def test_losses_of_a_sheet_equal_finite_elements() -> None:
    """The same sheet, mu_r = 100 (1 - 0.05 j): the imaginary part of the complex Delta L, R = -omega times that."""
    plate = sheet(100.0, 10.0, 0.5, 0.5, loss_tangent=0.05)
    seen = Sources((COIL,), "rings", plate.centre, 0.5 * MM)
    fine, coarse = (core.response[-1, -1] for core in
                    prepared_core(as_plate(plate), plate.metal.susceptibility, LADDER[0][1], 3 * MM, seen))
    found = (4 * fine - coarse) / 3
    assert found.real == pytest.approx(1.016965e-6, rel=1e-2)
    assert found.imag == pytest.approx(-3.11451e-9, rel=3e-2)


@pytest.mark.slow
def test_finer_rungs_of_ferrite_are_nearer() -> None:
    """The estimate falls with the tolerance, and the error with it."""
    plate, exact = sheet(100.0, 10.0, 0.5, 0.5), 1.016819e-6
    seen = Sources((COIL,), "rings", plate.centre, 0.5 * MM)
    off, told = [], []
    for _, rung in (LADDER[0], LADDER[-1]):
        two = prepared_core(as_plate(plate), plate.metal.susceptibility, rung, 3 * MM, seen)
        fine, coarse = (core.response[-1, -1].real for core in two)
        off.append(abs((4 * fine - coarse) / 3 - exact))
        told.append(abs(fine - coarse) / 3)
    assert off[1] < off[0] and told[1] < told[0] / 2
    assert off[1] < 3 * told[1]


@pytest.mark.slow
@pytest.mark.parametrize("mu", [10.0, 2000.0])
@pytest.mark.parametrize("thickness", [0.3, 2.0])
def test_wide_sheets_are_infinite_slabs(mu: float, thickness: float) -> None:
    """Dodd and Deeds' layer, of which 20 mm lack some: less than 2 % where little flux returns through the plate."""
    found, error = answers(COIL, sheet(mu, 20.0, thickness, 0.5), 0.5)
    above = coil_sections(COIL).mirrored()
    exact = float(coil_change(above, 0.5 * MM + COIL.height, 1.0, [Layer(1e-9, thickness * MM, mu)]).delta_L)
    lacking = 0.02 if thickness == 2.0 or mu == 10.0 else 0.03
    assert -lacking * exact - 2 * error < found - exact < 2 * error


@pytest.mark.slow
def test_thick_permeable_blocks_are_images() -> None:
    """A ring before a deep block: (mu - 1)/(mu + 1) of the mutual inductance with its mirror image."""
    keys = ('coils=[{name="C", centre=["0 mm", "0 mm"], layers=1, turns=1, inner_diameter="3.9 mm", '
            'track_width="0.1 mm", track_thickness="35 um"}]')
    ring = load_sensor("biorob2018", [keys]).coils[0]
    plate = sheet(50.0, 16.0, 6.0).model_copy(update={"centre": (0.0, 0.0, -ring.height / 2 - 4 * MM)})
    found, error = answers(ring, plate, 1.0)
    exact = 49.0 / 51.0 * float(mutual_loops(2 * MM, 2 * MM, 2 * MM))
    assert found == pytest.approx(exact, rel=0.03)
    assert abs(found - exact) < 2 * error + 0.01 * exact


def test_polynomials_and_coils_are_one_field() -> None:
    """Combinations of a coil's potential answer like the coil itself; and all is symmetric."""
    centred = COIL.model_copy(update={"centre": (1 * MM, 0.5 * MM)})
    (core,) = prepare_core([AXES], 99.0 + 0j, BOX, Sources((centred,), "rings", (0.0, 0.0, 3 * MM), 3 * MM))
    A = coil_potential(centred, core.box.points() + (0.0, 0.0, 3 * MM - BOX.half[2]), 3 * MM)
    a = seen(core, A[..., None], len(core.response))[:, 0]
    own = core.response[-1, -1]
    assert a @ core.response @ a == pytest.approx(own, rel=2e-4)
    assert a @ core.response[:, -1] == pytest.approx(own, rel=2e-4)
    np.testing.assert_allclose(core.response, core.response.T, rtol=0, atol=1e-9 * np.abs(core.response).max())
    assert np.linalg.eigvalsh(core.response).min() > -1e-9 * np.abs(core.response).max()  # L rises


def test_cube_in_a_uniform_field() -> None:
    """A = B (-y, x, 0) / 2: the moment is V chi / (1 + N chi) B / mu0 with N = 1/3, for weak chi that is all."""
    side = np.linspace(0, 1, 4) * MM
    box = Box(np.full(3, 1.0001) * MM, (2, 2, 2), (4.0, 4.0, 4.0))
    for chi in (1e-3, 0.5):
        core = _cube(side, box, chi)
        points = core.box.points()
        field = np.column_stack([-points[:, 1], points[:, 0], 0 * points[:, 0]])[..., None] / 2
        a = seen(core, field, len(core.response))[:, 0]
        found = float((a @ core.response @ a).real) * 4e-7 * np.pi
        assert found == pytest.approx(8 * MM**3 * chi / (1 + chi / 3), rel=1e-5 if chi < 0.01 else 5e-3)


def _cube(side: np.ndarray, box: Box, chi: float) -> Core:
    return prepare_core([(side, side, side)], chi + 0j, box, Sources((COIL,), "rings", (0, 0, 5 * MM), 4 * MM))[0]


def test_losses_follow_the_loss_tangent() -> None:
    """Weak magnetisation: R = omega Delta L mu_r tan delta / (mu_r - 1), for the flux in it is the coil's."""
    seen = Sources((COIL,), "rings", (0.0, 0.0, 3 * MM), 3 * MM)
    mu, tan = 1.001, 1e-4
    (core,) = prepare_core([AXES], mu * (1 - 1j * tan) - 1, BOX, seen)
    Z = (core.admittance(1e6) @ np.eye(len(core.response)))[-1, -1]
    assert Z.real / Z.imag == pytest.approx(mu * tan / (mu - 1), rel=1e-2)
    assert Z.real > 0.0 and Z.imag > 0.0


@pytest.mark.slow
def test_ferrite_behind_a_sensor() -> None:
    """L rises without target, and falls less under it than without ferrite; losses add to R; reciprocal."""
    bare = load_sensor("biorob2018")
    rest = Pose(0.0, 2 * MM)
    z0 = sheets(bare, 1e-2).impedance(rest, 5e6)
    found = []
    for tan in (0.0, 0.05):
        sensor = bare.model_copy(update={"conductors": (sheet(100.0, 18.0, 0.5, loss_tangent=tan),)})
        found.append(sheets(sensor, 1e-2).impedance(rest, 5e6))
        np.testing.assert_allclose(found[-1].L, found[-1].L.T, rtol=1e-12)
    alone = sheets(sensor.model_copy(update={"target": None}), 1e-2).impedance(rest, 5e6)
    assert np.all(np.diag(alone.L) > np.diag(z0.L0))
    assert np.all(np.diag(found[0].L) < np.diag(alone.L))
    assert np.all(np.diag(found[0].L - alone.L) < np.diag(z0.L - z0.L0))  # the target takes more: field is stronger
    assert np.all(np.diag(found[1].R) > np.diag(found[0].R))
    with pytest.raises(ValueError, match=r"conductors.ferrite.loss_tangent: planar-fem takes .* got 0.05"):
        planar_fem(sensor)
