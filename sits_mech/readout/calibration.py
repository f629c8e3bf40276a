"""Map forces to inductances by a smooth map of a table, and back where there is exactly one answer.

    forward    L(F), a `SmoothMap` of each coil's inductance over the forces
    inverse    minimise sum_c (w_c (L_c(F) - L_c))^2, w one over the coil's noise (`inversion`)
    domain     where det(P dL/dF) keeps its sign, P the projection onto the directions in which L varies most (as many
               as forces; P = 1 for as many coils), inside the hull of the loads that the table holds

A map whose determinant keeps its sign over a box and whose image of the box's edge does not cross itself is one to one.
Where either fails, every reading is tried against the other parts of the box; one that more than one force explains is
"ambiguous" and has no answer. Numbers only: measured tables go the same way as computed ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sits_mech.arguments import real_numbers
from sits_mech.maps.domain import Domain, domain_of, hull_of
from sits_mech.maps.surrogate import SmoothMap, fit_map
from sits_mech.quantities import WRENCH, Array, Wrench, shown_unit, tensor_grid
from sits_mech.readout.inversion import MARGIN, Inverse, InverseSearch
from sits_mech.readout.inversion import OK as OK
from sits_mech.readout.inversion import OUTSIDE as OUTSIDE
from sits_mech.readout.loads import answered, check_enough, several, varied
from sits_mech.readout.table_errors import TableErrors


@dataclass(frozen=True)
class Calibration:
    """Forces to inductances and back.

    Attributes
    ----------
    forces : tuple of str
        What was varied, such as ("F_x", "F_z").
    coils : tuple of str
        Names, in the order of the inductances.
    unit : str
        Of the inductances, "H" or "H/m".
    L0 : ndarray, shape (n,)
        Inductances without target [unit].
    map : SmoothMap
        Forces to inductances.
    weights : ndarray, shape (n,)
        Of each coil in the inverse, one over its noise [1/unit].
    full_scale : ndarray, shape (n,)
        Range of each inductance over the table [unit].
    domain : Domain
        Where the inverse holds.
    seeds : tuple of ndarray
        Starting points of Newton's method, in scaled forces, an array for each part of the domain, the valid first.
    noise, model_error : ndarray, shape (n,), optional
        Of each inductance: standard deviation of a reading, and estimated error of the table itself [unit].
    table_errors : TableErrors, optional
        The same over the loads, with what the loads share.
    in_codes : callable, optional
        Makes the calibration of the same loads in codes of a converter.
    """

    forces: tuple[str, ...]
    coils: tuple[str, ...]
    unit: str
    L0: Array
    map: SmoothMap
    weights: Array
    full_scale: Array
    domain: Domain
    seeds: tuple[Array, ...] = field(repr=False)
    noise: Array | None = None
    model_error: Array | None = None
    table_errors: TableErrors | None = field(default=None, repr=False)
    in_codes: Callable[[], Calibration] | None = field(default=None, repr=False)

    @property
    def low(self) -> Array:
        """Least force of the table in each direction [N, N m]."""
        return self.map.low

    @property
    def high(self) -> Array:
        """Greatest force of the table in each direction [N, N m]."""
        return self.map.high

    @property
    def rest(self) -> Array:
        """The load of the table nearest to none [N, N m]."""
        return np.asarray(np.clip(0.0, self.low, self.high))

    @property
    def middle(self) -> Array:
        """The load in the middle of the table [N, N m]."""
        return 0.5 * (self.low + self.high)

    @property
    def error(self) -> float:
        """Largest error of predicting a load that is left out, over the coil's full scale."""
        return float(np.max(self.map.error / self.full_scale))

    def forward(
        self, forces: ArrayLike | Wrench | None = None, /, *, beyond: bool = False, **named: ArrayLike
    ) -> Array:
        """Return the inductances, shape (..., n) [unit], at forces.

        Parameters
        ----------
        forces : array_like, shape (..., d), or Wrench, optional
            Loads in the order of `forces` [N, N m], or one of them.
        beyond : bool
            Answer loads beyond the table too, where a smooth map knows nothing.
        **named : array_like
            In place of an array: each force by its name, of shapes that broadcast [N, N m].

        Raises
        ------
        ValueError
            When a force is missing, unknown or not a number, or lies beyond the table by more than noise at rest does.

        Examples
        --------
        >>> known.forward(F_x=0.1, F_z=0.4)  # or known.forward(sm.Wrench(F_x=0.1, F_z=0.4))
        """
        return self.map.at(self._points(forces, named, beyond))

    def slopes(self, forces: ArrayLike | Wrench | None = None, /, *, beyond: bool = False, **named: ArrayLike) -> Array:
        """Return the derivatives of the inductances by the forces, shape (..., n, d) [unit / N], as `forward`."""
        return self.map.slopes(self._points(forces, named, beyond))

    def codes(self, forces: ArrayLike | Wrench | None = None, /, *, beyond: bool = False, **named: ArrayLike) -> Array:
        """Return what the converter shows at forces, idle coils and leads included, as `forward`.

        Returns
        -------
        ndarray, shape (..., n)
            Codes, not rounded: a part gives the integer below or above.

        Raises
        ------
        ValueError
            As `forward`; when there is no converter, or the calibration is of inductances alone.
        """
        return self.code_calibration.map.at(self._points(forces, named, beyond))

    @cached_property
    def code_calibration(self) -> Calibration:
        """Calibration of the same loads in codes of the converter; made once."""
        if self.in_codes is None:
            raise ValueError("codes: must come from a sensor and its table; this calibration has inductances alone")
        return self.in_codes()

    def _points(self, forces: ArrayLike | Wrench | None, named: Mapping[str, ArrayLike], beyond: bool) -> Array:
        """Return forces as one table (..., d), each within the range of the table unless `beyond`."""
        if isinstance(forces, Wrench):
            load = dict(zip(WRENCH, forces.components, strict=True))
            named = {name: value for name, value in load.items() if value != 0.0 or name in self.forces} | dict(named)
        elif forces is not None:
            points = real_numbers("forces", forces)
            if named or points.shape[-1:] != (len(self.forces),):
                shape = f"a table whose last axis holds {', '.join(self.forces)}, or each by its name"
                raise ValueError(f"forces: must be {shape}; got shape {points.shape}")
            named = dict(zip(self.forces, np.moveaxis(points, -1, 0), strict=True))
        if set(named) != set(self.forces):
            raise ValueError(f"forces: must be {', '.join(self.forces)}; got {', '.join(named) or 'none'}")
        points = np.stack(np.broadcast_arrays(*(real_numbers(name, named[name]) for name in self.forces)), -1)
        self._check_within(points, np.inf if beyond else 1.0 + MARGIN)
        return points

    def _check_within(self, points: Array, most: float) -> None:
        """Refuse forces (..., d) that are no numbers or, scaled, beyond `most`."""
        out = ~(np.abs(self.map.scaled(points)) <= most)
        if out.any():
            k = int(np.argwhere(out)[0, -1])
            name, unit = self.forces[k], shown_unit(self.forces[k])
            value = points[..., k][out[..., k]].flat[0]
            span = f"from {self.low[k]:.4g} to {self.high[k]:.4g} {unit}, as the table does"
            raise ValueError(f"{name}: must lie {span}; got {value:.4g} {unit}")

    def force_error(self, forces: ArrayLike, L_error: ArrayLike) -> Array:
        """Return how far each force is off, at most, when each inductance is off by its error, of either sign.

        Parameters
        ----------
        forces : array_like, shape (..., d)
            Where [N, N m].
        L_error : array_like, shape (n,) or (..., n)
            Of the inductances, of all loads or of each [unit].

        Returns
        -------
        ndarray, shape (..., d)
        """
        wrong = np.asarray(L_error, dtype=float)
        spread = np.abs(self.answers(forces)) @ wrong.reshape(-1, wrong.shape[-1], 1)
        return np.asarray(spread.reshape(np.shape(forces)))

    def force_noise(self, forces: ArrayLike, L_noise: ArrayLike) -> Array:
        """Return the standard deviation of each force for independent noise of the inductances; as `force_error`."""
        spread = np.sqrt(self.answers(forces) ** 2 @ np.asarray(L_noise, dtype=float) ** 2)
        return np.asarray(spread.reshape(np.shape(forces)))

    def answers(self, forces: ArrayLike) -> Array:
        """Return the derivatives of the inverse by the inductances (m, d, n) at forces of m points [N / unit]."""
        answers = self.search.answers(self.map.scaled(forces).reshape(-1, len(self.low)))
        return answers * self._half[:, None]

    @cached_property
    def search(self) -> InverseSearch:
        """Search for the forces of readings."""
        return InverseSearch(self.map, self.domain, self.weights, self.full_scale, self.seeds)

    def inverse(self, L: ArrayLike) -> Inverse:
        """Return the forces that show inductances.

        Parameters
        ----------
        L : array_like, shape (..., n)
            Inductance of each coil [unit]; of what is not finite there is no solution.

        Returns
        -------
        Inverse
            Of shape (...).

        Raises
        ------
        ValueError
            When the number of coils is not the table's, or is less than the number of forces.
        """
        L, n, d = real_numbers("L", L), len(self.coils), len(self.forces)
        if L.ndim == 0 or L.shape[-1] != n:
            raise ValueError(f"L: must be of {n} coils ({', '.join(self.coils)}); got shape {L.shape}")
        check_resolved(self)
        unknown = np.full(n, np.nan)
        spreads = [self.map.error, *(unknown if size is None else size for size in (self.model_error, self.noise))]
        finite = np.where(np.isfinite(L), L, np.nan).reshape(-1, n)
        x, residual, status, errors = self.search.solved(finite, np.array(spreads))
        wrong, shape = (status != OK)[:, None], L.shape[:-1]
        forces = np.where(wrong, np.nan, self.map.unscaled(x)).reshape(*shape, d)
        by_map, by_model, by_noise = (np.where(wrong, np.nan, part * self._half).reshape(*shape, d) for part in errors)
        return Inverse(forces, status.reshape(shape), by_map, by_model, by_noise, residual.reshape(shape))

    @property
    def _half(self) -> Array:
        """Half the range of each force [N, N m]."""
        return 0.5 * (self.high - self.low)

    @cached_property
    def condition(self) -> float:
        """Condition number of the inductances by the forces, in coils' weights and ranges of the forces, mid-table."""
        slopes = self.slopes(self.middle) * self.weights[:, None] * self._half
        return float(np.linalg.cond(slopes))

    @cached_property
    def unresolved(self) -> tuple[str, ...]:
        """Forces that the coils do not resolve: errors exceed their range at most loads, or near zero load."""
        if len(self.coils) < len(self.forces):
            return self.forces
        off = np.where(np.isfinite(self.map.error), self.map.error, 0.0)
        off = off + (0.0 if self.model_error is None else self.model_error)
        least = self.map.scaled(self.rest)
        whole, here = (self.search.lost(x, off) for x in (np.concatenate(self.seeds), least[None]))
        none = whole | (here & (np.abs(least) < 1.0 - 1e-9))
        return tuple(name for name, unseen in zip(self.forces, none, strict=True) if unseen)

    @cached_property
    def share(self) -> float:
        """Share of the loads that have an inverse: none where a force is not resolved [-]."""
        return 0.0 if self.unresolved else self.domain.share

    @cached_property
    def no_inverse(self) -> tuple[str, ...]:
        """Reason, or regions, without an inverse, in words."""
        why = f"{', '.join(self.unresolved)}: errors of map and table are twice the range"
        return (why,) if self.unresolved and len(self.coils) >= len(self.forces) else self.domain.regions


