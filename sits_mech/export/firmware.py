"""Write a calibration in codes and its inverse as a C header for microcontrollers, in integers alone.

The map, the domain and the starting points are laid down in `fixed_point`; the header (``firmware.h.in``) has the
arithmetic of the inverse for any number of forces, and as many coils or more: the same polynomials, the same least
squares, the same statuses. What one built sensor differs by is a struct that firmware reads at run time
(analysis/built/constants.py), bound to its header by a checksum of the calibrated impedances.

Neglected: noise.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template

import numpy as np
import xarray as xr

from sits_mech.analysis.built.constants import BEYOND, Constants, as_computed
from sits_mech.analysis.readings.bench import Readings, code_calibration, readings
from sits_mech.export.fixed_point import FACET_BITS, FixedPoint, fixed_point
from sits_mech.export.source import Source, comment
from sits_mech.quantities import TOUCH, Array, Integers, shown_unit
from sits_mech.readout.calibration import Calibration, check_resolved
from sits_mech.readout.converter import converter
from sits_mech.readout.inversion import APART, HOPELESS, LONGEST, MARGIN, REACH
from sits_mech.readout.loads import fixed, load_words, several
from sits_mech.readout.quality import reading_errors
from sits_mech.report.page.explorer import page_file
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError
from sits_mech.version import __version__

_EVALUATIONS, _MORE = 30, 100  # of the map from a starting point; of more coils than forces, as in Python
_FORCE, _MOMENT, _PLACE = (1e6, "uN"), (1e9, "nN m"), (1e9, "nm")  # the header's units
_GAIN_BITS, _FACTOR_BITS = 30, 20  # fractional bits of a unit's numbers


def write_header(source: Source, path: Path) -> tuple[str, ...]:
    """Write the C header.

    Raise ValueError for a sensor without converter, a force that coils do not resolve, too few loads, a map that has no
    inverse anywhere, or a failed write.
    """
    if source.sensor.readout.converter == "none":
        raise SceneError('--to c: must have codes of a converter; the scene has readout.converter = "none"')
    cal = code_calibration(source.sensor, source.data)
    check_resolved(cal)
    domain = cal.domain
    if not np.any(domain.labels == 1):
        regions = "; ".join(domain.regions) or "everywhere"
        raise SceneError(f"--to c: must have a region where codes belong to one force; there is none: {regions}")
    found, own = fixed_point(cal), _own_error(readings(source.sensor, source.data))
    write_text(path, header(source, found))
    notes = [
        f"{len(found.power)} terms for each of {len(cal.coils)} coils, {_bytes(found)} bytes of tables, "
        f"within {found.error:.2g} codes of the map",
        f"interpolation error, by leaving out loads: {cal.map.error.max():.3g} codes",
        f"estimated errors of the loads: up to {own:.3g} codes",
        f"with the spread that its silicone states, 90 % of the true forces are within a median of {_within(cal)}",
    ]
    if domain.share < 1.0 or domain.regions:
        notes.append(f"{1.0 - domain.share:.1%} of the loads have no answer: {'; '.join(domain.regions)}")
    return tuple(notes)


def _own_error(read: Readings) -> float:
    """Return the largest estimated error of a load of the table, by its inductance, in codes."""
    if read.codes is None or read.front is None:
        return 0.0
    return float(np.nanmax(0.5 * (read.codes + read.front.below) * read.error_L / read.L))


def _within(cal: Calibration) -> str:
    """Return the half width that holds 90 % of each true force, median and greatest over the loads, as `quality`."""
    rows = zip(cal.forces, 1e3 * reading_errors(cal), strict=True)
    each = (f"{usual:.4g} m{_unit(name)[1][1:]} of {name} (up to {worst:.4g})" for name, (_, usual, worst) in rows)
    return ", ".join(each)


def _unit(name: str) -> tuple[float, str]:
    """Return how many of the header's units are one newton, newton metre or metre, and what they are."""
    if name in TOUCH:
        return _PLACE
    return _FORCE if name.startswith("F") else _MOMENT


