"""Which constants of a law describe a tensile test? Least squares, held to constants that stay stable.

Uniaxial, incompressible, stretch ``lambda = 1 + engineering strain``, engineering stress P:

    P = 2 (lambda - lambda^-2) (dW/dI1 + dW/dI2 / lambda),   I1 = lambda^2 + 2/lambda,   I2 = 2 lambda + lambda^-2

    neo-hookean     dW/dI1 = mu/2,                                        dW/dI2 = 0
    mooney-rivlin   dW/dI1 = c10,                                         dW/dI2 = c01
    yeoh            dW/dI1 = c10 + 2 c20 (I1 - 3) + 3 c30 (I1 - 3)^2,     dW/dI2 = 0

P is linear in the constants, so the fit is a linear least-squares problem. Constants are accepted only where they are
stable: ``c30 >= 0``, a positive shear modulus, and, from the largest fitted stretch down to the stretch in compression
that has the same I1 as it, ``dP/d(lambda) > 0`` (in uniaxial loading) and ``dW/dI1 + lambda^2 dW/dI2 > 0`` (in shear).
Where the unconstrained answer is not, the least-squares answer under these linear inequalities is taken.

The data are one pull to failure: rate, history, softening and volume change are neglected, and strain taken from
crosshead travel includes what the grips let through.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import LinearConstraint, brentq, minimize

from sits_mech.quantities import Array

_LAWS: Mapping[str, tuple[str, ...]] = {
    "neo-hookean": ("shear_modulus",),
    "mooney-rivlin": ("c10", "c01"),
    "yeoh": ("c10", "c20", "c30"),
}
_STIFFNESS_LEFT = 1e-3  # smallest stiffness kept in the fitted range, relative to the initial one
_SECTION_UNITS = {"pa": 1.0, "kpa": 1e3, "mpa": 1e6}


@dataclass(frozen=True)
class TensileTest:
    """One uniaxial pull.

    Attributes
    ----------
    strain : ndarray, shape (n,)
        Engineering strain, increasing [-].
    stress : ndarray, shape (n,)
        Engineering stress [Pa].
    source : str
        File it came from.
    """

    strain: Array
    stress: Array
    source: str


@dataclass(frozen=True)
class Fit:
    """A law's constants fitted to a tensile test.

    Attributes
    ----------
    law : str
        "neo-hookean", "mooney-rivlin" or "yeoh".
    constants : dict
        By the names of `sits_mech.materials.LAWS` [Pa].
    max_strain : float
        Largest engineering strain used [-].
    rms : float
        Root mean square of what is left of the engineering stress [Pa].
    stable : bool
        Whether the constants pass the stability conditions over the fitted range, in tension and compression.
    source : str
        File the data came from.
    """

    law: str
    constants: dict[str, float]
    max_strain: float
    rms: float
    stable: bool
    source: str


def read_tensile(path: str | Path) -> TensileTest:
    """Read a tensile test by content: a header of any length, a row of column names, numbers.

    Parameters
    ----------
    path : str or Path
        Text separated by semicolons, tabs or commas, with the columns "Engineering Strain" and "Engineering Stress
        (MPa)"; the stress may be in Pa or kPa as well.

    Returns
    -------
    TensileTest
        Up to the largest stress, that is without the break, and with increasing strain.

    Raises
    ------
    ValueError
        When the file cannot be read, the columns are missing, or fewer than 5 rows hold numbers.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: must be a readable tensile test; got: {error}") from None
    for number, line in enumerate(lines):
        for separator in ";\t,":
            names = [name.strip().lower() for name in line.split(separator)]
            found = _columns(names)
            if found is not None:
                return _test(lines[number + 1 :], separator, found, str(path))
    raise ValueError(
        f'{path}: must have the columns "Engineering Strain" and "Engineering Stress (MPa)"; got none with these names'
    )


def _columns(names: list[str]) -> tuple[int, int, float] | None:
    """Return where strain and stress are, and the unit of stress [Pa]."""
    strain = [i for i, name in enumerate(names) if name.startswith("engineering strain")]
    stress = [(i, name) for i, name in enumerate(names) if name.startswith("engineering stress")]
    if not strain or not stress:
        return None
    unit = re.search(r"\(\s*([kM]?pa)\s*\)", stress[0][1], flags=re.IGNORECASE)
    return (strain[0], stress[0][0], _SECTION_UNITS[unit[1]]) if unit else None


def _test(lines: list[str], separator: str, columns: tuple[int, int, float], source: str) -> TensileTest:
    """Return the rows that hold numbers, up to the largest stress."""
    at_strain, at_stress, unit = columns
    rows = []
    for line in lines:
        cells = line.split(separator)
        try:
            rows.append((float(cells[at_strain]), float(cells[at_stress]) * unit))
        except (ValueError, IndexError):
            continue
    data = np.array([row for row in rows if np.isfinite(row).all()]).reshape(-1, 2)
    data = data[: int(np.argmax(data[:, 1])) + 1] if len(data) else data
    rising = data[:, 0] > np.maximum.accumulate(np.r_[-1.0, data[:-1, 0]]) if len(data) else np.zeros(0, dtype=bool)
    if np.count_nonzero(rising) < 5:
        raise ValueError(f"{source}: must hold at least 5 rows of rising strain; got {np.count_nonzero(rising)}")
    return TensileTest(data[rising, 0], data[rising, 1], source)


def _terms(law: str, stretch: Array) -> tuple[Array, Array]:
    """Return dW/dI1 and dW/dI2 per unit of each constant, shape (n, constants)."""
    one, zero = np.ones_like(stretch), np.zeros_like(stretch)
    excess = stretch**2 + 2.0 / stretch - 3.0
    if law == "neo-hookean":
        return 0.5 * one[:, None], zero[:, None]
    if law == "mooney-rivlin":
        return np.stack([one, zero], 1), np.stack([zero, one], 1)
    return np.stack([one, 2.0 * excess, 3.0 * excess**2], 1), np.zeros((stretch.size, 3))


