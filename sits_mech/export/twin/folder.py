"""Write a sensor's twin to a folder: numbers, an evaluator for Python, one for C, a pad for MuJoCo.

``sensor.npz``, arrays alone; ``twin.py``, which needs numpy alone; ``twin.h`` with the numbers in ``sensor.h``, C99;
``pad.xml`` where the pad's compliance is known. twin.py and twin.h are the package's own files, as they are.
"""

from __future__ import annotations

import io
from importlib import resources
from pathlib import Path

import numpy as np

from sits_mech.export.source import Source, own_folder
from sits_mech.export.twin.arrays import twin_arrays
from sits_mech.export.twin.mjcf import mjcf
from sits_mech.export.twin.tables import c_tables
from sits_mech.scene.files import write_bytes, write_text

EVALUATORS = ("twin.py", "twin.h")


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
        write_text(path / name, (resources.files("sits_mech.export.twin") / name).read_text(encoding="utf-8"))
    write_text(path / "sensor.h", c_tables(numbers, source.about))
    pad = mjcf(source.sensor, numbers)
    if pad is None:
        (path / "pad.xml").unlink(missing_ok=True)  # of another calibration
        return (*notes, "no pad.xml: the model of the mechanics tells no compliance")
    write_text(path / "pad.xml", pad)
    return notes
