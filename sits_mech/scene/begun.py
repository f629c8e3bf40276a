"""Write a first scene from a few sizes: one to four round coils under a target on a layer, each key with its meaning.

Coils stand as close as their windings allow, a distance p from centre to centre: along x, or at the corners of a
triangle or a square about the middle, at p/2, p/sqrt 3 and p/sqrt 2 of it.
"""

from __future__ import annotations

import json
import math
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, Field

from sits_mech.inputs import FORM, whole
from sits_mech.units import quantity

CLEAR = 2e-4
"""Between the windings of neighbours [m]: what a board maker keeps between tracks, with some to spare."""
_ANGLES = {1: (0.0,), 2: (180.0, 0.0), 3: (90.0, 210.0, 330.0), 4: (135.0, 225.0, 45.0, 315.0)}
_READ = {1: "F_z", 2: "F_z and F_x", 3: "F_z, F_x and F_y", 4: "F_z, F_x and F_y, one to spare"}
_RADII = {1: 0.0, 2: 0.5, 3: 1.0 / math.sqrt(3.0), 4: 1.0 / math.sqrt(2.0)}  # of the pitch of the coils



def _number(text: object) -> object:
    """Return a written whole number; anything else as it is."""
    return int(text) if isinstance(text, str) and text.isdecimal() else text


_Count = Annotated[int, whole(1), BeforeValidator(_number)]


class Beginning(BaseModel):
    """What a first scene is made of, lengths as they are written; the words are what a user is asked for."""

    model_config = FORM
    name: str = Field("A first sensor", description="Name of the sensor")
    coils: Annotated[int, whole(1, 4), BeforeValidator(_number)] = Field(3, description="Coils, one to four")
    layers: _Count = Field(2, description="Layers of each")
    turns: _Count = Field(12, description="Turns in a layer")
    inner: str = Field("2.2 mm", description="Diameter within the innermost turn")
    track: str = Field("0.1 mm", description="Width of a track")
    gap: str = Field("0.1 mm", description="Gap between tracks")
    target: str = Field("copper", description="Metal of the target")
    size: str = Field("12 mm", description="Its diameter")
    thickness: str = Field("0.2 mm", description="Its thickness")
    silicone: str = Field("ecoflex-00-30", description="Silicone, of sits-mech catalog")
    layer: str = Field("2 mm", description="Thickness of its layer")
    pad: str = Field("20 mm", description="Diameter of its layer")
    frequency: str = Field("5 MHz", description="Frequency")
    converter: str = Field("LDC1614", description='Converter, or "none"')


def first_scene(asked: Beginning) -> str:
    """Return the text of a scene, with comments; SceneError for a length that is none."""
    inner, track, gap = (quantity(getattr(asked, name), "m", name) for name in ("inner", "track", "gap"))
    radius = _RADII[asked.coils] * (inner + 2.0 * (asked.turns * (track + gap) - gap) + CLEAR)
    angles = [math.radians(angle) for angle in _ANGLES[asked.coils]]
    places = [[f"{1e3 * radius * f(angle):.4f} mm".replace("-0.0000", "0.0000") for f in (math.cos, math.sin)]
              for angle in angles]
    return "\n".join([_head(asked), *(_coil(asked, k, place) for k, place in enumerate(places)), _rest(asked)])


def _head(asked: Beginning) -> str:
    """Return the first lines."""
    return f"""\
# A soft inductive tactile sensor: a metal target on a silicone layer above coils. z = 0 is the top face of the coils, x
# is shear, z up. Lengths, frequencies, ... have their units; sits-mech schema scene lists all keys.
name = {json.dumps(asked.name)}
frequency = "{asked.frequency}"  # that the coils are driven at
"""


def _coil(asked: Beginning, number: int, place: list[str]) -> str:
    """Return a coil; the first one says what its keys mean."""
    keys = {
        "centre": (json.dumps(place), f"of its axis; so many coils read {_READ[asked.coils]}"),
        "layers": (asked.layers, "of the board that are wound"),
        "turns": (asked.turns, "in each layer"),
        "inner_diameter": (json.dumps(asked.inner), "within the innermost turn"),
        "track_width": (json.dumps(asked.track), ""),
        "track_gap": (json.dumps(asked.gap), "between neighbouring tracks"),
        "track_thickness": ('"35 um"', "1 oz of copper"),
        "layer_pitch": ('"85 um"', "from the middle of a layer to the next"),
    }
    lines = [
        f"{key} = {value}{f'  # {note}' if note and number == 0 else ''}" for key, (value, note) in keys.items()
        if key != "layer_pitch" or asked.layers > 1
    ]
    return "\n".join(["[[coils]]", f'name = "C{number + 1}"', *lines, ""])


def _rest(asked: Beginning) -> str:
    """Return target, layer and readout."""
    return f"""\
[target]  # bonded on the layer, where the force acts
material = "{asked.target}"  # copper, aluminium, brass, ferrite; or conductivity = "..."
shape = "disc"  # or rectangle with width and length, outline with points
diameter = "{asked.size}"
thickness = "{asked.thickness}"

[elastomer]  # between coils and target
material = "{asked.silicone}"  # of sits-mech catalog; or a law with constants of your own: sits-mech fit
diameter = "{asked.pad}"
thickness = "{asked.layer}"
standoff = "0 mm"  # a film, or solder mask, between coils and layer

[readout]
converter = "{asked.converter}"  # or "none"
parallel_capacitance = "330 pF"  # of each coil's tank
idle_coil = "shorted"  # what the others are while one is read: shorted, open, live
"""
