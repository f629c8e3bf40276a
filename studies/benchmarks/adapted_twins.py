"""What do five readings tell of a built sensor, do its intervals hold the truth, and is foreign physics noticed?

Twins of a catalogued sensor are computed by a finer tolerance with another law, modulus, gap, tilt, offset and load
cell, read under five planned loads and under five in a corner of the range, and adapted. Then the errors of the forces
over the range, how often 90 % intervals hold the truth, how often readings with foreign physics are doubted, and by how
much less than its estimated errors a table differs from a finer one (what `adapt` takes as its deviation).

Foreign are hysteresis, drift and a second layer: the target rests on two layers, one four times as stiff as the other,
each of which deforms half as far as the whole one of its stiffness would, p = p(F/s_1)/2 + p(F/s_2)/2; under small
loads they are as soft as the whole one, 1/s_1 + 1/s_2 = 2. Neglected: that thin layers are stiffer by their shape, and
that the seam between them bends. Errors of the forces are told of all readings that were not refused.

Then the story of a bench as its users go through it, on small tables of three sensors: all that may be unknown is drawn
as the prior says, within two deviations, the planned loads are read by a meter, the calibration is adapted, and loads
that were held out are read from the table that `adapt -o` writes, each within the one error that `invert` prints. The
loads on the bench are misread as `adapt` takes them to be.

Run ``python -m benchmarks.adapted_twins [--coarse] --output DIR``.
"""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np
import xarray as xr
from common.outputs import study_arguments, write_rows
from common.twins import CELL, LAWS, NARROWEST, SOFTEST, STIFFEST, Truth, finer, inverted, loads, made

from sits_mech.analysis.bench.load_plan import LoadPlan, plan_loads
from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.corrected import corrected
from sits_mech.analysis.built.prior import Prior, load_noise_of, prior_of
from sits_mech.analysis.readings.bench import terminal_calibration
from sits_mech.analysis.readings.measured import Measured
from sits_mech.chain.calibrate import calibrate
from sits_mech.disk_cache import nothing_kept
from sits_mech.quantities import Array
from sits_mech.readout.budget import budget
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

SENSORS = {"biorob2018-w15": (100, {"F_x": 0.7, "F_z": 2.8}), "triaxial-4": (40, {"F_x": 0.8, "F_z": 3.2})}
PLACES = {"gap": 2e-4, "d_h": 3e-4, "d_y": 3e-4, "alpha": 0.035, "alpha_x": 0.035}  # at most [m, rad]
HYSTERESIS, DRIFT = 0.1, 5e-9  # of the force; of L over the bench [H]
LAYERS = (0.625, 2.5)  # s of two layers, over that of the whole one
SURE, DOUBT = 1.645, 0.05
DISC = ("target.material=aluminium", "elastomer.material=dragon-skin-30", "elastomer.thickness=3 mm")
STORIES = {  # scene, its changes, how many of its coils, ranges [N], planned loads
    "three coils, Dragon Skin 30": ("triaxial-3", DISC, 3, {"F_x": 3.0, "F_z": 10.0}, 5),
    "biorob2018-w15": ("biorob2018-w15", (), 2, {"F_x": 0.5, "F_z": 2.0}, 5),
    "one coil": ("biorob2018", ("coils.0.centre=[0.0, 0.0]", "coils.1.centre=[0.02, 0.0]"), 1, {"F_z": 2.0}, 3),
}
VALUES, ASKED, METER, HELD_OUT = 5, 0.01, 1e-11, 22  # loads along each force; tolerance; noise [H]; loads of a twin


def drawn(rng: np.random.Generator) -> tuple[float, dict[str, float], float]:
    """Return modulus, places and load cell of a twin."""
    places = {name: rng.uniform(-most, most) for name, most in PLACES.items()}
    places["gap"] = max(places["gap"], NARROWEST)
    return rng.uniform(SOFTEST, STIFFEST), places, 1.0 + CELL * rng.standard_normal()


def one_twin(prior: Prior, truth: Truth, bench: Array, grid: Array, seed: int) -> dict[str, Any]:
    """Return errors and coverage of a twin's forces over a grid, read under the loads of a bench."""
    rng = np.random.default_rng(seed)
    modulus, places, cell = drawn(rng)
    L = truth.readings(modulus, places, cell * bench)
    L = L + prior.noise * rng.standard_normal(L.shape)
    began = time.process_time()
    with nothing_kept():
        found = adapt(prior, Measured(bench, L, "twin"))
    took = time.process_time() - began
    off = inverted(found, truth.readings(modulus, places, grid), grid) - grid
    _, deviations = found.force_deviations(grid)
    ranges = np.ptp(grid, axis=0)
    return {
        "error": np.abs(off) / ranges, "held": np.abs(off) < SURE * deviations, "said": SURE * deviations / ranges,
        "p": found.p_value, "seconds": took,
    }