def calibration(
    data: xr.Dataset, L0: Sequence[float] | None = None, noise: Sequence[float] | None = None
) -> Calibration:
    """Return the calibration that a table holds, in henry where `L0` is given or the table is in henry.

    `data` has L over (forces, coil, coil_2) and L0, as from `calibrate`, or L over (forces, coil); forces are the
    components of the load with more than one value. Loads without an answer, by ``status`` or L, are left out. `L0` [H]
    is for tables per metre of depth: the table's relative change is taken of it. `noise` of each coil weighs, equal by
    default. ValueError when there is no force with more than one value, or too few loads.
    """
    names, points, values = own_values(data, "L")
    table_L0 = _own(data["L0"]).to_numpy() if "L0" in data else np.full(data.sizes["coil"], np.nan)
    unit = str(data.attrs.get("unit_L", "H"))
    if L0 is not None:
        unit, values, table_L0 = "H", values / table_L0 * np.asarray(L0), np.asarray(L0, dtype=float)
    coils = tuple(str(name) for name in data["coil"].to_numpy())
    return calibration_of(points, values, forces=names, coils=coils, free=(unit, table_L0), noise=noise)


def own_values(data: xr.Dataset, name: str) -> tuple[tuple[str, ...], Array, Array]:
    """Return forces of more than one value, loads with an answer (m, d), and a coil's own L or R there (m, n)."""
    names = several(data)
    if not names:
        raise ValueError("table: must hold at least two values of a force; got one load")
    data = data.isel({each: 0 for each in varied(data) if each not in names})
    own = _own(data[name]).transpose(*names, "coil").to_numpy()
    good = np.isfinite(own).all(axis=-1)
    if "status" in data:
        good &= answered(data).transpose(*names).to_numpy()
    return names, tensor_grid(*(data[each].to_numpy() for each in names))[good], own[good]


