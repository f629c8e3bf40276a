"""From hertz to 100 MHz, foil to block, touching to far: does every magnetic model answer as a passive plate does?

Without permeable parts, at any pose: L and R symmetric, ``R >= 0``, ``-L0 <= Delta L <= 0``, and |Delta L| and R grow
with frequency, up to the errors that the model itself states. A permeable plate draws flux: it is held to the first two
and to L positive. Each row is one plate at six frequencies; its violation is the worst of them all, relative to L0 or
to R. Where two models hold the same scene they are held against each other, in sums of the errors they state.

The chain's rows add that pressing never raises L_v.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from extreme.rows import DONE, Row, measured
from scipy.constants import mu_0

from sits_mech.chain.models import MAGNETICS
from sits_mech.chain.simulate import simulate
from sits_mech.quantities import Array, Impedance, Pose, SolveFailed, Wrench
from sits_mech.report.notes import sentences
from sits_mech.scene.sensor import Coil, Sensor, Target, load_sensor

MM = 1e-3
FREQUENCIES = (1.0, 1e3, 1e5, 1e6, 1e7, 1e8)
ROUNDING = 1e-10
SIZES = "{} mm wide, {} mm thick, gap {} mm, {:g} S/m"
MUST = (
    "no load", "a millionth of a newton", "2 N and 0.5 N of shear", "K/mu = 1e7", "1 Hz", "100 MHz",
    "layer of 0.1 mm, 2 N",
)
# width [mm], thickness [mm], gap [mm], conductivity [S/m]
PLATES = [
    (8, 0.2, 2, 5.8e7), (0.5, 0.2, 0.05, 1e9), (8, 0.2, 0.05, 5.8e7), (8, 0.2, 0.5, 1e9), (8, 0.2, 2, 1e3),
    (8, 0.005, 2, 5.8e7), (8, 0.005, 0.05, 1e3), (8, 5, 2, 5.8e7), (8, 5, 50, 1e9), (100, 0.2, 50, 5.8e7),
    (100, 5, 50, 1e9), (0.5, 0.005, 50, 1e3), (0.5, 5, 0.5, 5.8e7),
]
FEW = [PLATES[k] for k in (0, 4, 5, 11)]  # for models that take seconds


def coil(name: str, x: float) -> Coil:
    """Return a published coil at x [mm]."""
    return Coil(
        name=name, centre=(x * MM, 0.0), layers=2, turns=12, inner_diameter=2.2 * MM, track_width=0.1 * MM,
        track_gap=0.1 * MM, track_thickness=35e-6, layer_pitch=85e-6,
    )


def scene(model: str, width: float, thickness: float, sigma: float, mu: float = 1.0) -> Sensor:
    """Return two coils below a square plate, or one below a disc for the axisymmetric model [mm, S/m]."""
    size = width * MM
    if model == "axisymmetric":
        disc = Target(conductivity=sigma, shape="disc", diameter=size, thickness=thickness * MM)
        return Sensor(name="disc", frequency=1e6, coils=(coil("C", 0.0),), target=disc)
    plate = Target(
        conductivity=sigma, relative_permeability=mu, shape="rectangle", width=size, length=size,
        thickness=thickness * MM,
    )
    return Sensor(name="plate", frequency=1e6, coils=(coil("C1", -4.0), coil("C2", 4.0)), target=plate)


def aside(model: str) -> float:
    """Return where the plate's centre is for a model [m]."""
    return 0.0 if model == "axisymmetric" else 0.3 * MM


def worst(z: Impedance, before: Impedance | None, permeable: bool) -> float:
    """Return the largest relative violation of what a passive plate must show; infinite where a number is missing."""
    if not (np.all(np.isfinite(z.L)) and np.all(np.isfinite(z.R))):
        return np.inf
    found = [float(np.abs(m - m.T).max() / max(np.abs(m).max(), 1e-300)) for m in (z.L, z.R)]
    found.append(-float(np.linalg.eigvalsh(z.R).min()) / max(float(np.abs(z.R).max()), 1e-300))
    L0, change = np.diagonal(z.L0), np.diagonal(z.L - z.L0)
    if permeable:
        return max(*found, -float(np.linalg.eigvalsh(z.L).min()) / float(L0.max()))
    found += [float(np.max(change / L0)), float(np.max(-1.0 - change / L0))]
    if before is not None:
        found += grown(z, before, change, L0)
    return max(found)


