"""Slopes by temperature of the whole chain: against answers at other temperatures, and tables moved along them."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

from sits_mech.analysis.readings.bench import (
    absolute,
    codes_of,
    sensor_calibration,
    sensor_front_end,
    table_codes,
    terminals,
)
from sits_mech.analysis.readings.codes import code_slopes
from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.derivatives import temperature as temperature_module
from sits_mech.chain.derivatives.gradient import gradient
from sits_mech.chain.derivatives.temperature import CHAINED, at_other_temperature, read_at, relative_slopes
from sits_mech.chain.models import mechanical_model
from sits_mech.chain.simulate import simulate
from sits_mech.quantities import SolveFailed, SolveReport, Wrench
from sits_mech.readout.inversion import Inverse
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.scene.thermal import at_temperature, clock_factor

PLANE = {"mechanics": "planar", "magnetics": "planar", "tolerance": 1e-2}
QUICK = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
LOAD = Wrench(F_x=0.1, F_z=0.5)
COEFFICIENTS = ('readout.capacitance_coefficient="30 ppm/K"', 'readout.clock_coefficient="-2 ppm/K"')


def sensor(*keys: str) -> Sensor:
    """Return the two-coil sensor with keys changed, free faces left alone."""
    return load_sensor("biorob2018", ['elastomer.contact="never"', *keys])


@pytest.fixture(scope="module")
def data() -> xr.Dataset:
    """A small table with slopes."""
    return calibrate(sensor(*COEFFICIENTS), F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], drift=True, **QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("celsius", [20, 50])
def test_the_whole_derivative_is_that_of_differences(celsius: int) -> None:
    """Sum of the causes against answers made anew 10 and 20 K around, differences of fourth order: to 1e-4 of the most.

    At 5 kHz: where the skin is thin the plate's division follows it, and answers made anew differ by that as well.
    """
    here = sensor(f'temperature="{celsius} degC"', 'frequency="5 kHz"')
    found = gradient(here, LOAD, CHAINED, **PLANE)
    ways = (-2, -1, 1, 2)
    each = {way: simulate(here.model_copy(update={"temperature": here.temperature + 10.0 * way}), LOAD, **PLANE)
            for way in ways}

    def slope(of) -> np.ndarray:
        return (8.0 * (of(each[1]) - of(each[-1])) - (of(each[2]) - of(each[-2]))) / (12.0 * 10.0)

    L = slope(lambda one: np.diagonal(one.impedance.L))
    by_cause = np.einsum("iin->in", found.L)
    np.testing.assert_allclose(by_cause.sum(axis=1), L, rtol=0.0, atol=1e-4 * np.abs(by_cause).max())
    pose = slope(lambda one: one.equilibrium.pose.components)
    np.testing.assert_allclose(found.pose.sum(axis=1)[:3], pose[:3], rtol=1e-4, atol=1e-4 * abs(pose[1]))


@pytest.mark.slow
@pytest.mark.parametrize("mechanics", ["linear", pytest.param("block", marks=pytest.mark.slow)])
def test_the_pose_goes_as_answers_made_anew(mechanics: str) -> None:
    """Other mechanics, by all causes at 40 degC, over 10 and 20 K to both sides: to 1e-3 of the largest component."""
    here = sensor('temperature="40 degC"')
    models = {"mechanics": mechanics, "magnetics": "planar", "tolerance": 0.1}
    found = gradient(here, LOAD, CHAINED, **models).pose.sum(axis=1)[:3]
    each = {}
    for way in (-2, -1, 1, 2):
        there = here.model_copy(update={"temperature": here.temperature + 10.0 * way})
        each[way] = mechanical_model(there, mechanics, 0.1, [LOAD])[0].equilibrium(LOAD).pose.components[:3]
    expected = (8.0 * (each[1] - each[-1]) - (each[2] - each[-2])) / 120.0
    lever = np.array([1.0, 1.0, 4e-3])
    np.testing.assert_allclose(lever * found, lever * expected, rtol=0.0, atol=1e-3 * np.abs(lever * expected).max())


@pytest.mark.slow
def test_causes_of_a_table_sum_to_the_whole(data: xr.Dataset) -> None:
    """What is read is the inductance's own slope, and the capacitor's and twice the clock's share of L."""
    L = np.diagonal(data["L"].transpose("F_x", "F_z", "coil", "coil_2").to_numpy(), axis1=2, axis2=3)
    by_cause = data["slope_T_L_by"].sum("thermal_cause").to_numpy()
    np.testing.assert_allclose(by_cause, data["slope_T_L"].to_numpy() + L * (30e-6 - 2 * 2e-6), rtol=1e-12)
    single = gradient(sensor(), Wrench(F_x=0.2, F_z=1.0), CHAINED, **QUICK)
    own = data.sel(F_x=0.2, F_z=1.0)
    np.testing.assert_allclose(own["slope_T_L"], np.einsum("iin->in", single.L).sum(axis=1), rtol=1e-3)
    np.testing.assert_allclose(own["slope_T_d_v"], single.pose[1].sum(), rtol=1e-3)


