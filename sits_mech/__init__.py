"""Force in, inductance out: soft inductive tactile sensors from first principles.

The public names; each is imported when it is first used, so that importing the package costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sits_mech.version import __version__

if TYPE_CHECKING:
    from sits_mech.analysis.envelope import envelope
    from sits_mech.analysis.readings.bench import sensor_calibration, terminal_calibration
    from sits_mech.analysis.spectrum import spectrum
    from sits_mech.batch.run import open_sweep
    from sits_mech.batch.sweep import sweep
    from sits_mech.chain.calibrate import calibrate
    from sits_mech.chain.cells.crosstalk import cell_crosstalk, cell_touch
    from sits_mech.chain.cells.forces import cell_forces
    from sits_mech.chain.derivatives.gradient import gradient
    from sits_mech.chain.models import magnetic_model, mechanical_model
    from sits_mech.chain.plans.plan import plan
    from sits_mech.chain.pressing import touch_load
    from sits_mech.chain.simulate import simulate
    from sits_mech.export.calibrations import adapt, compare, export_calibration, invert, quality
    from sits_mech.magnetics.slopes import slopes
    from sits_mech.quantities import Impedance, Pose, SolveFailed, Wrench
    from sits_mech.readout.crosstalk import crosstalk, sensitivity
    from sits_mech.report.folder import read_calibration
    from sits_mech.report.shown import show
    from sits_mech.scene.cells import load_cells
    from sits_mech.scene.sensor import SceneError, Sensor, catalogue, load_sensor, save_sensor
    from sits_mech.synthesis.run import design

__all__ = [
    "Impedance", "Pose", "SceneError", "Sensor", "SolveFailed", "Wrench", "__version__", "adapt", "calibrate",
    "catalogue", "cell_crosstalk", "cell_forces", "cell_touch", "compare", "crosstalk", "design", "envelope",
    "export_calibration", "gradient", "invert", "load_cells", "load_sensor", "magnetic_model", "mechanical_model",
    "open_sweep", "plan", "quality", "read_calibration", "save_sensor", "sensitivity", "sensor_calibration", "show",
    "simulate", "slopes", "spectrum", "sweep", "terminal_calibration", "touch_load",
]

_HOMES = {
    "analysis.readings.bench": ("sensor_calibration", "terminal_calibration"),
    "analysis.envelope": ("envelope",),
    "chain.calibrate": ("calibrate",),
    "chain.cells.forces": ("cell_forces",),
    "chain.cells.crosstalk": ("cell_crosstalk", "cell_touch"),
    "chain.derivatives.gradient": ("gradient",),
    "synthesis.run": ("design",),
    "export.calibrations": ("adapt", "compare", "export_calibration", "invert", "quality"),
    "report.folder": ("read_calibration",),
    "chain.models": ("magnetic_model", "mechanical_model"),
    "chain.plans.plan": ("plan",),
    "chain.pressing": ("touch_load",),
    "chain.simulate": ("simulate",),
    "magnetics.slopes": ("slopes",),
    "quantities": ("Impedance", "Pose", "SolveFailed", "Wrench"),
    "readout.crosstalk": ("crosstalk", "sensitivity"),
    "report.shown": ("show",),
    "scene.cells": ("load_cells",),
    "scene.sensor": ("SceneError", "Sensor", "catalogue", "load_sensor", "save_sensor"),
    "analysis.spectrum": ("spectrum",),
    "batch.run": ("open_sweep",),
    "batch.sweep": ("sweep",),
}


def __getattr__(name: str) -> Any:
    """Import a public name from its home."""
    home = next((room for room, names in _HOMES.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{home}"), name)


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
