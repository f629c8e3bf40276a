"""Files of every kind, damaged as files are: cut short, swapped, enormous, with odd bytes, numbers or variables."""

from __future__ import annotations

import os
import random
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import xarray as xr

from sits_mech.report.folder import read_calibration

NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
ODD_NUMBERS = (
    b"nan", b"inf", b"-1", b"0", b"1e308", b"-1e308", b"1e-320", b"9" * 400, b"", b"x", b"1,5", b"=1+1", b"1e400",
)
READ_BY: dict[str, tuple[tuple[str, ...], ...]] = {
    "scene.toml": (("inductance", "{}", "--dv", "2 mm", "--tolerance", "0.1"), ("explain", "{}", "--fz", "1 N")),
    "soft.toml": (
        ("pose", "{}", "--fz", "0.2 N", "--model", "planar"), ("cycle", "{}", "--fz", "0.2 N", "--mechanics", "linear"),
    ),
    "dome.msh": (("pose", "dome.toml", "--fz", "0.1 N", "--tolerance", "0.3"), ("explain", "dome.toml", "--fz", "1 N")),
    "slotted_disc.msh": (
        ("inductance", "biorob2018", "--dv", "2 mm", "--tolerance", "0.1",
         "--set", 'target={{material="copper", shape="outline", mesh="{}", thickness="0.2 mm"}}'),
    ),
    "probe.kicad_pcb": (("import", "{}", "--net", "L1", "-o", "probe.toml"), ("import", "{}", "--net", "GND")),
    "drawn.kicad_pcb": (
        ("import", "{}", "-o", "coils.png"), ("import", "{}", "--net", "A"), ("import", "{}", "--footprint", "L1"),
        ("import", "{}", "--at", "35,5"),
    ),
    "loads.csv": (("simulate", "soft.toml", "--history", "{}", "--tolerance", "0.2", "--magnetics", "planar"),),
    "study.toml": (("sweep", "{}", "-o", "out"),),
    "requirements.toml": (("design", "{}", "-o", "out", "--most", "1"),),
    "bench.csv": (("compare", "calibration", "{}"), ("compare", "calibration", "{}", "--free", "modulus,gap")),
    "tensile.csv": (("fit", "{}"), ("fit", "{}", "--law", "ogden", "--terms", "2"), ("fit", "{}", "-o", "fit.png")),
    "hold.csv": (("fit", "--relaxation", "{}"), ("fit", "tensile.csv", "--relaxation", "{}")),
    "cycles.csv": (("fit", "--cyclic", "{}", "--law", "yeoh"), ("fit", "--cyclic", "{}", "--relaxation", "hold.csv")),
}
OF_FOLDER: tuple[tuple[str, ...], ...] = (
    ("invert", "calibration", "--l1", "90 %", "--l2", "90 %"), ("quality", "calibration"), ("report", "calibration"),
    ("converter", "calibration"), ("compare", "calibration", "bench.csv"),
    ("quality", "calibration", "--gap", "9 um", "--samples", "2"),
    *(("export", "calibration", "--to", to)
      for to in ("csv", "netcdf", "xlsx", "c", "spice", "kicad", "twin", "page", "svg")),
)


def damaged_file(dice: random.Random, folder: Path, sound: Path) -> list[str]:
    """Copy the sound files, damage one of them, and return a command that reads it."""
    shutil.copytree(sound, folder, dirs_exist_ok=True)
    if dice.random() < 0.35:
        damage_folder(dice, folder / "calibration")
        return list(dice.choice(OF_FOLDER))
    name = dice.choice(sorted(READ_BY))
    damage(dice, folder / name, folder)
    return [word.format(name) for word in dice.choice(READ_BY[name])]


def damage_folder(dice: random.Random, folder: Path) -> None:
    """Damage the table of a calibration: its bytes, its variables, or the files beside it."""
    if dice.random() < 0.4:
        damage(dice, dice.choice(sorted(path for path in folder.iterdir() if path.is_file())), folder.parent)
        return
    _, data = read_calibration(folder)
    (folder / "result.nc").unlink()
    try:
        data = dice.choice(TABLES)(dice, data.copy(deep=True))
        data.to_netcdf(folder / "result.nc", engine="netcdf4")
    except (ValueError, TypeError, KeyError, RuntimeError):  # RuntimeError: of the netCDF library
        pass  # what xarray cannot write is cut short, or missing


def damage(dice: random.Random, path: Path, folder: Path) -> None:
    """Damage a file of any kind in its place."""
    kind = dice.random()
    if kind < 0.1:  # swapped for another one
        shutil.copy(dice.choice(sorted(each for each in folder.iterdir() if each.is_file())), path.with_name("swap"))
        path.with_name("swap").replace(path)
    elif kind < 0.15:  # enormous, most of it a hole
        os.truncate(path, 10 ** dice.choice((7, 9, 11)))
    else:
        path.write_bytes(dice.choice(BYTES)(dice, path.read_bytes()))


