"""Name each variable of a table with its unit, by the CF conventions, so that any reader knows it.

No standard name of CF fits inductances, poses or forces on a sensor; units are UDUNITS'. `{L}` and `{R}` stand for the
units of inductance and resistance, which planar models give per metre, `{F}` for that of a table's loads.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sits_mech.quantities import LOAD_ARGUMENTS, POSE_ARGUMENTS, shown_unit
from sits_mech.version import __version__

if TYPE_CHECKING:
    import xarray as xr

_RELATIVE = "% of L0"
_COMPONENTS = {
    "F_x": "shear force along x",
    "F_y": "shear force along y",
    "F_z": "normal force, pressing down",
    "M": "moment about y",
    "M_x": "moment about x",
    "M_z": "moment about z",
    "d_h": "place of the target along x",
    "d_y": "place of the target along y",
    "d_v": "height of the target's bottom face",
    "alpha": "rotation of the target about y",
    "alpha_x": "rotation of the target about x",
    "alpha_z": "rotation of the target about z",
    "touch_x": "place of the touch on the target at rest along x",
    "touch_y": "place of the touch on the target at rest along y",
}
_VARIABLES = {name: (shown_unit(name), words) for name, words in _COMPONENTS.items()} | {
    "L": ("{L}", "inductance"),
    "L_coil": ("{L}", "inductance of each coil alone, the others open"),
    "L_terminal": ("H", "inductance at each coil's terminals, leads and idle coils included"),
    "L0": ("{L}", "inductance without target"),
    "R": ("{R}", "resistance without that of direct current"),
    "R_dc": ("{R}", "direct-current resistance"),
    "relative": ("1 of L0", "inductance over that without target"),
    "dL_v": (_RELATIVE, "change of the coils' mean inductance over L0"),
    "dL_x": (_RELATIVE, "first moment of the inductances along x over L0"),
    "dL_y": (_RELATIVE, "first moment of the inductances along y over L0"),
    "L_v": ("{L}", "sum of the inductances"),
    "L_h": ("{L}", "difference of the inductances"),
    "L_v_percent": (_RELATIVE, "sum of the inductances over L0"),
    "L_h_percent": (_RELATIVE, "difference of the inductances over L0"),
    "L_h_turned": (_RELATIVE, "difference of the inductances over L0 by the rotation"),
    "code": ("1", "code of the converter"),
    "code_time": ("s", "middle of the window of a code"),
    "code_ready": ("s", "time at which a code can be read"),
    "code_L": ("H", "inductance in the window of a code"),
    "time": ("s", "time"),
    "frequency": ("Hz", "frequency of the current"),
    "share": ("1", "share of the largest load"),
    "elastic_share": ("1", "share of the elastic answer to the largest load"),
    "given": ("1", "whether the history names this time"),
    "finite_strain": ("1", "share by which a press of 1 N changes how far a cell sinks per newton"),
    "min_J": ("1", "smallest volume ratio in the layer"),
    "stretch": ("1", "99.9th-percentile stretch, or its reciprocal, in the layer"),
    "largest_stretch": ("1", "largest stretch over the loads"),
    "least_clearance": ("m", "least distance of target and coils over the loads"),
    "mechanics": ("", "model of the layer"),
    "magnetics": ("", "model of the coils"),
    "error_mechanics": ("1", "estimated relative error of the pose"),
    "error_magnetics": ("1", "estimated error of the inductances over their largest change"),
    "iterations": ("1", "linear solves"),
    "seconds": ("s", "processor time of the solve"),
    "failed_loads": ("1", "loads without result"),
    "resolution": ("{F}", "largest standard deviation of a read load by the converter's noise"),
    "error_by_model": ("{F}", "largest error of a read load by the errors of the table"),
    "linearity": ("1", "largest distance of a load's own signal from a straight line over full scale"),
    "crosstalk": ("1", "largest crosstalk in the best linear readout over full scale"),
    "crosstalk_after": ("1", "largest crosstalk after the inverse over full scale"),
    "condition": ("1", "largest condition of the slopes"),
    "valid_share": ("1", "share of the loads where the inverse holds"),
    "status": ("", "what the answer is worth"),
    "flags": ("", "all that holds of the answer, worst first"),
    "reason": ("", "why there is no result"),
}
"""Unit, as a reader is shown it, and long name of each variable; texts have no unit."""
_BEFORE = {
    "error_map_": "estimated error of the map between solved cases, of the ",
    "error_": "estimated error of the ",
    "shared_": "part of the error that loads share, of the ",
    "alone_": "part of the error that each load has alone, of the ",
    "load_": "of each load: ",
    "slope_T_": "slope by temperature of the ",
}
_AFTER = {"_untilted_percent": " without rotation", "_untilted": " without rotation", "_turned": " by the rotation",
          "_by": ", by cause"}


def unit_of(name: str, unit_L: str, unit_F: str = "") -> str:
    """Return the unit of a variable or of a column such as ``error_L[C1][C2]``, "" where none is known."""
    unit = _found(name.partition("[")[0])[0]
    for place, own in (("{L}", unit_L), ("{R}", unit_L.replace("H", "ohm", 1)), ("{F}", unit_F)):
        if place in unit:
            return unit.replace(place, own) if own else ""
    return unit


def with_unit(name: str, unit: str) -> str:
    """Return the heading of a column with its unit, where it has one."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def described(name: str) -> str:
    """Return long name and unit of a variable for a reader, "" where none is known."""
    bare = next((name.removeprefix(before) for before in _BEFORE if name.startswith(before)), name)
    if _found(bare)[1] == bare.replace("_", " "):
        return ""
    unit, words = unit_of(name, "H", "N"), _found(name)[1]
    return f"{with_unit(words[:1].upper() + words[1:], unit)}."


def _found(name: str) -> tuple[str, str]:
    """Return unit and long name by the table, or by what stands before and after a name of it."""
    name = (LOAD_ARGUMENTS | POSE_ARGUMENTS).get(name, name)
    if name in _VARIABLES:
        return _VARIABLES[name]
    for before, words in _BEFORE.items():
        if name.startswith(before):
            unit, own = _found(name.removeprefix(before))
            return f"{unit}/K" if before == "slope_T_" and unit else unit, f"{words}{own}"
    for after, words in _AFTER.items():
        if name.endswith(after):
            bare = name.removesuffix(after)
            unit, own = _found(f"{bare}_percent" if after.endswith("percent") else bare)
            return unit, f"{own}{words}"
    return "", name.replace("_", " ")


def labelled(data: xr.Dataset) -> xr.Dataset:
    """Return a table whose variables have unit and long name by the CF conventions; of keys of a scene as they are."""
    given = data["unit_L"] if "unit_L" in data else data.attrs.get("unit_L", "")
    units = {str(unit) for unit in np.ravel(given)} - {""}
    forces = {shown_unit(name) for name in np.asarray(data.coords.get("force", ()))}
    one_L, one_F = (found.pop() if len(found) == 1 else "" for found in (units, forces))
    data = data.copy()
    for name, item in data.variables.items():
        unit = unit_of(str(name), one_L, one_F).partition(" of ")[0] if item.dtype.kind in "fiu" else ""
        errors = {"ancillary_variables": f"error_{name}"} if f"error_{name}" in data else {}
        own = {"long_name": _found(str(name))[1]} | ({"units": unit} if unit else {}) | errors
        data[name].attrs = data[name].attrs | own
    heads = {"title": str(data.attrs.get("name", "study")), "history": f"made by sits-mech {__version__}"}
    return data.assign_attrs(Conventions="CF-1.11", **heads)
