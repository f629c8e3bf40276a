"""Do stated errors of the three-dimensional model hold, are tolerances met, and is a finer answer better?

Forty scenes by chance (common/sheet_scenes.py: discs, rectangles, rings, foils, blocks, two plates, grounds; 5 kHz to
25 MHz; gaps of 0.05 to 5 mm), a small foil at 0.1 mm, and twenty discs of steel, ferrite and filled rubber (5 kHz to
1 MHz, 0.1 to 3 mm; L relative to a tenth of |Delta Z| at least, as it passes zero; R only where it is 1e-3 of that),
asked to three tolerances: true and stated errors of the
change of L and of R, unknowns, and seconds of the processor from the scene on. References of coaxial discs are
axisymmetric finite elements of order 4 (asked 1e-5, where that fits; order 3 differs from it by no more than stands
beside them), kept in common/reference_sheets.json; those of all others the same model on the finest of some far finer
divisions that the limits of memory and of seconds allow (`--memory`, `--seconds`), made anew where that file has none.
Scenes that none of these holds are not judged, nor tolerances that are refused, nor where the stated error is less than
five times the reference's own: `scenes` counts those that are.

Run ``python -m benchmarks.sheets_errors [--coarse] --output DIR``. Table, what holds together, and a picture: true
errors against unknowns and seconds, each scene a thin line, each regime (`regime`) one by their geometric means.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from common.outputs import kept_rows, study_arguments, write_rows
from common.references import FINER as BETTER
from common.sheet_scenes import COUNT, METAL, SheetScene, sheet_scene
from threadpoolctl import threadpool_limits

from sits_mech.magnetics.axis.coaxial import coaxial_discs
from sits_mech.magnetics.axis_fem import axisymmetric_fem, solved_axis
from sits_mech.magnetics.modes import skin_depth
from sits_mech.magnetics.sheets import Sheets, sheets
from sits_mech.magnetics.space import rungs
from sits_mech.magnetics.space.divisions import prepared, prepared_near
from sits_mech.quantities import SolveFailed
from sits_mech.report.pictures.style import COLUMN, new_figure, save_figure, strokes
from sits_mech.scene.sensor import metal_parts
from sits_mech.units import SceneError

Row = dict[str, Any]
STORED = Path(__file__).parents[1] / "common" / "reference_sheets.json"
ASKED, COARSE = (1e-2, 3e-3, 1e-3), (1e-1,)
ANY = 0.5  # a tolerance that the roughest rung meets
REFUSED = SceneError, rungs.TooLarge  # by seconds, by memory
FOUND = "unknowns", "true L", "stated L", "true R", "stated R"
CLOSE = 0.03  # gap over the coil's diameter below which a scene is a close one
_CROSSING, _LOST = 0.1, 1e-3  # of |Delta Z| of permeable parts: the least L that errors are of, and R
AXIS = (1e-5, 1e-4, 1e-3)  # tolerances of the axisymmetric model, the first that its unknowns carry
FINER = tuple(  # than any that is asked, the finest first; and levels of outlines: apart, as limits magnify their jumps
    (rungs.PlateRung(along=(m, m + 2, m + 4), across=(5, 6, 7), terms=11.0), outlines)
    for m, outlines in ((5, (3, 6, 9)), (4, (2, 4, 8)), (3, (2, 4, 8)))
)


def reference(number: int) -> tuple[complex, float]:
    """Return Delta Z [ohm] of a scene, kept or new, and its relative error; nan where none can be afforded."""
    kept = json.loads(STORED.read_text("utf-8"))["Delta Z"].get(str(number))
    if kept is not None:
        return complex(kept[0], kept[1]), kept[2]
    scene = sheet_scene(number)
    omega = 2 * np.pi * scene.sensor.frequency
    if scene.coaxial:
        discs = coaxial_discs(scene.sensor, float(np.asarray(scene.pose.d_v)))
        for tolerance in AXIS:
            with suppress(SolveFailed):
                found = solved_axis(axisymmetric_fem(scene.sensor, tolerance), discs, scene.sensor.frequency)
                return 1j * omega * found.of_order_4.flux, tolerance
    usual = rungs.ROUGHEST, rungs._ANY
    try:
        for finer, outlines in FINER:
            rungs.ROUGHEST = 0.0, finer  # there is no coarser one to take
            rungs._ANY = dict.fromkeys(usual[1], (outlines,) * 2)
            with suppress(*REFUSED):
                z = unprepared(scene, ANY).impedance(scene.pose, scene.sensor.frequency)
                change = complex(z.R.item(), omega * (z.L - z.L0).item())
                return change, max(z.error_R.item() / change.real, omega * z.error_L.item() / abs(change.imag))
    finally:
        rungs.ROUGHEST, rungs._ANY = usual
    return complex(math.nan, math.nan), math.nan


def unprepared(scene: SheetScene, tolerance: float) -> Sheets:
    """Return the model of a scene, when no plate is prepared any more."""
    for plates in (prepared, prepared_near):
        plates.cache_clear()
    return sheets(scene.sensor, tolerance)


def regime(scene: SheetScene) -> str:
    """Return what a scene's error is by: its rings, its permeability, its gap, or its thickness over the skin depth."""
    coil, ((_, part), *_) = scene.sensor.coils[0], metal_parts(scene.sensor)
    thick = part.thickness > skin_depth(scene.sensor.frequency, part.metal.conductivity)
    gap = scene.pose.d_v if scene.sensor.target else -coil.height - part.centre[2] - part.thickness / 2
    close = "close" if gap < CLOSE * coil.outer_diameter else "thick" if thick else "thin"
    return "permeable" if part.metal.susceptibility else "ring" if part.shape == "ring" else close


