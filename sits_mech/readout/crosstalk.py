"""How well do the two signals resolve the two forces? Sensitivity, crosstalk both ways, error by rotation.

For a table over (F_x, F_z) with the signals L_v, L_h [%], the pose d_h and, where it has it, the shear signal
L_h_untilted that the same displacement would give without rotation:

    sensitivity     S = d(L_v, L_h) / d(F_z, F_x)
    crosstalk       c_h = (L_h(F_x, F_z) - L_h(F_x, 0)) / FS_h,   FS_h = range of L_h over F_x at F_z = 0
                    c_v = (L_v(F_x, F_z) - L_v(0, F_z)) / FS_v,   FS_v = range of L_v over F_z at F_x = 0
    rotation error  e = L_h - L_h_untilted: as a force e / (dL_h/dF_x),
                                            as a displacement e (dd_h/dF_x) / (dL_h_untilted/dF_x)

where 0 stands for the grid's load nearest to it. Derivatives are second-order differences on the grid. A point that
is missing stays missing, and takes the derivatives next to it with it. Numbers only, no physics.
"""

from __future__ import annotations

import numpy as np
import xarray as xr


def sensitivity(data: xr.Dataset) -> xr.DataArray:
    """Return the sensitivity matrix at every point of the grid.

    Parameters
    ----------
    data : Dataset
        With L_v_percent and L_h_percent over (F_x, F_z) [%], forces in newtons.

    Returns
    -------
    DataArray, dims (signal, force, F_x, F_z)
        ``signal`` is L_v, L_h; ``force`` is F_z, F_x [% / N]. NaN along a force with one value only.
    """
    rows = [[slope(data[f"{signal}_percent"], force) for force in ("F_z", "F_x")] for signal in ("L_v", "L_h")]
    matrix = xr.concat([xr.concat(row, "force") for row in rows], "signal")
    return matrix.assign_coords(signal=["L_v", "L_h"], force=["F_z", "F_x"]).rename("sensitivity")


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


def crosstalk(data: xr.Dataset) -> xr.Dataset:
    """Return the crosstalk both ways.

    Parameters
    ----------
    data : Dataset
        As for `sensitivity`.

    Returns
    -------
    Dataset
        ``L_h_from_F_z`` and ``L_v_from_F_x`` over (F_x, F_z) [% of full scale]; attributes ``largest_L_h_from_F_z``,
        ``largest_L_v_from_F_x`` [% of full scale], ``full_scale_L_h``, ``full_scale_L_v`` [% of L0].
    """
    maps: dict[str, xr.DataArray] = {}
    attributes: dict[str, float] = {}
    for signal, other in (("L_h", "F_z"), ("L_v", "F_x")):
        values = data[f"{signal}_percent"]
        base = values.isel({other: int(np.argmin(np.abs(data[other].to_numpy())))})
        full_scale = float(base.max() - base.min())
        response = (values - base) / full_scale * 100.0 if full_scale > 0.0 else xr.full_like(values, np.nan)
        name = f"{signal}_from_{other}"
        maps[name] = response.transpose("F_x", "F_z").drop_vars(other).assign_coords({other: data[other]})
        attributes[f"largest_{name}"] = float(np.abs(response).max())
        attributes[f"full_scale_{signal}"] = full_scale
    return xr.Dataset(maps, attrs=attributes)


def rotation_error(data: xr.Dataset) -> xr.Dataset:
    """Return what the target's rotation alone is mistaken for.

    Parameters
    ----------
    data : Dataset
        As for `sensitivity`, with d_h [m] and L_h_untilted_percent [%].

    Returns
    -------
    Dataset
        ``F_x_error`` [N] and ``d_h_error`` [m] over (F_x, F_z).
    """
    excess = data["L_h_percent"] - data["L_h_untilted_percent"]
    shift = slope(data["d_h"], "F_x") / slope(data["L_h_untilted_percent"], "F_x")
    return xr.Dataset({"F_x_error": excess / slope(data["L_h_percent"], "F_x"), "d_h_error": excess * shift})