def _stress_terms(law: str, stretch: Array) -> Array:
    """Return the engineering stress per unit of each constant, shape (n, constants)."""
    first, second = _terms(law, stretch)
    stress: Array = 2.0 * (stretch - stretch**-2)[:, None] * (first + second / stretch[:, None])
    return stress


def engineering_stress(law: str, constants: Mapping[str, float], strain: Array) -> Array:
    """Return the uniaxial engineering stress of an incompressible law.

    Parameters
    ----------
    law : str
        "neo-hookean", "mooney-rivlin" or "yeoh".
    constants : mapping
        By the names of `sits_mech.materials.LAWS` [Pa].
    strain : ndarray, shape (n,)
        Engineering strain, above -1 [-].

    Returns
    -------
    ndarray, shape (n,)
        [Pa].

    Raises
    ------
    ValueError
        When the law is none of the three.
    """
    stress: Array = _stress_terms(law, 1.0 + strain) @ np.array([constants[name] for name in _names(law)])
    return stress


def _names(law: str) -> tuple[str, ...]:
    """Return the constants of a law that can be fitted."""
    if law not in _LAWS:
        raise ValueError(f'law: must be one of {", ".join(_LAWS)}; got "{law}"')
    return _LAWS[law]


def _conditions(law: str, max_stretch: float) -> Array:
    """Return rows whose products with the constants must not be negative: stiffness less the share of it to be kept."""
    excess = max_stretch**2 + 2.0 / max_stretch - 3.0
    compressed = brentq(lambda stretch: stretch**2 + 2.0 / stretch - 3.0 - excess, 1e-6, 1.0)
    stretch = np.geomspace(compressed, max_stretch, 101)
    step = 1e-6
    slope = (_stress_terms(law, stretch * (1 + step)) - _stress_terms(law, stretch * (1 - step))) / (2 * step)
    first, second = _terms(law, stretch)
    at_rest = sum(_terms(law, np.ones(1)))
    rows = np.vstack([slope / (6.0 * stretch[:, None]), first + second * stretch[:, None] ** 2])
    rows = rows - _STIFFNESS_LEFT * at_rest
    return np.vstack([rows, np.eye(3)[2:]]) if law == "yeoh" else rows


def fit_law(test: TensileTest, law: str, max_strain: float = 1.0) -> Fit:
    """Fit a law's constants to the part of a tensile test up to a strain.

    Parameters
    ----------
    test : TensileTest
        The data.
    law : str
        "neo-hookean", "mooney-rivlin" or "yeoh".
    max_strain : float
        Largest engineering strain to use [-].

    Returns
    -------
    Fit
        Stable over the fitted range.

    Raises
    ------
    ValueError
        When the law is none of the three, or fewer than 5 points lie below `max_strain`.
    """
    names = _names(law)
    used = (test.strain > 0.0) & (test.strain <= max_strain)
    if np.count_nonzero(used) < 5:
        raise ValueError(
            f"max_strain: must leave at least 5 points of {test.source}, which reaches {test.strain[-1]:.3g}; "
            f"got {max_strain:g} with {np.count_nonzero(used)} points"
        )
    strain, stress = test.strain[used], test.stress[used]
    matrix, weight = _stress_terms(law, 1.0 + strain), _weights(strain)
    scale = float(stress[-1] / strain[-1])
    if not scale > 0.0:
        raise ValueError(f"{test.source}: must be a pull with positive stress; got {stress[-1]:g} Pa at its end")
    conditions = _conditions(law, 1.0 + float(strain[-1]))
    answer = scale * _least_squares(matrix * weight[:, None], stress * weight / scale, conditions)
    return Fit(
        law=law,
        constants=dict(zip(names, (float(value) for value in answer), strict=True)),
        max_strain=float(strain[-1]),
        rms=float(np.sqrt(np.average((matrix @ answer - stress) ** 2, weights=weight**2))),
        stable=bool((conditions @ answer >= -1e-9 * scale).all()),
        source=Path(test.source).name,
    )


def _weights(strain: Array) -> Array:
    """Return the square roots of each point's share of the strain range, so that the sampling rate plays no part."""
    edges: Array = np.concatenate([np.zeros(1), 0.5 * (strain[1:] + strain[:-1]), strain[-1:]])
    weights: Array = np.sqrt(np.diff(edges) / strain[-1])
    return weights


def _least_squares(matrix: Array, right: Array, conditions: Array) -> Array:
    """Return the least-squares answer under ``conditions @ answer >= 0`` (a small convex programme)."""
    free: Array = np.asarray(np.linalg.lstsq(matrix, right)[0], dtype=np.float64)
    if (conditions @ free >= 0.0).all():
        return free
    size = np.linalg.norm(matrix, axis=0)  # columns of one size: c30 multiplies far larger numbers than c10
    scaled, limits = matrix / size, conditions / size
    limits = limits / np.linalg.norm(limits, axis=1)[:, None]

    def left(x: Array) -> tuple[float, Array]:
        """Return half the squared residual, and its gradient."""
        residual = scaled @ x - right
        return 0.5 * float(residual @ residual), scaled.T @ residual

    start = np.zeros(matrix.shape[1])
    start[0] = float(scaled[:, 0] @ right)
    inside = LinearConstraint(limits, 0.0, np.inf)
    answer = minimize(left, start, jac=True, method="SLSQP", constraints=inside, options={"ftol": 1e-15})
    constants: Array = answer.x / size
    return constants
