"""Work on a calibration from Python as the commands do: adapt, invert, compare, quality, export.

Each takes the folder of a calibration, or the sensor and table that `read_calibration` makes of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from sits_mech.analysis.built import comparison
from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.built.adaptation import adapt as adapted
from sits_mech.analysis.built.comparison import Comparison
from sits_mech.analysis.built.delivered import known_by
from sits_mech.analysis.built.fit import EndReached
from sits_mech.analysis.built.grown import grown
from sits_mech.analysis.built.mistakes import STRANGE, as_read, mistake, refuse_unlikely
from sits_mech.analysis.built.prior import Prior, prior_of
from sits_mech.analysis.readings.bench import (
    code_calibration,
    coil_table,
    sensor_calibration,
    sensor_front_end,
    terminal_calibration,
    with_idle,
)
from sits_mech.analysis.readings.codes import tank_of
from sits_mech.analysis.readings.measured import Measured, Tank, read_measured
from sits_mech.arguments import Idle, checked_arguments
from sits_mech.export import formats
from sits_mech.export.source import Source
from sits_mech.quantities import SURE, Array, Wrench
from sits_mech.readout import quality as figures
from sits_mech.readout.budget import budget
from sits_mech.readout.loads import fixed, several
from sits_mech.readout.quality import Quality
from sits_mech.report.folder import cases_folder, read_calibration
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

Calibrated = str | Path | tuple[Sensor, xr.Dataset]
"""Folder of a calibration, or its sensor and table."""


def _opened(calibration: Calibrated) -> tuple[Sensor, xr.Dataset]:
    """Return sensor and table."""
    return calibration if isinstance(calibration, tuple) else read_calibration(calibration)


@checked_arguments
def adapt(
    calibration: Calibrated, readings: str | Path | Measured, *, free: Sequence[str] = (), noise: float | None = None,
    load_noise: float | None = None, depth_noise: float = 1e-5, lot: str | Path | None = None,
    clock: float | None = None, idle: Idle | None = None, grow: bool = False,
) -> Adaptation:
    """Return which sensor was built, by a few readings of it under known loads: as ``sits-mech adapt``.

    Parameters
    ----------
    calibration : path or (Sensor, Dataset)
        As computed.
    readings : path or Measured
        CSV: F_x, F_z, ..., L1 [uH] or code1, ..., depth [mm].
    free : sequence of str
        What is unknown: ``"modulus", "gap = 0 +- 0.3 mm"``; by default all that may be.
    noise, load_noise, depth_noise : float
        Deviations of a reading [H], of a force [N], of the way down [m]; by default the converter's, and 0.1 % of the
        largest force.
    lot : path
        What other units have shown: ``lot.json`` of ``sits-mech lot``.
    clock : float
        Of codes [Hz]; by default the part's largest.
    idle : str
        What the other coils are while one is read: open, shorted, live; by default as the scene says.
    grow : bool
        Whether a few more loads are solved where the fit ends at the table's end; the table is then ``prior.data``.

    Raises
    ------
    SceneError
        For readings that are none of such a sensor, or beyond the table, with the load that it must reach.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> loads = [(0.0, 0.0), (0.15, 0.3), (-0.15, 0.3), (0.0, 0.7)]
    >>> known = sm.terminal_calibration(sensor, data)
    >>> L = [known.forward(F_x=F_x, F_z=F_z) for F_x, F_z in loads]
    >>> rows = ["F_x [N], F_z [N], L1 [H], L2 [H]", *(", ".join(map(str, [*F, *l])) for F, l in zip(loads, L))]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "bench.csv").write_text("\\n".join(rows))
    ...     result = sm.adapt((sensor, data), Path(folder) / "bench.csv", free=["modulus", "gap = 0 +- 0.1 mm"])
    >>> result.names[:2], bool(abs(result.values[0] - 1.0) < 0.1)
    (('modulus', 'gap'), True)
    """
    sensor, data = _opened(calibration)

    def by(table: xr.Dataset) -> Prior:
        """Return what is known beforehand, by a table."""
        prior = prior_of(sensor, table, free, noise=noise)
        return prior if lot is None else known_by(prior, Path(lot))

    prior = by(data)
    measured = readings if isinstance(readings, Measured) else read_bench(
        prior, Path(readings), tank_of(sensor, data, clock))
    kept = None if isinstance(calibration, tuple) else cases_folder(Path(calibration))

    def further(prior: Prior, end: EndReached) -> Prior:
        """Return the same by more loads."""
        return by(grown(prior, measured.forces, end, kept if kept and kept.is_dir() else None))

    noises = {"load_noise": load_noise, "depth_noise": depth_noise}
    return adapted_as_read(prior, measured, noises, free, idle, further if grow else None)[0]


def read_bench(prior: Prior, path: Path, tank: Tank | None) -> Measured:
    """Return what a bench recorded of a sensor; SceneError for poses."""
    found = read_measured(path, prior.forces, prior.sensor.coil_names, tank, fixed(prior.data), unseen=True)
    if found.poses is not None:
        raise SceneError(f"{path}: must be of loads, or depths and loads that are nan; got poses: sits-mech compare")
    return found


def read_with(prior: Prior, coded: bool, free: Sequence[str]) -> Prior:
    """Return the sensor as codes show it, or a meter, which knows of no tank unless its capacitance is named."""
    return prior if coded or any("capacitance" in each for each in free) else prior.read_by(tank=False)


def adapted_as_read(
    prior: Prior, measured: Measured, noises: dict[str, Any], free: Sequence[str] = (), idle: str | None = None,
    further: Callable[[Prior, EndReached], Prior] | None = None,
) -> tuple[Adaptation, str]:
    """Return what readings tell, and what is wrong with strange ones; raise SceneError where they tell nothing.

    `further` makes a longer table where the fit ends at the table's end, twice at most.
    """
    for left in (2, 1, 0):
        own = read_with(prior, measured.coded, free).read_by(idle)
        measured.check()
        refuse_unlikely(own, measured, noises["load_noise"])
        try:
            found = as_read(
                own.sensor, own.data, measured.source, partial(_read_by, own, measured, noises),
                partial(mistake, own, measured, None, **noises),
            )
        except EndReached as end:
            if further is None or not left:
                raise
            prior = further(prior, end)
        else:
            break
    return found, mistake(own, measured, found, **noises) if found.p_value < STRANGE else ""


def _read_by(prior: Prior, measured: Measured, noises: dict[str, Any], idle: str) -> Adaptation:
    """Return what readings tell with idle coils of one kind."""
    return adapted(prior.read_by(idle), measured, **noises)


@dataclass(frozen=True)
class ForceReading:
    """Forces of readings, each with the error within which 90 % of the true forces lie."""

    forces: Array  # (..., d), in the order of the table's; NaN where the status is not "ok" [N, N m]
    error: Array  # (..., d) [N, N m]
    parts: dict[str, Array]  # of the error by cause, map, table, silicone, noise: their squares add up, (..., d)
    status: NDArray[np.str_]  # (...), as of `Calibration.inverse`


@checked_arguments
def invert(
    calibration: Calibrated, readings: ArrayLike, *, codes: bool = False, clock: float | None = None,
    idle: Idle | None = None,
) -> ForceReading:
    """Return the forces that belong to readings, and how well they are known: as ``sits-mech invert``.

    Parameters
    ----------
    calibration : path or (Sensor, Dataset)
        As computed or adapted.
    readings : array_like, shape (..., n)
        Of each coil, at its terminals [H], or codes of the converter.
    codes : bool
        Whether they are codes.
    clock, idle
        As of `adapt`.

    Raises
    ------
    ValueError
        Where the table holds too few loads, or there are not as many readings as coils.

    Examples
    --------
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> result = sm.invert((sensor, data), sm.terminal_calibration(sensor, data).forward(F_x=0.1, F_z=0.4))
    >>> result.forces.round(3).tolist(), bool((result.error > 0.0).all())
    ([0.1, 0.4], True)
    """
    sensor, data = _opened(calibration)
    known = code_calibration(sensor, data, clock=clock) if codes else terminal_calibration(sensor, data, idle)
    found = known.inverse(readings)
    left = budget(known, found.forces)
    return ForceReading(
        found.forces, left.total, {cause: SURE * part for cause, part in left.parts.items()}, found.status
    )


@checked_arguments
def compare(
    calibration: Calibrated, measured: str | Path, *, free: Sequence[str] = (), noise: float | None = None,
    magnetics: str = "auto", clock: float | None = None, idle: Idle | None = None,
) -> Comparison:
    """Return a measurement with what the model predicts, and the parameters that fit it best: as ``sits-mech compare``.

    Parameters
    ----------
    calibration : path or (Sensor, Dataset)
        Or the path of a scene, where stages have set poses.
    measured : path
        CSV: F_x, ... or d_v [mm], alpha [deg], ...; L1 [uH] or code1, ...
    free : sequence of str
        To fit: ``"modulus", "gap = 0 +- 0.3 mm"``, a key of the scene; by default modulus, gap and lead.
    noise : float
        Deviation of a reading, the weight of the data [H].
    magnetics : str
        Model of poses that were set.
    clock, idle
        As of `adapt`.

    Raises
    ------
    SceneError
        For an unknown parameter, a table that is too small, or a value at the end of its reach.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> rows = "d_v [mm], L1 [uH], L2 [uH]", "2, 2.35, 2.35", "2.5, 2.43, 2.43", "3, 2.48, 2.48", "4, 2.55, 2.55"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "bench.csv").write_text("\\n".join(rows))
    ...     result = sm.compare("biorob2018", Path(folder) / "bench.csv", free=["gap"], magnetics="planar")
    >>> result.fit.names, result.predicted.shape
    (('gap',), (4, 2))
    """
    alone = isinstance(calibration, str | Path) and not Path(calibration).is_dir()
    sensor, data = (load_sensor(str(calibration)), None) if alone else _opened(calibration)
    loads, held, tank = ((), None, None) if data is None else (
        several(data), fixed(data), tank_of(sensor, data, clock))
    bench = read_measured(measured, loads, sensor.coil_names, tank, held)
    asked = free or (comparison.USUAL if bench.poses is None else comparison.USUAL[1:])
    return as_read(with_idle(sensor, idle), data, measured, lambda way: comparison.compare(
        with_idle(sensor, way), data, bench, asked, noise=noise, magnetics=magnetics))


@checked_arguments
def quality(
    calibration: Calibrated, *, noise: ArrayLike | None = None, branches: tuple[Array, Array] | None = None
) -> Quality:
    """Return range, linearity, crosstalk, resolution and errors of a calibrated sensor: as ``sits-mech quality``.

    Parameters
    ----------
    calibration : path or (Sensor, Dataset)
        As computed or adapted.
    noise : array_like, shape () or (n,)
        Deviation of each inductance [H]; by default the converter's.
    branches : two arrays, shape (m, n)
        Inductances at the same loads, loading and unloading, for the hysteresis [H].

    Raises
    ------
    ValueError
        Where the table holds too few loads, or the noise is not positive.

    Examples
    --------
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> result = sm.quality((sensor, data), noise=1e-11)
    >>> result.forces, result.full_scale.tolist()
    (('F_x', 'F_z'), [[-0.2, 0.2], [0.0, 1.0]])
    """
    sensor, data = _opened(calibration)
    cal = sensor_calibration(sensor, data)
    sizes = sensor_front_end(sensor, data)[0].noise if noise is None else np.broadcast_to(noise, len(cal.coils))
    return figures.quality(cal, sizes, table=coil_table(sensor, data), branches=branches)


@checked_arguments
def export_calibration(
    calibration: Calibrated, to: str, path: str | Path, *, load: Wrench | None = None
) -> tuple[Path, tuple[str, ...]]:
    """Write a calibration for another program, and return the path with a line for each thing to know of it.

    Parameters
    ----------
    calibration : path or (Sensor, Dataset)
        As computed or adapted.
    to : str
        csv, netcdf, xlsx, c, spice, kicad, vtu, twin, page, pdf, svg or a plug-in's.
    path : path
        File, or of vtu, twin, pdf and svg a folder.
    load : Wrench
        Of the state that spice shows.

    Raises
    ------
    SceneError
        For an unknown format, the ending of another one, a sensor that does not fit, a failed write.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> sensor, models = sm.load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sensor, F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sm.export_calibration((sensor, data), "csv", Path(folder) / "table.csv")[0].name
    'table.csv'
    """
    return formats.export(Source(*_opened(calibration), load or Wrench()), to, Path(path))
