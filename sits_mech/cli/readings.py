"""Read a reading from the command line: inductances by number or name, or codes, one for each coil."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sits_mech.cli.options import clock_of
from sits_mech.quantities import Array
from sits_mech.readout.converter import Converter, converter, fault
from sits_mech.units import SceneError, quantity, shown

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.readout.calibration import Calibration
    from sits_mech.scene.sensor import Sensor

_NUMBERED = re.compile(r"l([1-9]\d*)")
Texts = Sequence[tuple[str, str]]  # of each coil in its order: the option that gave it, and what was written


@dataclass(frozen=True)
class CalibratedReading:
    """A reading and the calibration in its unit."""

    cal: Calibration
    values: Array  # (n,) [unit of the calibration]
    convention: str  # what is read, in words


def given_texts(
    coils: Sequence[str], inductances: Mapping[str, str], readings: Sequence[str], codes: Sequence[str]
) -> Texts:
    """Return what was written for each coil; raise SceneError for unknown, missing or repeated coils, mixed kinds."""
    if codes and (inductances or readings):
        raise SceneError("--code: must be given for every coil, without --l1 or --reading; got both kinds")
    given = [_numbered(coils, name, text) for name, text in inductances.items()]
    given += [_named(coils, "--reading", text) for text in readings]
    given += [_named(coils, "--code", text) for text in codes]
    return _of_each(coils, given, "--code" if codes else "--reading" if readings else "")


def _of_each(coils: Sequence[str], given: Sequence[tuple[int, str, str]], option: str) -> Texts:
    """Return option and text of each coil, checked; `option` is that of the kind asked for, empty for --l1, --l2."""
    found: dict[int, tuple[str, str]] = {}
    for k, name, text in given:
        if k in found:
            raise SceneError(f"{name}: must be the only reading of coil {coils[k]}; {found[k][0]} gives it too")
        found[k] = (name, text)
    if len(found) < len(coils):
        options = option or " ".join(f"--l{k + 1}" for k in range(len(coils)))
        missing = ", ".join(coil for k, coil in enumerate(coils) if k not in found)
        came = f"{len(found)}, without {missing}" if found else "none"
        raise SceneError(f"{options}: must be given, one for each coil ({', '.join(coils)}); got {came}")
    for name, text in found.values():
        _check_number(name, text, option == "--code")
    return [found[k] for k in range(len(coils))]


def _check_number(option: str, text: str, coded: bool) -> None:
    """Refuse what is no code, or no inductance."""
    unit = "" if "%" in text else "H/m" if "/" in text else "H"
    _plain_code(option, text) if coded else quantity(text, unit, option)


def _plain_code(option: str, text: str) -> float:
    """Return a written code."""
    try:
        return float(int(text, 0)) if text.lower().startswith("0x") else float(text)
    except ValueError:
        raise SceneError(f"{option}: must be a code of the converter, a whole number; got {text!r}") from None


def _numbered(coils: Sequence[str], name: str, text: str) -> tuple[int, str, str]:
    """Return number, option and text of ``--l1 "92 %"``."""
    match = _NUMBERED.fullmatch(name)
    if match is None:
        raise SceneError(f"--{name}: must be --l1, --l2, ..., --reading, --code, --clock or --json; got another option")
    if int(match[1]) > len(coils):
        raise SceneError(f"--{name}: must be of one of {len(coils)} coils ({', '.join(coils)}); got number {match[1]}")
    return int(match[1]) - 1, f"--{name}", text


def _named(coils: Sequence[str], option: str, text: str) -> tuple[int, str, str]:
    """Return number, option and text of ``--reading "C1=92 %"``."""
    name, found, value = (part.strip() for part in text.partition("="))
    if not (found and value):
        raise SceneError(f'{option}: must be COIL=VALUE, such as "{coils[0]}=..."; got {text!r}')
    if name not in coils:
        raise SceneError(f"{option} {name}: must be of one of the coils {', '.join(coils)}; got {name!r}")
    return list(coils).index(name), f"{option} {name}", value


def given_inductances(sensor: Sensor, data: xr.Dataset, texts: Texts, idle: str | None) -> CalibratedReading:
    """Return written inductances and the calibration at the terminals, in henry."""
    from sits_mech.analysis.readings.bench import convention, self_inductances, terminal_calibration, with_idle

    cal, free = terminal_calibration(sensor, data, idle), np.diagonal(data["L0"].to_numpy())
    per_metre, even = str(data.attrs["unit_L"]) == "H/m", self_inductances(sensor)
    scales = [(float(m), float(L0)) if per_metre else None for m, L0 in zip(free, even, strict=True)]
    each = [_inductance(cal, k, written, scales[k]) for k, written in enumerate(texts)]
    return CalibratedReading(cal, np.array(each), convention(with_idle(sensor, idle)))


def other_convention(sensor: Sensor, data: xr.Dataset, values: Array, idle: str | None) -> str:
    """Return in words that readings in henry are of a load with idle coils the other way; "" where they are not."""
    from sits_mech.analysis.readings.bench import other_way, terminal_calibration

    other, words = other_way(idle or sensor.readout.idle_coil)
    if len(sensor.coils) < 2 or terminal_calibration(sensor, data, other).inverse(values).status != "ok":
        return ""
    return words


def _inductance(cal: Calibration, k: int, written: tuple[str, str], scale: tuple[float, float] | None) -> float:
    """Return a written inductance of coil k [H].

    `scale` has its free-space value per metre and that of even current [H] where the table is in H/m.
    """
    (name, text), free = written, float(cal.L0[k])
    if "%" in text:
        return quantity(text, "", name) * free
    plain = text.strip()[-1:].isdigit() or text.strip().endswith(".")
    if scale is not None and (plain or "/" in text):
        return free + (quantity(text, "H/m", name) / scale[0] - 1.0) * scale[1]
    found = quantity(text, "H", name)
    if not 0.2 * free < found < 5.0 * free:
        per = "; the table's own values are in H/m" if scale is not None else ""
        raise SceneError(f"{name}: must be near the inductance in free space, {free:.4g} H{per}; got {shown(text)}")
    return found


def given_codes(sensor: Sensor, data: xr.Dataset, texts: Texts, clock: str | None) -> CalibratedReading:
    """Return written codes and the calibration in codes."""
    from sits_mech.analysis.readings.bench import code_calibration, convention

    cal = code_calibration(sensor, data, clock=clock_of(clock, sensor.readout.converter))
    part = converter(sensor.readout.converter)
    values = np.array([_code(cal, k, written, part) for k, written in enumerate(texts)])
    return CalibratedReading(cal, values, convention(sensor, "codes of the converter"))


def _code(cal: Calibration, k: int, written: tuple[str, str], part: Converter | None = None) -> float:
    """Return a written code of coil k."""
    option, text = written
    found = _plain_code(option, text)
    if part is not None and (why := fault(found, part)):
        raise SceneError(f"{option}: must be of a coil that is read; got a fault, {text}: {why}")
    middle = float(cal.forward(cal.middle)[k])
    if not 0.5 * middle < found < 2.0 * middle:
        raise SceneError(f"{option}: must be near the calibration's codes, {middle:.0f}; got {text}: another clock?")
    return found
