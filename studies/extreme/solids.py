"""Pads in three dimensions: boxes and cylinders, pressed, sheared, tilted, overloaded.

Neo-Hookean, the force at the bonded face, which leads: the model takes no places. Held against each other: work and
energy of the mesh that answers; no load and no motion; the way back (checks.py).
"""

from __future__ import annotations

from collections.abc import Iterator

from extreme.checks import nothing, to_and_fro
from extreme.driven import Drive, drive, refused
from extreme.rows import Row, measured

from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import Wrench
from sits_mech.sensor import Sensor, load_sensor

MM = 1e-3
SILICONE = '{law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'
BOX = ["target.load_height=0", f"elastomer.material={SILICONE}"]
CYLINDER = [
    'target={material="copper", shape="disc", diameter="15 mm", thickness="0.2 mm", load_height=0}',
    f'elastomer={{material={SILICONE}, diameter="20 mm", thickness="2 mm"}}',
]
WAYS = (
    Drive("pressed", "sink", (0.1, 0.2, 0.3), 0.025, by_force=True),
    Drive("sheared", "d_h", (0.5, 1.0), 0.125, by_force=True),
    Drive("tilted", "alpha", (2.0, 5.0), 0.5, by_force=True),
)


def pad(round_one: bool = False) -> Sensor:
    """Return the catalogue's pad of 20 x 20 x 2 mm under 8 x 8 mm, or a cylinder of 20 mm under a disc of 15 mm."""
    return load_sensor("biorob2018", CYLINDER if round_one else BOX)


def solids(coarse: bool) -> Iterator[Row]:
    """Yield the rows of pads in three dimensions."""
    if coarse:
        return
    box, cylinder = block_pad(pad(), 2e-2), block_pad(pad(round_one=True), 2e-2)
    yield measured("mechanics", "3D box, no load", lambda: nothing(box, 2 * MM), True)
    yield measured("mechanics", "3D box, to and fro", lambda: to_and_fro(box, Wrench(0.1, 0.3), 4 * MM), True)
    heavy = Wrench(0.0, 1e3)
    yield measured(
        "mechanics", "3D box, 100 times too much", lambda: refused(box, lambda: to_and_fro(box, heavy, 4 * MM))
    )
    for name, model, ways in (("3D box", box, WAYS), ("3D cylinder", cylinder, WAYS[:1])):
        for way in ways:
            for goal, question in drive(model, way):
                yield measured("mechanics", f"{name}, {way.amount(goal)}", question, goal == way.goals[0])
