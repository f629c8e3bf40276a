"""Errors of a table's inductances at any load between its own: what all loads share, with signs, and the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from scipy.interpolate import NearestNDInterpolator, RegularGridInterpolator

from sits_mech.quantities import Array, tensor_grid


@dataclass(frozen=True)
class TableErrors:
    """Errors of a table's inductances over its loads, two deviations each, and what is not known of its silicone."""

    axes: tuple[Array, ...]  # values of each force that the table holds [N, N m]
    shared: Array  # (k, *sizes, n), parts with their signs, each common to all loads and coils [unit]
    own: Array  # (*sizes, n), what is left, of each coil for itself [unit]
    modulus: float = 0.0  # standard deviation of the logarithm of the silicone's modulus [-]

    def scaled(self, rate: Array) -> TableErrors:
        """Return the errors in another unit, `rate` (n,) of it a unit of each coil."""
        return replace(self, shared=self.shared * rate, own=self.own * np.abs(rate))

    def at(self, forces: Array) -> tuple[Array, Array]:
        """Return shared parts (k, m, n) and own parts (m, n) at forces (m, d), linear between the table's loads."""
        values = np.moveaxis(np.concatenate([self.shared, self.own[None]]), 0, -1)  # (*sizes, n, k + 1)
        inside = np.clip(forces, [axis[0] for axis in self.axes], [axis[-1] for axis in self.axes])
        found = np.moveaxis(RegularGridInterpolator(self.axes, values, bounds_error=False)(inside), -1, 0)
        return found[:-1], found[-1]

    def at_most(self, answers: Array, forces: Array) -> Array:
        """Return what all parts make of forces (m, d) together, by derivatives of the inverse (m, d, n) [N, N m]."""
        shared, own = self.at(forces)
        return np.asarray(np.abs(np.einsum("mdn,kmn->kmd", answers, shared)).sum(axis=0)
                          + np.einsum("mdn,mn->md", np.abs(answers), own))


def error_parts(table: xr.Dataset, forces: Sequence[str]) -> tuple[Array, Array, Array]:
    """Return errors of the inductances at a table's loads: shared (j, *sizes, n), own (k, *sizes, n), the rest.

    Shared and own parts have their signs; `table` has ``error_L`` and, where known, ``shared_L`` and ``alone_L``.
    """
    whole = table["error_L"].transpose(*forces, "coil").to_numpy()
    shared, alone = (
        table[name].transpose(dim, *forces, "coil").to_numpy() if name in table else np.zeros((0, *whole.shape))
        for name, dim in (("shared_L", "part"), ("alone_L", "cause"))
    )
    return shared, alone, np.maximum(whole - np.abs(shared).sum(axis=0) - np.abs(alone).sum(axis=0), 0.0)


def table_errors(table: xr.Dataset, forces: Sequence[str], modulus: float = 0.0) -> TableErrors:
    """Return the errors of a table with inductances over forces and coils; a failed load has those of the nearest."""
    shared, alone, rest = error_parts(table, forces)
    axes = tuple(table[name].to_numpy() for name in forces)
    values = np.moveaxis(np.concatenate([shared, alone, rest[None]]), 0, -1)
    good = np.isfinite(values).all(axis=(-2, -1))
    if not good.all():
        points = (tensor_grid(*axes) - [axis[0] for axis in axes]) / [np.ptp(axis) for axis in axes]
        values = NearestNDInterpolator(points[good], values[good])(points)
    found = np.moveaxis(values, -1, 0)
    order = [np.argsort(axis) for axis in axes]
    for k, rows in enumerate(order):
        found = np.take(found, rows, axis=k + 1)
    rising = tuple(axis[rows] for axis, rows in zip(axes, order, strict=True))
    return TableErrors(rising, found[:-1], found[-1], modulus)
