"""Layers in plane strain: stiff and soft, thin and tall, pressed, pulled, sheared, tilted and overloaded.

A metre long, the force at the bonded face; neo-Hookean but for one of Gent's law. What is held against what: checks.py;
how they are led: driven.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from extreme.checks import REST, Way, energy_row, identity, nothing, refined, scaled, to_and_fro
from extreme.driven import Drive, drive, refused
from extreme.rows import Row, measured

from sits_mech.mechanics.closed_form import compression_modulus, shear_stiffness
from sits_mech.mechanics.layer import planar_layer
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

MM, MU = 1e-3, 3e4
LOADS = ((100.0, 1000.0), (267.0, 4050.0), (600.0, 0.0), (0.0, 6000.0))  # F_x, F_z [N/m]
UPRIGHT = ("d_h", "alpha")
WAYS = (
    Drive("pressed", "sink", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6), 0.05, held=UPRIGHT),
    Drive("pulled", "sink", (0.1, 0.3, 0.5), 0.025, -1.0, held=UPRIGHT),
    Drive("sheared", "d_h", (0.5, 1.0, 1.5, 3.0), 0.1),
    Drive("tilted", "alpha", (2.0, 5.0, 10.0, 20.0), 0.5),
    Drive("pressed", "sink", (0.4,), 0.02, by_force=True),
    Drive("pulled", "sink", (0.5,), 0.02, -1.0, by_force=True),
)


def pad(W: float, w: float, t: float, *, mu: float = MU, ratio: float = 1e3, j_m: float | None = None) -> Sensor:
    """Return a pad a metre long [mm, Pa]: newtons are newtons per metre."""
    law = 'law="neo-hookean"' if j_m is None else f'law="gent", j_m={j_m}'
    material = f"elastomer.material={{{law}, shear_modulus={mu}, bulk_modulus={mu * ratio}}}"
    sizes = [f'elastomer.width="{W} mm"', f'elastomer.thickness="{t} mm"', f'target.width="{w} mm"']
    return load_sensor("biorob2018", ["elastomer.length=1.0", "target.load_height=0", material, *sizes])


def combined(sensor: Sensor, *, press: float = 0.05, shear: float = 0.1, points: int = 9) -> Row:
    """Return the row of a layer under shear and compression, by its closed forms; work against energy."""
    layer, elastomer, target = planar_layer(sensor, 1e-2), sensor.elastomer, sensor.target
    assert elastomer is not None and target is not None
    t, w, silicone = elastomer.thickness, target.extent[0], elastomer.silicone
    mu, K = silicone.shear_modulus, silicone.bulk_modulus
    F_x = shear * t * shear_stiffness(mu, max(w, 0.5 * t), t)
    peak = Wrench(F_x, press * w * (compression_modulus(mu, K, 0.5 * w / t) + 4.0 * mu))
    shares, path = np.linspace(0.0, 1.0, points), [layer.equilibrium(REST)]
    for share in shares[1:]:
        path.append(layer.equilibrium(scaled(peak, share), start=path[-1]))
    return energy_row(layer, Way((peak.F_x, peak.F_z, peak.M), False, shares.tolist(), path))


def overloaded(sensor: Sensor, *, press: float, shear: float) -> Row:
    """Return the row of a layer under far too much, with what stands where its load path ended."""
    layer = planar_layer(sensor, 1e-2)
    return refused(layer, lambda: combined(sensor, press=press, shear=shear, points=5))


def layers(coarse: bool) -> Iterator[Row]:
    """Yield the rows of the layers."""

    def ask(case: str, question: Callable[[], Row], must: bool = True) -> Row:
        return measured("mechanics", case, question, must)

    points, finest = (5, 1e-3) if coarse else (9, 1e-4)
    for ratio in (0.5, 1e9) if coarse else (0.5, 10.0, 1e3, 1e5, 1e9):
        yield ask(f"K/mu = {ratio:g}", lambda ratio=ratio: combined(pad(20, 15, 2, ratio=ratio), points=points))
    for S in (0.3,) if coarse else (0.3, 0.5, 1, 3, 8, 25):
        t, ratio = 7.5 / S, 1e5 if S > 8 else 1e3
        yield ask(f"S = {S:g}, flush", lambda t=t, ratio=ratio: combined(pad(15, 15, t, ratio=ratio), press=0.03))
    for t in (20.0,) if coarse else (0.1, 20.0):
        yield ask(f"t = {t:g} mm", lambda t=t: combined(pad(20, 15, t, ratio=1e5), press=0.02))
    if not coarse:
        yield from driven("overhanging 20/15/2", pad(20, 15, 2), coarse)
    yield from driven("flush 15/15/3", pad(15, 15, 3), coarse)
    gent = planar_layer(pad(15, 15, 3, j_m=2.0), 1e-2)
    locking = Drive("sheared", "d_h", (0.5,) if coarse else (0.5, 1.0, 1.3), 0.1)
    pressed = Drive("pressed", "sink", (0.1, 0.2, 0.3, 0.4), 0.05, held=UPRIGHT)  # until its silicone is at its stretch
    for way in (locking,) if coarse else (locking, pressed):
        for goal, question in drive(gent, way):
            must = goal == way.goals[0]
            yield ask(f"Gent j_m = 2 (locks at shear 1.41), {way.amount(goal)}", question, must)
    thin, block = planar_layer(pad(20, 15, 2)), pad(15, 15, 3)
    yield ask("no load", lambda: nothing(thin, 2 * MM))
    there = scaled(Wrench(200.0, 2000.0, 1.0), 0.2 if coarse else 1.0)
    yield ask("load to and fro", lambda: to_and_fro(thin, there, 7.5 * MM))
    if not coarse:
        yield ask("moment identity, pressed and sheared", lambda: identity(block, Wrench(100.0, 400.0)))
    yield ask("moment identity, sheared by half", lambda: identity(block, Wrench(F_x=200.0)))
    pads = {"overhanging 20/15/2": thin.sensor, "flush 15/15/3": block}
    for F_x, F_z in LOADS[:1] if coarse else LOADS:
        for name, sensor in list(pads.items())[: 1 if coarse else None]:
            load, case = Wrench(F_x, F_z), f"{name}, refined at {F_x:g} and {F_z:g} N/m"
            yield ask(case, lambda load=load, sensor=sensor: refined(sensor, load, finest), F_z == 1000.0)
    if not coarse:
        yield from cornered()
        yield ask("100 times too much, pressed", lambda: overloaded(thin.sensor, press=5.0, shear=0.1), False)
        yield ask("100 times too much, sheared", lambda: overloaded(thin.sensor, press=0.0, shear=10.0), False)


def cornered() -> Iterator[Row]:
    """Yield the rows of corners of 0.01 mm radius: on a layer of 0.2 mm, and on one too thick for them."""
    for t in (0.2, 2.0):
        sharp = pad(20, 15, t)
        assert sharp.elastomer is not None
        rounded = sharp.model_copy(update={"elastomer": sharp.elastomer.model_copy(update={"edge_radius": 1e-5})})
        case = f"corners of 0.01 mm radius, t = {t:g} mm"
        yield measured("mechanics", case, lambda sensor=rounded: refined(sensor, Wrench(300.0, 3000.0), 2e-3), t < 1.0)


def driven(name: str, sensor: Sensor, coarse: bool) -> Iterator[Row]:
    """Yield the rows of a layer that is pressed, pulled, sheared and tilted further and further."""
    layer = planar_layer(sensor, 1e-2)
    for way in WAYS[2:3] if coarse else WAYS:
        for goal, question in drive(layer, way):
            if coarse and goal > way.goals[0]:
                break
            must = goal == way.goals[0] and not way.by_force
            yield measured("mechanics", f"{name}, {way.amount(goal)}", question, must)
