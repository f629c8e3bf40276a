"""Malformed inputs by number: a command line and the files that it reads, the same for a number and a seed."""

from __future__ import annotations

import copy
import math
import random
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from extreme.any_scene import random_case
from extreme.command_lines import command_line
from extreme.damaged import damaged_file
from extreme.sound import REQUIREMENTS, STUDY
from extreme.texts import TEXTS

from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS, Pose
from sits_mech.scene.files import written
from sits_mech.scene.sensor import SceneError, catalogue, load_sensor, scene_text, sensor_from

VALUES: tuple[Any, ...] = (
    *TEXTS, 0, 1, -1, 2, 7, 1000, 10**6, 10**30, -(10**30), 1e-300, 1e300, 1e-9, 1e-6, 1e-3, 0.5, 1.0, 30.0,
    float("nan"), float("inf"), True, False, [], {}, [[]], [0.0], [0.0, 0.0], [1e-3, 1e-3, 1e-3], {"law": "yeoh"},
    [[0.0, 0.0], [1e-3, 0.0], [0.0, 1e-3]], {"a": {"b": {"c": {}}}}, ["x"] * 300, [[0.0, 0.0]] * 300,
)
TENSILE = b"engineering strain (%),engineering stress (kPa)\n"
BYTES = (
    b"", b"\x00", b"\xff\xfe\x00", b"\xef\xbb\xbf", b"[" * 5000, b"a = " + b"[" * 5000, b"a = 1\na = 2\n",
    b".".join([b"a"] * 3000) + b" = 1", b"= 1", b"name = ", b"[[coils]]\n" * 300, b"key = 1e999\n",
    b'name = "' + b"x" * 10**6 + b'"',
    b"(kicad_pcb" + b"(" * 3000, b"(kicad_pcb)", b"strain,stress\n1,2\n", b"F_x,F_z,L1,L2\n" + b"1,1,1,1\n" * 9,
    b"d_v [mm],L1 [uH],L2 [uH]\n2,3,3\nx,3,3\n3,nan,3\n-1,1e99,0\n", TENSILE,
    TENSILE + b"".join(b"%d,%d\n" % (k, -k) for k in range(40)), TENSILE + b"0,0\n1e-300,1e300\n" * 9,
)
LOADS = ("--fx", "--fy", "--fz", "--mx", "--moment", "--mz")
PLACES = ("--dv", "--dh", "--dy", "--alpha", "--alphax", "--alphaz")
OPTIONS = (
    *LOADS, *PLACES, "--set", "--tolerance", "--model", "--mechanics", "--magnetics", "--frequency", "--memory",
    "--via", "--period", "--cycles", "-o", "--kind", "--driven", "--what",
)
KEYS = ("target.width", "coils.0.turns", "coils.9.turns", "a.b.c", "", "frequency", "elastomer", "conductors.x.name")
Asked = tuple[str, list[str]]
"""A kind of input, and the command line that asks for it."""


def malformed(number: int, folder: Path, sound: Path, *, seed: int = 0, lines: bool = False) -> Asked:
    """Write what an input needs into a folder; return its kind and its command line.

    Parameters
    ----------
    number : int
        From 0 on.
    folder : Path
        An empty one, which is the working directory of the command.
    sound : Path
        Folder of `sound_files`.
    seed : int
        Another one draws other inputs.
    lines : bool
        Whether it is a command line about sound files.
    """
    dice = random.Random(f"{seed} {number} {lines}")
    maker = command_line if lines else dice.choice(MAKERS)
    return maker.__name__.strip("_").replace("_", " "), maker(dice, folder, sound)