def grown(z: Impedance, before: Impedance, change: Array, L0: Array) -> list[float]:
    """Return by how much |Delta L| and R shrink from one frequency to the next, beyond both errors."""
    uncertainty = np.diagonal(z.error_L + before.error_L)
    lost = float(np.max((change - np.diagonal(before.L - before.L0) - uncertainty) / L0))
    R, earlier, doubt_R = np.diagonal(z.R), np.diagonal(before.R), np.diagonal(z.error_R + before.error_R)
    return [lost, float(np.max((earlier - R - doubt_R) / np.maximum(R, 1e-300)))]


def plate_row(model: str, plate: tuple[float, float, float, float], mu: float = 1.0) -> Row:
    """Return one plate's row over all frequencies."""
    width, thickness, gap, sigma = plate
    solver = MAGNETICS[model](scene(model, width, thickness, sigma, mu), 1e-2)
    pose = Pose(aside(model), gap * MM)
    row, before, refused = Row("", "", DONE, violation=0.0, allowed=ROUNDING, estimated=0.0), None, []
    for frequency in FREQUENCIES:
        try:
            z = solver.impedance(pose, frequency)
        except SolveFailed as failed:
            refused.append((failed.report.status, frequency))
            continue
        violation = max(row.violation, worst(z, before, mu > 1.0))
        row, before = replace(row, violation=violation, estimated=max(row.estimated, z.report.estimated_error)), z
    ends = [(2.0 / (2.0 * np.pi * f * mu * mu_0 * sigma)) ** 0.5 / (thickness * MM) for f in FREQUENCIES]
    remark = f"skin depth over thickness {ends[-1]:.1e} to {ends[0]:.1e}"
    if not refused:
        return replace(row, remark=remark)
    where = ", ".join(f"{frequency:g} Hz" for _, frequency in refused)
    return replace(row, status=refused[0][0], remark=f"{remark}; refused at {where}")


def agreement_row(
    first: str, second: str, plate: tuple[float, float, float, float], frequencies: Sequence[float] = FREQUENCIES
) -> Row:
    """Return how far two models are apart over some frequencies, in sums of the errors they state: 1 is allowed.

    Of Delta L and of R, each over its largest entry; a Delta L that rounding of L would blur does not count.
    """
    width, thickness, gap, sigma = plate
    sensor, pose = scene(first, width, thickness, sigma), Pose(aside(first), gap * MM)
    a, b = (MAGNETICS[name](sensor, 1e-2) for name in (first, second))
    row, apart = Row("", "", DONE, violation=0.0, allowed=1.0, estimated=0.0), np.zeros(2)
    for frequency in frequencies:
        x, y = (model.impedance(pose, frequency) for model in (a, b))
        gaps = [np.abs((x.L - x.L0) - (y.L - y.L0)).max(), np.abs(x.R - y.R).max()]
        errors = [(x.error_L + y.error_L).max(), (x.error_R + y.error_R).max()]
        sizes = [np.abs(y.L - y.L0).max(), np.abs(y.R).max()]
        counts = slice(0 if sizes[0] > 1e-6 * y.L0.max() else 1, 2)
        apart[counts] = np.maximum(apart, np.array(gaps) / np.maximum(sizes, 1e-300))[counts]
        worst_of = max(float(gap / error) for gap, error in zip(gaps[counts], errors[counts], strict=True))
        estimated = max(row.estimated, x.report.estimated_error + y.report.estimated_error)
        row = replace(row, violation=max(row.violation, worst_of), estimated=estimated)
    return replace(row, remark=f"apart by {apart[0]:.1e} of Delta L, by {apart[1]:.1e} of R")


