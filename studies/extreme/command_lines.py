"""Command lines by number: each command's own example, asked quickly, with words left out, repeated, swapped or odd."""

from __future__ import annotations

import random
import shlex
import shutil
from pathlib import Path

from extreme.texts import TEXTS

from sits_mech.cli.main import commands as loaded

QUICK = {
    "calibrate": ["biorob2018", "--fx", "-0.2 N:0.2 N:3", "--fz", "0 N:1 N:3", "--mechanics", "planar", "--magnetics",
                  "planar", "--tolerance", "0.1", "-o", "out"],
    "envelope": ["biorob2018", "--rays", "4", "--mechanics", "planar"], "quality": ["calibration"],
    "explain": ["biorob2018", "--fz", "2 N"], "sweep": ["study.toml", "-o", "widths"],
    "design": ["requirements.toml", "-o", "fingertip", "--most", "1"],
    "simulate": ["biorob2018", "--fz", "1 N", "--tolerance", "0.1"],
    "cycle": ["soft.toml", "--fz", "0.5 N", "--mechanics", "planar", "--magnetics", "planar", "--tolerance", "0.1"],
    "view": ["biorob2018", "--dv", "2 mm", "--kind", "field", "-o", "field.png"],
    "export": ["calibration", "--to", "csv", "-o", "loads.csv"],
}
"""Words in place of a command's example where that one takes seconds."""
VALUES = {
    "float": ("0.1", "0.3", "1e-3"), "int": ("1", "2", "3", "4096"), "bool": (),
    "str": ("1 N", "0.2 N", "2 mm", "-1 mm", "1 deg", "5 MHz", "1 mN*m", "20 degC", "1 N:2 N:2",
            "auto", "planar", "sheets"),
    "Path": ("out", "out.png", "out.nc", "out.html", "scene.toml", "calibration", "bench.csv",
             "/dev/stdin", "/dev/full"),
    "tuple": ("target.width=15 mm", "C1=91 %", "fz=1 N", "L1", "coils.0.turns=3", "elastomer.friction=0.5"),
}
"""Sound values by the kind of an option."""


def command_line(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """Copy the sound files into a folder, and return a command line that may be malformed."""
    shutil.copytree(sound, folder, dirs_exist_ok=True)
    name = dice.choice(commands())
    words = [name, *QUICK.get(name, _example(name))]
    for _ in range(dice.choice((0, 1, 1, 2, 4))):
        words = dice.choice((_longer, _longer, _longer, _odd_word, _odd_word, _shorter, _twice, _swapped))(dice, words)
    return words


def commands() -> list[str]:
    """Return the names of all commands, which `cli/main.py` brings."""
    return sorted(name for name in loaded() if not name.startswith("-"))


def _example(name: str) -> list[str]:
    """Return the words after a command's name in the example of its help."""
    return shlex.split(str(loaded()[name].default_command.__doc__).split("Example: sits-mech", 1)[1])[1:]


def options(name: str) -> list[tuple[str, str]]:
    """Return the options of a command, each with the kind of its value."""
    found = []
    for each in loaded()[name].assemble_argument_collection():
        words = str(each.hint)
        kind = next((kind for kind in ("tuple", "bool", "float", "int", "Path") if kind in words), "str")
        found += [(option, kind) for option in each.names if option.startswith("-") and "[" not in option]
    return found


def _longer(dice: random.Random, words: list[str]) -> list[str]:
    """Add an option of the command, or of any other, with a value of its kind or an odd one."""
    name = words[0] if words and words[0] in commands() and dice.random() < 0.9 else dice.choice(commands())
    option, kind = dice.choice([*options(name), ("--help", "bool"), ("--json", "bool")])
    value = dice.choice(TEXTS if dice.random() < 0.4 else VALUES[kind] or ("",))
    return [*words, option] if kind == "bool" else [*words, option, value]


def _odd_word(dice: random.Random, words: list[str]) -> list[str]:
    """Put an odd word in place of one."""
    at = dice.randrange(len(words)) if words else 0
    return [*words[:at], dice.choice(TEXTS), *words[at + 1 :]]


def _shorter(dice: random.Random, words: list[str]) -> list[str]:
    """Leave a word out."""
    at = dice.randrange(len(words)) if words else 0
    return [*words[:at], *words[at + 1 :]]


def _twice(dice: random.Random, words: list[str]) -> list[str]:
    """Say a part of the line again."""
    at = dice.randrange(len(words) + 1)
    return [*words, *words[at:]]


def _swapped(dice: random.Random, words: list[str]) -> list[str]:
    """Put the words after the command in another order."""
    return [*words[:1], *dice.sample(words[1:], len(words[1:]))]
