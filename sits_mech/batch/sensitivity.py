"""Compute Sobol' indices from the table of a sweep with Saltelli's design: which key moves a quantity, and how much.

    S = Var(E(f | x)) / Var(f)        first order: what a key moves alone
    T = E(Var(f | all but x)) / Var(f)    total: alone and with others

by `scipy.stats.sobol_indices` (A. Saltelli et al., Computer Physics Communications 181 (2010) 259), of keys that are
independent and evenly spread over their ranges. Intervals of 95 % are percentiles over rows that are drawn anew; they
hold for the number of samples, not for the errors of the cases. Indices of a quantity that nothing moves are zero.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import sobol_indices

from sits_mech.inputs import unknown
from sits_mech.quantities import Array
from sits_mech.units import SceneError

if TYPE_CHECKING:
    import xarray as xr

_DRAWS = 999  # of the bootstrap; percentiles take some 1000 (B. Efron, R. Tibshirani, An Introduction to the Bootstrap)


@dataclass(frozen=True)
class Sensitivity:
    """Indices of a quantity, or of each of its parts; shapes (parts, keys), intervals (2, parts, keys)."""

    of: str
    parts: tuple[str, ...]  # such as "C1", or "" of a number
    keys: tuple[str, ...]
    first_order: Array
    total_order: Array
    first_interval: Array
    total_interval: Array
    design_rows: tuple[int, int]  # of the design: used, and asked


def sensitivity(data: xr.Dataset, of: str) -> Sensitivity:
    """Return the indices of a variable of a sweep's table.

    A row of the design with a case that has no number is left out, and then more, to the next lower power of two.
    Raise SceneError for another design, a variable that is none or no number, or too few rows.
    """
    if data.attrs.get("combine") != "saltelli":
        came = data.attrs.get("combine", "no sweep")
        raise SceneError(f'sensitivity: must be of a study with combine = "saltelli"; got {came}')
    numbers = [str(name) for name, item in data.data_vars.items() if item.dtype.kind == "f" and "case" in item.dims]
    if of not in numbers:
        raise SceneError(f"--of {unknown(of, numbers)}")
    inner = [str(name) for name in data[of].dims if name != "case"]
    parts = tuple(map(", ".join, product(*(map(str, data[name].to_numpy().tolist()) for name in inner))))
    derived = json.loads(data.attrs.get("derive", "{}"))
    keys = tuple(str(name) for name in data["status"].coords if name not in derived)
    asked = int(data.attrs["samples"])
    values = data[of].transpose(*inner, "case").to_numpy().reshape(len(parts), len(keys) + 2, asked)
    values = values[..., np.isfinite(values).all(axis=(0, 1))]
    used = 1 << values.shape[-1].bit_length() >> 1  # the highest power of two that is there, or none
    if used < 2:
        raise SceneError(f"--of {of}: must have numbers in two rows of the design at least; got {used} of {asked}")
    values = values[..., :used]
    draw = np.random.default_rng(0)
    drawn = np.array([_indices(values[..., draw.integers(used, size=used)]) for _ in range(_DRAWS)])
    (first, total), spans = _indices(values), np.percentile(drawn, [2.5, 97.5], axis=0)
    return Sensitivity(of, parts, keys, first, total, spans[:, 0], spans[:, 1], (used, asked))


def _indices(values: Array) -> Array:
    """Return first-order and total indices (2, parts, keys) of values at A, B and AB (parts, keys + 2, rows)."""
    a, b, ab = values[:, 0], values[:, 1], np.moveaxis(values[:, 2:], 1, 0)
    found = sobol_indices(func={"f_A": a, "f_B": b, "f_AB": ab}, n=values.shape[-1])
    shape = (len(values), -1)
    return np.array([np.reshape(found.first_order, shape), np.reshape(found.total_order, shape)])