def plates(coarse: bool) -> Iterator[Row]:
    """Yield the rows of models against each other, and of the one that need not be passive by its form."""
    every, few, hertz = (PLATES[:1], FEW[1:2], FREQUENCIES[1::2]) if coarse else (PLATES, FEW, FREQUENCIES)
    kinds = {"planar-fem": FEW[:1] if coarse else FEW}  # sums over modes are passive by construction
    apart = [plate for plate in every if plate[2] >= 0.5]  # where planar-fem takes seconds
    pairs = {("planar", "planar-fem"): apart, ("axisymmetric", "sheets"): few}
    for models, rows in pairs.items():
        for plate in rows:
            name = f"{' against '.join(models)}: {SIZES.format(*plate)}"
            yield measured("magnetics", name, lambda m=models, p=plate: agreement_row(*m, p, hertz), True)
    for model, rows in kinds.items():
        for plate in rows:
            name = SIZES.format(*plate)
            yield measured("magnetics", f"{model}: {name}", lambda m=model, p=plate: plate_row(m, p), plate in FEW)
    for mu in () if coarse else (1e2, 1e4):
        name = f"planar-fem: 8 mm wide, 0.2 mm thick, gap 2 mm, 1e7 S/m, permeability {mu:g}"
        yield measured("magnetics", name, lambda mu=mu: plate_row("planar-fem", (8, 0.2, 2, 1e7), mu))


def chain_row(overrides: list[str], wrench: Wrench, rest: bool = False) -> Row:
    """Return a whole sensor under a load: passive, finite, its L_v not above that at rest."""
    sensor = load_sensor("biorob2018", overrides)
    found = simulate(sensor, wrench, tolerance=2e-2)
    shown, report = found.signals, found.equilibrium.report
    violation = worst(found.impedance, None, permeable=False)
    if not rest:
        at_rest = simulate(sensor, Wrench(), tolerance=2e-2).signals
        uncertainty = float(shown.error_L_v_percent) + float(at_rest.error_L_v_percent)
        violation = max(violation, (float(shown.L_v_percent) - float(at_rest.L_v_percent) - uncertainty) / 100.0)
    min_J = np.nan if report.min_J is None else report.min_J
    estimated = float(shown.error_L_v_percent) / float(shown.L_v_percent)
    return Row("", "", DONE, min_J, violation, ROUNDING, estimated, remark="; ".join(sentences(report.notes)))


def chain(coarse: bool) -> Iterator[Row]:
    """Yield the rows of whole sensors."""
    stiff = 'elastomer.material={law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="300 GPa"}'
    rows: list[tuple[str, list[str], Wrench]] = [
        ("no load", [], Wrench()),
        ("a millionth of a newton", [], Wrench(1e-6, 1e-6)),
        ("2 N and 0.5 N of shear", [], Wrench(0.5, 2.0)),
        ("K/mu = 1e7", [stiff], Wrench(0.5, 2.0)),
        ("1 Hz", ['frequency="1 Hz"'], Wrench(0.5, 2.0)),
        ("100 MHz", ['frequency="100 MHz"'], Wrench(0.5, 2.0)),
        ("layer of 0.1 mm, 2 N", ['elastomer.thickness="0.1 mm"'], Wrench(0.0, 2.0)),
        ("layer of 0.1 mm, 2 N and 0.3 N of shear", ['elastomer.thickness="0.1 mm"'], Wrench(0.3, 2.0)),
        ("layer of 20 mm", ['elastomer.thickness="20 mm"'], Wrench(0.01, 0.1)),
        ("a hundred times too much", [], Wrench(50.0, 500.0)),
        ("pulled off by 50 N", [], Wrench(0.0, -50.0)),
        ("target larger than its layer", ['target.width="25 mm"'], Wrench(0.0, 1.0)),
        ("not a number", [], Wrench(0.0, float("nan"))),
        ("layer of 0.1 mm, 2 N and 0.5 N of shear", ['elastomer.thickness="0.1 mm"'], Wrench(0.5, 2.0)),
    ]
    for name, overrides, wrench in rows[1:2] + rows[5:6] if coarse else rows:
        loaded = wrench.F_z > 0.0
        yield measured("chain", name, lambda o=overrides, w=wrench, r=not loaded: chain_row(o, w, r), name in MUST)