def _own(matrix: xr.DataArray) -> xr.DataArray:
    """Return the diagonal of a coil-by-coil matrix; what is none stays as it is."""
    if "coil_2" not in matrix.dims:
        return matrix
    other = [dim for dim in matrix.dims if dim not in ("coil", "coil_2")]
    values = np.diagonal(matrix.transpose(*other, "coil", "coil_2").to_numpy(), axis1=-2, axis2=-1)
    return xr.DataArray(values, dims=[*other, "coil"])


def calibration_of(
    points: ArrayLike, L: ArrayLike, *, forces: Sequence[str], coils: Sequence[str],
    free: tuple[str, ArrayLike], noise: Sequence[float] | None = None,
) -> Calibration:
    """Return the calibration through scattered loads (m, d) [N, N m] with the inductances L (m, n).

    `free` has the unit of the inductances and their values without target; `noise` of each coil weighs, equal by
    default. ValueError when loads are too few, values not finite, or an inductance does not change.
    """
    L = np.asarray(L, dtype=float)
    found = fit_map(forces, points, L)
    full_scale = np.ptp(L, axis=0)
    if not np.all(full_scale > 0.0):
        raise ValueError(f"L: must change with the load; coil {coils[int(np.argmin(full_scale))]} does not")
    weights = np.full(len(coils), 1.0 / full_scale.max()) if noise is None else 1.0 / np.asarray(noise, dtype=float)
    domain, seeds = domain_of(found, weights, hull_of(found.scaled(points)))
    unit, L0, size = *free, None if noise is None else np.asarray(noise, dtype=float)
    return Calibration(
        tuple(forces), tuple(coils), unit, np.asarray(L0, dtype=float), found, weights, full_scale, domain, seeds, size
    )


def check_resolved(cal: Calibration) -> None:
    """Refuse a calibration whose coils are fewer than its forces, or do not resolve one of them."""
    check_enough(cal.coils, cal.forces)
    if cal.unresolved:
        coils, names, forces = (", ".join(words) for words in (cal.coils, cal.unresolved, cal.forces))
        raise ValueError(
            f"coils: {coils} do not resolve {names} of {forces}: condition number {cal.condition:.2g}, errors of twice "
            "the range; leave it out, or add coils that it changes"
        )
