"""Requirement files: what they ask in SI, and one clear line for each mistake."""

from pathlib import Path
from typing import Any

import pytest

from sits_mech.synthesis.required.requirements import read_requirements, requirements_of
from sits_mech.units import SceneError

FULL: dict[str, Any] = {
    "scene": "biorob2018-w15",
    "loads": {"F_x": ["-1 N", "1 N"], "F_z": ["0 N", "4 N"], "overload": 1.5},
    "vary": {
        "elastomer.thickness": {"from": "1 mm", "to": "6 mm"},
        "elastomer.material": ["ecoflex-00-30", "dragon-skin-10"],
        "coils.*.turns": [8, 10],
    },
    "require": {
        "resolution": {"F_x": "10 mN"}, "drift": {"F_z": "20 mN/K"}, "error": {"F_z": "5 %"},
        "crosstalk_before_inverse": "60 %", "rate": "100 Hz",
        "footprint": ["25 mm", "20 mm"], "height": "8 mm",
    },
    "tolerance": {
        "elastomer.thickness": "0.05 mm", "modulus": "10 %", "coil_offset": "0.1 mm", "repeatability": "0.01 %",
    },
    "goal": {"minimise": {"error.F_z": 2, "height": 1}, "yield": "90 %"},
}


def test_a_file_in_si(tmp_path: Path) -> None:
    """Every key, units and shares made numbers; a star stands for every coil."""
    found = requirements_of(FULL)
    assert found.loads == {"F_x": (-1.0, 1.0), "F_z": (0.0, 4.0)} and found.overload == 1.5
    assert found.limits == pytest.approx({
        "resolution.F_x": 0.01, "drift.F_z": 0.02, "error.F_z": 0.05, "crosstalk_before_inverse": 0.6, "rate": 100.0,
        "footprint.x": 0.025,
        "footprint.y": 0.02, "height": 0.008,
    })
    assert found.tolerance == pytest.approx(
        {"elastomer.thickness": 5e-5, "modulus": 0.1, "coil_offset": 1e-4, "repeatability": 1e-4}
    )
    assert found.minimised == {"error.F_z": 2.0, "height": 1.0} and found.least_yield == 0.9
    assert len(found.space.choices) == 4
    assert found.space.overrides({"coils.*.turns": 8}) == ["coils.C1.turns=8", "coils.C2.turns=8"]


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("reqire",), {}, r'key must be one of .*\(did you mean "require"'),
        (("loads", "F_q"), ["0 N", "1 N"], "loads.F_q: the key must be one of"),
        (("loads", "F_z"), ["4 N", "0 N"], r"loads.F_z: must rise"),
        (("loads", "F_z"), ["1 N", "2 N"], "with no load between its ends"),
        (("loads", "overload"), 0.5, "loads.overload: must be 1 or more; got 0.5"),
        (("vary", "elastomer.thickness"), {"from": "6 mm", "to": "1 mm"}, "vary.elastomer.thickness: must be bounds"),
        (("vary", "elastomer.material"), ["ecoflex-99"], r"material: .*ecoflex-99.* must leave a possible"),
        (("vary", "elastomer.thicknes"), {"from": "1 mm", "to": "2 mm"}, "elastomer.thicknes"),
        (("require", "resolutin"), {"F_x": "1 mN"}, r'resolutin: the key must be one of .*mean "resolution"'),
        (("require", "resolution"), {"F_y": "1 mN"}, "require.resolution: must be a table of some of F_x, F_z"),
        (("require", "drift"), {"F_z": "5 mN"}, 'require.drift.F_z: must be a quantity in N/K'),
        (("require", "drift"), {"F_x": "0 N/K"}, "require.drift.F_x: must be positive"),
        (("require", "height"), "1.1 mm", r"require.height: must be at least 1.32 mm, .*; got 1.1 mm"),
        (("require", "rate"), "1 MHz", r"require.rate: must be at most 1.858e.05 Hz, which LDC1614 has; got 1e.06 Hz"),
        (("require", "resolution"), {"F_x": "0.01 mN"}, "require.resolution.F_x: must be at least 0.05 mN, .* 0.01"),
        (("require", "error"), {"F_x": "0.001 %"}, "require.error.F_x: must be at least 0.01 %, .*; got 0.001 %"),
        (("require", "footprint"), ["25 mm", "15 mm"], "require.footprint.y: must be at least 20 mm, .*; got"),
        (("require", "hysteresis"), "5 %", "require: hysteresis needs prony or mullins of .*; of ecoflex-00-30"),
        (("tolerance", "elastomer.material"), "1 mm", "tolerance.elastomer.material: must be of a length"),
        (("tolerance", "elastomer.thikness"), "1 mm", "tolerance: elastomer.thikness must be one of"),
        (("tolerance", "modulus"), "0 %", "tolerance.modulus: must be a positive standard deviation"),
        (("tolerance", "modulus"), "60 %", "tolerance.modulus: must leave a sensor that is off by twice of it; got"),
        (("tolerance", "elastomer.thickness"), "1 mm", "elastomer.thickness: must leave a sensor .*off by twice"),
        (("vary", "elastomer.thickness"), {"from": 0.0, "to": 0.002}, "vary.elastomer.thickness: 0.0 must leave"),
        (("vary", "pitch_x"), {"from": "9 mm", "to": "14 mm"}, 'vary.pitch_x: must be .* request = "cells"'),
        (("goal", "minimise"), "hysteresis", "goal: hysteresis needs prony or mullins"),
        (("goal", "minimise"), "error.F_y", "goal.minimise: must be one of"),
        (("goal", "yield"), "110 %", "goal.yield: must be a share"),
    ],
)
def test_mistakes_are_told_in_one_line(place: tuple[str, ...], value: Any, words: str) -> None:
    """Which key, what it must be, what came."""
    table = {key: dict(item) if isinstance(item, dict) else item for key, item in FULL.items()}
    if len(place) == 1:
        table[place[0]] = value
    else:
        table[place[0]][place[1]] = value
    with pytest.raises(SceneError, match=words) as caught:
        requirements_of(table)
    assert "\n" not in str(caught.value)


def test_a_file_is_named(tmp_path: Path) -> None:
    """The message begins with its path."""
    path = tmp_path / "finger.toml"
    path.write_text('scene = "biorob2018"\n[loads]\nF_z = ["0 N", "1 N"]\n')
    with pytest.raises(SceneError, match="finger.toml: vary: must be given; it is missing"):
        read_requirements(path)


def test_a_drift_of_what_is_not_known_is_refused() -> None:
    """A target of brass, whose resistivity's coefficient is not known; a silicone of the scene's own."""
    plate = FULL | {"vary": FULL["vary"] | {"target.material": ["copper", "brass"]}}
    with pytest.raises(SceneError, match="drift: target.temperature_coefficient: must be given"):
        requirements_of(plate)