@pytest.mark.slow
def test_a_moved_table_is_one_at_another_temperature(data: xr.Dataset) -> None:
    """By 2 K: within 1 % of the change, as a second derivative leaves; what is read has capacitor and clock in it."""
    scene = sensor(*COEFFICIENTS)
    moved = at_other_temperature(scene, data, scene.temperature + 2.0)
    anew = calibrate(scene.model_copy(update={"temperature": scene.temperature + 2.0}), F_x=[-0.2, 0.0, 0.2],
                     F_z=[0.0, 0.5, 1.0], **QUICK)
    cold, warm, read = (np.diagonal(part["L"].to_numpy(), axis1=2, axis2=3) for part in (data, anew, moved))
    change = warm * (1 + 60e-6) * (1 - 4e-6) ** 2 - cold  # 1/((2 pi f)^2 C): C larger, the clock slower
    np.testing.assert_allclose(read - cold, change, rtol=1e-2)
    assert at_other_temperature(scene, data, scene.temperature) is data


@pytest.fixture(scope="module")
def planar() -> xr.Dataset:
    """A table with slopes of the cheap models that solve the pad."""
    return calibrate(sensor(*COEFFICIENTS), F_x=np.linspace(-0.4, 0.4, 5), F_z=np.linspace(0.0, 1.5, 5), drift=True,
                     **PLANE)


def read_by(temperature: float, data: xr.Dataset, load: Wrench) -> tuple[Inverse, np.ndarray]:
    """Return forces of a reading that the chain makes at a temperature [degC], and what is left of them."""
    scene = sensor(*COEFFICIENTS)
    warm, dT = scene.model_copy(update={"temperature": 273.15 + temperature}), temperature - 20.0
    L = np.diagonal(simulate(warm, load, **PLANE).impedance.L) / np.diagonal(data["L0"])
    share = L * (1.0 + 30e-6 * dT) * (1.0 - 2e-6 * dT) ** 2  # as 1/((2 pi f)^2 C) shows it

    def inverse(table: xr.Dataset) -> Inverse:
        cal = sensor_calibration(scene, table)
        return cal.inverse(share * cal.L0)

    table, left = read_at(scene, data, warm.temperature, inverse)
    return inverse(table), left


@pytest.mark.slow
@pytest.mark.parametrize(
    ("temperature", "load"),
    [
        (0.0, Wrench(F_x=-0.2, F_z=1.45)), (35.0, Wrench(F_x=0.15, F_z=1.0)), (60.0, Wrench(F_z=0.4)),
        (60.0, Wrench(F_x=-0.2, F_z=1.45)),
    ],
)
def test_readings_of_the_chain_come_back_within_their_errors(
    planar: xr.Dataset, temperature: float, load: Wrench
) -> None:
    """Straight lines alone are 20 % off at 60 degC, or off the table; solved there, within what is told to be left."""
    found, left = read_by(temperature, planar, load)
    off = np.abs(found.forces - [load.F_x, load.F_z])
    assert found.status == "ok"
    assert np.all(off <= left + 1e-9) and np.all(left < [5e-4, 1.5e-2])  # of two meshes


