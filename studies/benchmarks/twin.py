"""Does a twin show what the chain shows, and how fast? biorob2018 over F_x and F_z, its folder as `export` writes it.

Held against the calibration's map at 10,000 random loads, and against loads solved anew by the whole chain (pad and
coils), within what the twin states of itself: error of its map and of the solved inductances. The map of poses is held
against the same solves at their own poses. Times are one core's processor time: numpy by batch, C99 compiled with -O2,
a step of 4096 pads with three branches of relaxation, readings and codes included. On a graphics card, by torch or jax,
times are the clock's; where there is none the table says "skipped".
Run ``python -m benchmarks.twin [--coarse] --output DIR``.
"""

from __future__ import annotations

import shutil
import subprocess
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from common.outputs import study_arguments, write_rows

from sits_mech.analysis.readings.bench import absolute, sensor_calibration
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import loaded_model, mechanical_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions
from sits_mech.chain.rests import at_rest
from sits_mech.chain.simulate import simulation_at
from sits_mech.export.source import Source
from sits_mech.export.twin.folder import write_twin
from sits_mech.export.twin.twin import Twin
from sits_mech.quantities import SolveFailed, Wrench
from sits_mech.readout.calibration import Calibration
from sits_mech.scene.sensor import load_sensor
from sits_mech.silicone.history import retardation

PRONY = ((0.08, 0.05), (0.06, 1.0), (0.05, 30.0))
PROGRAM = """
#include <stdio.h>
#include <time.h>
#include "twin.h"
#define MANY 1024
int main(void)
{
    static SITS_REAL wrench[MANY][6];
    SITS_REAL L[SITS_COILS], sum = 0;
    int32_t codes[SITS_COILS];
    const long rounds = ROUNDS;
    for (int i = 0; i < MANY; ++i)
        for (int k = 0; k < SITS_WRENCH_D; ++k)
            wrench[i][sits_wrench_column[k]] =
                sits_wrench_middle[k] + sits_wrench_half[k] * (SITS_REAL)((i * (2 * k + 1)) % MANY) / MANY;
    const clock_t began = clock();
    for (long r = 0; r < rounds; ++r)
        for (int i = 0; i < MANY; ++i) {
            sits_read(wrench[i], L, codes);
            sum += L[0] + (SITS_REAL)codes[0];
        }
    const double seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
    printf("%.9g %.9g\\n", (double)MANY * (double)rounds / seconds, (double)sum);
    return 0;
}
"""


def seconds(what: Callable[[], Any], times: int) -> float:
    """Return the processor time of one call, the least of three rounds of so many [s]."""
    what()
    found = []
    for _ in range(3):
        began = time.process_time()
        for _ in range(times):
            what()
        found.append((time.process_time() - began) / times)
    return min(found)


def against_map(twin: Twin, cal: Calibration, count: int) -> dict[str, Any]:
    """Return differences to the calibration's map, over full scale, in both precisions, and of the way back."""
    wrench = np.zeros((count, 6))
    wrench[:, :2] = np.random.default_rng(1).uniform(cal.low, cal.high, (count, 2))
    L, codes = cal.forward(wrench[:, :2]), cal.codes(wrench[:, :2])
    found, single = twin.read(wrench), twin.read(wrench.astype(np.float32))
    scale = cal.code_calibration.full_scale
    return {
        "map, float64": float(np.abs((found.L - L) / cal.full_scale).max()),
        "map, float32": float(np.abs((single.L - L) / cal.full_scale).max()),
        "codes, float32": float(np.abs((single.codes - codes) / scale).max()),
        "wrench from L [N]": float(np.abs(twin.estimate(found.L).wrench - wrench).max()),
        "error of the map": cal.error,
    }


def against_chain(twin: Twin, source: Source, cal: Calibration, count: int) -> dict[str, Any]:
    """Return how loads that are solved anew agree with the twin: by their wrench, and by their pose."""
    sensor, request = source.sensor, source.request
    names = request["mechanics"], request["magnetics"]
    forces = np.random.default_rng(2).uniform(cal.low, cal.high, (count, 2))
    loads = [Wrench(*pair) for pair in forces.tolist()]
    field, _ = loaded_model(sensor, names[1], request["tolerance"], loads)
    layer, _ = mechanical_model(sensor, names[0], request["tolerance"], loads)
    off, by_pose, failed = [], [], 0
    for load in loads:
        try:
            left_out = mechanical_omissions(sensor, names[0], [load])
            found = simulation_at(sensor, field, at_rest(sensor, layer, load, left_out))
        except SolveFailed:
            failed += 1
            continue
        L = np.diagonal(absolute(sensor, found.impedance)[0].L)
        off.append(twin.read(load.components[None]).L[0] - L)
        by_pose.append(twin.read_pose(found.equilibrium.pose.components[None]).L[0] - L)
    stated = (cal.map.error + twin.numbers["model_error"]) / cal.full_scale
    misses = np.abs(off) / cal.full_scale
    return {
        "solved anew": len(misses), "not reached": failed, "within stated error": float((misses <= stated).mean()),
        "median miss": float(np.median(misses)), "largest miss": float(misses.max()),
        "stated error": float(stated.max()),
        "largest miss by pose": float((np.abs(by_pose) / cal.full_scale).max()),
    }