def _bytes(found: FixedPoint) -> int:
    """Return the size of the header's tables."""
    wide = (found.base, found.weight, found.tolerance, found.far, found.direction, found.span, found.facet, found.nodes)
    middle, short = (found.coefficient, found.down, found.first), (found.power, found.ends, found.seed, found.valid)
    sizes = (8 * sum(item.size for item in wide), 4 * sum(item.size for item in middle), 2 * found.image.size)
    small = sum(item.size for item in short)
    return int(sum(sizes) + small + 16 * found.power.shape[1] + 4 * len(found.base))


def _products(found: FixedPoint) -> int:
    """Return how many products an evaluation of all polynomials and slopes takes."""
    d, n = found.power.shape[1], len(found.base)
    levels = np.minimum(found.ends + 1, d)  # sums that a term is added to, each with slopes of its own and later forces
    each = [sum(2 + k for k in range(level)) for level in levels]
    return int(n * sum(each) + 2 * d * max(int(found.power.max()) - 1, 0))


def header(source: Source, found: FixedPoint) -> str:
    """Return the header of a calibration."""
    cal, read = found.cal, readings(source.sensor, source.data)
    registers = () if read.front is None else read.front.registers
    counts, units = zip(*map(_unit, cal.forces), strict=True)
    many = np.array(counts)
    low, high = (np.rint(many * values).astype(np.int64) for values in (cal.low, cal.high))
    if max(np.abs(low).max(), np.abs(high).max()) > 2**31 / (1.0 + MARGIN):
        most = "forces below 2147 N, moments below 2.1 N m, places within 2.1 m"
        raise SceneError(f"--to c: must have {most}; got {_ranges(cal)}")
    worth = many * cal.force_error(cal.middle, np.ones(len(cal.coils)))
    one, d, n, degree = 2.0**found.bits, len(cal.forces), len(cal.coils), max(int(found.power.max()), 1)
    stacked = 2 * d * (degree + 1) + n * (1 + d) + (d + 1) ** 2 + 2 * d * n + d * d + 5 * n + 10 * d  # by all functions
    return Template(page_file("firmware.h.in", "export")).substitute(
        name=comment(source.sensor.name), about=comment(source.about), version=__version__,
        part=source.sensor.readout.converter, ranges=_ranges(cal) + _held(source),
        coils=comment(", ".join(cal.coils)),
        forces=", ".join(f"{name} [{unit}]" for name, unit in zip(cal.forces, units, strict=True)),
        forces_within=_within(cal),
        worth=", ".join(f"{w:.3g} {u} of {f}" for f, w, u in zip(cal.forces, worth, units, strict=True)),
        fixed_error=f"{found.error:.2g}", map_error=f"{cal.map.error.max():.3g}", own_error=f"{_own_error(read):.3g}",
        bytes=_bytes(found), stack=8 * stacked + 640, products=_products(found),
        tries=_MORE if n > d else _EVALUATIONS, hopeless=HOPELESS,
        d=d, n=n, terms=len(found.power), degree=degree, bits=found.bits,
        fraction=found.fraction, reach=_long(REACH * one), longest=_long(LONGEST * one), settled=found.settled,
        margin=_long((MARGIN + 1e-9) * 2.0**FACET_BITS),
        unit_margin=_long((2.0 * BEYOND + MARGIN) * 2.0**FACET_BITS), apart=_long(APART * one), merit=found.merit,
        full=2**converter(source.sensor.readout.converter).bits - 1,
        parts=len(found.first) - 1, seeds=len(found.seed), facets=len(found.facet), registers=len(registers),
        names=", ".join(f"SITS_{name.upper()} = {i}" for i, name in enumerate(cal.forces)),
        identity=identity(source.data), nominal=initializer(unit_numbers(source.data, cal.forces, as_computed(cal))),
        low=_row(low), range=_row(high - low),
        rest=_row(np.rint(cal.forward(cal.rest)).astype(np.int64)), base=_row(found.base),
        register_rows=", ".join(f"{{0x{address:02X}, 0x{value:04X}}}" for address, _, value in registers),
        power=c_rows(found.power), ends=_row(found.ends), coefficient=c_rows(found.coefficient),
        weight=_row(found.weight), tolerance=_row(found.tolerance), far=_row(found.far),
        direction=c_rows(found.direction), span=c_rows(found.span), down=_row(found.down),
        seed=c_rows(found.seed), image=c_rows(found.image), first=_row(found.first),
        facet=c_rows(found.facet), nodes=_row(found.nodes), valid=_row(found.valid), valid_bytes=len(found.valid),
    )


