"""How wide is the loop of the calibration curve when a load comes and goes, at which period?

The published sensor on its catalogued silicone with a rate and a softening of its own: two branches that relax a tenth
of the stiffness each, in half a second and in half a minute, and Mullins' effect of depth 1/r. These constants are an
example, not a measurement: put those of the sensor's silicone in their place. Triangular loads to one peak, one
figure: the loops of L_v at some periods, and their widths of the first and of the last cycle against the period.

Run ``python studies/hysteresis.py [--coarse] --output DIR``: figure and table.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from common.outputs import study_arguments, write_rows

from sits_mech.analysis.cycle import load_cycle, triangle
from sits_mech.quantities import Wrench
from sits_mech.report.pictures.style import new_figure, save_figure, strokes
from sits_mech.scene.sensor import Sensor, load_sensor, sensor_from
from sits_mech.silicone.material import table_of

PEAK = Wrench(F_x=0.25, F_z=2.0)
PRONY = [{"weight": 0.1, "time": "0.5 s"}, {"weight": 0.1, "time": "30 s"}]
MULLINS = {"r": 4.0}
CYCLES = 4


def aged(sensor: Sensor) -> Sensor:
    """Return the sensor with a rate and a softening in its silicone."""
    scene = sensor.model_dump(exclude_none=True)
    assert sensor.elastomer is not None
    scene["elastomer"]["material"] = table_of(sensor.elastomer.silicone) | {"prony": PRONY, "mullins": MULLINS}
    return sensor_from(scene)


def draw(loops: dict[float, xr.Dataset], path: Path) -> None:
    """Write loops and widths as a picture."""
    periods = sorted(loops)
    shown = {periods[0], periods[len(periods) // 2], periods[-1]}
    with new_figure(height=0.75, columns=2) as (figure, (left, right)):
        for stroke, period in zip(strokes(len(shown)), sorted(shown), strict=True):
            data, way = loops[period], {key: stroke[key] for key in ("color", "linestyle")}
            left.plot(PEAK.F_z * data["share"], data["L_v_percent"], **way, lw=0.7, label=f"{period:.4g} s")
        for place, name, way in ((0, "first cycle", "C0o-"), (-1, "last cycle", "C1s--")):
            widths = [loops[period].attrs["loop_L_v_percent"][place] for period in periods]
            right.plot(periods, widths, way, label=name)
        left.set(xlabel="normal force $F_z$ [N]", ylabel="$L_v\\,/\\,L_0$ [%]")
        right.set(xscale="log", xlabel="period [s]", ylabel="loop width [% of range]", ylim=(0.0, None))
        right.set_xlim(periods[0] / 2.0, 2.0 * periods[-1])
        left.legend(title="period")
        if np.isfinite([loop.attrs["loop_L_v_percent"] for loop in loops.values()]).any():
            right.legend()
        else:
            right.text(0.5, 0.5, "no width:\nthe range of $L_v$\nis within its error", transform=right.transAxes,
                       ha="center", va="center")
        save_figure(figure, path)


def main() -> None:
    """Run the periods; write figure and table."""
    coarse, output = study_arguments(__doc__ or "")
    sensor, cycles, points = aged(load_sensor("biorob2018")), *((2, 5) if coarse else (CYCLES, 17))
    models = {"mechanics": "planar", "magnetics": "planar", "tolerance": 3e-2} if coarse else {}
    periods = np.geomspace(0.1, 1000.0, 2 if coarse else 9).tolist()
    loops = {period: load_cycle(sensor, PEAK, triangle(period, cycles), points=points, **models) for period in periods}
    names = [f"{kind}{name}" for name in ("loop_L_v_percent", "loop_L_h_percent") for kind in ("", "error_")]
    rows = [
        {"period_s": period, "cycle": k + 1} | {name: data.attrs[name][k] for name in names}
        for period, data in loops.items()
        for k in range(cycles)
    ]
    print(write_rows(rows, output / "hysteresis.csv"))
    draw(loops, output / "hysteresis.png")


if __name__ == "__main__":
    main()
