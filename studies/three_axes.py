"""Do loads that are solved directly come back from a three-axis calibration, of which few loads were solved?

Random loads within the calibrated range are solved by the models of the calibration, each for itself, and what their
coils show is read by the inverse of the table: how far each force is off, over its range and over its stated error,
that of the map and that of the solved loads. Errors that loads have in common by their mesh cancel in this.

Run ``python studies/three_axes.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common.outputs import study_arguments, write_rows

from sits_mech.analysis.readings.bench import model_errors, sensor_calibration
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.propagation import poses_of, read_poses
from sits_mech.chain.rests import at_rest
from sits_mech.notes import Note, NoteKind, unpacked
from sits_mech.quantities import Array, Wrench
from sits_mech.readout.calibration import OK
from sits_mech.scene.sensor import Sensor, load_sensor

SENSORS = ("triaxial-4", "triaxial-3")
SHEAR, NORMAL, COUNT, LOADS = 0.5, 2.0, 5, 200


def direct(sensor: Sensor, loads: list[Wrench], tolerance: float) -> Array:
    """Return the inductance of each coil under loads that are solved one by one, from rest, shape (m, n) [H]."""
    layer, field = (choose(sensor, "auto", tolerance, loads)[0] for choose in (mechanical_model, loaded_model))
    found = [at_rest(sensor, layer, load, ()) for load in loads]
    reading = read_poses(sensor, field, poses_of(found))
    return np.asarray(np.diagonal(reading.impedance.L, axis1=-2, axis2=-1))


def compare(name: str, count: int, loads: int, tolerance: float) -> list[dict[str, Any]]:
    """Return a row for each force."""
    sensor, shear = load_sensor(name), np.linspace(-SHEAR, SHEAR, count).tolist()
    began = time.process_time()
    data = calibrate(sensor, F_x=shear, F_y=shear, F_z=np.linspace(0.0, NORMAL, count).tolist(), tolerance=tolerance)
    seconds, known = time.process_time() - began, sensor_calibration(sensor, data)
    draw = np.random.default_rng(14).uniform(known.low, known.high, (loads, len(known.forces)))
    wrenches = [Wrench(**dict(zip(known.forces, row, strict=True))) for row in draw.tolist()]
    found = known.inverse(direct(sensor, wrenches, tolerance))
    good, span = found.status == OK, known.high - known.low
    off = np.abs(found.forces - draw)[good]
    stated = found.error[good] + known.force_error(found.forces[good], model_errors(sensor, data))
    between = sum(Note(NoteKind.INTERPOLATED) in unpacked(text) for text in data["notes"].to_numpy().ravel())
    head = {"sensor": name, "loads": data["status"].size, "between solved ones": between, "calibrate [s]": seconds}
    head |= {"read back": int(np.count_nonzero(good)), "of": loads}
    rows = []
    for k, force in enumerate(known.forces):
        row = {"force": force, "largest error, % of range": 100.0 * off[:, k].max() / span[k]}
        row |= {"rms error, % of range": 100.0 * float(np.sqrt(np.mean(off[:, k] ** 2))) / span[k]}
        row |= {"median stated, % of range": 100.0 * float(np.median(stated[:, k])) / span[k]}
        row |= {"median stated by the map, % of range": 100.0 * float(np.median(found.error[good, k])) / span[k]}
        rows.append(head | row | {"within stated, %": 100.0 * float(np.mean(off[:, k] <= stated[:, k]))})
    return rows


def main() -> None:
    """Calibrate and read back, sensor by sensor."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    names, *asked = (SENSORS[1:], 4, 2, 0.1) if coarse else (SENSORS, COUNT, LOADS, 1e-2)
    rows = [row for name in names for row in compare(name, *asked)]
    print(write_rows(rows, folder / "three_axes.csv"))


if __name__ == "__main__":
    main()
