"""A silicone's law: its constants, its isochoric energy with two derivatives, and how it is fitted.

A law states its energy in one of two forms:

    of invariants   w(I1, I2),            I1 = J^(-2/3) F : F,   I2 = J^(-4/3) cof F : cof F
    of stretches    w = sum_i f(e_i),     e_i = ln lambda_i - (ln J)/3   (K. C. Valanis, R. F. Landel 1967)

and nothing else of it stands anywhere: stress and tangent in space and in plane strain (energy.py), the uniform tests
(homogeneous.py), stability and the fit to data all read these derivatives. Units are those of the constants.

Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), sections 6.4 and 6.5; K. C. Valanis, R. F. Landel, J. Appl.
Phys. 38 (1967) 2997. Neglected: viscosity, stress softening, temperature.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from sits_mech.quantities import Array, Mask

Constants = Mapping[str, float | tuple[float, ...]]
"""Values of a law's constants by name: a number each, or, for a law of several terms, a tuple each."""


@dataclass(frozen=True)
class Invariants:
    """Isochoric invariants of deformations, shape (...); I2 is computed when asked for."""

    I1: Array
    second: Callable[[], Array]

    @property
    def I2(self) -> Array:
        """Second invariant."""
        return self.second()


class InvariantDerivatives(NamedTuple):
    """An energy density of I1 and I2 with derivatives, each of their shape; None: identically zero."""

    w: Array
    w_1: Array
    w_2: Array | None = None
    w_11: Array | None = None
    w_12: Array | None = None
    w_22: Array | None = None


class StretchDerivatives(NamedTuple):
    """The energy of each principal direction with derivatives by its logarithmic strain e, shape (..., 3).

    `quotient` is ``(f_1(e_i) - f_1(e_j))/(exp(e_i) - exp(e_j))`` for the pairs (i, j) of (1, 2), (2, 0) and (0, 1), and
    its limit ``f_11/exp(e)`` at equal strains.
    """

    f: Array
    f_1: Array
    f_11: Array
    quotient: Array


@dataclass(frozen=True)
class OfInvariants:
    """An energy as a function of constants and invariants."""

    derivatives: Callable[[Constants, Invariants], InvariantDerivatives]


@dataclass(frozen=True)
class OfStretches:
    """An energy as a function of constants and logarithmic principal strains (..., 3)."""

    derivatives: Callable[[Constants, Array], StretchDerivatives]


@dataclass(frozen=True)
class LinearFit:
    """Fit of a law that is linear in its constants x, under stability and these sign conditions.

    `tension_alone`: rows C of C x >= 0 that hold where the data are of tension alone.
    """

    not_negative: tuple[str, ...] = ()
    tension_alone: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True)
class TermFit:
    """Fit of a law whose stress is a sum of moduli m > 0, each times a function of one shape x.

    With e the data's largest I1 - 3: `starts` gives the first shapes by e, `limits` lower and upper limits of shapes
    that start at x by x and e, `held` which shapes x the data do not determine (at an end of their range), with a
    `note`. Shapes start from `tension_alone` on where the data are of tension alone.
    """

    constants: Callable[[Array, Array], dict[str, float | tuple[float, ...]]]
    starts: Callable[[float], Array]
    limits: Callable[[Array, float], tuple[Array, Array]]
    held: Callable[[Array, float], Mask]
    note: str
    several: bool = False
    tension_alone: float = -math.inf


def anything(constants: Constants) -> str:
    """Accept all constants."""
    return ""


@dataclass(frozen=True)
class Law:
    """A law of hyperelasticity."""

    name: str  # in a material table
    units: Mapping[str, str]  # of each constant in formula order, "Pa" or ""
    shear_modulus: Callable[[Constants], float]  # initial, in the unit of the constants
    energy: OfInvariants | OfStretches  # isochoric
    fit: LinearFit | TermFit = LinearFit()
    refusal: Callable[[Constants], str] = anything  # error in words, "" if valid
    lists: bool = False  # each constant is a list, one number a term
    fails: str = "is unstable"  # behaviour of a layer from an unstable stretch on
    stiffened: Callable[[Constants, float], tuple[str, Constants]] | None = None  # of w + share mu/2 (I1 - 3)^2

    def rescaled(self, constants: Constants, change: Callable[[float], float]) -> Constants:
        """Return the constants with a change of all that are stresses."""
        stresses = {name: value for name, value in constants.items() if self.units[name] == "Pa"}
        return dict(constants) | {
            name: tuple(map(change, value)) if isinstance(value, tuple) else change(value)
            for name, value in stresses.items()
        }


def number(constants: Constants, name: str) -> float:
    """Return a constant that is one number."""
    value = constants[name]
    return float(sum(value)) if isinstance(value, tuple) else float(value)
