"""Define the electronics of a sensor, and what a built sensor and its bench may be off by."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, model_validator

from sits_mech.inputs import FORM
from sits_mech.readout.converter import CONVERTERS
from sits_mech.scene.bounds import Capacitance, Coefficient, Farads, Inductance, Offset, Resistance, Share, Turn

if TYPE_CHECKING:
    ConverterName = str
else:
    ConverterName = Literal[(*CONVERTERS, "none")]  # as read by pydantic


class Readout(BaseModel):
    """The electronics.

    Attributes
    ----------
    converter : str
        One of `CONVERTERS` (readout/converter.py), such as "LDC1614", or "none".
    parallel_capacitance : float
        Of the resonant circuit [F].
    idle_coil : str
        "shorted" (the LDC1614 grounds idle channels), "open" (as a meter reads them, where there is no converter), or
        "live": each tank swings all the time, as on chips of their own.
    lead_inductance, lead_resistance : float
        In series with each coil [H, ohm].
    capacitance_coefficient, clock_coefficient : float
        By which the capacitance and the frequency of the reference clock grow with temperature, from 20 degC [1/K].
    """

    model_config = FORM
    converter: ConverterName = "LDC1614"
    parallel_capacitance: Capacitance = 330e-12
    idle_coil: Literal["shorted", "open", "live"] = "shorted"
    lead_inductance: Inductance = 0.0
    lead_resistance: Resistance = 0.0
    capacitance_coefficient: Coefficient = 0.0
    clock_coefficient: Coefficient = 0.0

    @model_validator(mode="before")
    @classmethod
    def _metered(cls, given: Any) -> Any:
        """Let idle coils be open where there is no converter, unless they are set to something else."""
        metered = isinstance(given, dict) and given.get("converter") == "none"
        return {"idle_coil": "open"} | given if metered else given


class Tolerances(BaseModel):
    """What a built sensor and its bench may be off by: standard deviations, zero for what is known, None for the usual.

    Attributes
    ----------
    modulus, stiffening : float or None
        Of the silicone: over its own modulus, and what it stiffens by besides.
    thickness, gap, d_h, d_y : float or None
        Of the layer; of the target's place as glued, upwards, along x and y [m].
    alpha, alpha_x : float or None
        Of its tilt about y and x [rad].
    lead, capacitance : float or None
        In series with each coil and of the tank [H, F].
    cell, frame, frame_x, frame_z : float or None
        Scale of the load cell, and its turn about y, x, z [-, rad].
    """

    model_config = FORM
    modulus: Share | None = None
    stiffening: Share | None = None
    thickness: Offset | None = None
    gap: Offset | None = None
    d_h: Offset | None = None
    d_y: Offset | None = None
    alpha: Turn | None = None
    alpha_x: Turn | None = None
    lead: Inductance | None = None
    capacitance: Farads | None = None
    cell: Share | None = None
    frame: Turn | None = None
    frame_x: Turn | None = None
    frame_z: Turn | None = None
