"""Pads in three dimensions: soft and stiff, thin and tall, of many shapes; pressed, pulled, sheared, tilted.

Neo-Hookean but for one of Gent's law, the force at the bonded face, which leads: the model takes no places.
Held against each other: work and energy of the mesh that answers; no load and no motion; the way back; all six
components on the whole pad against half of it and against themselves, turned (checks.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from extreme.checks import half_and_whole, nothing, quarter_turned, to_and_fro
from extreme.driven import Drive, drive, refused
from extreme.rows import Row, measured

from sits_mech.mechanics.block import BlockPad, block_pad
from sits_mech.quantities import Wrench
from sits_mech.scene.sensor import Sensor, load_sensor

MM = 1e-3
MESHES = Path(__file__).parents[2] / "meshes"
SILICONE = '{law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
CYLINDER = [
    'target={material="copper", shape="disc", diameter="15 mm", thickness="0.2 mm", load_height=0}',
    f'elastomer={{material={SILICONE}, diameter="20 mm", thickness="2 mm"}}',
]
WAYS = (
    Drive("pressed", "sink", (0.1, 0.2, 0.3), 0.025, by_force=True),
    Drive("sheared", "d_h", (0.5, 1.0), 0.125, by_force=True),
    Drive("tilted", "alpha", (2.0, 5.0), 0.5, by_force=True),
    Drive("pulled", "sink", (0.1,), 0.025, -1.0, by_force=True),
)
SHORT = (Drive("pressed", "sink", (0.1,), 0.025, by_force=True), Drive("sheared", "d_h", (0.5,), 0.125, by_force=True))
DOME = (Drive("pressed", "sink", (0.1, 0.2), 0.05, by_force=True), Drive("sheared", "d_h", (0.2,), 0.1, by_force=True))
LOCKING = Drive("sheared", "d_h", (0.5, 1.0, 1.3), 0.125, by_force=True)


def pad(*, mu: float = 3e4, ratio: float = 1e3, t: float = 2.0, j_m: float | None = None) -> Sensor:
    """Return the catalogue's pad of 20 x 20 mm under 8 x 8 mm, of some silicone and thickness [Pa, mm]."""
    law = 'law="neo-hookean"' if j_m is None else f'law="gent", j_m={j_m}'
    material = f"elastomer.material={{{law}, shear_modulus={mu}, bulk_modulus={mu * ratio}}}"
    return load_sensor("biorob2018", ["target.load_height=0", f'elastomer.thickness="{t} mm"', material])


def cylinder() -> Sensor:
    """Return a cylinder of 20 mm under a disc of 15 mm."""
    return load_sensor("biorob2018", CYLINDER)


def flush() -> Sensor:
    """Return a pad of 8 x 8 x 2 mm under a target as large, whose faces fold from some 10 % of compression on."""
    size = [f'elastomer.{side}="8 mm"' for side in ("width", "length")]
    return load_sensor("biorob2018", ["target.load_height=0", f"elastomer.material={SILICONE}", *size])


def dome() -> Sensor:
    """Return the dome of the meshes' folder."""
    disc = 'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm", load_height=0}'
    pad = f'diameter="16 mm", thickness="3 mm", mesh="{MESHES / "dome.msh"}"'
    return load_sensor("biorob2018", [disc, f"elastomer={{material={SILICONE}, {pad}}}"])


def shaped(target: str, pad: str, t: float = 2.0) -> Sensor:
    """Return a pad of some shape and thickness [mm] under a target of some shape, both as in a scene."""
    plate = f'target={{material="copper", {target}, thickness="0.2 mm", load_height=0}}'
    return load_sensor("biorob2018", [plate, f'elastomer={{material={SILICONE}, thickness="{t} mm", {pad}}}'])


def shapes() -> dict[str, Sensor]:
    """Return targets wider than their pad, and pillars."""
    coin, square = 'shape="disc", diameter="10 mm"', 'shape="rectangle", width="8 mm", length="8 mm"'
    box, bar = 'width="8 mm", length="8 mm"', 'shape="rectangle", width="10 mm", length="6 mm"'
    return {
        "coin of 10 mm over a cylinder of 8": shaped(coin, 'diameter="8 mm"'),
        "coin of 10 mm over a box of 8": shaped(coin, box),
        "10 x 6 mm over a box of 8": shaped(bar, box),
        "nine pillars of 2 mm": shaped(square, 'shape="pillars", pitch="2.8 mm", diameter="2 mm"'),
    }


def solids(coarse: bool) -> Iterator[Row]:
    """Yield the rows of pads in three dimensions."""
    if coarse:
        return
    box, drum = block_pad(pad(), 2e-2), block_pad(cylinder(), 2e-2)
    yield measured("mechanics", "3D box, no load", lambda: nothing(box, 2 * MM), True)
    yield measured("mechanics", "3D box, to and fro", lambda: to_and_fro(box, Wrench(0.1, 0.3), 4 * MM), True)
    heavy = Wrench(0.0, 1e3)
    yield measured(
        "mechanics", "3D box, 100 times too much", lambda: refused(box, lambda: to_and_fro(box, heavy, 4 * MM))
    )
    for name, model, ways in (("3D box", box, WAYS), ("3D cylinder", drum, WAYS[:1])):
        yield from led(name, model, ways)
    odd = {"K/mu = 0.5": pad(ratio=0.5), "K/mu = 1e+09": pad(ratio=1e9)}
    odd |= {"t = 0.5 mm": pad(t=0.5), "t = 10 mm": pad(t=10.0)}
    for name, sensor in odd.items():
        yield from led(f"3D box, {name}", block_pad(sensor, 2e-2), SHORT)
    yield from led("3D box, Gent j_m = 2 (locks at shear 1.41)", block_pad(pad(j_m=2.0), 2e-2), (LOCKING,))
    yield from led("3D flush 8/8/2", block_pad(flush(), 2e-2), (WAYS[0], SHORT[1]))
    for name, sensor in shapes().items():
        yield from led(f"3D {name}", block_pad(sensor, 2e-2), SHORT)
    yield from led("3D dome on a mesh of the user's", block_pad(dome(), 2e-2), DOME)
    for name, sensor, loads in (("3D box", pad(), (0.3, 3.0)), ("3D flush 8/8/2", flush(), (2.0, 8.0))):
        for F_z in loads:
            load, across = Wrench(0.05 * F_z, F_z, 1e-5 * F_z), Wrench(0.05 * F_z, F_z, F_y=0.02 * F_z, M_z=2e-5 * F_z)
            words = f"{name}, {F_z:g} N and a twentieth of it in shear"
            yield measured("mechanics", f"{words}: half and whole", lambda s=sensor, w=load: half_and_whole(s, w), True)
            yield measured("mechanics", f"{words}: turned", lambda s=sensor, w=across: quarter_turned(s, w), True)


def led(name: str, model: BlockPad, ways: tuple[Drive, ...]) -> Iterator[Row]:
    """Yield the rows of a pad that is led some ways."""
    for way in ways:
        for goal, question in drive(model, way):
            yield measured("mechanics", f"{name}, {way.amount(goal)}", question, goal == way.goals[0])
