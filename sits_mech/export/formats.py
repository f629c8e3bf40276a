"""Choose the format of an export by name, and the file it writes.

Formats are found as entry points of the group `sits_mech.exports`: those of this package, listed in its pyproject.toml,
and those of any other that is installed beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sits_mech.quantities import TOUCH
from sits_mech.readout.loads import check_enough, varied
from sits_mech.report.folder import checked_file, prepare_folder, read_calibration
from sits_mech.scene.sensor import SceneError, Sensor

if TYPE_CHECKING:
    from sits_mech.batch.studies.asked import Study
    from sits_mech.export.source import Source

GROUP = "sits_mech.exports"


@dataclass(frozen=True)
class Format:
    """A format of exports.

    Parameters
    ----------
    suffix : str
        How the name of its file or folder ends; no other format has it.
    write : callable
        Writes a `Source` (the sensor, the table of its calibration, a load) to a path; returns a line for each thing to
        know about it, or raises SceneError.
    inverts : bool
        Whether it needs as many coils as forces.
    at_load : bool
        Whether it shows the state under the source's load.
    """

    suffix: str
    write: Callable[[Source, Path], tuple[str, ...]]
    inverts: bool = False
    at_load: bool = True


def _own(
    suffix: str, name: str, *, inverts: bool = False, at_load: bool = False, places: bool = True, **options: Any
) -> Format:
    """Return a format whose function is of this room, and imported when it is needed; `places` of a touch it may take.
    """

    def write(source: Source, path: Path) -> tuple[str, ...]:
        """Write by it."""
        over = [each for each in TOUCH if each in source.data.coords]
        if over and not places:
            raise SceneError(f"--to: must be csv, netcdf, xlsx, c, vtu, pdf or svg of a table over {', '.join(over)}")
        module, _, function = name.rpartition(".")
        notes: tuple[str, ...] = getattr(import_module(f"{__package__}.{module}"), function)(source, path, **options)
        return notes

    return Format(suffix, write, inverts, at_load)


CSV = _own(".csv", "tables.write_csv")
NETCDF = _own(".nc", "tables.write_netcdf")
XLSX = _own(".xlsx", "tables.write_xlsx")
C = _own(".h", "firmware.write_header", inverts=True)
SPICE = _own(".cir", "spice.write_spice", at_load=True, places=False)
KICAD = _own(".kicad_mod", "kicad.write_kicad")
VTU = _own("_vtu", "vtu.write_vtu")
TWIN = _own("_twin", "twin.folder.write_twin", inverts=True, places=False)
PAGE = _own(".html", "page.html.write_page", inverts=True, places=False)
PDF = _own("_pdf", "pictures.write_pictures", form="pdf")
SVG = _own("_svg", "pictures.write_pictures", form="svg")


@cache
def formats() -> Mapping[str, EntryPoint]:
    """Return where formats are, by name."""
    return {each.name: each for each in sorted(entry_points(group=GROUP), key=lambda each: each.name)}


def format_of(kind: str) -> Format:
    """Return a format by its name; raise SceneError where there is none, or its package fails."""
    if kind not in formats():
        raise SceneError(f"--to: must be one of {', '.join(formats())}; got {kind!r}")
    entry = formats()[kind]
    try:
        found = entry.load()
    except (ImportError, AttributeError) as error:
        raise SceneError(f"--to: {kind} must be a format that can be loaded; got {entry.value}: {error}") from None
    if not isinstance(found, Format):
        raise SceneError(f"--to: {kind} must be a sits_mech.export.formats.Format; got {entry.value}")
    return found


def check_exports(study: Study) -> None:
    """Refuse formats of a study's last stage that are none."""
    for number, stage in enumerate(study.then, 1):
        for kind in stage.export:
            try:
                format_of(kind)
            except SceneError as error:
                raise SceneError(f"then.{number}.export: {str(error).removeprefix('--to: ')}") from None


def export(source: Source, kind: str, path: Path) -> tuple[Path, tuple[str, ...]]:
    """Write a calibration in a format; return the path and one line for each thing to know about it.

    `path` is a folder for `vtu`, `twin`, `pdf` and `svg`. Raise SceneError for an unknown format, an ending of another
    one, a sensor that does not fit or a failed write; SolveFailed.
    """
    path = export_path(source.sensor, kind, path)
    return path, format_of(kind).write(source, path)


def export_path(sensor: Sensor, kind: str, path: Path | None) -> Path:
    """Return where a calibration goes in a format, by default a name of the sensor's.

    Raise SceneError for an unknown format, or the ending of another one.
    """
    form = format_of(kind)
    path = Path(f"{plain_name(sensor.name)}{form.suffix}") if path is None else path
    if path.suffix not in ("", form.suffix):  # others are loaded only where one may be meant
        other = next((name for name in formats() if name != kind and _suffix(name) == path.suffix), None)
        if other is not None:
            raise SceneError(f"--output: must end in {form.suffix} for --to {kind}; got {path.name!r}, as for {other}")
    return checked_file(path) if form.suffix.startswith(".") else path


def _suffix(kind: str) -> str | None:
    """Return the suffix of a format; None of one that cannot be loaded, which others need not mind."""
    try:
        return format_of(kind).suffix
    except SceneError:
        return None


def plain_name(name: str) -> str:
    """Return a name of letters, digits and underscores."""
    kept = "".join(sign if sign.isascii() and sign.isalnum() else "_" for sign in name)
    return "_".join(part for part in kept.split("_") if part)[:60] or "sensor"


def export_case(folder: Path, case: int, kinds: Sequence[str], place: Path) -> list[str]:
    """Write a case, from 1 on, to a folder of its own; return one line for each thing to know about it.

    Raise SceneError for a case without a table, a sensor that does not fit, a failed write; SolveFailed.
    """
    from sits_mech.export.source import Source
    from sits_mech.report.written import write_calibration

    sensor, data = read_calibration(folder, case)
    for kind in kinds:
        if format_of(kind).inverts:
            check_enough(sensor.coils, varied(data))
    notes = write_calibration(sensor, data, prepare_folder(place, cases=False), layer=False)
    for kind in kinds:
        notes += export(Source(sensor, data), kind, place / export_path(sensor, kind, None))[1]
    return notes
