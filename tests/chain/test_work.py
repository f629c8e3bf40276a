"""How much work is a load, and a table? Factorisations, which no machine and no other program changes."""

import pytest

from sits_mech.chain.calibrate import calibrate
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element import assembly
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Unknowns of each stiffness that is factored from here on."""
    found, factor = [], assembly.factor

    def watched(dissection, values):  # type: ignore[no-untyped-def]
        found.append(len(dissection.order))
        return factor(dissection, values)

    monkeypatch.setattr(assembly, "factor", watched)
    return found


@pytest.mark.parametrize(
    ("name", "load", "most"),
    [("biorob2018-w15", (0.5, 2.0), 16), pytest.param("biorob2018", (1.0, 2.0), 50, marks=pytest.mark.slow)],
)
def test_factorisations_of_a_load(name: str, load: tuple[float, float], most: int, counted: list[int]) -> None:
    """From rest, three meshes and all checks: 14 of a moderate load, 44 of one beyond stretch two."""
    block_pad(load_sensor(name), 1e-2).equilibrium(Wrench(*load))
    assert 0 < len(counted) <= most and max(counted) < 10_000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "F_x", "F_z", "most"),
    [("biorob2018-w15", 0.7, 2.8, 120), ("biorob2018", 0.4, 1.6, 135)],
)
def test_factorisations_of_a_table(name: str, F_x: float, F_z: float, most: int, counted: list[int]) -> None:
    """Loads and tolerance by default: 114 and 127, none of a mesh beyond the third."""
    forces = {"F_x": [F_x * k / 4 for k in range(-4, 5)], "F_z": [F_z * k / 8 for k in range(9)]}
    calibrate(load_sensor(name), **forces)
    assert 0 < len(counted) <= most and max(counted) < 10_000
