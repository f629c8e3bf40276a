"""Does metal around a sensor spoil the answer of the three-dimensional model, or the estimate of its error?

Fifty scenes of the published coils under a copper target: ground planes behind them, whole and slotted, screws, a
battery can, a shield frame, the target of a second sensor; ten with a coaxial disc and ground disc. True errors of
Delta L and R of the coil that is changed most: against rings of both discs together (`common.ring_discs`), otherwise
against the model's own finest setting, whose estimate must be small for that (it is listed).

Run ``python -m benchmarks.surroundings [--coarse] --output DIR``: writes CSV and Markdown; processor seconds, cold.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from common.accuracy import forget
from common.outputs import study_arguments, write_rows
from common.ring_discs import joint_reaction
from threadpoolctl import threadpool_limits

from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Array, Pose
from sits_mech.scene.materials import metals
from sits_mech.scene.sensor import Conductor, Sensor, Target, load_sensor

MM = 1e-3
FINE, COARSE = (5e-3, 1e-3), (1e-1, 3e-2)  # what is asked, and the finest, which judges


def bar(name: str, centre: tuple[float, ...], size: tuple[float, float, float], metal: str = "copper") -> Conductor:
    """A rectangular plate, centre and size [mm]."""
    x, y, z = (MM * value for value in centre)
    width, length, thickness = (MM * value for value in size)
    return Conductor(name=name, material=metal, shape="rectangle", centre=(x, y, z), width=width, length=length,
                     thickness=thickness)


def ground(some: np.random.Generator) -> tuple[Conductor, ...]:
    """A plane behind the coils."""
    side, depth, t = some.uniform(14, 26), some.uniform(0.3, 1.6), some.choice([0.018, 0.035, 0.07])
    return (bar("ground", (0, 0, -0.12 - depth - t / 2), (side, side * some.uniform(0.7, 1.0), t)),)


def slotted(some: np.random.Generator) -> tuple[Conductor, ...]:
    """A plane behind the coils in two halves."""
    width, slot, depth = some.uniform(8, 12), some.uniform(0.4, 1.5), some.uniform(0.4, 1.6)
    return tuple(bar(f"half {k + 1}", (s * (width + slot) / 2, 0, -0.14 - depth), (width, 1.4 * width, 0.035))
                 for k, s in enumerate((-1, 1)))


def screws(some: np.random.Generator) -> tuple[Conductor, ...]:
    """Two brass heads beside the target."""
    d, t, z = some.uniform(2, 4), some.uniform(1, 3), some.uniform(0.5, 4)
    return tuple(Conductor(name=f"screw {k + 1}", material="brass", shape="disc", diameter=d * MM, thickness=t * MM,
                           centre=(s * (9 + d / 2) * MM, 0.0, z * MM)) for k, s in enumerate((-1, 1)))


def can(some: np.random.Generator) -> tuple[Conductor, ...]:
    """A battery can below the board."""
    t, depth = some.uniform(3, 6), some.uniform(1.5, 5)
    return (bar("can", (some.uniform(-3, 3), 0, -depth - t / 2), (some.uniform(18, 30), 20, t), "aluminium"),)


def frame(some: np.random.Generator) -> tuple[Conductor, ...]:
    """Four walls around the coils."""
    side, high, t = some.uniform(20, 26), some.uniform(1, 2.5), some.choice([0.2, 0.3])
    inner = side - 2 * t - 0.6
    walls = [bar(f"wall {k + 1}", (s * side / 2, 0, high / 2), (t, side, high)) for k, s in enumerate((-1, 1))]
    walls += [bar(f"wall {k + 3}", (0, s * side / 2, high / 2), (inner, t, high)) for k, s in enumerate((-1, 1))]
    return tuple(walls)


def second(some: np.random.Generator) -> tuple[Conductor, ...]:
    """The target of a second sensor."""
    x, z = some.uniform(9, 14), some.uniform(1.5, 3)
    return (bar("second", (x, some.uniform(-4, 4), z), (8, 8, 0.2)),)


KINDS: dict[str, Callable[[np.random.Generator], tuple[Conductor, ...]]] = {
    "ground": ground, "slotted": slotted, "screws": screws, "can": can, "frame": frame, "second": second,
}


def scenes(coarse: bool) -> Iterator[tuple[str, Sensor, float, float]]:
    """Yield kind, scene, gap [m] and frequency [Hz]."""
    whole, some = load_sensor("biorob2018"), np.random.default_rng(16)
    names = [name for name in KINDS for _ in range(7)][:40] if not coarse else ["ground"]
    for name in names:
        parts, gap = KINDS[name](some), some.uniform(1, 3) * MM
        yield name, whole.model_copy(update={"conductors": parts}), gap, 10 ** some.uniform(5, 7)
    coil = whole.coils[0].model_copy(update={"centre": (0.0, 0.0)})
    for _ in range(1 if coarse else 10):
        t, depth = some.choice([0.018, 0.035, 0.07]) * MM, some.uniform(0.3, 1.5) * MM
        target = Target(material="copper", shape="disc", diameter=some.uniform(7, 10) * MM, thickness=0.2 * MM)
        plane = Conductor(name="ground", material="copper", shape="disc", diameter=some.uniform(10, 18) * MM,
                          thickness=t, centre=(0.0, 0.0, -coil.height - depth - t / 2))
        changes = {"coils": (coil,), "target": target, "conductors": (plane,)}
        yield "discs", whole.model_copy(update=changes), some.uniform(1, 3) * MM, 10 ** some.uniform(5, 7)


def rings(sensor: Sensor, gap: float, frequency: float) -> tuple[Array, Array, float]:
    """Delta L and R of discs together, and the relative size of the last step."""
    target, (plane,), copper = sensor.target, sensor.conductors, metals()["copper"].conductivity
    assert target is not None
    t, depth = target.thickness, -plane.centre[2]
    discs = [(target.extent[0] / 2, gap + t / 2, t, copper), (plane.extent[0] / 2, -depth, plane.thickness, copper)]
    Z, step = joint_reaction(sensor.coils[0], discs, frequency, size=0.35 * MM)
    return np.array([[Z.imag / (2 * np.pi * frequency)]]), np.array([[Z.real]]), abs(step.imag / Z.imag)


def measure(kind: str, sensor: Sensor, gap: float, frequency: float, tolerances: tuple[float, float]) -> dict[str, Any]:
    """One line of the table."""
    pose, (asked, finest) = Pose(0.0, gap, 0.0), tolerances
    forget()
    began = time.process_time()
    z = sheets(sensor, asked).impedance(pose, frequency)
    seconds = time.process_time() - began
    if kind == "discs":
        delta_L, R, left = rings(sensor, gap, frequency)
    else:
        best = sheets(sensor, finest).impedance(pose, frequency)
        delta_L, R, left = best.L - best.L0, best.R, best.report.estimated_error
    n = int(np.argmax(np.abs(np.diag(delta_L))))
    line: dict[str, Any] = {"scene": kind, "gap_mm": gap / MM, "frequency": frequency, "seconds": seconds}
    for name, found, exact, error in (("L", z.L - z.L0, delta_L, z.error_L), ("R", z.R, R, z.error_R)):
        true, told = abs(found[n, n] / exact[n, n] - 1), error[n, n] / abs(exact[n, n])
        line |= {f"true_{name}": float(true), f"told_{name}": float(told), f"ratio_{name}": float(true / told)}
    return line | {"reference": float(left)}


def main() -> None:
    """Go through the scenes; write the table."""
    coarse, folder = study_arguments(__doc__ or "", timed=True)
    with threadpool_limits(limits=1):
        lines = []
        for scene in scenes(coarse):
            lines.append(measure(*scene, COARSE if coarse else FINE))
            print(*(f"{value:.3g}" if isinstance(value, float) else value for value in lines[-1].values()), flush=True)
    for name in ("ratio_L", "ratio_R"):
        ratios = np.array([line[name] for line in lines])
        print(f"{name}: {np.mean((ratios > 0.2) & (ratios < 5)):.0%} within 0.2 to 5, {np.mean(ratios > 5):.0%} above")
    print(f"slowest {max(line['seconds'] for line in lines):.3g} s")
    write_rows(lines, folder / "surroundings.csv")


if __name__ == "__main__":
    main()
