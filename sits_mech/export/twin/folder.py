"""Write a sensor's twin to a folder: numbers, an evaluator for Python, one for C, a pad for MuJoCo.

``sensor.npz``, arrays alone; ``twin.py``, which needs numpy alone; ``twin.h`` with the numbers in ``sensor.h``, C99;
``pad.xml`` where the pad's compliance is known. twin.py and twin.h are the package's own files, as they are.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sits_mech.export.source import Source, comment, own_folder
from sits_mech.export.twin.arrays import twin_arrays
from sits_mech.export.twin.mjcf import mjcf
from sits_mech.report.page.explorer import page_file
from sits_mech.scene.files import write_bytes, write_text
from sits_mech.version import __version__

EVALUATORS = ("twin.py", "twin.h")
_MAPS = (("wrench", True), ("pose", True), ("guess_L", False), ("guess_codes", False))  # and whether of codes as well


def write_twin(source: Source, path: Path) -> tuple[str, ...]:
    """Write a sensor's twin to a folder, made where missing; return one line for each thing to know.

    The lines say terms and errors of the maps, and what is not known. Raise SceneError where `path` cannot be written,
    the table's outermost loads failed, or it has one load.
    """
    own_folder(path, "twin", (".npz", ".py", ".h", ".xml"))
    numbers, notes = twin_arrays(source)
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **numbers)
    write_bytes(path / "sensor.npz", stream.getvalue())
    for name in EVALUATORS:
        write_text(path / name, page_file(name, "export.twin"))
    write_text(path / "sensor.h", c_tables(numbers, source.about))
    pad = mjcf(source.sensor, numbers)
    if pad is None:
        (path / "pad.xml").unlink(missing_ok=True)  # of another calibration
        return (*notes, "no pad.xml: the model of the mechanics tells no compliance")
    write_text(path / "pad.xml", pad)
    return notes


def c_tables(numbers: Mapping[str, Any], about: str) -> str:
    """Return the text of ``sensor.h``; `about` is one line on the sensor, for a comment."""
    n, codes, inverse = len(numbers["coils"]), int(numbers["codes"]), "guess_L_powers" in numbers
    powers = [numbers[f"{name}_powers"] for name, _ in _MAPS if f"{name}_powers" in numbers]
    valid = numbers["valid"] if inverse else np.ones((1, 1), dtype=np.uint8)
    flat, branches = bool(valid.all()), len(numbers["creep_times"])
    sizes = {
        "COILS": n, "CODES": codes, "OUTPUTS": n * (1 + codes), "BRANCHES": branches, "INVERSE": int(inverse),
        "VALID": int(not flat), "MOST_D": max(each.shape[1] for each in powers),
        "MOST_DEGREE": max(int(each.max()) for each in powers),
    }
    parts = [f"#define SITS_{name} {size}" for name, size in sizes.items()]
    if codes:
        parts.append(f"#define SITS_FULL UINT32_C({2 ** int(numbers['bits']) - 1})")
    for name, readings in _MAPS:
        parts += _map(name, numbers, readings)
    for name, sign in (("creep", -1.0), ("relaxation", 1.0)):  # of 1 + sum_j weight_j exp(-t/time_j)
        parts.append(_table("SITS_REAL", f"{name}_weight", _some(sign * numbers[f"{name}_weights"])))
        parts.append(_table("SITS_REAL", f"{name}_time", _some(numbers[f"{name}_times"])))
    if inverse:
        parts += _inverse(numbers, codes)
        parts.append(_table("int", "valid_nodes", np.array(valid.shape)))
        parts.append(_table("unsigned char", "valid", np.ones(1) if flat else valid.ravel()))
    coils = comment(", ".join(numbers["coils"]))
    first = f"/* {comment(about)}\n * Numbers for twin.h. Made by sits-mech {__version__}. Coils: {coils}. */"
    return "\n".join([first, "#ifndef SITS_SENSOR_H", "#define SITS_SENSOR_H", *parts, "#endif", ""])


def _map(name: str, numbers: Mapping[str, Any], readings: bool) -> list[str]:
    """Return the lines of a map; of one that is not there its number of components, 0."""
    upper = name.upper()
    if f"{name}_powers" not in numbers:
        return [f"#define SITS_{upper}_D 0"]
    powers, base = numbers[f"{name}_powers"], numbers[f"{name}_base"]
    lines = [f"#define SITS_{upper}_D {powers.shape[1]}", f"#define SITS_{upper}_TERMS {len(powers)}"]
    lines.append(_table("unsigned char", f"{name}_power", powers))
    lines.append(_table("SITS_REAL", f"{name}_coefficient", numbers[f"{name}_coefficients"].T))
    if not readings:
        return [*lines, _table("SITS_REAL", f"{name}_base", base)]
    n, low, high = len(numbers["coils"]), numbers[f"{name}_low"], numbers[f"{name}_high"]
    fixed = numbers[f"{name}_fixed"]
    return [
        *lines, _table("SITS_REAL", f"{name}_base", base[:n]),
        _table("int32_t", f"{name}_base_codes", _some(base[n:])),
        _table("int", f"{name}_column", numbers[f"{name}_columns"]), _table("SITS_REAL", f"{name}_fixed", fixed),
        _table("SITS_REAL", f"{name}_middle", 0.5 * (high + low)),
        _table("SITS_REAL", f"{name}_half", 0.5 * (high - low)),
        _one(f"{name}_same", 1e-9 + 1e-5 * float(np.abs(fixed).max())),
    ]


def _inverse(numbers: Mapping[str, Any], codes: int) -> list[str]:
    """Return the tables of the inverse."""
    lines = [_one("margin", float(numbers["margin"])), _one("residual", float(numbers["residual"]))]
    for kind in ("L", "codes")[: 1 + codes]:
        lines.append(_table("SITS_REAL", f"scale_{kind}", numbers[f"scale_{kind}"]))
        lines.append(_table("SITS_REAL", f"directions_{kind}", numbers[f"directions_{kind}"]))
    return lines


def _some(values: Any) -> Any:
    """Return values, or one that nobody reads: C has no table without entries."""
    return values if len(values) else np.ones(1)


def _one(name: str, value: float) -> str:
    """Return a number."""
    return f"static const SITS_REAL sits_{name} = {_written('SITS_REAL', value)};"


def _table(kind: str, name: str, values: Any) -> str:
    """Return a table of one or two dimensions."""
    rows = [", ".join(_written(kind, value) for value in np.atleast_1d(row).tolist()) for row in values]
    sizes = "".join(f"[{size}]" for size in np.shape(values))
    body = ",\n".join(f"{{{row}}}" for row in rows) if np.ndim(values) == 2 else ", ".join(rows)
    return f"static const {kind} sits_{name}{sizes} = {{{body}}};"


def _written(kind: str, value: float) -> str:
    """Return a number as C writes it: reals with every digit, in the type of the build."""
    return f"(SITS_REAL){value!r}" if kind == "SITS_REAL" else str(int(value))
