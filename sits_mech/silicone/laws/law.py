"""What makes a law of a silicone? Its constants, its isochoric energy with two derivatives, and how it is fitted.

A law states its energy in one of two forms:

    of invariants   w(I1, I2),            I1 = J^(-2/3) F : F,   I2 = J^(-4/3) cof F : cof F
    of stretches    w = sum_i f(e_i),     e_i = ln lambda_i - (ln J)/3   (K. C. Valanis, R. F. Landel 1967)

and nothing else of it stands anywhere: stress and tangent in space and in plane strain (energy.py), the uniform tests
(homogeneous.py), stability and the fit to data all read these derivatives. Units are those of the constants.

Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), sections 6.4 and 6.5; K. C. Valanis, R. F. Landel, J. Appl.
Phys. 38 (1967) 2997. Neglected: viscosity, stress softening, temperature.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sits_mech.quantities import Array

Constants = Mapping[str, float | tuple[float, ...]]
"""Values of a law's constants by name: a number each, or, for a law of several terms, a tuple each."""


@dataclass(frozen=True)
class Invariants:
    """The isochoric invariants of deformations, shape (...) each; the second is computed when a law asks for it."""

    I1: Array
    second: Callable[[], Array]

    @property
    def I2(self) -> Array:
        """The second invariant."""
        return self.second()


class InvariantDerivatives(NamedTuple):
    """An energy density of I1 and I2 with its derivatives, each of their shape; None for one that is always zero."""

    w: Array
    w_1: Array
    w_2: Array | None = None
    w_11: Array | None = None
    w_12: Array | None = None
    w_22: Array | None = None


class StretchDerivatives(NamedTuple):
    """What each principal direction stores, with derivatives by its logarithmic strain e.

    All of shape (..., 3). `quotient` is ``(f_1(e_i) - f_1(e_j))/(exp(e_i) - exp(e_j))`` for the pairs (i, j) of (1, 2),
    (2, 0) and (0, 1), and its limit ``f_11/exp(e)`` at equal strains.
    """

    f: Array
    f_1: Array
    f_11: Array
    quotient: Array


@dataclass(frozen=True)
class OfInvariants:
    """An energy given as a function of constants and invariants."""

    derivatives: Callable[[Constants, Invariants], InvariantDerivatives]


@dataclass(frozen=True)
class OfStretches:
    """An energy given as a function of constants and logarithmic principal strains (..., 3)."""

    derivatives: Callable[[Constants, Array], StretchDerivatives]


@dataclass(frozen=True)
class LinearFit:
    """How to fit a law that is linear in its constants; stability holds them, and here and there their sign.

    Attributes
    ----------
    not_negative : tuple of str
        Constants that must not be negative whatever the data say.
    """

    not_negative: tuple[str, ...] = ()


@dataclass(frozen=True)
class TermFit:
    """How to fit a law whose stress is a sum of moduli m > 0, each times a function of one shape x.

    Attributes
    ----------
    constants : callable
        The law's constants of m and x, shape (terms,) each.
    starts : callable
        The shapes at which to begin the search, by the data's largest I1 - 3.
    limits : callable
        Lower and upper limits of shapes that started at x, by x and the data's largest I1 - 3.
    held : callable
        Which of the shapes x the data do not determine: those at an end of their range. Takes what `limits` takes.
    note : str
        What is to be said then.
    several : bool
        Whether the law may have more than one term.
    """

    constants: Callable[[Array, Array], dict[str, float | tuple[float, ...]]]
    starts: Callable[[float], Array]
    limits: Callable[[Array, float], tuple[Array, Array]]
    held: Callable[[Array, float], NDArray[np.bool_]]
    note: str
    several: bool = False


def anything(constants: Constants) -> str:
    """Refuse no constants."""
    return ""


@dataclass(frozen=True)
class Law:
    """A law of hyperelasticity.

    Attributes
    ----------
    name : str
        As a material table names it.
    units : mapping
        Unit of each constant by its name, "Pa" or "" for a plain number, in the order of the formula.
    shear_modulus : callable
        Initial shear modulus of the constants, in the unit of theirs.
    energy : OfInvariants or OfStretches
        The isochoric energy.
    fit : LinearFit or TermFit
        How constants are found from data.
    refusal : callable
        What is wrong with constants, in words; "" where they are a law's.
    lists : bool
        Whether each constant is a list, of one number a term.
    limit : str
        What a layer of it does from a stretch on at which it is not stable.
    """

    name: str
    units: Mapping[str, str]
    shear_modulus: Callable[[Constants], float]
    energy: OfInvariants | OfStretches
    fit: LinearFit | TermFit = LinearFit()
    refusal: Callable[[Constants], str] = anything
    lists: bool = False
    limit: str = "is unstable"


def number(constants: Constants, name: str) -> float:
    """Return a constant that is one number."""
    value = constants[name]
    return float(sum(value)) if isinstance(value, tuple) else float(value)
