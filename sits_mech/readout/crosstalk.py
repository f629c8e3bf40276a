"""Find how well the signals resolve the forces: sensitivity, crosstalk of every force into every signal, rotation.

For a table over any components of a load. Three of them have a signal of their own [% of L0],

    F_z -> dL_v,    F_x -> dL_x,    F_y -> dL_y          (a pair on x: L_v = L1 + L2 and L_h = L1 - L2, as published),

where the coils' places give it one: coils that share a coordinate have no signal along it.

    sensitivity     S = d(signals) / d(components)
    crosstalk       c(F) = (s(F) - s(F, F_j = 0)) / FS,    FS = range of s over its own force, the others 0
    rotation error  e = s - s_untilted, the signal of a shear force less what the same displacement would give without
                    rotation: as a force e / (ds/dF_x), as a displacement e (dd_h/dF_x) / (ds_untilted/dF_x); in y alike

where 0 stands for the table's load nearest to it. Derivatives are second-order differences on the grid. A point that
is missing stays missing, and takes the derivatives next to it with it.

The error e of a value y at a load has signed parts m_j, variables ``shared_...`` of the table, which all loads share up
to one factor between -1 and 1 each, and a rest a = e - sum_j |m_j| of its own. A figure f of many values y_i is off by

    sum_j |f(y + m_j) - f(y)|  +  (sum_i (df/dy_i a_i)^2)^1/2,

so that what is alike at the loads that a figure compares cancels. Of a table without such parts nothing is known of how
its errors go together: a = e, and the worst of all signs counts, sum_i |df/dy_i| a_i.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr

from sits_mech.arguments import checked_arguments
from sits_mech.quantities import POSE, WRENCH
from sits_mech.readout.loads import varied
from sits_mech.readout.signals import COMBINED, SIGNALS, shown_signals

FORCES = ("F_z", "F_x", "F_y")
"""The components of a load that have a signal of their own, in the order of `SIGNALS`."""


def signals_of(data: xr.Dataset) -> dict[str, str]:
    """Return the variable with the signal of each component of a load that has one of its own, F_z first.

    The published signals of a pair stand for theirs; but a pair on y has no signal along x, whatever L1 - L2 is.
    """
    each = zip(FORCES, SIGNALS, strict=True)
    found = {force: name for force, name in each if name in data and np.nan_to_num(data[name]).any()}
    names = shown_signals(data)
    if COMBINED[0] in map(short_name, names) and ("F_x" in found or "F_y" not in found):
        return dict(zip(FORCES, names, strict=False)) | {k: name for k, name in found.items() if k == "F_y"}
    return found


def short_name(variable: str) -> str:
    """Return the name of a signal, without the unit that its variable has."""
    return variable.removesuffix("_percent")


def components_of(data: xr.Dataset) -> tuple[str, ...]:
    """Return the components that a table varies, those with a signal of their own first."""
    own = [name for name in signals_of(data) if name in data.dims]
    return (*own, *(name for name in varied(data) if name not in own))


@checked_arguments
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

    Examples
    --------
    >>> models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sm.load_sensor("biorob2018"), F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> slopes = sm.sensitivity(data)
    >>> round(float(slopes.sel(signal="L_h", force="F_x", F_x=0.0, F_z=0.0)), 1)  # % of L0 a newton
    7.2
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


def slope_error(errors: xr.DataArray, along: str, *, independent: bool = False) -> xr.DataArray:
    """Return how far `slope` can be off when each value is off by its error: of the worst sign, or independently."""
    coordinate = errors[along].to_numpy().astype(float)
    if coordinate.size < 2:
        return xr.full_like(errors, np.nan)
    weights = np.gradient(np.eye(coordinate.size), coordinate, axis=0, edge_order=2 if coordinate.size > 2 else 1)
    reach, power = np.abs(np.asarray(weights)), 2.0 if independent else 1.0
    sizes = np.moveaxis(np.abs(errors.to_numpy()), errors.get_axis_num(along), 0)
    found = np.tensordot(reach**power, np.where(np.isfinite(sizes), sizes, 0.0) ** power, axes=1) ** (1.0 / power)
    found[np.tensordot(reach, np.isinf(sizes), axes=1) > 0.0] = np.inf
    return errors.copy(data=np.moveaxis(found, 0, errors.get_axis_num(along)))


def shared_parts(data: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Return a table of some variables, over "part" with each shared part of its errors added to all that have them."""
    found = data[list(names)]
    return found.assign({name: found[name] + data[f"shared_{name}"] for name in found if f"shared_{name}" in data})


def own_errors(data: xr.Dataset, name: str) -> xr.DataArray:
    """Return what is left of the errors of a variable without the parts that loads share; NaN where none is known."""
    if f"error_{name}" not in data:
        return xr.full_like(data[name], np.nan)
    errors = data[f"error_{name}"]
    if f"shared_{name}" not in data:
        return errors
    return (errors - abs(data[f"shared_{name}"]).sum("part")).clip(min=0.0).transpose(*errors.dims)


def slope_doubt(data: xr.Dataset, name: str, along: str) -> xr.DataArray:
    """Return how far the `slope` of a variable can be off by the errors of a table."""
    found, shared = own_slope_error(data, name, along), data.get(f"shared_{name}")
    return found if shared is None else found + abs(slope(shared, along)).sum("part", skipna=False)


def own_slope_error(data: xr.Dataset, name: str, along: str) -> xr.DataArray:
    """Return how far the `slope` of a variable can be off by what is left of its errors without shared parts."""
    return slope_error(own_errors(data, name), along, independent=f"shared_{name}" in data)


