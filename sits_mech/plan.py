"""Which models does a scene need, and why? The cheapest that can hold it; what a request does not need is left out.

Also what a request's ranges stand for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sits_mech.materials import unknown
from sits_mech.sensor import Sensor
from sits_mech.units import SceneError, quantity, shown

_MOST = 10_000  # values of a range


@dataclass(frozen=True)
class Choice:
    """A model and the reason for it.

    Attributes
    ----------
    name : str
        As on the command line.
    reason : str
        One sentence.
    """

    name: str
    reason: str


_LONG = 10.0  # widths of a pad from which on its length stands for the depth of a planar model
_PLANE = (
    "finite strain in plane strain, the force spread over the elastomer's length; "
    "a pad or a target shorter than that is softer: compare with block"
)


def choose_mechanics(sensor: Sensor, asked: str, known: tuple[str, ...]) -> Choice:
    """Return the mechanical model for a scene.

    Parameters
    ----------
    sensor : Sensor
        Needs a target and an elastomer.
    asked : str
        A name of `known`, or "auto".
    known : tuple of str
        What there is.

    Returns
    -------
    Choice
        The model's name and the reason.

    Raises
    ------
    SceneError
        When the model is unknown or the scene has no layer.
    """
    _check_known("mechanics", asked, known)
    for part in ("target", "elastomer"):
        if getattr(sensor, part) is None:
            raise SceneError(f"{sensor.name}: {part}: must be given for a force to move the target; it is missing")
    meshed = sensor.elastomer is not None and sensor.elastomer.mesh is not None
    if meshed and asked not in ("auto", "block"):
        raise SceneError(f"{sensor.name}: model (mechanics) must be block for an elastomer.mesh; got {asked}")
    if asked != "auto":
        return Choice(asked, "asked for")
    if meshed:
        return Choice("block", "the layer has a mesh of its own")
    if "block" in known and _is_finite(sensor):
        return Choice("block", "finite strain in three dimensions: the pad is too short for plane strain")
    return Choice("planar", _PLANE)


def _is_finite(sensor: Sensor) -> bool:
    """Say whether a pad is one that the 3D model holds and the planar one does not."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or target.shape == "outline":
        return False
    return elastomer.extent[1] < _LONG * elastomer.extent[0]


def choose_magnetics(sensor: Sensor, asked: str, known: tuple[str, ...]) -> Choice:
    """Return the cheapest magnetic model for a scene; arguments, result and errors as of `choose_mechanics`."""
    _check_known("magnetics", asked, known)
    if asked != "auto":
        return Choice(asked, "asked for")
    target = sensor.target
    if sensor.substrate_radius is not None:
        return Choice("planar-fem", "coils on a curved substrate")
    parts = (*(() if target is None else (target,)), *sensor.conductors)
    if any(part.metal.relative_permeability != 1.0 for part in parts):
        return Choice("planar-fem", "permeable parts: the air around them is meshed")
    if len(sensor.coils) == 1 and target is not None and target.shape == "disc":
        return Choice("axisymmetric", "one coil under a disc; off its axis ask for sheets")
    if any(coil.centre[1] != 0.0 for coil in sensor.coils):
        return Choice("sheets", "coils beside the section y = 0 have no planar model")
    if target is not None and target.shape != "rectangle":
        return Choice("sheets", "the target's outline has no planar section that stands for it")
    reason = "no target: free space alone" if target is None else "nothing permeable: no mesh of the air"
    return Choice("planar", reason)


def left_out(sensor: Sensor, force: bool) -> tuple[str, ...]:
    """Return what a request does not need solved, each with its reason.

    Parameters
    ----------
    sensor : Sensor
        The scene.
    force : bool
        Whether a force is asked for.
    """
    found = []
    if not force:
        found.append("mechanics: the pose is given")
    if sensor.target is None:
        found.append("eddy currents: no target")
    if sensor.coils[0].winding == "spiral":
        found.append("pitch of the spiral windings: in all models but sheets, which take them as rings")
    if sensor.readout.idle_coil == "shorted" and len(sensor.coils) > 1:
        found.append("current in the idle coil: each coil is driven alone; L holds the mutual inductances to add it")
    return tuple(found)


def _check_known(kind: str, asked: str, known: tuple[str, ...]) -> None:
    """Refuse a model that does not exist."""
    if asked not in ("auto", *known):
        raise SceneError(f"model ({kind}) {unknown(asked, ('auto', *known))}")


def quantity_range(text: str, unit: str, name: str) -> list[float]:
    """Return the values of a written range.

    Parameters
    ----------
    text : str
        ``"first:last:count"`` such as "-1 N:1 N:9", or one quantity.
    unit : str
        The SI unit of the result.
    name : str
        What the range is called where the user wrote it.

    Returns
    -------
    list of float
        Evenly spaced [unit]; an exact mirror image of itself when its ends are.

    Raises
    ------
    SceneError
        One line: `name`, what it must be, what came.
    """
    parts = text.split(":")
    ends = [quantity(part, unit, name) for part in parts[:2]]
    if len(parts) == 1:
        return ends
    if len(parts) != 3 or not parts[2].strip().isdecimal() or not 1 < int(parts[2]) <= _MOST or ends[0] == ends[1]:
        form = f'first:last:count with two different ends and a count from 2 to {_MOST}, such as "0 N:4 N:9"'
        raise SceneError(f"{name}: must be {form}, or one quantity; got {shown(text)}")
    values = np.linspace(ends[0], ends[1], int(parts[2]))
    return [float(value) for value in ((values - values[::-1]) / 2 if ends[0] == -ends[1] else values)]