@pytest.mark.slow
def test_where_the_sensor_has_no_answer_nothing_is_read(data: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line, with temperature and load; at the calibration's own temperature nothing is solved."""
    scene = sensor(*COEFFICIENTS)

    def inverse(table: xr.Dataset) -> Inverse:
        cal = sensor_calibration(scene, table)
        return cal.inverse(cal.forward(F_x=0.1, F_z=0.8))

    def failing(*_: object, **__: object) -> None:
        raise SolveFailed("no equilibrium", SolveReport("", 0, 0, 0.0, 0.0, 0.0))

    monkeypatch.setattr(temperature_module, "simulate", failing)
    table, left = read_at(scene, data, scene.temperature, inverse)
    assert table is data and not left.any()
    with pytest.raises(SceneError, match="got 40 degC with F_x = 0.1 N, F_z = 0.8 N: no equilibrium"):
        read_at(scene, data, scene.temperature + 20.0, lambda _: inverse(data))


def test_relative_slopes_have_a_row_for_each_cause(data: xr.Dataset) -> None:
    found = relative_slopes(sensor(*COEFFICIENTS), Wrench(F_z=0.5), **QUICK)
    own = data.sel(F_x=0.0, F_z=0.5)
    L = np.diagonal(own["L"].to_numpy())
    np.testing.assert_allclose(found, own["slope_T_L_by"] / L, rtol=1e-3, atol=1e-10)


def test_what_has_no_slopes_is_refused(data: xr.Dataset) -> None:
    """One line each: a table without, a model without derivatives, a silicone whose expansion is not known."""
    scene = sensor(*COEFFICIENTS)
    with pytest.raises(SceneError, match="must be 20 degC, that of the calibration, which was made without --drift"):
        at_other_temperature(scene, data.drop_vars(["slope_T_L", "slope_T_L_by"]), 300.0)
    with pytest.raises(SceneError, match="got 176.85 degC"):
        at_other_temperature(scene, data, 450.0)
    silicone = 'elastomer.material={law="neo-hookean",shear_modulus="20 kPa",bulk_modulus="20 MPa"}'
    with pytest.raises(SceneError, match="drift: elastomer.material.expansion: must be given"):
        calibrate(sensor(silicone), F_z=[0.0, 1.0], drift=True, **QUICK)
    flush = sensor('target.width="20 mm"', "coils.C1.centre.0=-0.004")
    with pytest.raises(SceneError, match="drift: must be asked of the mechanics block, planar, axisymmetric or linear"):
        calibrate(flush, F_z=[0.0, 0.1], drift=True, **(QUICK | {"mechanics": "closed-form"}))


@pytest.mark.slow
def test_the_bench_sees_the_sensor_at_its_temperature(data: xr.Dataset) -> None:
    """Codes of a calibration at 20 K more: those of its inductances with its capacitor and its clock; warmer tracks."""
    cold = sensor(*COEFFICIENTS)
    warm = cold.model_copy(update={"temperature": cold.temperature + 20.0})
    front, own = ({}, {})
    for name, scene in (("cold", cold), ("warm", warm)):
        front[name], own[name] = sensor_front_end(scene, data)[0], terminals(scene, data)[0]
    assert np.all(own["warm"]["R"] > 1.02 * own["cold"]["R"])
    L, R = (own["cold"][name].to_numpy() for name in ("L", "R"))
    each = [codes_of(scene, front["cold"], L, lossy) for lossy in (0.0 * R, R) for scene in (warm, cold)]
    np.testing.assert_allclose(each[0] / each[1], (1 + 600e-6) ** -0.5 / (1 - 40e-6), rtol=1e-12)
    damping = np.sqrt([1.0 - R**2 * 330e-12 * c / L for c in (1 + 600e-6, 1.0)])
    np.testing.assert_allclose([each[2] / each[0], each[3] / each[1]], damping, rtol=1e-12)


def tank_code(scene: Sensor, load: Wrench) -> float:
    """Return the code of the first coil solved at its temperature, its tank by a root of the circuit's susceptance."""
    found = absolute(scene, simulate(scene, load, **QUICK).impedance)[0]
    seen, C = at_terminals(scene, found)[0], at_temperature(scene).readout.parallel_capacitance
    assert seen is not None

    def susceptance(f: float) -> float:
        omega = 2.0 * np.pi * f
        return float((1.0 / (seen.R[0] + 1j * omega * seen.L[0]) + 1j * omega * C).imag)

    return 2.0**28 * brentq(susceptance, 3e6, 1e7, xtol=1e-7, rtol=1e-15) / (40e6 * clock_factor(scene))


def test_slopes_of_codes_are_those_of_tanks_at_other_temperatures() -> None:
    """By all causes, over 10 and 20 K to both sides: to 1e-3, of which the tank's 1/Q^2 is more than 2 %.

    At 5 kHz, and with boards that do not grow: of tables per metre uneven current and the growth of L0 are left out.
    """
    ways = ("board_expansion", "board_expansion_z")
    scene = sensor(*COEFFICIENTS, 'frequency="5 kHz"', *(f"coils.{k}.{way}=0" for k in ("C1", "C2") for way in ways))
    data = calibrate(scene, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], drift=True, **QUICK)
    one, load = {"F_x": 0.2, "F_z": 0.5, "coil": "C1"}, Wrench(F_x=0.2, F_z=0.5)
    each = {way: tank_code(scene.model_copy(update={"temperature": 293.15 + 10.0 * way}), load)
            for way in (-2, -1, 0, 1, 2)}
    front = sensor_front_end(scene, data)[0]
    assert float(table_codes(scene, data, front).sel(one)) == pytest.approx(each[0], rel=1e-9)
    expected = (8.0 * (each[1] - each[-1]) - (each[2] - each[-2])) / 120.0
    found = float(code_slopes(scene, data).sel(one).sum())
    assert found == pytest.approx(expected, rel=1e-3)
    without = float(code_slopes(scene, data.drop_vars("slope_T_R_by")).sel(one).sum())
    assert abs(without / expected - 1.0) > 0.02
    moved = at_other_temperature(scene, data, 303.15)
    assert float(table_codes(scene, moved, front).sel(one)) - each[0] == pytest.approx(each[1] - each[0], rel=3e-2)


