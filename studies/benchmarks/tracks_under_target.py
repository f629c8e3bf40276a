"""How right are R and L of a whole coil whose tracks see the target, and what did they miss that did not?

Eight coils of different fill and layers under a coaxial disc, every turn solid copper in series, by NGSolve
(common/solid_turns.json, made by common/ngsolve_turns.py), gaps of 0.1 to 3 mm, 1 to 8 MHz, tracks 0.3 to 14 skin
depths wide. The errors' constants are of the first five, and hold on the other three. Beside it what a model of even
current gives with the losses of tracks alone. The reference's L is some 3e-5 off by its far boundary.

Run ``python -m benchmarks.tracks_under_target [--coarse] --output DIR``: the table and a figure of R and Q against the
gap. Where NGSolve is installed one of its numbers is made anew.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from common.ngsolve_turns import MM, solid_turns
from common.outputs import study_arguments, write_rows
from common.track_losses import track_spectrum

from sits_mech.magnetics.coils.tracks import Tracked
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.quantities import Pose
from sits_mech.report.pictures.style import COLUMN, new_figure, save_figure
from sits_mech.scene.sensor import Coil, Sensor, Target

STORED = json.loads((Path(__file__).parents[1] / "common" / "solid_turns.json").read_text(encoding="utf-8"))
COPPER = 5.8e7


def scene(name: str, frequency: float, gap: float | None) -> Sensor:
    """Return a coil of the references, under the disc or alone."""
    own = STORED["coils"][name]
    coil = Coil(
        name="C", centre=(0.0, 0.0), layers=own["layers"], turns=own["turns"], inner_diameter=own["inner"] * MM,
        track_width=own["width"] * MM, track_gap=own["gap"] * MM, track_thickness=own["thickness"] * MM,
        layer_pitch=own["pitch"] * MM, conductivity=COPPER,
    )
    disc = Target(conductivity=COPPER, shape="disc", diameter=8.0 * MM, thickness=0.2 * MM)
    return Sensor(name=name, frequency=frequency, coils=(coil,), target=None if gap is None else disc)


def measured(row: dict[str, Any]) -> dict[str, Any]:
    """Return one line: R and L beside the reference, and of even current."""
    sensor, gap, f = scene(row["coil"], row["frequency"], row["gap"]), row["gap"], row["frequency"]
    model, pose = axisymmetric(sensor, 1e-2), Pose(0.0, MM if gap is None else gap * MM)
    found, even = Tracked(model, sensor).impedance(pose, f), model.impedance(pose, f)
    R, before = (float(each.R[0, 0] + each.R_dc[0]) for each in (found, even))
    before += float(track_spectrum(sensor.coils[0], [f]).R[0] - even.R_dc[0])
    line = {"coil": row["coil"], "frequency": f, "gap_mm": gap, "R": R, "R_off": R / row["R"] - 1.0}
    line |= {"R_told": float(found.error_R[0, 0]) / row["R"], "R_before_off": before / row["R"] - 1.0}
    line |= {"Q": 2 * np.pi * f * float(found.L[0, 0]) / R, "Q_before": 2 * np.pi * f * float(even.L[0, 0]) / before}
    if gap is None:
        assert found.error_L0 is not None
        return line | {"L_off": float(found.L[0, 0]) / row["L"] - 1.0, "L_told": float(found.error_L0[0, 0]) / row["L"]}
    alone = row["coil"], f, None
    free = next(one["L"] for one in STORED["rows"] if (one["coil"], one["frequency"], one["gap"]) == alone)
    change = row["L"] - free
    line |= {"change_off": float((found.L - found.L0)[0, 0]) / change - 1.0}
    line |= {"change_told": float(found.error_L[0, 0]) / abs(change)}
    return line | {"change_before_off": float((even.L - even.L0)[0, 0]) / change - 1.0}


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw R and Q against the gap."""
    with new_figure(0.45, 2, width=2 * COLUMN) as (figure, axes):
        for name in dict.fromkeys(row["coil"] for row in rows):
            highest = max(row["frequency"] for row in rows if row["coil"] == name)
            own = [row for row in rows if row["coil"] == name and row["frequency"] == highest and row["gap_mm"]]
            gaps = [row["gap_mm"] for row in own]
            (line,) = axes[0].plot(gaps, [1.0 + row["R_off"] for row in own], "o-", label=name)
            axes[0].plot(gaps, [1.0 + row["R_before_off"] for row in own], "--", color=line.get_color())
            axes[1].plot(gaps, [row["Q"] for row in own], "o-", color=line.get_color())
            axes[1].plot(gaps, [row["Q_before"] for row in own], "--", color=line.get_color())
        axes[0].set(xlabel="gap [mm]", ylabel="R over that of solid turns", xscale="log")
        axes[1].set(xlabel="gap [mm]", ylabel="Q (dashed: tracks without the target)", xscale="log")
        axes[0].legend()
        save_figure(figure, path)


def main() -> None:
    """Write the table and the figure."""
    coarse, folder = study_arguments(__doc__ or "")
    some = [row for row in STORED["rows"] if not coarse or row["coil"] == "biorob2018"]
    rows = [measured(row) for row in some]
    print(write_rows(rows, folder / "tracks_under_target.csv"))
    ratios = [abs(row["R_off"]) / row["R_told"] for row in rows]
    ratios += [abs(row["change_off"]) / row["change_told"] for row in rows if row["gap_mm"]]
    print(f"true over told: at most {max(ratios):.2f}, median {np.median(ratios):.2f}, of {len(ratios)}")
    draw(rows, folder / "tracks_under_target.png")
    if find_spec("ngsolve") is None:
        print("ngsolve: not installed, left out: pip install ngsolve")
        return
    again = next(row for row in some if row["gap"] == 1.0)
    R, L = solid_turns(STORED["coils"][again["coil"]], again["gap"], again["frequency"])
    print(f"made anew: R {R / again['R'] - 1.0:.1e}, L {L / again['L'] - 1.0:.1e} off what is stored")


if __name__ == "__main__":
    main()
