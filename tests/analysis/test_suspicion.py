"""Readings that belong to no load, made by hand: a coil that is off, a component that the table does not have."""

import numpy as np
import pytest

from sits_mech.analysis.suspicion import suspicion
from sits_mech.readout.calibration import Calibration, calibration_of

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, 0.0]])


def shown(F: np.ndarray, coils: int = 5) -> np.ndarray:
    """Coils at four corners and in the middle [H], by F_x, F_y and F_z."""
    x, y, z = np.asarray(F, dtype=float).T[..., None]
    a, b = CORNERS[:coils].T
    return 2e-6 * np.exp(-0.02 * z * (1.0 + 0.5 * (a == 0.0))) + 3e-8 * (a * np.sin(0.8 * x) + b * np.sin(0.8 * y))


def known(forces: tuple[str, ...], coils: int = 5) -> Calibration:
    """A calibration over some of the forces, the others zero."""
    ends = {"F_x": (-0.5, 0.5), "F_y": (-0.5, 0.5), "F_z": (0.0, 2.0)}
    axes = [np.linspace(*ends[name], 7) if name in forces else np.zeros(1) for name in ends]
    F = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    points = F[:, [name in forces for name in ends]]
    names = [f"C{k + 1}" for k in range(coils)]
    return calibration_of(points, shown(F, coils), forces=forces, coils=names, free=("H", np.full(coils, 2e-6)))


def others(coils: int = 5) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """What F_y, and a moment about x, make of the coils at rest."""
    across = 2.4e-8 * CORNERS[:coils, 1]
    return ("F_y", "M_x"), np.stack([across, -50.0 * across], -1), np.array([1.0, 0.01])


def test_a_component_that_the_table_does_not_have() -> None:
    """A force across a table without it: along F_y, or the moment that looks the same, unless that is too large."""
    cal, reading = known(("F_x", "F_z")), shown(np.array([0.2, 0.3, 1.0]))
    assert cal.inverse(reading).status == "no solution"
    said = suspicion(cal, reading, others())
    assert said.startswith("coils contradict each other by ")
    assert said.endswith("% of the range: the residual points along F_y (about 0.3 N) or M_x (about -0.0059 N m)")
    names, slopes, _ = others()
    assert suspicion(cal, reading, (names, slopes, np.array([1.0, 1e-3]))).endswith("along F_y (about 0.3 N)")


@pytest.mark.parametrize("coil", [0, 3, 4])
def test_a_coil_that_is_off(coil: int) -> None:
    """Five coils, two forces: the four others agree; by how much it is off is said."""
    reading = shown(np.array([0.2, 0.0, 1.0]))
    reading[coil] *= 1.01
    said = suspicion(known(("F_x", "F_z")), reading, others())
    assert said.endswith(f"of the range: coil C{coil + 1} (+1 %) alone is off, the other coils fit a load of the table")


@pytest.mark.slow
def test_what_cannot_be_told() -> None:
    """Four coils, three forces: any coil explains it; all are off: none does; two coils, two forces: nothing."""
    forces = ("F_x", "F_y", "F_z")
    cal, reading = known(forces, 4), shown(np.array([0.1, 0.1, 1.0]), 4)
    reading[2] *= 1.003
    said = suspicion(cal, reading, ((), np.zeros((4, 0)), np.zeros(0)))
    assert said.endswith(
        "of the range: coil C1 (+0.3 %), coil C2 (-0.3 %), coil C3 (+0.3 %) or coil C4 (-0.3 %) "
        "would explain it"
    )
    broken = shown(np.array([0.2, 0.0, 1.0])) * [1.01, 1.0, 1.006, 1.0, 0.994]
    assert known(("F_x", "F_z")).inverse(broken).status == "no solution"
    assert "neither one coil alone nor another component" in suspicion(known(("F_x", "F_z")), broken, others())
    assert suspicion(known(("F_x", "F_z")), shown(np.array([0.2, 0.0, 2.4])), others()) == ""  # outside, of its kind
    assert suspicion(known(("F_x", "F_z"), 2), shown(np.array([0.1, 0.1, 1.0]), 2), others(2)) == ""