def speed(twin: Twin, cal: Calibration, many: int) -> dict[str, Any]:
    """Return wrenches per second by numpy, few and many at once, the way back, and the time of a step of 4096 pads."""
    wrench = np.zeros((many, 6))
    wrench[:, :2] = np.random.default_rng(3).uniform(cal.low, cal.high, (many, 2))
    weights, times = retardation(PRONY)
    pads = Twin({**twin.numbers, "creep_weights": weights, "creep_times": times})
    state, few, found = pads.start(4096), wrench[:4096], {}
    for kind in (np.float64, np.float32):
        for count in (4096, many):
            given = wrench[:count].astype(kind)
            found[f"numpy, {kind.__name__}, {count}"] = count / seconds(lambda g=given: twin.read(g), many // count)
    L = twin.read(few).L
    found["numpy, back, 4096"] = 4096 / seconds(lambda: twin.estimate(L), 5)
    found["step of 4096 pads [s]"] = seconds(lambda: pads.step(state, few, 1e-3), 100)
    return found


def speed_in_c(folder: Path, rounds: int) -> dict[str, Any]:
    """Return wrenches per second of the compiled evaluator in both precisions; nothing without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return {}
    (folder / "speed.c").write_text(PROGRAM)
    found = {}
    for real in ("double", "float"):
        words = [compiler, "-std=c99", "-O2", f"-DSITS_REAL={real}", f"-DROUNDS={rounds}"]
        words += ["-o", f"speed_{real}", "speed.c", "-lm"]
        subprocess.run(words, cwd=folder, check=True, timeout=120)
        done = subprocess.run([folder / f"speed_{real}"], capture_output=True, text=True, check=True, timeout=120)
        found[f"C, {real}"] = float(done.stdout.split()[0])
    return found


def to_torch() -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Return what puts an array on a device of torch, and what waits for one; ImportError or RuntimeError for none."""
    torch = import_module("torch")
    return lambda array: torch.as_tensor(array, device="cuda"), lambda found: torch.cuda.synchronize()


def to_jax() -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Return the same of jax."""
    jax = import_module("jax")
    device = jax.devices("gpu")[0]
    return lambda array: jax.device_put(array, device), lambda found: found.block_until_ready()


def speed_on_devices(twin: Twin, cal: Calibration) -> dict[str, Any]:
    """Return wrenches per second on a graphics card, by the clock; by name, where there is none."""
    rows: dict[str, Any] = {}
    wrench = np.zeros((2**20, 6), dtype=np.float32)
    wrench[:, :2] = np.random.default_rng(3).uniform(cal.low, cal.high, (2**20, 2))
    for name, place in (("torch, cuda", to_torch), ("jax, gpu", to_jax)):
        try:
            put, wait = place()
            given = put(wrench)
        except (ImportError, RuntimeError, AssertionError) as error:  # torch asserts that it was compiled for one
            rows[name] = f"skipped: {type(error).__name__}"
            continue
        wait(twin.read(given).L)
        began = time.perf_counter()
        for _ in range(10):
            wait(twin.read(given).L)
        rows[name] = 10 * 2**20 / (time.perf_counter() - began)
    return rows


def main() -> None:
    """Write the table and print it."""
    coarse, folder = study_arguments(__doc__ or "")
    sensor, count = load_sensor("biorob2018"), 5 if coarse else 9
    models = {"mechanics": "planar", "magnetics": "planar", "tolerance": 3e-2} if coarse else {}
    data = calibrate(sensor, F_x=np.linspace(-0.5, 0.5, count), F_z=np.linspace(0.0, 2.0, count), **models)
    source = Source(sensor, data)
    cal = sensor_calibration(sensor, data)
    notes = write_twin(source, folder / "twin")
    twin = Twin.load(folder / "twin" / "sensor.npz")
    rows = against_map(twin, cal, 10_000) | against_chain(twin, source, cal, 5 if coarse else 200)
    many, rounds = (2**16, 100) if coarse else (2**20, 5000)
    rows |= speed(twin, cal, many) | speed_in_c((folder / "twin").resolve(), rounds) | speed_on_devices(twin, cal)
    print("\n".join(notes))
    print(write_rows([{"what": name, "value": value} for name, value in rows.items()], folder / "twin.csv"))


if __name__ == "__main__":
    main()