def scripted(forces: list[float], error: float) -> Callable[[xr.Dataset], Inverse]:
    """Return an inverse that gives these F_z one after the other, F_x always the same; it ends with the list."""
    answers = iter(forces)
    none = np.zeros(2)

    def inverse(_: xr.Dataset) -> Inverse:
        return Inverse(np.array([0.1, next(answers)]), np.array("ok"), np.full(2, error), none, none, np.array(0.0))

    return inverse


def test_a_reading_is_read_again_until_every_force_settles(
    data: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within a tenth of its error each, at most three times; corrections that grow beyond the errors are refused."""
    scene = sensor(*COEFFICIENTS)
    none = [xr.zeros_like(data["L0"].isel(coil_2=0, drop=True))] * 2
    monkeypatch.setattr(temperature_module, "_remainder", lambda *_: none)
    warm = scene.temperature + 10.0
    for forces, last in (([0.8, 1.3, 1.31], 0.01), ([0.8, 0.81], 0.01), ([0.2, 0.9, 0.3, 0.6], 0.3)):
        _, left = read_at(scene, data, warm, scripted(forces, 1.0))
        np.testing.assert_allclose(left, [0.0, last], atol=1e-12)
    with pytest.raises(SceneError, match="got 30 degC, where corrections of the load do not settle"):
        read_at(scene, data, warm, scripted([0.1, 0.2, 0.4, 0.8], 0.01))
