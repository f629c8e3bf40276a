"""State what is known of a built sensor before anything of it is read.

What a user states ("gap=0+-0.3 mm") counts; the rest is

    modulus     ln s = 0 +- ln(1 + S)/1.69, S the spread of the silicone's sources, the range of some three of them:
                1.69 deviations are the mean range of three normal numbers; 0.3 where no source is known
    others      chosen, as moulding by hand, gluing by eye and a load cell of 1 % leave them; see `USUAL`

A planar magnetic model has no poses out of its plane, one on an axis none beside it: of such nothing is unknown.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sits_mech.analysis.built.unknowns import LAYER, Known, checked
from sits_mech.scene.sensor import Sensor
from sits_mech.silicone.laws import LAWS

USUAL = {
    "stiffening": 0.05, "thickness": 0.025, "gap": 1e-4, "d_h": 2e-4, "d_y": 2e-4, "alpha": 0.026, "alpha_x": 0.026,
    "cell": 0.01, "frame": 0.0175, "frame_x": 0.0175, "frame_z": 0.0175, "lead": 2e-8, "capacitance": 0.01,
}
"""Deviations, of the thickness over the layer's, of the capacitance over the tank's [-]; others [m, rad, H]."""
_THREE = 1.693  # mean range of three normal numbers, in deviations
_UNKNOWN = 0.3  # of the modulus, without a source's spread
_BESIDE = ("d_y", "alpha_x", "frame_x", "frame_z")
_OFF_AXIS = ("d_h", "alpha", "frame", *_BESIDE)
_ABSENT = {"planar": _BESIDE, "planar-fem": _BESIDE, "axisymmetric": _OFF_AXIS}
_SLOPED = ("block", "planar", "linear")  # mechanical models with derivatives by the layer
_PAIRS = {"frame": ("F_x", "F_z"), "frame_x": ("F_y", "F_z"), "frame_z": ("F_x", "F_y")}


def usual_unknowns(sensor: Sensor, models: tuple[str, str], forces: Sequence[str]) -> tuple[str, ...]:
    """Return what is not known of a sensor that is read under forces, by a mechanical and a magnetic model."""
    absent = set(_ABSENT.get(models[1], ()))
    if models[0] not in _SLOPED:
        absent |= {*LAYER}
    if sensor.elastomer is None or LAWS[sensor.elastomer.silicone.law].stiffened is None:
        absent |= {"stiffening"}
    absent |= {name for name, pair in _PAIRS.items() if not {*pair} <= {*forces}}
    return tuple(name for name in ("modulus", *USUAL) if name not in absent)


def priors(sensor: Sensor, texts: Sequence[str]) -> tuple[Known, ...]:
    """Return unknowns (`setup.known`) with what is known of each beforehand; SceneError as `setup.checked`."""
    found = checked(sensor, texts, False)
    return tuple(each if each.value is not None else _usual(sensor, each.name) for each in found)


def _usual(sensor: Sensor, name: str) -> Known:
    """Return what is known of an unknown that nothing was said of; keys of the scene have said it."""
    if name == "modulus":
        spread = None if sensor.elastomer is None else sensor.elastomer.silicone.spread
        return Known(name, 1.0, _UNKNOWN if spread is None else float(np.log1p(spread)) / _THREE)
    of = {"capacitance": sensor.readout.parallel_capacitance}
    if sensor.elastomer is not None:
        of["thickness"] = sensor.elastomer.thickness
    return Known(name, 1.0 if name == "cell" else 0.0, USUAL.get(name, USUAL["alpha"]) * of.get(name, 1.0))


