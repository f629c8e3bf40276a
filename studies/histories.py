"""What does a sensor show whose silicone remembers, point by point, and what does that cost?

The published sensor with the rate and softening of studies/hysteresis.py, an example and not a measurement. Three
figures: the loop of L_v over F_z at three rates, by every point of the pad and, grey, by the pad as a whole (the cheap
rung of ``cycle``); the creep of L_v after steps of load; a load that presses, shears while pressed and lets go. Two
tables: how far the cheap rung is from the full one, and processor time of a time of a history, over that of an elastic
load in the same path on the same meshes, each going on from the one before.

Run ``python studies/histories.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from common.outputs import study_arguments, write_rows
from hysteresis import aged

from sits_mech.analysis.cycle import Programme, load_cycle
from sits_mech.analysis.histories.full_cycle import difference, full_cycle
from sits_mech.analysis.histories.response import in_time
from sits_mech.chain.models import mechanical_model
from sits_mech.mechanics.histories import LoadHistory, motion_of
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.style import new_figure, save_figure, strokes
from sits_mech.scene.sensor import Sensor, load_sensor

PEAK = Wrench(F_z=2.0)
PERIODS = (0.1, 2.0, 60.0)  # [s]
SAMPLES = 100  # of a leg that is drawn
STEP = 1e-3  # in which a load comes at once [s]


def legs(period: float, cycles: int = 2) -> Programme:
    """Return a load that rises and falls evenly, as many times between its corners as are drawn."""
    phase = np.arange(2 * SAMPLES * cycles + 1) / (2 * SAMPLES)
    return Programme(phase * period, 1.0 - np.abs(2.0 * (phase % 1.0) - 1.0))


def history(times: list[float], **forces: list[float]) -> LoadHistory:
    """Return a history of F_x and F_z [N]."""
    wrench = np.zeros((len(times), 6))
    for name, values in forces.items():
        wrench[:, ("F_x", "F_z").index(name)] = values
    return LoadHistory(np.array(times), wrench)


def draw_loops(found: dict[float, tuple[xr.Dataset, xr.Dataset]], path: Path) -> None:
    """Write the loops of both rungs."""
    with new_figure(height=0.75) as (figure, (axes,)):
        for stroke, (period, (cheap, full)) in zip(strokes(len(found)), found.items(), strict=True):
            way = {key: stroke[key] for key in ("color", "linestyle")}
            last = slice(2 * SAMPLES, None)
            axes.plot(PEAK.F_z * cheap["share"][last], cheap["L_v_percent"][last], color="0.6", lw=1.6)
            axes.plot(PEAK.F_z * full["share"][last], full["L_v_percent"][last], **way, lw=0.8, label=f"{period:g} s")
        axes.set(xlabel="normal force $F_z$ [N]", ylabel="$(L_1 + L_2)\\,/\\,L_0$ [%]")
        axes.legend(title="period; grey: pad as a whole")
        save_figure(figure, path)


def draw_creep(found: dict[float, xr.Dataset], path: Path) -> None:
    """Write what L_v does after steps of load."""
    with new_figure(height=0.7) as (figure, (axes,)):
        for stroke, (force, data) in zip(strokes(len(found)), found.items(), strict=True):
            signal, after = data["L_v_percent"].to_numpy(), data["time"].to_numpy()
            late = after >= STEP
            axes.plot(after[late], signal[late] - signal[0], **stroke, label=f"{force:g} N")
        axes.set(xscale="log", xlabel="time after the step [s]", ylabel="change of $(L_1 + L_2)\\,/\\,L_0$ [%]")
        axes.legend(loc="lower left")
        save_figure(figure, path)


def draw_way(data: xr.Dataset, path: Path) -> None:
    """Write loads and signals of a press with shear."""
    with new_figure(height=0.8, rows=2) as (figure, (upper, lower)):
        for name, stroke in zip(("F_z", "F_x"), strokes(2), strict=True):
            way = {key: stroke[key] for key in ("color", "linestyle")}
            upper.plot(data["time"], data[name], **way, label=f"${name}$ [N]")
        for name, stroke in zip(("L_v", "L_h"), strokes(2), strict=True):
            way = {key: stroke[key] for key in ("color", "linestyle")}
            values = data[f"{name}_percent"] - data[f"{name}_percent"][0]
            lower.plot(data["time"], values, **way, label=f"${name} - {name}(0)$ [%]")
        upper.legend()
        lower.legend()
        upper.set(ylabel="load")
        lower.set(xlabel="time [s]", ylabel="signal")
        save_figure(figure, path)


def cost(title: str, sensor: Sensor, mechanics: str, tolerance: float, parts: int = 8) -> dict[str, Any]:
    """Return processor time of a time of a history and of an elastic load on the same path, in parts of each leg."""
    way, _ = history([0.0, 1.0, 2.0, 3.0], F_z=[0.0, 1.0, 1.0, 0.5], F_x=[0.0, 0.0, 0.2, 0.2]).divided(parts)
    began = time.process_time()
    moved = motion_of(sensor, mechanical_model(sensor, mechanics, tolerance)[0], way)
    middle = time.process_time()
    layer, start = mechanical_model(sensor, mechanics, tolerance)[0], None
    for load in way.course.tolist():
        start = layer.equilibrium(Wrench(*load), start=start)
    end = time.process_time()
    each, elastic = (middle - began) / moved.time.size, (end - middle) / way.time.size
    return {
        "pad": title, "times": moved.time.size, "ms_a_time": 1e3 * each, "ms_elastic": 1e3 * elastic,
        "ratio": each / elastic, "estimated_error": moved.report.estimated_error,
    }


def main() -> None:
    """Run the loops, steps and costs; write figures and tables."""
    coarse, output = study_arguments(__doc__ or "")
    sensor = aged(load_sensor("biorob2018"))
    models = {"mechanics": "planar", "magnetics": "planar", "tolerance": 1e-1} if coarse else {"tolerance": 1e-2}
    found = {}
    for period in PERIODS[:1] if coarse else PERIODS:
        way = legs(period)
        found[period] = load_cycle(sensor, PEAK, way, points=9, **models), full_cycle(sensor, PEAK, way, **models)
    draw_loops(found, output / "loops.png")
    print(write_rows([{"period_s": p} | difference(*pair) for p, pair in found.items()], output / "cheap_rung.csv"))
    steps = {force: in_time(sensor, history([0.0, STEP, 300.0], F_z=[0.0, force, force]), **models)
             for force in ((1.0,) if coarse else (0.5, 1.0, 2.0))}
    draw_creep(steps, output / "creep.png")
    shear = {"F_z": [0.0, 2.0, 2.0, 1.0, 0.0, 0.0], "F_x": [0.0, 0.0, 0.4, 0.4, 0.0, 0.0]}
    press = history([0.0, 1.0, 2.0, 3.0, 4.0, 6.0], **shear)
    draw_way(in_time(sensor, press, **models), output / "press_and_shear.png")
    cases = [("section, 1e-2", "planar", 1e-2), ("section, 1e-3", "planar", 1e-3), ("in space, 3e-2", "block", 3e-2)]
    quick = [("section, 1e-1", "planar", 1e-1, 3)]
    rows = [cost(title, sensor, *case) for title, *case in (quick if coarse else cases)]
    print(write_rows(rows, output / "costs.csv"))


if __name__ == "__main__":
    main()