def layered(truth: Truth, modulus: float, places: dict[str, float], forces: Array) -> Array:
    """Return L (m, n) [H] under true forces (m, d) with a second layer."""
    each = [truth.poses(forces / (modulus * share)) for share in LAYERS]
    return truth.shown(np.mean(each, axis=0), places)


def foreign(prior: Prior, truth: Truth, bench: Array, grid: Array, seed: int, kind: str) -> tuple[bool, Array | None]:
    """Return whether readings up and down the loads of a bench are doubted, with foreign physics in them.

    And the errors over a grid of loads of what is read afterwards, over the ranges; none of what is refused.
    """
    rng = np.random.default_rng(1000 + seed)
    modulus, places, cell = drawn(rng)
    shown = layered if kind == "layer" else Truth.readings
    way = np.concatenate([bench, bench[::-1]])
    side = np.repeat([-0.5, 0.5], len(bench))[:, None] * (HYSTERESIS if kind == "hysteresis" else 0.0)
    L = shown(truth, modulus, places, cell * way * (1.0 + side))
    L = L + prior.noise * rng.standard_normal(L.shape)
    if kind == "drift":
        L = L + DRIFT * np.linspace(0.0, 1.0, len(way))[:, None]
    try:
        found = adapt(prior, Measured(way, L, "twin"))
    except ValueError:  # an unknown went to its end
        return True, None
    off = inverted(found, shown(truth, modulus, places, grid), grid) - grid
    return min(found.p_value, found.p_structured) < DOUBT, np.abs(off) / np.ptp(grid, axis=0)


def against_finer(sensor: Sensor, data: xr.Dataset, axes: dict[str, Any]) -> dict[str, float]:
    """Return what a table differs from a finer one, root mean square over its estimated errors."""
    finer = calibrate(sensor, **axes, tolerance=0.1 * float(json.loads(data.attrs["request"])["tolerance"]))
    found = {}
    for name in ("d_h", "d_v", "alpha", "L"):
        off, error = data[name] - finer[name], data[f"error_{name}"]
        judged = error.to_numpy() > 1e-12 * float(np.abs(data[name]).max())
        found[name] = float(np.sqrt(np.mean((off.to_numpy()[judged] / error.to_numpy()[judged]) ** 2)))
    return found


def as_known(prior: Prior, rng: np.random.Generator) -> dict[str, float]:
    """Return what a unit has of each unknown: normal as the prior says, within two deviations, leads of some length."""
    each = {one.name: float(np.clip(rng.standard_normal(), -2.0, 2.0)) for one in prior.setup.parameters}
    return {
        one.name: np.exp(one.deviation * each[one.name]) if one.name == "modulus"
        else abs(one.deviation * each[one.name]) if one.name == "lead"
        else (one.value or 0.0) + one.deviation * each[one.name]
        for one in prior.setup.parameters
    }


def measured_again(prior: Prior, plan: LoadPlan, truth: Prior, seed: int) -> dict[str, Any]:
    """Return errors of held-out loads (m, d), what `invert` and `adapt` say of them [N], p; or why it was refused.

    `truth` is the sensor of a finer table, which shows what a unit's unknowns make of it.
    """
    rng = np.random.default_rng(seed)
    unit = as_known(prior, rng)
    built = np.array([unit.get(each.name, 0.0) for each in truth.known])  # whose own errors are left out
    held = rng.uniform(plan.read.min(axis=0), plan.read.max(axis=0), (HELD_OUT, len(prior.forces)))
    loaded = plan.loads + load_noise_of(prior.table, None) * rng.standard_normal(plan.loads.shape)
    L, shown = truth.bench(loaded).model(built[None])[0], truth.bench(held).model(truth.used(built)[None])[0]
    try:
        found = adapt(prior, Measured(plan.loads, L + METER * rng.standard_normal(L.shape), "twin"))
    except ValueError as refused:
        return {"refused": str(refused)}
    known = terminal_calibration(*corrected(found))
    read = known.inverse(shown + METER * rng.standard_normal(shown.shape))
    return {
        "off": np.abs(read.forces - held), "said": budget(known, read.forces).total,
        "adapt": SURE * found.force_deviations(held)[1], "p": found.p_value,
    }


