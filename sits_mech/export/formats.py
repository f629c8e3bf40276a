"""Choose the format of an export by name, and the file it writes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sits_mech.scene.sensor import SceneError, Sensor

if TYPE_CHECKING:
    from sits_mech.export.source import Source


@dataclass(frozen=True)
class Format:
    """A format: how its files end, and what writes them and returns one line for each thing to know."""

    suffix: str
    write: Callable[[Source, Path], tuple[str, ...]]


def _written(name: str, source: Source, path: Path, **options: Any) -> tuple[str, ...]:
    """Write by a function of this room, which is imported when it is needed."""
    module, _, function = name.rpartition(".")
    notes: tuple[str, ...] = getattr(import_module(f"{__package__}.{module}"), function)(source, path, **options)
    return notes


FORMATS: Mapping[str, Format] = {
    "csv": Format(".csv", partial(_written, "tables.write_csv")),
    "netcdf": Format(".nc", partial(_written, "tables.write_netcdf")),
    "xlsx": Format(".xlsx", partial(_written, "tables.write_xlsx")),
    "c": Format(".h", partial(_written, "firmware.write_header")),
    "spice": Format(".cir", partial(_written, "spice.write_spice")),
    "kicad": Format(".kicad_mod", partial(_written, "kicad.write_kicad")),
    "vtu": Format("_vtu", partial(_written, "vtu.write_vtu")),
    "twin": Format("_twin", partial(_written, "twin.folder.write_twin")),
    "pdf": Format("_pdf", partial(_written, "pictures.write_pictures", form="pdf")),
    "svg": Format("_svg", partial(_written, "pictures.write_pictures", form="svg")),
}
"""The formats by name."""


def export(source: Source, kind: str, path: Path | None = None) -> tuple[Path, tuple[str, ...]]:
    """Write a calibration in a format of `FORMATS`; return the path and one line for each thing to know about it.

    `path` is a folder for `vtu`, `twin`, `pdf` and `svg`; by default it is named after the sensor, here. Raise
    SceneError for an unknown format, an ending of another one, a sensor that does not fit or a failed write;
    SolveFailed.
    """
    path = export_path(source.sensor, kind, path)
    return path, FORMATS[kind].write(source, path)


def export_path(sensor: Sensor, kind: str, path: Path | None = None) -> Path:
    """Return where a calibration goes in a format; raise SceneError for an unknown one, or the ending of another."""
    if kind not in FORMATS:
        raise SceneError(f"--to: must be one of {', '.join(FORMATS)}; got {kind!r}")
    form = FORMATS[kind]
    path = Path(f"{plain_name(sensor.name)}{form.suffix}") if path is None else path
    other = next((name for name, each in FORMATS.items() if each.suffix == path.suffix and name != kind), None)
    if other is not None:
        raise SceneError(f"--output: must end in {form.suffix} for --to {kind}; got {path.name!r}, as for {other}")
    return path


def plain_name(name: str) -> str:
    """Return a name of letters, digits and underscores."""
    kept = "".join(sign if sign.isascii() and sign.isalnum() else "_" for sign in name)
    return "_".join(part for part in kept.split("_") if part)[:60] or "sensor"
