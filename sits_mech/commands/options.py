"""What do the commands have in common? The app, the kinds of their options, and how a scene or a pose is written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from sits_mech.console import warn
from sits_mech.version import __version__

if TYPE_CHECKING:
    from sits_mech.quantities import Pose, Wrench
    from sits_mech.sensor import Sensor

app = App(
    name="sits-mech", version=__version__, help="Force in, inductance out: soft inductive tactile sensors.",
    suppress_keyboard_interrupt=False,
)  # fmt: skip

Quantity = Annotated[str, Parameter(allow_leading_hyphen=True)]
Scene = Annotated[str, Parameter(help="Path of a scene file, or a name of the catalogue.")]
Frequency = Annotated[str, Parameter(allow_leading_hyphen=True, help='One, or a range "first:last:count".')]
Tolerance = Annotated[float, Parameter(help="Asked relative error.")]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]
Output = Annotated[Path | None, Parameter(name=["--output", "-o"])]
Overrides = Annotated[
    tuple[str, ...], Parameter(name="--set", negative="", help='Change a key of the scene: target.width="15 mm".')
]


@Parameter(name="*")
@dataclass(frozen=True)
class Load:
    """The load: forces and moments; the last three options leave the plane y = 0, and the pad is then solved whole."""

    fx: Annotated[Quantity, Parameter(help="Shear force, along +x.")] = "0 N"
    fz: Annotated[Quantity, Parameter(help="Normal force, pressing down.")] = "0 N"
    moment: Annotated[Quantity, Parameter(help="Moment about y, lifts the left edge.")] = "0 N*m"
    fy: Annotated[Quantity, Parameter(help="Shear force, along +y.")] = "0 N"
    mx: Annotated[Quantity, Parameter(help="Moment about the x axis, by the right hand.")] = "0 N*m"
    mz: Annotated[Quantity, Parameter(help="Moment about the z axis, by the right hand.")] = "0 N*m"

    def wrench(self) -> Wrench:
        """Return the load in SI."""
        from sits_mech.quantities import Wrench
        from sits_mech.units import quantity

        return Wrench(*(quantity(getattr(self, name), unit, f"--{name}") for name, unit in LOAD_UNITS.items()))


LOAD_UNITS = {"fx": "N", "fz": "N", "moment": "N*m", "fy": "N", "mx": "N*m", "mz": "N*m"}
"""The options of a load, in the order of the components of a wrench, with their SI units."""


@Parameter(name="*")
@dataclass(frozen=True)
class Place:
    """A pose of the target, instead of a load."""

    dv: Annotated[Quantity | None, Parameter(help="Height of the target's bottom face above the coils.")] = None
    dh: Annotated[Quantity, Parameter(help="Where the target's centre is along x.")] = "0 mm"
    alpha: Annotated[Quantity, Parameter(help="Rotation that lifts the left edge.")] = "0 deg"

    def pose(self) -> Pose:
        """Return the pose in SI."""
        return place_at(self.dh, self.dv or "0 m", self.alpha)


@Parameter(name="*")
@dataclass(frozen=True)
class Models:
    """Which model takes each half, and to what relative error."""

    mechanics: Annotated[str, Parameter(help="auto, block, planar, linear or closed-form.")] = "auto"
    magnetics: Annotated[str, Parameter(help="auto, planar, planar-fem, axisymmetric or sheets.")] = "auto"
    tolerance: Tolerance = 1e-2


def place_at(dh: str, dv: str, alpha: str) -> Pose:
    """Return a written pose in SI."""
    from sits_mech.quantities import Pose
    from sits_mech.units import quantity

    return Pose(quantity(dh, "m", "--dh"), quantity(dv, "m", "--dv"), quantity(alpha, "rad", "--alpha"))


def sensor_of(scene: str, overrides: Sequence[str]) -> Sensor:
    """Return the scene a command is about; what is implausible in it is said on stderr."""
    from sits_mech.sensor import load_sensor
    from sits_mech.silicone.material import implausible

    found = load_sensor(scene, overrides)
    for line in () if found.elastomer is None else implausible(found.elastomer.silicone):
        warn(f"{scene}: {line}")
    return found
