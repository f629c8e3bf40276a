"""Write the pictures of a calibration as PDF or SVG for a paper, their text as text.

The same calibration makes the same files, byte by byte. The layer under a load is that of ``sits-mech view``.
"""

from __future__ import annotations

from pathlib import Path

from sits_mech.export.source import Source, own_folder
from sits_mech.report.pictures.style import check_drawing, save_figures
from sits_mech.report.plots.curves import calibration_pictures


def write_pictures(source: Source, path: Path, form: str) -> tuple[str, ...]:
    """Write curves and crosstalk to a folder, made where missing; `form` is pdf or svg.

    Return one line for each picture that the table has no loads for, and how to draw the layer. Raise SceneError.
    """
    check_drawing()
    own_folder(path, form, (f".{form}",))
    notes = save_figures(path, calibration_pictures(source.data), form)
    return (*notes, f"the layer under a load: sits-mech view SCENE --fz ... -o layer.{form}")
