"""How well do the signals resolve the forces? Sensitivity, crosstalk of every force into every signal, rotation.

For a table over any components of a load. Three of them have a signal of their own [% of L0],

    F_z -> dL_v,    F_x -> dL_x,    F_y -> dL_y          (a pair on x: L_v = L1 + L2 and L_h = L1 - L2, as published),

where the coils' places give it one: coils that share a coordinate have no signal along it.

    sensitivity     S = d(signals) / d(components)
    crosstalk       c(F) = (s(F) - s(F, F_j = 0)) / FS,    FS = range of s over its own force, the others 0
    rotation error  e = s - s_untilted, the signal of a shear force less what the same displacement would give without
                    rotation: as a force e / (ds/dF_x), as a displacement e (dd_h/dF_x) / (ds_untilted/dF_x); in y alike

where 0 stands for the table's load nearest to it. Derivatives are second-order differences on the grid. A point that
is missing stays missing, and takes the derivatives next to it with it. The error of a figure is the largest it can be
when every signal is off by its own estimated error. Numbers only, no physics.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from sits_mech.quantities import POSE, WRENCH
from sits_mech.readout.loads import varied
from sits_mech.readout.signals import PAIR, SIGNALS, told

FORCES = ("F_z", "F_x", "F_y")
"""The components of a load that have a signal of their own, in the order of `SIGNALS`."""


def signals_of(data: xr.Dataset) -> dict[str, str]:
    """Return the variable with the signal of each component of a load that has one of its own, F_z first.

    Parameters
    ----------
    data : Dataset
        With the signals of any coils, and the published ones of a pair, which stand for theirs; but a pair on y has
        no signal along x, whatever L1 - L2 is.
    """
    each = zip(FORCES, SIGNALS, strict=True)
    found = {force: name for force, name in each if name in data and np.nan_to_num(data[name]).any()}
    if PAIR[0] in (short_name(name) for name in told(data)) and ("F_x" in found or "F_y" not in found):
        return dict(zip(FORCES, told(data), strict=False)) | {k: name for k, name in found.items() if k == "F_y"}
    return found


def short_name(variable: str) -> str:
    """Return the name of a signal, without the unit that its variable has."""
    return variable.removesuffix("_percent")


def components_of(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components that a table varies, those with a signal of their own first."""
    own = [name for name in signals_of(data) if name in data.dims]
    return (*own, *(name for name in varied(data) if name not in own))


def sensitivity(data: xr.Dataset) -> xr.DataArray:
    """Return the sensitivity matrix at every point of the grid.

    Parameters
    ----------
    data : Dataset
        As for `signals_of`, over components of a load [N, N m].

    Returns
    -------
    DataArray, dims (signal, force, ...)
        ``signal`` such as L_v, L_h, ``force`` such as F_z, F_x [% / N, % / (N m)]. NaN along a force with one value.
    """
    signals, forces = list(signals_of(data).values()), list(components_of(data))
    rows = [[slope(data[signal], force) for force in forces] for signal in signals]
    matrix = xr.concat([xr.concat(row, "force") for row in rows], "signal")
    return matrix.assign_coords(signal=[short_name(name) for name in signals], force=forces).rename("sensitivity")


def slope(values: xr.DataArray, along: str) -> xr.DataArray:
    """Return the derivative of `values` along a coordinate; NaN where the grid has one value only."""
    coordinate = values[along].to_numpy().astype(float)
    if coordinate.size < 2:
        return xr.full_like(values, np.nan)
    axis = values.get_axis_num(along)
    rates = np.gradient(values.to_numpy(), coordinate, axis=axis, edge_order=2 if coordinate.size > 2 else 1)
    return values.copy(data=np.asarray(rates))


def slope_error(errors: xr.DataArray, along: str) -> xr.DataArray:
    """Return how far `slope` can be off when each value is off by its error, of either sign."""
    coordinate = errors[along].to_numpy().astype(float)
    if coordinate.size < 2:
        return xr.full_like(errors, np.nan)
    weights = np.gradient(np.eye(coordinate.size), coordinate, axis=0, edge_order=2 if coordinate.size > 2 else 1)
    reach = np.abs(np.asarray(weights))
    sizes = np.moveaxis(np.abs(errors.to_numpy()), errors.get_axis_num(along), 0)
    found = np.tensordot(reach, np.where(np.isfinite(sizes), sizes, 0.0), axes=1)
    found[np.tensordot(reach, np.isinf(sizes), axes=1) > 0.0] = np.inf
    return errors.copy(data=np.moveaxis(found, 0, errors.get_axis_num(along)))


def nearest_none(values: xr.DataArray | xr.Dataset, force: str) -> int:
    """Return the index of the value of a component that is nearest to none of it."""
    return int(np.argmin(np.abs(values[force].to_numpy())))


