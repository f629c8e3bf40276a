"""Is one more unit of a lot as good as `sits-mech lot` promises, of which some units were read?

Each lot is a production of twins of `biorob2018-w15`, computed by a finer tolerance with another law: they share
silicone, thickness, bench (scale and turn of the load cell) and jig (mean gap, offset, tilt, lead, capacitor), and
scatter. Some are read under a tare and three planned loads, which tell of the lot (`produced`). Further ones are read
under a tare, then one load, then two, as planned for the lot, and adapted by what the lot is known by; the same
readings once more by what is known of any such sensor. Told are, over the range to be read, within what of it 90 % of a
force's readings lie on 90 % of units, and the share of units within 2 %, each beside what `delivered` promised; how
often 90 % intervals hold the truth; how often readings are doubted or refused; and the same errors of forces that
firmware reads by a unit's constants (`constants_of`).

Run ``python -m benchmarks.produced_lots [--coarse] --output DIR``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common.outputs import study_arguments, write_rows
from common.twins import CELL, LAWS, NARROWEST, SOFTEST, STIFFEST, Truth, inverted, loads, made

from sits_mech.analysis.bench.load_plan import LoadPlan, plan_loads
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.constants import constants_of, inverse
from sits_mech.analysis.built.delivered import MOST, delivered
from sits_mech.analysis.built.prior import Prior, load_noise_of, prior_of
from sits_mech.analysis.built.production import Production, produced
from sits_mech.analysis.readings.bench import code_calibration
from sits_mech.analysis.readings.codes import unit_codes
from sits_mech.analysis.readings.measured import Measured
from sits_mech.chain.calibrate import calibrate
from sits_mech.quantities import SURE, Array
from sits_mech.readout.calibration import Calibration
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

RANGES = {"F_x": 0.7, "F_z": 2.8}
LIMIT, DOUBT = 0.02, 0.05
FILLED, WIDE = ("full", "none"), 7.0  # of marks by what is known; of the picture [in]
MEANS = {"gap": 1e-4, "d_h": 2e-4, "d_y": 2e-4, "alpha": 0.02, "alpha_x": 0.02, "lead": 1.5e-8, "capacitance": 2e-12}
"""At most, of a lot [m, rad, H, F]."""
SCATTER = {
    "gap": 3e-5, "d_h": 1e-4, "d_y": 1e-4, "alpha": 0.0122, "alpha_x": 0.0122, "lead": 5e-9, "capacitance": 1.6e-12,
}
"""Standard deviations of a unit."""
MODULUS, FRAME, THICKNESS = 0.03, 0.0175, 0.02  # deviations: of a unit; of a bench [rad]; of a lot, over the layer's


class Read(NamedTuple):
    """What is read of one unit after some readings of it."""

    off: Array  # of forces over a grid of loads, by the adapted sensor, over the ranges, (m, d)
    held: float  # share of 90 % intervals that hold the truth
    constants: Array  # as `off`, by constants for firmware
    doubted: bool


@dataclass(frozen=True)
class Unit:
    """A unit of a lot, on its bench and off it."""

    truth: Truth
    modulus: float
    places: Mapping[str, float]
    cell: float
    frame: float

    def shown(self, forces: Array) -> Array:
        """Return L (m, n) [H] under true forces (m, d)."""
        return self.truth.readings(self.modulus, self.places, forces)

    def measured(self, prior: Prior, bench: Array, rng: np.random.Generator) -> Measured:
        """Return readings under loads that the bench shows, with their noises."""
        x, z = (bench + load_noise_of(prior.table, None) * rng.standard_normal(bench.shape)).T
        c, s = np.cos(self.frame), np.sin(self.frame)
        L = self.shown(self.cell * np.column_stack([c * x - s * z, s * x + c * z]))
        return Measured(bench, L + prior.noise * rng.standard_normal(L.shape), "unit")


def lot_of(
    sensor: Sensor, law: str, models: tuple[int, float, str], units: int, rng: np.random.Generator
) -> list[Unit]:
    """Return the units of a lot; `models` are count, tolerance and mechanics of its truth."""
    layer = sensor.elastomer
    assert layer is not None
    thickness = layer.thickness * (1.0 + THICKNESS * rng.standard_normal())
    scene = sensor.model_copy(update={"elastomer": layer.model_copy(update={"thickness": thickness})})
    truth = made(scene, law, RANGES, *models)
    modulus = float(np.exp(rng.uniform(*np.log([SOFTEST, STIFFEST]))))
    cell, frame = 1.0 + CELL * rng.standard_normal(), FRAME * rng.standard_normal()
    means = {name: rng.uniform(-most, most) for name, most in MEANS.items()}
    found = []
    for _ in range(units):
        places = {name: mean + SCATTER[name] * rng.standard_normal() for name, mean in means.items()}
        places["gap"] = max(places["gap"], NARROWEST)
        found.append(Unit(truth, modulus * float(np.exp(MODULUS * rng.standard_normal())), places, cell, frame))
    return found


def read_by(found: Adaptation, cal: Calibration, unit: Unit, grid: Array) -> Read:
    """Return what an adapted unit reads over a grid of loads, by its model and by its constants."""
    ranges, L, prior = np.ptp(grid, axis=0), unit.shown(grid), found.prior
    off = inverted(found, L, grid) - grid
    own = constants_of(found, cal)
    codes = own.codes(unit_codes(prior.sensor, prior.data, L))
    start = np.asarray(np.linalg.solve(own.factor, (grid - own.shift).T).T)
    by_constants = own.forces(inverse(cal, codes, start)[0]) - grid
    held = float(np.mean(np.abs(off) < SURE * found.force_deviations(grid)[1]))
    return Read(off / ranges, held, by_constants / ranges, min(found.p_value, found.p_structured) < DOUBT)


def summary(found: list[Read | None], forces: tuple[str, ...]) -> dict[str, Any]:
    """Return columns of a row: errors of what further units read, but of refused ones, of which none is within 2 %."""
    kept, row = [each for each in found if each is not None], dict[str, Any]()
    for words, part in (("", "off"), (" by constants", "constants")):
        each = np.array([np.quantile(np.abs(getattr(one, part)), MOST, axis=0) for one in kept])
        for k, force in enumerate(forces):
            row[f"{force}{words} [%]"] = 100.0 * float(np.quantile(each[:, k], MOST))
        row[f"yield{words} [%]"] = 100.0 * float(np.sum(np.all(each <= LIMIT, axis=1))) / len(found)
    row["held [%]"] = 100.0 * float(np.mean([one.held for one in kept]))
    row["doubted [%]"] = 100.0 * float(np.mean([one is None or one.doubted for one in found]))
    return row


def known_by_plan(prior: Prior, plan: LoadPlan) -> LoadPlan:
    """Return a plan with what its loads tell of a sensor that less is known of."""
    gain = prior.fisher(plan.loads)
    after = np.concatenate([np.zeros((1, *gain.shape[1:])), np.cumsum(gain, axis=0)])
    return replace(plan, known_after=prior.tared + after)


def one_lot(
    prior: Prior, units: list[Unit], first: int, every: int, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """Return rows of a lot of which the first units tell: each step by what the lot is known by, and without that.

    Errors are told at every so many of the plan's loads.
    """
    cal, rest = code_calibration(prior.sensor, prior.data), np.zeros((1, len(prior.forces)))
    bench = np.concatenate([rest, plan_loads(prior, 3).loads])
    lot = produced(prior, {f"{k}": unit.measured(prior, bench, rng) for k, unit in enumerate(units[:first])}, {})
    plan = plan_loads(lot.next, 2)
    bench = np.concatenate([rest, plan.loads])
    readings = [unit.measured(prior, bench, rng) for unit in units[first:]]
    rows = []
    for known, by, chosen in (("lot", lot, plan), ("any", Production.alone(prior), known_by_plan(prior, plan))):
        for count, promised in enumerate(delivered(by, chosen, LIMIT)[1:], 1):
            found: list[Read | None] = []
            for unit, whole in zip(units[first:], readings, strict=True):
                some = replace(whole, forces=whole.forces[:count], L=whole.L[:count])
                try:
                    found.append(read_by(adapt(by.next, some), cal, unit, plan.read[::every]))
                except ValueError:  # an unknown went to its end
                    found.append(None)
            low, high = (100.0 * end for end in promised.lots)
            row = {"known": known, "read": promised.after, "yield promised [%]": 100.0 * promised.good,
                   "in single lots [%]": f"{low:.0f} to {high:.0f}"}
            row |= {f"{force} promised [%]": 100.0 * float(error)
                    for force, error in zip(prior.forces, promised.error, strict=True)}
            rows.append(row | summary(found, prior.forces))
    return rows


def main() -> None:
    """Produce lots."""
    coarse, folder = study_arguments(__doc__ or "")
    count, tolerance, mechanics = (4, 0.1, "planar") if coarse else (9, 1e-2, "auto")
    lots, first, further, every = (1, 3, 3, 3) if coarse else (4, 10, 20, 1)
    sensor = load_sensor("biorob2018-w15")
    prior = prior_of(sensor, calibrate(sensor, **loads(RANGES, count), tolerance=tolerance, mechanics=mechanics))
    rows, table = list[dict[str, Any]](), ""
    for number in range(lots):
        rng, law = np.random.default_rng(number), LAWS[number % len(LAWS)]
        units = lot_of(sensor, law, (count, 0.3 * tolerance, mechanics), first + further, rng)
        rows += [{"lot": number + 1, "law": law, **row} for row in one_lot(prior, units, first, every, rng)]
        table = write_rows([*rows, *averaged(rows)], folder / "produced_lots.csv")  # of those done so far
    print(table)
    draw(rows, prior.forces, folder)


def averaged(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row of each step, averaged over the lots: units of one lot share what it was found wrong by."""
    found = []
    for step in dict.fromkeys((row["known"], row["read"]) for row in rows):
        some = [row for row in rows if (row["known"], row["read"]) == step]
        numbers = [name for name, value in some[0].items() if isinstance(value, float)]
        means = {name: float(np.mean([row[name] for row in some])) for name in numbers}
        found.append(dict.fromkeys(some[0], "") | {"lot": "mean", "known": step[0], "read": step[1], **means})
    return found


