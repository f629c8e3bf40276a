"""Make, read or refuse the folder of a calibration; nothing heavy is imported."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.arguments import checked_arguments
from sits_mech.batch.tables import SWEPT, case_calibration
from sits_mech.readout.loads import LOADS, answered, point
from sits_mech.report.pictures.style import check_drawing
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor
from sits_mech.status import ANSWERED, INTERPOLATED, UNFINISHED
from sits_mech.store import STORE, glance, read_table
from sits_mech.units import printable
from sits_mech.version import __version__

if TYPE_CHECKING:
    import xarray as xr

_FORMATS = (".png", ".pdf", ".svg")
_WORDS = ("status", "reason", "notes", "flags")
_READ: dict[str, Callable[[Any], object]] = {
    "request": lambda text: [json.loads(text)[key] for key in ("mechanics", "magnetics", "tolerance")],
    "frequency": float, "magnetics_tolerance": float, "unit_L": ("H", "H/m").index,
}
_NEEDED = ("status", "d_h", "d_v", "alpha", "L", "R", "L0", "error_L", "error_R")


def prepare_folder(folder: Path, *, cases: bool = True) -> Path:
    """Make a folder, with one for finished loads, and prove that it can be written to; raise SceneError if not."""
    try:
        (cases_folder(folder) if cases else folder).mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise SceneError(f"{folder}: must be a folder that can be written to; got: {error.strerror or error}") from None


def checked_picture(path: Path, option: str = "--output") -> Path:
    """Return where a picture goes; raise SceneError where it cannot be drawn or its folder is not there."""
    check_drawing()
    if path.suffix not in _FORMATS:
        raise SceneError(f"{option}: must end in {', '.join(_FORMATS)}; got {path.name!r}")
    return checked_file(path, option)


def checked_file(path: Path, option: str = "--output") -> Path:
    """Return where a file goes; raise SceneError where its folder is not there."""
    if not path.parent.is_dir():
        raise SceneError(f"{option}: must be in a folder that exists; got {path}")
    return path


def cases_folder(folder: Path) -> Path:
    """Return where the finished loads of a calibration are kept."""
    return folder / "cases"


@checked_arguments
def read_calibration(folder: str | Path, case: int | None = None) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and table of a calibration's folder, or of a case, from 1 on, of a sweep of calibrations.

    Raise SceneError for no calibration, a stopped one, one of another version or scene, or one without converged load.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from sits_mech.report.written import write_calibration  # as sits-mech calibrate does
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = write_calibration(sensor, data, Path(folder), layer=False)
    ...     again, table = sm.read_calibration(folder)
    >>> again == sensor, bool((table["L"] == data["L"]).all())
    (True, True)
    """
    folder = Path(folder)
    _checked(folder, case)
    data = read_table(folder / "result.nc")
    if case is not None:
        return _case(folder, data, case)
    check_table(data, str(folder / "result.nc"))
    _check_attributes(data.attrs, str(folder / "result.nc"))
    sensor = load_sensor(folder / "scene.toml")
    if data.attrs.get("scene") != (folder / "scene.toml").read_text(encoding="utf-8"):
        raise SceneError(f"{folder}: scene.toml must be the scene of result.nc; it was changed: calibrate anew")
    return sensor, data


def check_table(data: xr.Dataset, name: str, *more: str) -> None:
    """Raise SceneError where a table, called `name`, is no calibration of this version with a load that converged.

    It must have `more` attributes, where they are named.
    """
    missing = [need for need in (*_NEEDED, *more) if need not in data.variables and need not in data.attrs]
    if missing:
        raise SceneError(f"{name}: must be the table of a calibration; {missing[0]} is missing")
    words = [key for key, item in data.data_vars.items() if item.dtype.kind not in "bif" and key not in _WORDS]
    if words:
        raise SceneError(f"{name}: must hold numbers in {words[0]}; got words")
    loads = data["status"].dims
    if not loads or not set(loads) <= set(LOADS):
        raise SceneError(f"{name}: must be the table of a calibration, over components of a load; got {loads}")
    _check_version(data.attrs, name)
    if not answered(data).any():
        raise SceneError(f"{name}: must hold at least one load that converged; got none")


def _check_attributes(attributes: Mapping[Any, Any], name: str) -> None:
    """Refuse a table, called `name`, whose attributes were changed; its request is a JSON object, others numbers."""
    for key, read in _READ.items():
        try:
            if key in attributes:
                read(attributes[key])
        except (KeyError, TypeError, ValueError):
            came = printable(str(attributes[key]), length=40)
            raise SceneError(f"{name}: must have {key} as it was written; got {came}: calibrate anew") from None


def look_at(folder: Path) -> tuple[Sensor, tuple[str, ...]]:
    """Return a calibration's sensor and varied components without its numbers; raise as `read_calibration`."""
    attributes = _checked(folder, None)
    _check_attributes(attributes, str(folder / "result.nc"))
    asked = json.loads(attributes.get("request", "{}"))
    return load_sensor(folder / "scene.toml"), tuple(name for name in LOADS if np.size(asked.get(name, 0.0)) > 1)


def is_sweep(folder: Path) -> bool:
    """Tell whether a folder has the table of a sweep."""
    path = folder / "result.nc"
    return path.exists() and "combine" in glance(path)[0]


def _checked(folder: Path, case: int | None) -> dict[str, Any]:
    """Return the attributes of the table in a folder; refuse a folder or a case that is not there."""
    path = folder / "result.nc"
    if not path.exists():
        stopped = cases_folder(folder).is_dir() or (folder / STORE).exists()
        state = "a calibration that was stopped: repeat its command" if stopped else "none"
        raise SceneError(f"{folder}: must be the folder of a finished calibration (sits-mech calibrate); got {state}")
    attributes, count = glance(path)
    swept = attributes.get("request") in SWEPT
    if not swept and case is not None:
        raise SceneError(f"--case: must be of a sweep with request = {' or '.join(SWEPT)}; got {folder}")
    if swept and (case is None or not 1 <= case <= count):
        given = "no --case" if case is None else f"--case {case}"
        what = f"quality and report take one of its cases, --case 1 to --case {count}"
        raise SceneError(f"{folder}: is the folder of a sweep: {what}; got {given}")
    _check_version(attributes, str(folder))
    return attributes


def _check_version(attributes: Mapping[Any, Any], name: str) -> None:
    """Refuse a table, called `name`, that another version made."""
    came = attributes.get("version", "an unknown one")
    if came != __version__:
        what, again = ("sweep", "sweep") if attributes.get("request") in SWEPT else ("calibration", "calibrate")
        raise SceneError(f"{name}: must be a {what} by version {__version__}; got {came}: {again} anew")


def _case(folder: Path, data: xr.Dataset, case: int) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and table of a case of a sweep, or refuse one that has none."""
    row = point(data, case - 1)
    if "load_status" not in row or not row["load_status"].isin(ANSWERED).any():
        word = row["status"].item()
        why = word if word in (UNFINISHED, INTERPOLATED) else row["reason"].item() or "no load converged"
        raise SceneError(f"{folder}: --case {case} must be a case with a table; it has none: {why}")
    return case_calibration(row)
