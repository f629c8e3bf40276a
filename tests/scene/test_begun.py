"""A first scene: what a reader of scenes makes of it, where its coils are, what is refused."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from sits_mech.cli.main import run
from sits_mech.scene.begun import CLEAR, Beginning, first_scene
from sits_mech.scene.sensor import load_sensor, sensor_from


@pytest.mark.parametrize("coils", [1, 2, 3, 4])
def test_coils_stand_as_close_as_they_may(coils: int) -> None:
    """About the middle; every pair of neighbours at the clear distance, to the digits that are written."""
    sensor = sensor_from(tomllib.loads(first_scene(Beginning(coils=coils, turns=10, track="0.15 mm"))))
    centres = np.array([coil.centre for coil in sensor.coils])
    assert len(centres) == coils and np.allclose(centres.mean(axis=0), 0.0, atol=1e-7)
    apart = np.linalg.norm(centres[:, None] - centres, axis=-1)[~np.eye(coils, dtype=bool)]
    if coils > 1:
        assert apart.min() == pytest.approx(sensor.coils[0].outer_diameter + CLEAR, abs=3e-7)


def test_the_command_writes_what_commands_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As asked, with comments; a file that is there is left alone, and what cannot be made is one line, no file."""
    path = tmp_path / "sensor.toml"
    words = ["--coils", "3", "--size", "14 mm", "--silicone", "dragon-skin-30", "--layers", "1", "--no-ask"]
    assert run(["new", str(path), *words]) == 0
    sensor, text = load_sensor(path), path.read_text()
    assert sensor.target is not None and sensor.target.extent == (0.014, 0.014) and len(sensor.coils) == 3
    assert text.count("  # ") >= 12 and "next: sits-mech view" in capsys.readouterr().err
    for more, why in (
        (["--coils", "3"], "must be a new file"), (["--coils", "5"], "coils: must be a whole number from 1 to 4"),
        (["--turns", "many"], 'turns: must be a whole number, 1 or more; got "many"'),
        (["--colour", "red"], "colour: the key must be one of name, coils"), (["--turn", "9"], 'did you mean "turns"'),
        (["--layer", "3 N"], "elastomer.thickness"), (["--silicone", "jelly"], "jelly"),
    ):
        there = path if "new file" in why else tmp_path / "other.toml"
        assert run(["new", str(there), "--no-ask", *more]) == 2
        assert why in capsys.readouterr().err and not (tmp_path / "other.toml").exists()


def test_what_is_not_given_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each with what is usual."""
    asked = list[str]()

    def answer(words: str, default: str) -> str:
        """Take what is usual, but two coils."""
        asked.append(words)
        return "2" if words == "Coils, one to four" else default

    monkeypatch.setattr("rich.prompt.Prompt.ask", answer)
    assert run(["new", str(tmp_path / "a.toml"), "--ask", "--turns", "8"]) == 0
    assert len(asked) == len(Beginning.model_fields) - 1 and "Turns in a layer" not in asked
    assert len(load_sensor(tmp_path / "a.toml").coils) == 2
