"""Write the pictures of a calibration as PDF or SVG for a paper, their text as text.

The same calibration makes the same files, byte by byte. The layer under a load is that of ``sits-mech view``.
"""

from __future__ import annotations

from pathlib import Path

from sits_mech.export.source import Source, own_folder
from sits_mech.report.pictures.style import save_figure
from sits_mech.report.plots.curves import calibration_pictures
from sits_mech.scene.sensor import SceneError


def write_pictures(source: Source, path: Path, form: str) -> tuple[str, ...]:
    """Write curves and crosstalk to a folder, made where missing; `form` is pdf or svg.

    Return one line for each picture that the table has no loads for, and how to draw the layer. Raise SceneError.
    """
    own_folder(path, form, (f".{form}",))
    notes = []
    for name, draw in calibration_pictures(source.data).items():
        try:
            save_figure(draw(), path / f"{name}.{form}")
        except SceneError as error:
            notes.append(f"no picture {name}.{form}: {error}")
    return (*notes, f"the layer under a load: sits-mech view SCENE --fz ... -o layer.{form}")
