"""Name a sensor's figures: units, how a reader is shown them, whether much or little is good.

Some kinds have a figure for every component of the load, such as "resolution.F_x", or for both axes: "footprint.x".
What each one is stands in `figures`.
"""

from __future__ import annotations

from typing import NamedTuple

from sits_mech.quantities import UNITS, shown_unit

INVERSE, STRAIN = "inverse", "strain"


class FigureKind(NamedTuple):
    """A kind of figure; {} in its units is that of a component of the load."""

    unit: str = ""  # SI
    shown: str = "%"
    scale: float = 100.0  # of what is shown, from SI
    of: str = ""  # "load" or "axes": what has one each
    least: bool = False  # must be at least so much; others at most
    scatters: bool = False  # with the tolerances
    exact: bool = False  # without error where none is given
    title: str = ""  # for a reader, where its name does not tell
    meaning: str = ""  # in a line

    @property
    def sign(self) -> float:
        """Of what is minimised: -1 for figures that must be at least so much."""
        return -1.0 if self.least else 1.0


KINDS = {
    "resolution": FigureKind(
        "{}", "m{}", 1e3, of="load", scatters=True, meaning="One standard deviation of a reading, at the worst load"
    ),
    "error": FigureKind(
        of="load", scatters=True,
        meaning="Misreading at the worst load that `yield` of the sensors made stay below, over the component's range",
    ),
    "drift": FigureKind("{}/K", "m{}/K", 1e3, of="load", meaning="Of zero, with temperature"),
    "crosstalk_before_inverse": FigureKind(meaning="What another component feigns in a linear readout, over the range"),
    "hysteresis": FigureKind(exact=True, meaning="Width of the loop under a load that comes and goes in a second"),
    "rate": FigureKind("Hz", "Hz", 1.0, least=True, exact=True, title="readings a second", meaning="Readings a second"),
    "height": FigureKind("m", "mm", 1e3, exact=True, meaning="Of the box around all parts at rest"),
    "footprint": FigureKind("m", "mm", 1e3, of="axes", exact=True, meaning="Of that box, along x and along y"),
    # whether there is one load for each reading; the silicone's largest strain under the overload, over what is known
    INVERSE: FigureKind("", "", 1.0, least=True, exact=True, title="one load for each reading (1: evenly)"),
    STRAIN: FigureKind(title="strain under the overload, of its data"),
}
ASKED = tuple(key for key in KINDS if key not in (INVERSE, STRAIN))
"""Kinds that requirements may limit."""


def kind_of(name: str) -> FigureKind:
    """Return the kind of a figure."""
    return KINDS[name.partition(".")[0]]


def figure_unit(name: str) -> str:
    """Return a figure's unit in SI."""
    return kind_of(name).unit.format(UNITS.get(name.partition(".")[2], ""))


def shown_as(name: str) -> tuple[str, float]:
    """Return the unit that a figure is shown in, and its factor from SI."""
    kind, part = kind_of(name), name.partition(".")[2]
    return kind.shown.format(shown_unit(part) if kind.of == "load" else ""), kind.scale


def figure_words(name: str, value: float) -> str:
    """Format a figure for a reader."""
    unit, scale = shown_as(name)
    return f"{scale * value:.3g} {unit}".strip()


def figure_names(forces: tuple[str, ...], keys: tuple[str, ...] = ASKED) -> tuple[str, ...]:
    """Return the names of all figures of some kinds, for some components of the load."""
    parts = {"load": forces, "axes": ("x", "y")}
    return tuple(f"{key}.{part}".rstrip(".") for key in keys for part in parts.get(KINDS[key].of, ("",)))
