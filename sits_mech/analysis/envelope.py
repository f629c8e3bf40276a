"""Find the forces that a sensor bears: the curve in the plane of forces at which the first of its limits is met.

Rays start at no force, at equal angles in the plane of F_x and F_z, each over what it bears alone; where coils stand
apart along y also in the plane of F_y and F_z. Of rays that are images of one another one is solved
(mechanics/symmetry.py). The limits are those of `capacity` (limits.py): stretch at the end of the silicone's data,
error of the pose at a tolerance, contact with coils or plates, folding, a load that is not carried.

A ray is followed on the first two meshes. Those of a block overestimate the stretch at bonded edges, and bear less:
from there the model goes on with a third mesh, as `pose` does. Where that one does not come to rest the stretch is that
of the second, here as there: along such rays `pose` goes beyond the data, back, and beyond again over a tenth of the
load.

Error. What a further mesh may change of the stretch (`status.FINER`), and how well an end is located.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sits_mech.analysis.limits import Capacity, capacity
from sits_mech.arguments import checked_arguments
from sits_mech.cases import Progress, untold
from sits_mech.chain.models import mechanical_model
from sits_mech.mechanics.loads import RefinedModel
from sits_mech.mechanics.models import strain_bound
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.notes import Note, NoteKind
from sits_mech.quantities import MechanicalModel, Wrench
from sits_mech.scene.sensor import Sensor, known_stretch
from sits_mech.status import FINER

TOLERANCE = 0.05
"""Of the pose: what three meshes tell stays within it up to the data's end of the catalogue's silicones."""
RAYS = 8
"""In a plane of forces, unless another number is asked for: five are solved where the pad is its own mirror image."""
_POSE = 1e-2  # of the pose: meshes end where those of `sits-mech pose` do by default
_MESHES = 3  # of a family, that the end of a ray is located on at most
_WITHIN = (0.02, 0.04)  # of a ray: how well its end is located on two meshes, and on three
_FIRST = {"F_z": 2.2, "F_x": 0.75, "F_y": 0.75}  # of the modulus: stress under the target that is tried first
_ADDED = (1.45, 1.15)  # times what two meshes bear is tried on three: seen along F_z, and elsewhere


@dataclass(frozen=True)
class Ray:
    """Where a ray ends.

    Attributes
    ----------
    plane : (str, str)
        Names of the forces that it combines.
    angle : float
        In that plane, each force over what it bears alone, from the first force on [rad].
    force : Wrench
        The largest that is borne; infinite where no limit was met [N].
    error : float
        Of its size, relative; nan where it is not known.
    limit : Note
        What comes next; `report.notes.sentence` words it.
    """

    plane: tuple[str, str]
    angle: float
    force: Wrench
    error: float
    limit: Note


@dataclass(frozen=True)
class Envelope:
    """The forces that a sensor bears.

    Attributes
    ----------
    rays : tuple of Ray
        By plane and angle.
    model : str
        Name of the mechanical model.
    known_stretch : float
        Of the data behind the silicone's constants [-]; nan where it is not known.
    tolerance : float
        Of the pose's error over the displacement.
    """

    rays: tuple[Ray, ...]
    model: str
    known_stretch: float
    tolerance: float


@checked_arguments
def envelope(
    sensor: Sensor, *, tolerance: float = TOLERANCE, mechanics: str = "auto", rays: int = RAYS,
    progress: Progress = untold,
) -> Envelope:
    """Return the forces that a sensor bears, and what limits them.

    Parameters
    ----------
    sensor : Sensor
        With target and elastomer.
    tolerance : float
        Of the pose's error over the displacement, which is a limit too.
    mechanics : str
        Name of the mechanical model.
    rays : int
        In each plane of forces; a multiple of four, so that each force alone is among them.
    progress : callable, optional
        Called with the number of rays done and of all.

    Raises
    ------
    ValueError
        When a model cannot hold the scene, or for another number of rays.

    Examples
    --------
    >>> found = sm.envelope(sm.load_sensor("biorob2018"), mechanics="planar", rays=4)
    >>> [(round(ray.force.F_x, 1), round(ray.force.F_z, 1), ray.limit.kind.value) for ray in found.rays[:2]]
    [(1.8, 0.0, 'limit data'), (0.0, 7.9, 'limit data')]
    """
    if rays < 4 or rays % 4:
        raise ValueError(f"rays: must be a multiple of four, such as {RAYS}; got {rays}")
    planes = [("F_x", "F_z")]
    if np.ptp([coil.centre[1] for coil in sensor.coils]) > 0.0:
        planes.append(("F_y", "F_z"))
    layer, choice = mechanical_model(sensor, mechanics, min(tolerance, _POSE), _first_loads(sensor, planes))
    rough, deeper = layer, None
    if isinstance(layer, RefinedModel):
        rough = layer.rough
        deeper = layer.towards(None, min(tolerance, _POSE), deepest=_MESHES) if choice.name == "block" else None
    search = _Search(sensor, rough, deeper, known_stretch(sensor), tolerance)
    found, count = [], len(planes) * rays
    for plane in planes:
        for ray in search.along(plane, rays):
            found.append(ray)
            progress(len(found), count)
    return Envelope(tuple(found), choice.name, search.known, tolerance)


@dataclass
class _Search:
    """Ends of rays of a scene on two meshes and on three, solving one of several images."""

    sensor: Sensor
    rough: MechanicalModel
    deeper: MechanicalModel | None
    known: float
    tolerance: float
    ends: dict[Wrench, Capacity] = field(default_factory=dict)
    finer: dict[Wrench, Capacity] = field(default_factory=dict)

    def along(self, plane: tuple[str, str], rays: int) -> Iterator[Ray]:
        """Yield the rays of a plane."""
        size = {name: float(getattr(load, name)) for load in _first_loads(self.sensor, [plane]) for name in plane}
        for name in plane:
            end = self.end(Wrench(**{name: size[name]}))
            if math.isfinite(end.multiple) and end.multiple > 0.0:
                size[name] *= end.multiple
                same = replace(end, multiple=1.0, error=end.error / end.multiple)
                self.ends[self.standard(Wrench(**{name: size[name]}))] = same
        for k in range(rays):
            angle = 2.0 * math.pi * k / rays
            shares = round(math.cos(angle), 12) + 0.0, round(math.sin(angle), 12) + 0.0
            load = Wrench(**{name: share * size[name] for name, share in zip(plane, shares, strict=True)})
            end = self.last(load)
            yield Ray(plane, angle, _times(end.multiple, load), _error(end), end.reason)

    def standard(self, load: Wrench) -> Wrench:
        """Return the image of a load that is solved for it."""
        return symmetry_of(self.sensor).standard(load)[0]

    def end(self, load: Wrench) -> Capacity:
        """Return where two meshes end, or the only one."""
        solved = self.standard(load)
        if solved not in self.ends:
            tolerance = math.inf if self.deeper is not None else self.tolerance
            self.ends[solved] = capacity(
                self.sensor, self.rough, solved, self.known, tolerance=tolerance, within=_WITHIN[0]
            )
        return self.ends[solved]

    def last(self, load: Wrench) -> Capacity:
        """Return where the last mesh that is solved ends, as a multiple of the load."""
        rough, solved = self.end(load), self.standard(load)
        if self.deeper is None or rough.rest is None:
            return rough
        if solved not in self.finer:
            alone = solved == Wrench(F_z=abs(solved.F_z))
            guess = rough.multiple * (_ADDED[not alone] if rough.reason.kind is NoteKind.LIMIT_DATA else 1.0)
            found = capacity(
                self.sensor, self.deeper, _times(guess, solved), self.known,
                tolerance=self.tolerance, within=_WITHIN[1],
            )
            self.finer[solved] = replace(found, multiple=guess * found.multiple, error=guess * found.error)
        return self.finer[solved]


def borne_share(sensor: Sensor, load: Wrench, mechanics: str = "auto") -> float:
    """Return the share of a load that a pad bears, to one digit, by two meshes (whose stretch is too large).

    The first share tried, to one digit, too, is that up to which small strains are within the data.
    """
    layer, _ = mechanical_model(sensor, mechanics, _POSE, [load])
    if not isinstance(layer, RefinedModel):
        return 1.0
    most, solved = known_stretch(sensor), symmetry_of(sensor).standard(load)[0]
    first = _to_one_digit(min(1.0, (most - 1.0) / strain_bound(sensor, [solved]))) or 1.0  # of no bound all
    found = capacity(sensor, layer.rough, _times(first, solved), most, within=_WITHIN[1])
    return _to_one_digit(min(first * found.multiple, 1.0))  # it may be infinite


def _to_one_digit(share: float) -> float:
    """Return the largest share of one digit that is not above another."""
    tens = 10.0 ** math.floor(math.log10(max(share, 1e-9)))
    return round(math.floor(share / tens + 1e-9) * tens, 10)


def _error(end: Capacity) -> float:
    """Return the relative error of where three meshes end."""
    if end.rest is None:  # a path that ended, near its largest load or not
        return end.error / end.multiple if end.multiple > 0.0 else math.nan
    if end.reason.kind is not NoteKind.LIMIT_DATA:
        return _WITHIN[1]
    report = end.rest.report
    changed = (report.error_stretch or 0.0) / ((report.stretch or 2.0) - 1.0)
    return _WITHIN[1] + FINER * changed


def _times(multiple: float, load: Wrench) -> Wrench:
    """Return a multiple of a load."""
    return Wrench(*(multiple * part if part else 0.0 for part in load.components.tolist()))


def _first_loads(sensor: Sensor, planes: Sequence[tuple[str, str]]) -> list[Wrench]:
    """Return the loads to try first in some planes: stresses of the size of the silicone's modulus under the target."""
    if sensor.target is None or sensor.elastomer is None:
        return []  # refused with the model
    force = sensor.elastomer.shear_modulus * math.prod(sensor.target.extent)
    return [Wrench(**{name: _FIRST[name] * force for name in plane}) for plane in planes]