def _scene_of_odd_values(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A catalogued scene with one to three entries replaced, removed, added or repeated, asked for anything."""
    table = _catalogued(dice)
    _damage(dice, table, dice.randint(1, 3))
    return [*_asked(dice, _kept(table, folder / "scene.toml")), "--json"]


def _scene_of_extreme_numbers(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A catalogued scene with one to three numbers many times too large or too small, or with many coils."""
    table = _catalogued(dice)
    for _ in range(dice.randint(1, 3)):
        place, key = dice.choice([(t, k) for t in _tables(table) for k, v in t.items() if _is_number(v)])
        if isinstance(place[key], int):
            place[key] = dice.choice((1, 2, 5, 60, 200, 1000))
        else:
            place[key] *= 10.0 ** dice.choice((-9, -6, -3, -2, -1, 1, 2, 3, 6, 9))
    if dice.random() < 0.15:
        table["coils"] = _many(table["coils"][0], dice.choice((9, 64, 200)))
    return [*_asked(dice, _kept(table, folder / "scene.toml")), "--json"]


def _odd_options(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A catalogued scene, one to three odd options."""
    asked = _asked(dice, dice.choice(sorted(catalogue())))
    words = [word for _ in range(dice.randint(1, 3)) for word in (dice.choice(OPTIONS), dice.choice(TEXTS))]
    sets = ["--set", f"{dice.choice(KEYS)}={dice.choice(TEXTS)}"] if dice.random() < 0.3 else []
    return [*asked, *words, *sets]


def _slipped_options(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A catalogued scene at a pose, a load or a frequency some thousands of times too large or too small."""
    scene, slip = dice.choice(sorted(catalogue())), dice.choice(("", "-")) + f"1e{dice.choice((-12, -9, -6, 6, 9, 12))}"
    loose = ["--tolerance", "0.1"]
    return dice.choice(
        (
            ["inductance", scene, f"--dv={slip} m", *loose],
            ["inductance", scene, "--dv", "2 mm", f"{dice.choice(PLACES[1:])}={slip}", *loose],
            ["inductance", scene, "--dv", "2 mm", f"--frequency={slip} Hz", *loose],
            ["inductance", scene, "--dv", "2 mm", f"--tolerance={slip}"],
            ["pose", scene, f"{dice.choice(LOADS)}={slip}", *loose],
            ["explain", scene, f"{dice.choice(LOADS)}={slip}", f"--tolerance={slip}"],
            ["simulate", scene, f"{dice.choice(LOADS)}={slip}", *loose],
        )
    )


def _odd_file(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A file of odd bytes where any command reads one."""
    path = folder / dice.choice(("odd.toml", "odd.csv", "odd.kicad_pcb", "odd", "odd.msh", "result.nc"))
    path.write_bytes(dice.choice(BYTES))
    name, out = str(dice.choice((path, path, path, folder, "/dev/null", "/dev/zero"))), str(folder / "out")
    return dice.choice(
        (
            ["inductance", name], ["simulate", name, "--fz", "1 N"], ["explain", name], ["sweep", name, "-o", out],
            ["design", name, "-o", out], ["fit", name], ["fit", name, "--law", "ogden", "--terms", "9"],
            ["compare", "biorob2018", name], ["compare", name, name], ["import", name, "--net", "L1"],
            ["invert", name, "--l1", "90 %"], ["quality", name], ["converter", name], ["report", name],
            ["export", name, "--to", "c"], ["inductance", "biorob2018", "--set", f"target.mesh={name}"],
            ["view", name, "-o", f"{out}.png"],
        )
    )


def _odd_tables(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A study or a file of requirements with one to three entries replaced, removed, added or repeated."""
    command, start = dice.choice((("sweep", STUDY), ("design", REQUIREMENTS)))
    table: dict[str, Any] = copy.deepcopy(start)
    _damage(dice, table, dice.randint(1, 3))
    more = ["--most", "1"] if command == "design" else []
    return [command, _kept(table, folder / "asked.toml"), "-o", str(folder / "out"), *more]


def _any_scene(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A scene of all that the loader accepts, asked as `extremes.py` asks it."""
    case = random_case(dice.randrange(10**9))
    arguments = POSE_ARGUMENTS if isinstance(case.given, Pose) else LOAD_ARGUMENTS
    given = [f"--{option}={getattr(case.given, name)!r}" for option, name in arguments.items()]
    models = [] if case.kind == "simulate" else ["--model", case.model]
    path = folder / "scene.toml"
    path.write_text(scene_text(case.sensor), encoding="utf-8")
    return [case.kind, str(path), *given, *models, f"--tolerance={max(case.tolerance, 1e-3)}", "--json"]


def _scene_at_a_border(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """A catalogued scene with one or two numbers at the end of what the loader accepts"""
    table = _catalogued(dice)
    for _ in range(dice.randint(1, 2)):
        place, key = dice.choice([(t, k) for t in _tables(table) for k, v in t.items() if isinstance(v, float) and v])
        start, low, high = place[key], 0.0, dice.choice((-1.0, 1.0)) * 40.0  # logarithms of the factor
        for _ in range(12):
            place[key] = start * math.exp(0.5 * (low + high))
            low, high = (0.5 * (low + high), high) if _is_accepted(table) else (low, 0.5 * (low + high))
        place[key] = start * math.exp(low)
    return [*_asked(dice, _kept(table, folder / "scene.toml")), "--json"]


def _is_accepted(table: dict[str, Any]) -> bool:
    """Whether the loader takes a scene."""
    try:
        sensor_from(table, "border")
    except SceneError:
        return False
    return True


MAKERS = (
    _scene_of_odd_values, _scene_of_extreme_numbers, _scene_of_extreme_numbers, _odd_options, _slipped_options,
    _slipped_options, _odd_file, _odd_tables, *3 * (damaged_file,), *5 * (_scene_at_a_border,), *6 * (_any_scene,),
)
"""What makes an input, as often as it is named."""


def _catalogued(dice: random.Random) -> dict[str, Any]:
    """The tables of a scene of the catalogue."""
    return tomllib.loads(scene_text(load_sensor(dice.choice(sorted(catalogue())))))


def _asked(dice: random.Random, scene: str) -> list[str]:
    """A command about a scene that is quick where the scene is sound."""
    return dice.choice(
        (
            ["inductance", scene, "--dv", "2 mm", "--tolerance", "0.1"], ["pose", scene, "--fz", "0.1 N"],
            ["explain", scene, "--fz", "0.1 N"], ["simulate", scene, "--fz", "0.1 N", "--tolerance", "0.1"],
        )
    )


def _many(coil: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Copies of a coil, 20 mm apart."""
    side = round(count**0.5) + 1
    return [
        copy.deepcopy(coil) | {"name": f"K{k}", "centre": [0.02 * (k % side), 0.02 * (k // side)]} for k in range(count)
    ]


def _damage(dice: random.Random, table: dict[str, Any], times: int) -> None:
    """Replace, remove, add or repeat entries anywhere in a table."""
    for _ in range(times):
        place = dice.choice(list(_tables(table)))
        key, kind = dice.choice([*place, *place, "width", "turns", "shape", "mesh", "odd"]), dice.random()
        if kind < 0.1:
            place.pop(key, None)
        elif kind < 0.2 and isinstance(place.get(key), list):
            place[key] = copy.deepcopy(place[key]) * dice.choice((0, 2, 70))
        else:
            place[key] = copy.deepcopy(dice.choice(VALUES))


def _tables(value: Any) -> Iterator[dict[str, Any]]:
    """Yield a table and those within it."""
    if isinstance(value, dict):
        yield value
    for item in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _tables(item)


def _is_number(value: Any) -> bool:
    """Tell a number from a flag."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _kept(table: dict[str, Any], path: Path) -> str:
    """Write a table as TOML, or what comes nearest to it, and return the path."""
    path.write_text(written(table), encoding="utf-8", errors="replace")
    return str(path)
