"""Fit maps from forces to readings, poses, their errors, and slopes of the layer.

Loads may leave the table while the map can be followed: its first missing term, of the size of its error e on [-1, 1],
is e T_(P+1)(x) beyond, and may be 5 e.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from sits_mech.analysis.bench.setup import shown_inductances
from sits_mech.analysis.bench.unknowns import LAYER
from sits_mech.analysis.readings.bench import loads_over, table_impedance, table_inductances
from sits_mech.chain.derivatives.gradient_grid import slopes_under
from sits_mech.chain.propagation import unloaded_pose
from sits_mech.disk_cache import kept
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import POSE, WRENCH, Array, shown_unit, tensor_grid
from sits_mech.readout.loads import answered, ends_of, fixed, varied
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.units import SLACK

_MISSING = 5.0  # of the map's error: what its first missing term may be beyond the table
_MODULI = (0.02, 10.0)  # least and greatest factor
_BEYOND = 0.8  # of the least factor that a table holds: where one below it is looked for next


@dataclass(frozen=True)
class ForceMaps:
    """Maps from forces to inductances at the terminals, to poses, and to parts of their errors."""

    map: SmoothMap
    places: SmoothMap
    parts: SmoothMap | None  # to (q * (6 + n)), parts of the errors that the loads share, as of `shared_errors`
    poses: Array  # of the table's loads, (l, 6)
    L: Array  # at the terminals there, (l, n) [H]

    def at(self, forces: Array) -> tuple[Array, Array]:
        """Return L, shape (k, m, n) [H], and the poses, shape (k, m, 6), at forces (k, m, d)."""
        return mapped(self.map, forces), mapped(self.places, forces)

    @property
    def shared(self) -> int:
        """The number of parts of the errors that the loads share."""
        return 0 if self.parts is None else self.parts.coefficients.shape[1] // (len(POSE) + self.L.shape[1])

    def parts_at(self, forces: Array) -> tuple[Array, Array]:
        """Return the parts of poses, shape (k, m, q, 6), and of L besides, (k, m, q, n) [H], at forces (k, m, d)."""
        found = np.zeros((*forces.shape[:-1], 0)) if self.parts is None else mapped(self.parts, forces)
        found = found.reshape(*forces.shape[:-1], self.shared, len(POSE) + self.L.shape[1])
        return found[..., : len(POSE)], found[..., len(POSE) :]

    def ends(self) -> tuple[Array, Array]:
        """Return how far the map can be followed in each force [N, N m]."""
        half = 0.5 * (self.map.high - self.map.low)
        known = np.all(np.isfinite(self.map.error))
        beyond = [np.cosh(np.arccosh(_MISSING) / (degree + 1)) - 1.0 if known else 0.0 for degree in self.map.degrees]
        return self.map.low - half * beyond, self.map.high + half * beyond

    @property
    def error(self) -> float:
        """The error of the map, over each range."""
        return float(np.max(self.map.error / self.ranges))

    @property
    def own(self) -> float:
        """The rms error of the map, over each range, of a grid fine enough to estimate it; else zero."""
        rms = self.map.rms / self.ranges
        return float(np.sqrt(np.mean(rms[np.isfinite(rms)] ** 2))) if np.any(np.isfinite(rms)) else 0.0

    @cached_property
    def ranges(self) -> Array:
        """The range of each inductance over the forces [H]."""
        return np.asarray(np.ptp(self.map.at(loads_over(self.map.low, self.map.high, 9)), axis=0))


def force_maps_of(sensor: Sensor, data: xr.Dataset, names: Sequence[str]) -> ForceMaps:
    """Return the maps of a calibration over its forces."""
    data = data.isel({name: 0 for name in varied(data) if name not in names})
    good = answered(data).transpose(*names).to_numpy()
    forces = tensor_grid(*(data[name].to_numpy() for name in names))[good]
    each = [data[name] if name in data else 0.0 * data["d_v"] for name in POSE]
    poses = np.stack([part.transpose(*names).to_numpy() for part in each], -1)[good]
    found = table_impedance(data)
    L = shown_inductances(sensor, replace(found, L=found.L[good], R=found.R[good]))
    parts = shared_errors(sensor, data, names)[good]
    shared = fit_map(names, forces, parts.reshape(len(parts), -1)) if np.any(parts) else None
    return ForceMaps(fit_map(names, forces, L), fit_map(names, forces, poses), shared, poses, L)


def shared_errors(sensor: Sensor, data: xr.Dataset, names: Sequence[str]) -> Array:
    """Return the parts of errors that loads share, shape (*loads, q, 6 + n): of poses, and of L where of no pose [H].

    What a component of the pose has for itself is a part of the sign of its displacement.
    """
    L = table_inductances(sensor, data).get("shared_L")
    shape = tuple(data.sizes[name] for name in names)
    whole = np.zeros((*shape, 0, len(sensor.coils)))
    if L is not None:
        whole = L.transpose(*names, "part", "coil").fillna(0.0).to_numpy()

    def each(prefix: str, *dims: str, count: tuple[int, ...] = ()) -> Array:
        """Return a column of each component of poses, the components last; zero of what the table lacks."""
        found = [data[f"{prefix}{name}"].transpose(*names, *dims).fillna(0.0).to_numpy()
                 if f"{prefix}{name}" in data else np.zeros((*shape, *count)) for name in POSE]
        return np.stack(found, -1)

    shared, loads = each("shared_", "part", count=whole.shape[-2:-1]), tuple(range(len(shape)))
    whole = np.where(np.any(shared, axis=(*loads, -1))[:, None], 0.0, whole)
    own = np.maximum(each("error_") - np.abs(shared).sum(axis=-2), 0.0)
    ways = own * np.sign(each("") - unloaded_pose(sensor).components)
    poses = np.concatenate([shared, ways[..., None] * np.eye(len(POSE))], axis=-2)
    whole = np.concatenate([whole, np.zeros((*shape, len(POSE), len(sensor.coils)))], axis=-2)
    found = np.concatenate([poses, whole], axis=-1)
    return found[..., np.any(found, axis=(*loads, -1)), :]


def mapped(smooth: SmoothMap, forces: Array) -> Array:
    """Return the outputs of a map at forces (..., d), shape (..., n)."""
    return smooth.at(forces.reshape(-1, forces.shape[-1])).reshape(*forces.shape[:-1], -1)


def layer_slopes(sensor: Sensor, data: xr.Dataset, names: Sequence[str], mechanics: str, tolerance: float) -> SmoothMap:
    """Return the map from forces to the derivatives of the pose by `LAYER`, on three values of each force.

    The loads are solved once more on the first meshes (chain/derivatives/gradient_grid.py): derivatives have no need of
    others. They are kept for the next command.
    """
    axes = {name: [low, 0.5 * (low + high), high] for name, (low, high) in ends_of(data, names).items()}
    held = {name: [value] for name, value in fixed(data).items()}
    asked = tuple(LAYER.values()), {**axes, **held}, mechanics, tolerance
    same = tuple((name, *values) for name, values in asked[1].items())

    def made() -> tuple[Array, Array]:
        """Return loads (m, 6) and derivatives (m, n, 6)."""
        loads, slopes = slopes_under(sensor, *asked)
        return np.array([load.components for load in loads]), slopes

    loads, slopes = kept(
        ("layer slopes", sensor, asked[0], same, mechanics, tolerance), made,
        lambda own: {"loads": own[0], "slopes": own[1]}, lambda arrays: (arrays["loads"], arrays["slopes"]), __name__,
    )
    return fit_map(names, loads[:, [WRENCH.index(name) for name in names]], slopes.reshape(len(loads), -1))


def required_load(force: float, softest: float) -> float:
    """Return to what load a table must reach for a sensor of modulus `softest` to be read at a force: two digits."""
    step = 10.0 ** (np.floor(np.log10(force / softest)) - 1.0)
    return float(f"{step * np.ceil(force / softest / step - SLACK):.3g}")


def needed(force: float, softest: float, unit: str) -> str:
    """Return `required_load` in words."""
    return f"calibrate to at least {required_load(force, softest):.3g} {unit}"


def lacking(forces: Array, table: ForceMaps, softest: float) -> dict[tuple[str, float], float]:
    """Return to what load a table must reach, by force and sign, for a sensor to be read at all forces (m, d).

    Of a modulus `softest`; only what the table does not hold. A force that is not known is NaN.
    """
    found, names = {}, table.map.names
    for k, (name, low, high) in enumerate(zip(names, *table.ends(), strict=True)):
        for sign, end in ((1.0, high), (-1.0, -low)):
            top = float(np.nanmax(sign * forces[:, k], initial=0.0))
            if top > 0.0 and top / softest > max(end, 0.0) * (1.0 + SLACK):
                found[name, sign] = required_load(top, softest)
    return found


def moduli(
    forces: Array, table: ForceMaps, names: Sequence[str], softest: float = 1.0
) -> tuple[tuple[float, float], tuple[str, str]]:
    """Return the least and greatest factor of the modulus for which the map holds every measured force, and why.

    `softest` is the least that is expected; a fit that goes on beyond the least one is looked for at `_BEYOND` of it.
    """
    (least, most), (why_least, why_most) = _MODULI, ("", "")
    for k, (name, low, high) in enumerate(zip(names, *table.ends(), strict=True)):
        unit = shown_unit(name)
        span = f"the table's map can be followed for {name} from {low:.4g} to {high:.4g} {unit}"
        for sign, end in ((1.0, high), (-1.0, -low)):
            top = float(np.max(sign * forces[:, k]))
            came = f"{span}, the measurement has {sign * top:.4g} {unit}"
            if end <= 0.0 <= top and end != top:
                raise SceneError(f"table: must reach beyond the measured forces; {came}")
            if end > 0.0 and top / end > least:
                least = top / end
                why_least = f"{came}: {needed(top, min(softest, _BEYOND * least), unit)} of {name}"
            if end < 0.0 and top / end < most:
                most, why_most = top / end, came
    return (least, most), (why_least, why_most)
