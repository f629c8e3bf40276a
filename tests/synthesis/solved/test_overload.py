"""The overload of a design: linear theory beside two meshes, loads that are too much, corners that are solved."""

import pytest

from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.synthesis.solved import overload
from sits_mech.synthesis.solved.overload import linear_strain, overload_of, strain_at_end

SENSOR = load_sensor("biorob2018")


def test_linear_theory_is_a_sheared_and_a_squeezed_layer() -> None:
    """A way of s thicknesses alone: gamma = s, lambda of simple shear; under a press the strain rises with the load."""
    assert SENSOR.elastomer is not None and SENSOR.target is not None
    silicone, area = SENSOR.elastomer.silicone, (SENSOR.target.width or 0.0) * (SENSOR.target.length or 0.0)
    load = Wrench(F_x=0.1, M=-0.1 * (SENSOR.target.load_height + 0.5 * SENSOR.elastomer.thickness))
    gamma = 0.1 / (silicone.shear_modulus * area)
    tilted = linear_strain(SENSOR, Wrench(F_x=0.1))
    alone = (gamma / 2 + (1 + gamma**2 / 4) ** 0.5 - 1) / (silicone.known_stretch - 1)
    assert alone < tilted and alone < linear_strain(SENSOR, load)  # levers of both signs add up: a bound
    few, many = (linear_strain(SENSOR, Wrench(F_z=force)) for force in (0.5, 1.0))
    assert 2.0 * few < many < 2.5 * few


def test_linear_theory_is_near_two_meshes_within_the_data() -> None:
    """Under 1 N, a third of what is known: 0.376 against 0.380 +- 0.19."""
    found = overload_of(SENSOR, {"F_z": (0.0, 1.0)}, 5e-2, finely=False)
    assert found.reason == "" and found.strain == pytest.approx(linear_strain(SENSOR, found.load), rel=0.1)


def test_what_is_too_much_under_a_part_of_the_load_is_not_solved_further(monkeypatch: pytest.MonkeyPatch) -> None:
    """40 N, 25 times the data by linear theory: the reason names both; at most a tenth of it was solved."""
    solved = list[float]()
    own = overload._strain

    def told(sensor, load, *rest, **more):  # type: ignore[no-untyped-def]
        solved.append(load.F_z)
        return own(sensor, load, *rest, **more)

    monkeypatch.setattr(overload, "_strain", told)
    found = overload_of(SENSOR, {"F_z": (0.0, 40.0)}, 5e-2, finely=False)
    assert found.reason.startswith("overload: ecoflex-00-30 is strained to") and found.reason.endswith("of F_z = 40 N")
    assert max(solved) < 4.0 and found.strain > 1.3
    assert ruled_out(Wrench(F_z=40.0))


def test_a_press_that_is_ruled_out_strains_beyond_the_data() -> None:
    """A tenth less than the least one that is: two meshes are strained to 2.2 times the data, linear theory to 1.8."""
    surely = next(f for f in (1.02**k for k in range(99)) if ruled_out(Wrench(F_z=f)))
    found = overload_of(SENSOR, {"F_z": (0.0, 0.9 * surely)}, 5e-2, finely=False)
    assert 3.0 < surely < 6.0 and found.strain > 1.0 and not ruled_out(Wrench(F_z=1.0))


def ruled_out(load: Wrench) -> bool:
    """Return whether a load surely strains the silicone beyond its data."""
    return linear_strain(SENSOR, load) > strain_at_end(SENSOR, load)


def test_a_search_solves_the_corners_near_the_largest_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of shear, press and both it is both; for an answer all three, the worst of them finely."""
    solved = list[tuple[float, float, bool]]()

    def told(sensor, load, tolerance, expected, *, finely):  # type: ignore[no-untyped-def]
        solved.append((load.F_x, load.F_z, finely))
        return overload.Overload("", linear_strain(sensor, load), 0.1, load)

    monkeypatch.setattr(overload, "_under", told)
    ranges = {"F_x": (-0.2, 0.2), "F_z": (0.0, 0.6)}
    overload_of(SENSOR, ranges, 5e-2, finely=False)
    assert solved == [(0.2, 0.6, False)]
    solved.clear()
    overload_of(SENSOR, ranges, 1e-2, finely=True)
    assert len(solved) == 4 and solved[-1] == (0.2, 0.6, True)