def response(values: xr.DataArray, force: str) -> xr.DataArray:
    """Return what a component of the load does to values: values less those at the load nearest to none of it."""
    return (values - values.isel({force: nearest_none(values, force)}, drop=True)).transpose(*values.dims)


def crosstalk(data: xr.Dataset) -> xr.Dataset:
    """Return the crosstalk of every component of the load into the signals of the others.

    Parameters
    ----------
    data : Dataset
        As for `sensitivity`; the errors of the figures need ``error_`` of the signals.

    Returns
    -------
    Dataset
        ``L_h_from_F_z`` and its like over the loads [% of full scale]; attributes ``largest_L_h_from_F_z`` [% of full
        scale], ``full_scale_L_h`` [% of L0], and of each its error, ``error_largest_L_h_from_F_z``; NaN where it is
        not known, infinite where it is beyond bounds.
    """
    maps: dict[str, xr.DataArray] = {}
    attributes: dict[str, float] = {}
    for own, name in signals_of(data).items():
        if own not in data.dims:
            continue
        signal, values = short_name(name), data[name]
        others = [force for force in components_of(data) if force != own]
        line = values.isel({force: nearest_none(data, force) for force in others})
        full_scale, error = float(line.max() - line.min()), 2.0 * _largest(data, f"error_{name}")
        attributes |= {f"full_scale_{signal}": full_scale, f"error_full_scale_{signal}": error}
        for other in others:
            moved = response(values, other)
            share = moved / full_scale * 100.0 if full_scale > 0.0 else xr.full_like(values, np.nan)
            largest, pair = float(np.abs(share).max()), f"{signal}_from_{other}"
            maps[pair], attributes[f"largest_{pair}"] = share, largest
            attributes[f"error_largest_{pair}"] = _quotient_error(largest, full_scale, (100.0 * error, error))
    return xr.Dataset(maps, attrs=attributes)


def rotation_error(data: xr.Dataset) -> xr.Dataset:
    """Return what the target's rotation alone is mistaken for.

    Parameters
    ----------
    data : Dataset
        As for `sensitivity`, with the place d_h or d_y [m] and the signals ``_untilted`` [%].

    Returns
    -------
    Dataset
        ``F_x_error`` [N] and ``d_h_error`` [m] over the loads where they vary F_x, and those of F_y.
    """
    found = {}
    for force, (place, signal, level) in _turned(data).items():
        excess = data[signal] - data[level]
        found[f"{force}_error"] = excess / slope(data[signal], force)
        found[f"{place}_error"] = excess * (slope(data[place], force) / slope(data[level], force))
    return xr.Dataset(found)


def _turned(data: xr.Dataset) -> dict[str, tuple[str, str, str]]:
    """Return, for each shear force, the names of its place, of its signal and of that without rotation."""
    found = {}
    for force, signal in signals_of(data).items():
        level = signal.replace(short_name(signal), f"{short_name(signal)}_untilted")
        if level in data and force in data.dims:
            found[force] = (POSE[WRENCH.index(force)], signal, level)
    return found


def largest_rotation(data: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Return the rotation error where it is largest, with its own error: of ``F_x`` [N], ``d_h`` [m], F_y and d_y.

    Parameters
    ----------
    data : Dataset
        As for `rotation_error`, with the errors of the signals; a force of one value has none.
    """
    wrong, found = rotation_error(data), {}
    for force, (place, signal, level) in _turned(data).items():
        for name, shown in ((force, signal), (place, level)):
            size = abs(wrong[f"{name}_error"])
            if not np.any(np.isfinite(size)):
                continue
            at = dict(zip(size.dims, np.unravel_index(int(np.nanargmax(size)), size.shape), strict=True))
            rate = abs(float(slope(data[shown], force).isel(at)))
            reach = 1.0 if name == force else abs(float(slope(data[place], force).isel(at)))
            unsure = data[f"error_{signal}"]
            errors = (2.0 * float(unsure.isel(at)), float(slope_error(unsure, force).isel(at)))
            value = float(size.isel(at))
            found[name] = (value, reach * _quotient_error(value / reach if reach > 0.0 else 0.0, rate, errors))
    return found


def _quotient_error(quotient: float, divisor: float, errors: tuple[float, float]) -> float:
    """Return how far a quotient can be off when dividend and divisor are off by their errors."""
    left = abs(divisor) - errors[1]
    if math.isnan(left):
        return math.nan
    return (errors[0] + abs(quotient) * errors[1]) / left if left > 0.0 else math.inf


def _largest(data: xr.Dataset, name: str) -> float:
    """Return the largest value of a variable, zero where none is a number; NaN where there is no such variable."""
    return float(np.max(np.nan_to_num(data[name].to_numpy()))) if name in data else math.nan