def _cut(dice: random.Random, text: bytes) -> bytes:
    """The beginning of a file."""
    return text[: dice.randrange(len(text) + 1)]


def _odd_bytes(dice: random.Random, text: bytes) -> bytes:
    """A file with some bytes that are others."""
    odd = bytearray(text or b"x")
    for _ in range(dice.choice((1, 3, 30))):
        odd[dice.randrange(len(odd))] = dice.randrange(256)
    return bytes(odd)


def _odd_numbers(dice: random.Random, text: bytes) -> bytes:
    """A file with some numbers that are none, or none that can be."""
    share = dice.choice((1.0, 5.0, 50.0)) / max(len(NUMBER.findall(text)), 1)
    return NUMBER.sub(lambda found: dice.choice(ODD_NUMBERS) if dice.random() < share else found[0], text)


def _scaled(dice: random.Random, text: bytes) -> bytes:
    """A file whose numbers have a factor, as if in another unit."""
    factor = dice.choice((-1.0, 1e-9, 1e-3, 1e3, 1e9))
    return NUMBER.sub(lambda found: b"%g" % (factor * float(found[0])) if len(found[0]) < 300 else found[0], text)


def _swapped_lines(dice: random.Random, text: bytes) -> bytes:
    """A file with its lines in another order."""
    lines = text.splitlines(keepends=True)
    dice.shuffle(lines)
    return b"".join(lines)


def _fewer_lines(dice: random.Random, text: bytes) -> bytes:
    """A file without some of its lines."""
    return b"".join(line for line in text.splitlines(keepends=True) if dice.random() < 0.8)


def _swapped_columns(dice: random.Random, text: bytes) -> bytes:
    """A table whose columns stand in another order than their headings."""
    heading, _, rest = text.partition(b"\n")
    return heading + b"\n" + b"\n".join(b",".join(line.split(b",")[::-1]) for line in rest.splitlines())


def _repeated(dice: random.Random, text: bytes) -> bytes:
    """A file many times over."""
    return text * dice.choice((2, 100, 10**7 // max(len(text), 1) + 1))


def _other_letters(dice: random.Random, text: bytes) -> bytes:
    """A file as other systems write it."""
    return dice.choice((text.decode("latin-1").encode("utf-16"), text.replace(b"\n", b"\r"), b"\xef\xbb\xbf" + text))


BYTES: tuple[Callable[[random.Random, bytes], bytes], ...] = (
    _cut, _odd_bytes, _odd_numbers, _odd_numbers, _scaled, _swapped_lines, _fewer_lines, _swapped_columns, _repeated,
    _other_letters,
)


def _without(dice: random.Random, data: xr.Dataset) -> xr.Dataset:
    """A table without some of its variables or attributes."""
    if dice.random() < 0.4:
        data.attrs.pop(dice.choice(sorted(data.attrs, key=str)))
        return data
    return data.drop_vars(dice.sample(sorted(data.variables, key=str), dice.choice((1, 1, 5))))


def _odd_values(dice: random.Random, data: xr.Dataset) -> xr.Dataset:
    """A table with a variable that is no number, nothing, everywhere the same, or far too large."""
    name = dice.choice([name for name, each in data.variables.items() if each.dtype.kind == "f"])
    value = dice.choice((float("nan"), float("inf"), 0.0, -1.0, 1e300, 1e-300))
    return data.assign({name: data[name] * 0.0 + value})


def _turned(dice: random.Random, data: xr.Dataset) -> xr.Dataset:
    """A table backwards, of fewer loads, of one load, or of none."""
    along = dice.choice(sorted(data.sizes, key=str))
    return data.isel({along: dice.choice((slice(None, None, -1), slice(0, 2), slice(0, 1), slice(0, 0)))})


def _renamed(dice: random.Random, data: xr.Dataset) -> xr.Dataset:
    """A table with a variable or a dimension under another name, or two of them swapped."""
    one, two = dice.sample(sorted([*data.variables, *data.sizes], key=str), 2)
    return data.rename({one: two, two: one} if one != two and dice.random() < 0.5 else {one: "odd"})


def _other_kind(dice: random.Random, data: xr.Dataset) -> xr.Dataset:
    """A table with an attribute or a variable of another kind."""
    if dice.random() < 0.6:
        odd = ("", "{}", "[", "null", 7, -1.0, "nan", "H/m" if dice.random() < 0.5 else "H", "x" * 10**6)
        data.attrs[dice.choice(sorted(data.attrs, key=str))] = dice.choice(odd)
        return data
    name = dice.choice(sorted(data.data_vars, key=str))
    return data.assign({name: data[name].astype(str)})


TABLES: tuple[Callable[[random.Random, xr.Dataset], xr.Dataset], ...] = (
    _without, _odd_values, _turned, _renamed, _other_kind,
)
