"""Differentiate what the sensor shows over a grid of loads by its sizes and its silicone: `gradient` over tables.

Loads are solved as for `calibrate`, on two meshes, as many as predict the others; each that is solved has the
derivatives of its pose there, by one factor more a mesh (mechanics/levels/gradient.py), and the map that carries poses
to the loads between carries them as well. What finer meshes change of the poses is in the poses alone. The magnetics'
half is that of all poses at once (gradient.py), by quick slopes of the poses (magnetics/pose_slopes.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from sits_mech.chain.columns import Columns, over_grid
from sits_mech.chain.derivatives.fixed_pose import at_fixed_poses
from sits_mech.chain.derivatives.gradient import (
    Moved,
    SlopedModel,
    moved_derivatives,
    scene_numbers,
    shown_change,
    sloped_model,
    symmetry_kept,
)
from sits_mech.chain.interpolate import LayerGrid, checked_values, loads_of
from sits_mech.chain.models import loaded_model
from sits_mech.chain.omitted.mechanical import with_omissions
from sits_mech.chain.plans.aimed import aimed_loads, status_of
from sits_mech.chain.propagation import poses_of, read_poses
from sits_mech.mechanics.loads import RefinedModel, settle
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, MechanicalModel, Pose, Wrench
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.status import OK


@dataclass(frozen=True)
class WithSlopes:
    """A mechanical model whose equilibria carry the derivatives of their poses by `numbers`, once for every load."""

    layer: MechanicalModel
    numbers: tuple[Parameter, ...]

    @property
    def rough(self) -> MechanicalModel:
        """The model on the first meshes; itself, where it has no others."""
        return replace(self, layer=self.layer.rough) if isinstance(self.layer, RefinedModel) else self

    def towards(self, goal: Array, tolerance: float, deepest: int = 99) -> MechanicalModel:
        """Return the model that solves as far as a goal needs; itself, where it has one set of meshes."""
        if not isinstance(self.layer, RefinedModel):
            return self
        return replace(self, layer=self.layer.towards(goal, tolerance, deepest))

    def equilibrium(self, wrench: Wrench, *, start: Equilibrium | None = None) -> Equilibrium:
        """Return the equilibrium; of a load solved again on finer meshes without derivatives."""
        found = self.layer.equilibrium(wrench, start=start)
        if (start is not None and start.wrench == wrench) or not isinstance(self.layer, SlopedModel):
            return found
        return replace(found, slopes=self.layer.slopes(found, self.numbers).pose.T)


def gradient_on_grid(
    sensor: Sensor, names: Sequence[str], loads: Mapping[str, Sequence[float]], *, tolerance: float = 1e-2,
    mechanics: str = "auto", magnetics: str = "auto",
) -> xr.Dataset:
    """Return the derivatives of what a sensor shows over a grid of loads by numbers of its scene, as a Dataset.

    `loads` holds values of components by name [N, N m]; others are zero. Dims are these in the order of `WRENCH`,
    coil, coil_2, component, parameter: ``pose``; ``L``, ``R`` with errors as of `calibrate`; ``by_pose``, ``by_L``,
    ``by_R`` and ``by_`` each signal with the dimension `parameter`; NaN where a load fails (``status``, ``reason``).
    Raises SceneError as `gradient`, for a component that no load has or values of one that are none, and where all
    loads fail.
    """
    numbers, moving = scene_numbers(sensor, names)
    grid = _checked(loads)
    every = loads_of(grid)
    _, by_field = loaded_model(sensor, magnetics, tolerance, every)
    layer, choice = sloped_model(sensor, mechanics, tolerance, every, magnetics)
    sloped = WithSlopes(layer, tuple(moving))
    solved = aimed_loads(LayerGrid(sensor, sloped, grid, symmetry_kept(sensor, moving), tolerance), magnetics)
    field, settled = solved.field, [solved.settled[load] for load in every]
    status, reasons = zip(*(status_of(sensor, one) for one in settled), strict=True)
    good = np.array(status) == OK
    own = [one.rest for one, fine in zip(settled, good, strict=True) if one.rest and fine]
    if not own:
        raise SceneError(next(filter(None, reasons), "loads: none is answered"))
    poses = poses_of(with_omissions(sensor, own, choice.name))
    pose = Pose.of(poses.value)
    slopes = np.array([rest.slopes.T for rest in own]).reshape(len(own), len(POSE), len(moving))
    moved = moved_derivatives(numbers, moving, Moved(slopes, np.zeros_like(slopes)))
    reading = read_poses(sensor, field, poses, separate=False)
    shown = reading.impedance
    direct = at_fixed_poses(sensor, (field, by_field.name, solved.asked), pose, numbers, reading.known)
    change = shown_change(sensor, field, shown, pose, numbers, moved, direct, known=reading.known)
    pair = ("coil", "coil_2")
    dims: dict[str, tuple[str, ...]] = {"pose": ("component",), "L": pair, "R": pair}
    values: Columns = {"pose": (("component",), pose.components)}
    values |= {name: (pair, getattr(shown, name)) for name in ("L", "R", "error_L", "error_R")}
    values["shared_L"] = ("part", "coil"), reading.shared.swapaxes(0, 1)
    values["alone_L"] = ("cause", "coil"), reading.alone.swapaxes(0, 1)
    by = {"pose": moved.pose, "L": change.L, "R": change.R, **change.signals}
    values |= {f"by_{name}": ((*dims.get(name, ()), "parameter"), own) for name, own in by.items()}
    axes = {name: values for name, values in grid.items() if name in loads}
    columns = over_grid(axes, good, values)
    columns |= over_grid(axes, np.ones(len(every)), {"status": ((), status), "reason": ((), reasons)})
    coils = sensor.coil_names
    coords = {**axes, "coil": coils, "coil_2": coils, "component": list(POSE), "parameter": list(names)}
    found = xr.Dataset(columns, coords)
    found["L0"] = (pair, shown.L0)
    return found.assign_attrs(frequency=sensor.frequency, **shown.convention)


def _checked(loads: Mapping[str, float | Sequence[float]]) -> dict[str, list[float]]:
    """Return the values of all components in the order of `WRENCH`; refuse components that no load has."""
    if unknown := [name for name in loads if name not in WRENCH]:
        raise SceneError(f"loads: must be of {', '.join(WRENCH)}; got {', '.join(unknown)}")
    return {name: checked_values(name, loads.get(name, 0.0)) for name in WRENCH}


def slopes_under(
    sensor: Sensor, names: Sequence[str], loads: Mapping[str, Sequence[float]], mechanics: str, tolerance: float
) -> tuple[list[Wrench], Array]:
    """Return the loads of a grid at which a layer rests, m of them, and the derivatives of poses there, (m, n, 6).

    By n numbers of the scene, on a model's first meshes. Raises SceneError as `gradient_on_grid`, and without a rest.
    """
    numbers, moving = scene_numbers(sensor, names)
    every = loads_of(_checked(loads))
    layer, _ = sloped_model(sensor, mechanics, tolerance, every)
    settled = settle(WithSlopes(layer, tuple(moving)).rough, every, symmetry=symmetry_kept(sensor, moving))
    rests = {load: settled[load].rest for load in every}
    known = {load: rest.slopes for load, rest in rests.items() if rest is not None}
    if not known:
        raise SceneError(f"loads: must be some at which the layer rests; got {', '.join(loads)} without any")
    slopes = np.zeros((len(known), len(numbers), len(POSE)))
    slopes[:, [number in moving for number in numbers]] = np.array(list(known.values()))
    return list(known), slopes