def draw(rows: list[dict[str, Any]], forces: tuple[str, ...], folder: Path) -> None:
    """Draw what was promised against what is true, each step of each lot: errors of the forces, yields."""
    with new_figure(0.4, columns=len(forces) + 1, width=WIDE) as (figure, panels):
        for axes, name in zip(panels, (*forces, "yield"), strict=True):
            for number, (known, read) in enumerate(dict.fromkeys((row["known"], row["read"]) for row in rows)):
                some = [row for row in rows if (row["known"], row["read"]) == (known, read)]
                promised, true = (np.array([row[f"{name}{words} [%]"] for row in some]) for words in (" promised", ""))
                axes.plot(promised, true, "os^"[number % 3], color=f"C{number // 3}", fillstyle=FILLED[number // 3],
                          label=f"{read}, of {'its lot' if known == 'lot' else 'any such'}")
            if name == "yield":
                axes.set(xlim=(-3, 103), ylim=(-3, 103))
            else:
                axes.set(xscale="log", yscale="log", title=f"error of ${name}$ [% of its range]")
            ends = [min(*axes.get_xlim(), *axes.get_ylim()), max(*axes.get_xlim(), *axes.get_ylim())]
            axes.plot(ends, ends, color="black", linewidth=0.5)
            axes.set(xlabel="promised")
        panels[0].set(ylabel="true")
        panels[0].legend(fontsize=5)
        panels[-1].set(title=f"units within {100.0 * LIMIT:.0f} % [%]")
    save_figure(figure, folder / "produced_lots.png")


if __name__ == "__main__":
    main()