def measure(number: int, asked: Sequence[float]) -> Row:
    """Return the row of a scene: nan where a tolerance is refused, as some are by their seconds."""
    scene, (true, known) = sheet_scene(number), reference(number)
    frequency = scene.sensor.frequency
    omega = 2 * np.pi * frequency
    X, R = max(abs(true.imag), _CROSSING * abs(true) * (number >= METAL)), true.real
    R = R if number < METAL or R > _LOST * abs(true) else math.nan
    row: Row = {"scene": number, "kind": scene.kind, "regime": regime(scene), "frequency": frequency}
    row["reference"] = known
    for tolerance in asked:
        model, began, found = unprepared(scene, tolerance), time.process_time(), (math.nan,) * 5
        with suppress(*REFUSED):
            z = model.impedance(scene.pose, frequency)
            off = z.R.item() + 1j * omega * (z.L - z.L0).item() - true
            stated = z.error_R.item() / R, omega * z.error_L.item() / X
            found = z.report.unknowns, abs(off.imag) / X, stated[1], abs(off.real) / R, stated[0]
        row[f"seconds {tolerance:g}"] = time.process_time() - began
        row |= {f"{name} {tolerance:g}": value for name, value in zip(FOUND, found, strict=True)}
    return row


def counts(rows: Sequence[Row], asked: Sequence[float], parts: str) -> list[Row]:
    """Return what holds together: shares of the scenes."""
    found = list[Row]()
    for finer, tolerance in zip((*asked[1:], None), asked, strict=True):
        for part in ("L", "R"):
            true, stated = (np.array([row[f"{of} {part} {tolerance:g}"] for row in rows]) for of in ("true", "stated"))
            after = true if finer is None else np.array([row[f"true {part} {finer:g}"] for row in rows])
            judged = np.isfinite(true + after) & (stated > BETTER * np.array([row["reference"] for row in rows]))
            true, stated, after = true[judged], stated[judged], after[judged]
            ratio = true / stated
            found.append({
                "parts": parts, "asked": tolerance, "of": part, "scenes": len(true),
                "met": float(np.mean(true <= tolerance)), "stated to be met": float(np.mean(stated <= tolerance)),
                "true over stated 0.2 to 1": float(np.mean((ratio >= 0.2) & (ratio <= 1.0))),
                "above 1": float(np.mean(ratio > 1.0)), "most": float(ratio.max()),
                "worse when finer is asked": math.nan if finer is None else float(np.mean(after > true)),
            })
    return found


def drawn(rows: Sequence[Row], asked: Sequence[float], path: Path) -> None:
    """Write errors against unknowns and seconds as a picture."""
    kinds = list(dict.fromkeys(row["regime"] for row in rows))
    with new_figure(0.9, 2, 2, width=2.0 * COLUMN) as (figure, panels):
        for axes, (part, key) in zip(panels, product("LR", ("unknowns", "seconds")), strict=True):
            for row in rows:
                axes.plot(*([row[f"{of} {t:g}"] for t in asked] for of in (key, f"true {part}")), color="0.85", lw=0.6)
            for kind, style in zip(kinds, strokes(len(kinds)), strict=True):
                some = np.array([[[row[f"{of} {t:g}"] for t in asked] for of in (key, f"true {part}")]
                                 for row in rows if row["regime"] == kind])
                some = some[np.isfinite(some).all((1, 2))]
                if len(some):
                    axes.plot(*np.exp(np.log(some).mean(0)), **style, label=f"{kind}: {len(some)}", lw=1.4, zorder=3)
            axes.set(xscale="log", yscale="log", xlabel=key, ylabel=f"error of the change of {part}")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(kinds))
        save_figure(figure, path)


def main() -> None:
    """Go through the scenes; write rows, shares and figure."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    asked = COARSE if coarse else ASKED
    with threadpool_limits(limits=1):
        rows = kept_rows(range(1 if coarse else COUNT), lambda number: measure(number, asked), folder)
    write_rows(rows, folder / "scenes.csv")
    kinds = {"metal": rows[:METAL], "permeable": rows[METAL:]}
    shares = [each for kind, some in kinds.items() if some for each in counts(some, asked, kind)]
    print(write_rows(shares, folder / "counts.csv"))
    drawn(rows, asked, folder / "sheets_errors.png")


if __name__ == "__main__":
    main()