def identity(data: xr.Dataset) -> str:
    """Return what constants of units and the header of a calibration have in common: its L and R, to the bit."""
    values = np.stack([data[name].transpose(*data["L"].dims).to_numpy() for name in ("L", "R")])
    return f"0x{zlib.crc32(np.ascontiguousarray(values, dtype='<f8').tobytes()):08X}"


def unit_numbers(data: xr.Dataset, forces: Sequence[str], constants: Constants) -> dict[str, int | str]:
    """Return the numbers of a unit by name, as `sits_unit` of the header has them, in its order.

    Raises SceneError for a unit so far off that its numbers have no room.
    """
    many = np.array([_unit(name)[0] for name in forces])
    rows = {
        "gain": constants.gain * 2.0**_GAIN_BITS, "offset": constants.offset, "rest": constants.rest,
        "factor": constants.factor * 2.0**_FACTOR_BITS * many[:, None] / many, "shift": constants.shift * many,
    }
    found: dict[str, int | str] = {"id": identity(data)}
    for name, row in rows.items():
        if not np.all(np.abs(row) < (2.0**32 if name == "rest" else 2.0**31)):
            raise SceneError(f"unit: must be nearer to the calibrated sensor; its {name} has no room in firmware")
        for place, value in np.ndenumerate(np.rint(row)):
            found[f"{name}{''.join(str(k + 1) for k in place)}"] = int(value)
    return found


def initializer(numbers: Mapping[str, int | str]) -> str:
    """Return the numbers of a unit as C initializes a `sits_unit`."""
    n = sum(name.startswith("gain") for name in numbers)
    d = sum(name.startswith("shift") for name in numbers)
    values = list(numbers.values())
    parts = np.split(np.array(values[1:]), np.cumsum([n, n, n, d * d]))
    factor = "}, {".join(_row(row) for row in parts[3].reshape(d, d))
    gain, offset, rest, shift = (_row(parts[k]) for k in (0, 1, 2, 4))
    return f"{{UINT32_C({values[0]}), {{{gain}}}, {{{offset}}}, {{{rest}}}, {{{{{factor}}}}}, {{{shift}}}}}"


def unit_header(title: str, source: Source, constants: Constants) -> str:
    """Return the C text of the constants of one unit, as an initializer of a `sits_unit`."""
    forces = several(source.data)
    left = ", ".join(f"{name} {100.0 * one:.2g} %" for name, one in zip(forces, constants.left, strict=True))
    return (
        f"/* {comment(title)}\n *\n * Constants of this unit, for the header of the calibration that was adapted:\n"
        f" * {comment(source.about)}\n * What they leave of the range, on 90 % of loads: {left}.\n */\n"
        f"#define SITS_UNIT {initializer(unit_numbers(source.data, forces, constants))}\n"
    )


def _ranges(cal: Calibration) -> str:
    """Return what was calibrated."""
    rows = zip(cal.forces, cal.low, cal.high, strict=True)
    return ", ".join(f"{name} {a:.4g} to {b:.4g} {shown_unit(name)}" for name, a, b in rows)


def _held(source: Source) -> str:
    """Return what all loads have besides, in words."""
    besides = load_words({name: value for name, value in fixed(source.data).items() if value != 0.0})
    return f"; all under {besides}" if besides else ""


def _long(value: float) -> str:
    """Return a number as C writes one of 64 bits."""
    return f"INT64_C({round(value)})"


def c_rows(values: Integers) -> str:
    """Return a table as C writes it."""
    return ",\n".join(f"{{{_row(row)}}}" for row in values)


def _row(values: Integers | Array) -> str:
    """Return numbers as C writes them."""
    return ", ".join(f"{int(value)}LL" if abs(int(value)) >= 2**31 else str(int(value)) for value in values)