def story(name: str, coarse: bool) -> dict[str, Any]:
    """Return how often the one error of a reading holds the truth, over units of a sensor."""
    scene, keys, coils, ranges, count = STORIES[name]
    sensor = load_sensor(scene, keys)
    sensor = sensor.model_copy(update={"coils": sensor.coils[:coils]})
    data = calibrate(sensor, **loads(ranges, VALUES), tolerance=ASKED, best=True)
    prior = prior_of(sensor, data, noise=METER).read_by(tank=False)
    layer = sensor.elastomer
    exact = finer(sensor, "" if layer is None else str(layer.material), ranges, VALUES + 2, 0.3 * ASKED)
    truth = prior_of(*exact, noise=METER).read_by(tank=False)
    plan = plan_loads(prior, count)
    each = [measured_again(prior, plan, truth, seed) for seed in range(3 if coarse else 30)]
    fit = [one for one in each if "refused" not in one]
    row = {"sensor": name, "units": len(each), "fit": len(fit), "doubted": sum(one["p"] < DOUBT for one in fit)}
    off, stated, by_adapt = (np.concatenate([one[key] for one in fit]) for key in ("off", "said", "adapt"))
    for k, force in enumerate(prior.forces):
        row[f"{force}, held [%]"] = 100.0 * float(np.mean(off[:, k] < stated[:, k]))
        row[f"{force}, held by adapt [%]"] = 100.0 * float(np.mean(off[:, k] < by_adapt[:, k]))
        row[f"{force}, 90 % within [N]"] = float(np.quantile(off[:, k], 0.9))
        row[f"{force}, said [N]"] = float(np.median(stated[:, k]))
        row[f"{force}, said by adapt [N]"] = float(np.median(by_adapt[:, k]))
    return row


def wide(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return rows that all have the names of any."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return [{name: row.get(name, "") for name in names} for row in rows]


def main() -> None:
    """Adapt twins of each sensor."""
    coarse, folder = study_arguments(__doc__ or "")
    stories = [story(name, coarse) for name in list(STORIES)[-1 if coarse else 0 :]]
    print(write_rows(wide(stories), folder / "bench_stories.csv"))
    rows, curves = list[dict[str, Any]](), dict[str, Array]()
    for name, (seeds, ranges) in SENSORS.items():
        if coarse and rows:
            break
        count, tolerance, laws, mechanics = (4, 0.1, LAWS[:1], "planar") if coarse else (9, 1e-2, LAWS, "auto")
        sensor = load_sensor(name)
        data = calibrate(sensor, **loads(ranges, count), tolerance=tolerance, mechanics=mechanics)
        ratios = {} if coarse else against_finer(sensor, data, loads(ranges, count))
        prior = prior_of(sensor, data)
        truths = [made(sensor, law, ranges, count, 0.3 * tolerance, mechanics) for law in laws]
        plan = plan_loads(prior, 5)
        corner = plan.read.max(axis=0) * np.array([[0.0, 0.0], [0.1, 0.1], [0.1, 0.2], [0.2, 0.1], [0.2, 0.2]])
        grid = plan.read[:: 3 if coarse else 1]
        for kind, bench in (("planned", plan.loads), ("a corner", corner)):
            numbers = range(2 if coarse else seeds)
            found = [one_twin(prior, truths[k % len(truths)], bench, grid, k) for k in numbers]
            row = {"sensor": name, "loads": kind, "twins": len(found)}
            for k, force in enumerate(prior.forces):
                errors = np.concatenate([one["error"][:, k] for one in found])
                curves[f"{name}, {force}, {kind}"] = np.sort(errors)
                row[f"{force}, 90 % within [%]"] = 100.0 * float(np.quantile(errors, 0.9))
                row[f"{force}, said [%]"] = 100.0 * float(np.mean([one["said"][:, k].mean() for one in found]))
                row[f"{force}, held [%]"] = 100.0 * float(np.mean([one["held"][:, k].mean() for one in found]))
            row["seconds"] = float(np.quantile([one["seconds"] for one in found], 0.9))
            if kind == "planned":
                row["promised F_z [%]"] = 100.0 * float(plan.errors[-1][prior.forces.index("F_z")])
                for physics in ("hysteresis", "layer") if coarse else ("none", "hysteresis", "drift", "layer"):
                    judged = [foreign(prior, truths[k % len(truths)], bench, grid, k, physics) for k in numbers]
                    row[f"doubted, {physics} [%]"] = 100.0 * float(np.mean([one for one, _ in judged]))
                    errors = np.concatenate([errors for _, errors in judged if errors is not None])
                    within = 100.0 * np.quantile(errors, 0.9, axis=0)
                    row |= {f"{force} with {physics}, 90 % within [%]": float(error)
                            for force, error in zip(prior.forces, within, strict=True)}
                row |= {f"{key}, error over estimate": ratio for key, ratio in ratios.items()}
            rows.append(row)
    print(write_rows(wide(rows), folder / "adapted_twins.csv"))
    with new_figure() as (figure, (axes,)):
        for number, (label, errors) in enumerate(curves.items()):
            share = np.linspace(0.0, 100.0, len(errors))
            axes.semilogx(1e2 * np.maximum(errors, 1e-6), share, ("-", "--")["corner" in label], label=label,
                          color=f"C{number % 7}")
        axes.axhline(90.0, color="black", linewidth=0.5)
        axes.set(xlabel="error of a force [% of its range]", ylabel="twins and loads [%]")
        axes.legend(fontsize=5)
    save_figure(figure, folder / "adapted_twins.png")


if __name__ == "__main__":
    main()
