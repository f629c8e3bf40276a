"""One error of a force against closed forms, sampled errors, and the commands that show it."""

from dataclasses import replace

import numpy as np

from sits_mech.quantities import SURE
from sits_mech.readout.budget import budget
from sits_mech.readout.calibration import Calibration, calibration_of
from sits_mech.readout.table_errors import TableErrors

SLOPES = 1e-9 * np.array([[4.0, -20.0], [-4.0, -20.0]])  # of two coils by F_x and F_z [H/N]
F_X, F_Z = np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 4.0, 5)
AT = np.array([[0.3, 1.0], [-0.5, 3.0]])


def linear(**more: object) -> Calibration:
    """A sensor whose inductances are linear in the forces."""
    F = np.stack(np.meshgrid(F_X, F_Z, indexing="ij"), -1).reshape(-1, 2)
    names = {"forces": ("F_x", "F_z"), "coils": ("C1", "C2"), "free": ("H", np.full(2, 2.1e-6))}
    return replace(calibration_of(F, 2e-6 + F @ SLOPES.T, **names), **more)


def test_each_part_by_hand() -> None:
    """What moves both coils alike is a force along z alone, whatever the coils' own parts would make of it."""
    own, common = np.full((5, 5, 2), 2e-11), np.full((1, 5, 5, 2), 4e-11)
    errors = TableErrors((F_X, F_Z), common, own, modulus=0.1)
    found = budget(linear(table_errors=errors, noise=np.full(2, 1e-12)), AT, temperature=np.full((2, 2), 0.01))
    one = np.sqrt(2.0) / np.array([8e-9, 40e-9])  # N/H of independent coils
    np.testing.assert_allclose(found.parts["noise"], np.tile(1e-12 * one, (2, 1)), rtol=1e-6)
    np.testing.assert_allclose(found.parts["table"][:, 0], 1e-11 * one[0], rtol=1e-6)
    np.testing.assert_allclose(found.parts["table"][:, 1], np.hypot(1e-11 * one[1], 2e-11 / 20e-9), rtol=1e-6)
    np.testing.assert_allclose(found.parts["silicone"], 0.1 * np.abs(AT), rtol=1e-12)
    np.testing.assert_allclose(found.parts["temperature"], 0.005)
    assert np.all(found.parts["map"] < 1e-6)
    np.testing.assert_allclose(found.total, SURE * np.sqrt(sum(part**2 for part in found.parts.values())))
    assert list(budget(linear(), AT).parts) == ["map"]  # what is not known is left out


def test_nine_of_ten_sampled_sensors_are_within() -> None:
    """Sensors whose table, modulus and readings are off by random errors of these deviations."""
    rng, count = np.random.default_rng(5), 20_000
    shared = np.stack([1e-9 * np.ones((5, 5, 2)), 5e-10 * F_Z[None, :, None] * [1.0, -0.5] * np.ones((5, 1, 1))])
    cal = linear(table_errors=TableErrors((F_X, F_Z), shared, np.full((5, 5, 2), 3e-10), 0.05), noise=np.full(2, 1e-10))
    F = np.array([0.4, 2.0])
    stiffer = np.exp(0.05 * rng.standard_normal((count, 1)))
    parts = np.array([[1e-9, 1e-9], [1e-9, -0.5e-9]])  # at F_z = 2 N
    table = 0.5 * rng.standard_normal((count, 2)) @ parts + 1.5e-10 * rng.standard_normal((count, 2))
    shown = cal.forward(F / stiffer, beyond=True) + table + 1e-10 * rng.standard_normal((count, 2))
    off = np.abs(cal.inverse(shown).forces - F)
    within = np.mean(off < budget(cal, F).total, axis=0)
    np.testing.assert_allclose(within, 0.9, atol=0.01)
