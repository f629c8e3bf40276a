"""Which formats are there, and which file does each ask for?"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from sits_mech.export.firmware import write_header
from sits_mech.export.kicad import write_kicad
from sits_mech.export.pictures import write_pictures
from sits_mech.export.source import Source
from sits_mech.export.spice import write_spice
from sits_mech.export.tables import write_csv, write_netcdf, write_xlsx
from sits_mech.export.twin.folder import write_twin
from sits_mech.export.vtu import write_vtu
from sits_mech.scene.sensor import SceneError


@dataclass(frozen=True)
class Format:
    """A format: how its files end, and what writes them and returns one line for each thing to know."""

    suffix: str
    write: Callable[[Source, Path], tuple[str, ...]]


FORMATS: Mapping[str, Format] = {
    "csv": Format(".csv", write_csv),
    "netcdf": Format(".nc", write_netcdf),
    "xlsx": Format(".xlsx", write_xlsx),
    "c": Format(".h", write_header),
    "spice": Format(".cir", write_spice),
    "kicad": Format(".kicad_mod", write_kicad),
    "vtu": Format("_vtu", write_vtu),
    "twin": Format("_twin", write_twin),
    "pdf": Format("_pdf", partial(write_pictures, form="pdf")),
    "svg": Format("_svg", partial(write_pictures, form="svg")),
}
"""The formats by name."""


def export(source: Source, kind: str, path: Path | None = None) -> tuple[Path, tuple[str, ...]]:
    """Write a calibration in a format.

    Parameters
    ----------
    source : Source
        The calibration, and the load of what shows a single state.
    kind : str
        A key of `FORMATS`.
    path : Path, optional
        The file, or the folder of `vtu`, `twin`, `pdf` and `svg`; by default named after the sensor, here.

    Returns
    -------
    tuple of Path and tuple of str
        What was written, and one line for each thing to know about it.

    Raises
    ------
    SceneError
        When the format is unknown, the file ends like one of another or cannot be written, or the sensor does not fit.
    SolveFailed
        When a state has to be solved anew and is not reached.
    """
    if kind not in FORMATS:
        raise SceneError(f"--to: must be one of {', '.join(FORMATS)}; got {kind!r}")
    form = FORMATS[kind]
    path = Path(f"{plain_name(source.sensor.name)}{form.suffix}") if path is None else path
    other = next((name for name, each in FORMATS.items() if each.suffix == path.suffix and name != kind), None)
    if other is not None:
        raise SceneError(f"--output: must end in {form.suffix} for --to {kind}; got {path.name!r}, as for {other}")
    return path, form.write(source, path)


def plain_name(name: str) -> str:
    """Return a name of letters, digits and underscores."""
    kept = "".join(sign if sign.isascii() and sign.isalnum() else "_" for sign in name)
    return "_".join(part for part in kept.split("_") if part)[:60] or "sensor"