def _both(data: xr.Dataset, name: str, one: xr.DataArray, other: xr.DataArray) -> xr.DataArray:
    """Return how far a difference of values of a variable can be off by what each has of an error of its own."""
    return (one**2 + other**2) ** 0.5 if f"shared_{name}" in data else one + other


def nearest_none(values: xr.DataArray | xr.Dataset, force: str) -> int:
    """Return the index of the value of a component that is nearest to none of it."""
    return int(np.argmin(np.abs(values[force].to_numpy())))


def response(values: xr.DataArray, force: str) -> xr.DataArray:
    """Return what a component of the load does to values: values less those at the load nearest to none of it."""
    return (values - _at_none(values, force)).transpose(*values.dims)


def _at_none(values: xr.DataArray, force: str) -> xr.DataArray:
    """Return values at the load nearest to none of a component."""
    return values.isel({force: nearest_none(values, force)}, drop=True)


@checked_arguments
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

    Examples
    --------
    >>> models = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}
    >>> data = sm.calibrate(sm.load_sensor("biorob2018"), F_x=[-0.2, 0.0, 0.2], F_z=[0.0, 0.5, 1.0], **models)
    >>> round(sm.crosstalk(data).attrs["largest_L_h_from_F_z"], 1)  # % of full scale
    4.6
    """
    maps: dict[str, xr.DataArray] = {}
    attributes: dict[str, float] = {}
    for force, name in signals_of(data).items():
        if force not in data.dims:
            continue
        signal, values, own = short_name(name), data[name], own_errors(data, name)
        others = [other for other in components_of(data) if other != force]
        at = {other: nearest_none(data, other) for other in others}
        shifted = shared_parts(data, [name])[name]
        scale, scales = _range(values.isel(at), force), _range(shifted.isel(at), force)
        full_scale, error = float(scale), _largest(_both(data, name, own, own).isel(at))
        attributes[f"full_scale_{signal}"] = full_scale
        attributes[f"error_full_scale_{signal}"] = error + _moved(scales, full_scale)
        for other in others:
            share, pair = _share(values, other, scale), f"{signal}_from_{other}"
            largest = float(np.abs(share).max())
            dividend = 100.0 * _largest(_both(data, name, own, _at_none(own, other)))
            unsure = _quotient_error(largest, full_scale, (dividend, error))
            each = abs(_share(shifted, other, scales)).max(values.dims)
            maps[pair], attributes[f"largest_{pair}"] = share, largest
            attributes[f"error_largest_{pair}"] = unsure + _moved(each, largest)
    return xr.Dataset(maps, attrs=attributes)


def _range(values: xr.DataArray, force: str) -> xr.DataArray:
    """Return the range of values along a component."""
    return values.max(force) - values.min(force)


def _moved(shifted: xr.DataArray, value: float) -> float:
    """Return by how much the shared parts of the errors move a value, all together."""
    return float(abs(shifted - value).sum(skipna=False))


def _share(values: xr.DataArray, other: str, full_scale: xr.DataArray) -> xr.DataArray:
    """Return the response of a signal to a component that is not its own [% of full scale]."""
    return response(values, other) / full_scale.where(full_scale > 0.0) * 100.0


def rotation_error(data: xr.Dataset) -> xr.Dataset:
    """Return what the target's rotation alone is mistaken for: ``F_x_error`` [N], ``d_h_error`` [m], and those of F_y.

    `data` is as for `sensitivity`, with the place d_h or d_y [m] and the signals ``_untilted`` [%].
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

    `data` is as for `rotation_error`, with the errors of the signals; a force of one value has none.
    """
    wrong, found = rotation_error(data), {}
    needed = set(signals_of(data).values()).union(*_turned(data).values())
    needed |= {name for name in SIGNALS if name in data}
    shifted = rotation_error(shared_parts(data, sorted(needed)))
    for force, (place, signal, level) in _turned(data).items():
        for name, shown in ((force, signal), (place, level)):
            size = abs(wrong[f"{name}_error"])
            if not np.any(np.isfinite(size)):
                continue
            at = dict(zip(size.dims, np.unravel_index(int(np.nanargmax(size)), size.shape), strict=True))
            rate = abs(float(slope(data[shown], force).isel(at)))
            reach = 1.0 if name == force else abs(float(slope(data[place], force).isel(at)))
            unsure, turned = own_errors(data, signal), data.get(f"error_{short_name(signal)}_turned")
            by_turning = 2.0 * unsure if turned is None else turned
            errors = (float(by_turning.isel(at)), float(own_slope_error(data, signal, force).isel(at)))
            value = float(size.isel(at))
            error = reach * _quotient_error(value / reach if reach > 0.0 else 0.0, rate, errors)
            found[name] = (value, error + _moved(abs(shifted[f"{name}_error"].isel(at)), value))
    return found


def _quotient_error(quotient: float, divisor: float, errors: tuple[float, float]) -> float:
    """Return how far a quotient can be off when dividend and divisor are off by their errors."""
    left = abs(divisor) - errors[1]
    if math.isnan(left):
        return math.nan
    return (errors[0] + abs(quotient) * errors[1]) / left if left > 0.0 else math.inf


def _largest(errors: xr.DataArray) -> float:
    """Return the largest of some errors, zero where a load has none; NaN where none has."""
    sizes = errors.to_numpy()
    return math.nan if np.isnan(sizes).all() else float(np.max(np.nan_to_num(sizes, posinf=np.inf)))
