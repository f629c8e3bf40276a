"""Write a calibration for other programs: one line per load as CSV, as netCDF, as a workbook of Excel."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import Any

from sits_mech.export.source import Source
from sits_mech.labels import labelled, unit_of
from sits_mech.readout.loads import fixed, varied
from sits_mech.report.tables.loads import csv_text, figures
from sits_mech.scene.files import write_bytes, write_text
from sits_mech.scene.sensor import SceneError, scene_text
from sits_mech.store import save_table


def write_csv(source: Source, path: Path) -> tuple[str, ...]:
    """Write one line per load, SI, every number to its last digit."""
    write_text(path, csv_text(source.data))
    return ()


def write_netcdf(source: Source, path: Path) -> tuple[str, ...]:
    """Write the labelled table; every variable has its unit."""
    save_table(labelled(source.data), path)
    return ()


def write_xlsx(source: Source, path: Path) -> tuple[str, ...]:
    """Write a workbook of loads, figures of merit, scene and models; raise SceneError, as without openpyxl."""
    try:
        from openpyxl import Workbook
    except ImportError:
        raise SceneError("--to xlsx: needs openpyxl: pip install '.[excel]' in a clone") from None
    book = Workbook()
    loads = book.active
    loads.title = "loads"
    names, *rows = csv.reader(io.StringIO(csv_text(source.data, units=False)))
    numbers = [[_cell(text) for text in row] for row in rows]
    _fill(loads, [names, [unit_of(name, source.data.attrs["unit_L"]) for name in names], *numbers], heading=2)
    loads.freeze_panes = loads.cell(3, 1 + len(varied(source.data)) + len(fixed(source.data)))
    table = [[name, _finite(value), _finite(error), unit] for name, value, error, unit in figures(source.data)]
    _fill(book.create_sheet("figures"), [["figure", "value", "estimated error", "unit"], *table], heading=1)
    _fill(book.create_sheet("scene"), [[line] for line in scene_text(source.sensor).splitlines()], heading=0)
    made = [[str(name), str(value)] for name, value in source.data.attrs.items() if name != "scene"]
    _fill(book.create_sheet("about"), made, heading=0)
    stream = io.BytesIO()
    book.save(stream)
    write_bytes(path, stream.getvalue())
    return ()


def _fill(sheet: Any, rows: list[list[Any]], heading: int) -> None:
    """Put rows into a sheet; the first ones are headings."""
    from openpyxl.styles import Font

    for number, row in enumerate(rows):
        sheet.append(row)
        for cell in sheet[number + 1]:
            if number < heading:
                cell.font = Font(bold=number == 0, italic=number > 0)
            elif str(cell.value).startswith("="):
                cell.data_type = "s"  # a line of a scene is no formula
    for column in sheet.columns:
        longest = max(len(str(cell.value or "")) for cell in column)
        sheet.column_dimensions[column[0].column_letter].width = min(max(10, longest + 2), 60)


def _cell(text: str) -> float | str | None:
    """Return a number where a text is one, and nothing where it is not finite."""
    try:
        return _finite(float(text))
    except ValueError:
        return text


def _finite(value: float) -> float | None:
    """Return a number that a sheet can hold."""
    return value if math.isfinite(value) else None
