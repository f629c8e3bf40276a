"""Walls and columns: pads several times taller than thick, bent aside and pressed until they fall over, against beams.

A column bonded below, with a target that is free to move and turn on top, height L, section A and I, modulus E = 3 mu,
shear stiffness 5/6 mu A:

    d_h = F_x (L^3/(3 E I) + L/(G A)),    sink = F_z L/(E A),    P (1 + P/(G A)) = pi^2 E I/(4 L^2)

P the force under which it falls over (J. A. Haringx, Philips Res. Rep. 3 (1948) 401). A wall has a modulus between 3 mu
and 4 mu, as it is long: 3.5 mu is taken, and a seventh more allowed. Bonded ends are as stiff as if the column was up
to half its thickness shorter: that over its height is allowed, and the error that is said.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from extreme.rows import DONE, Row, measured
from extreme.solids import shaped

from sits_mech.mechanics.block import block_pad
from sits_mech.quantities import SolveFailed, SolveReport, Wrench
from sits_mech.scene.sensor import Sensor

MU = 3e4  # of the pads of solids.py [Pa]


@dataclass(frozen=True)
class Column:
    """A flush pad, width and length along x and y, height [mm]."""

    width: float
    length: float
    height: float

    @property
    def thin(self) -> float:
        """The smaller of its sides [mm]."""
        return min(self.width, self.length)

    @property
    def is_wall(self) -> bool:
        """Whether it is longer than thick."""
        return max(self.width, self.length) > 1.5 * self.thin

    @property
    def sensor(self) -> Sensor:
        """The scene."""
        size = f'width="{self.width} mm", length="{self.length} mm"'
        return shaped(f'shape="rectangle", {size}', size, self.height)

    @property
    def bending(self) -> tuple[float, float]:
        """E I across the thin side, and G A [N m2, N]."""
        return self.modulus * self.area * (1e-3 * self.thin) ** 2 / 12.0, 5.0 / 6.0 * MU * self.area

    @property
    def modulus(self) -> float:
        """E [Pa]."""
        return (3.5 if self.is_wall else 3.0) * MU

    @property
    def area(self) -> float:
        """Of its section [m2]."""
        return 1e-6 * self.width * self.length

    @property
    def carried(self) -> float:
        """The force under which it falls over [N]."""
        (EI, GA), L = self.bending, 1e-3 * self.height
        return 0.5 * GA * (np.sqrt(1.0 + np.pi**2 * EI / (GA * L**2)) - 1.0)

    def allowed(self, stated: float) -> float:
        """Return what a beam may be off, the error that is said included."""
        return 0.5 * self.thin / self.height + (1.0 / 7.0 if self.is_wall else 0.0) + stated


COLUMNS = {
    "column 4 x 4 x 16 mm": Column(4.0, 4.0, 16.0),
    "column 4 x 4 x 32 mm": Column(4.0, 4.0, 32.0),
    "wall 2 x 20 x 10 mm": Column(2.0, 20.0, 10.0),
    "wall 20 x 2 x 10 mm": Column(20.0, 2.0, 10.0),  # falls over in the direction that the symmetry of its load hides
}


def walls(coarse: bool) -> Iterator[Row]:
    """Yield the rows of columns and walls; the coarse ones: those of one column."""
    for name, column in list(COLUMNS.items())[: 1 if coarse else None]:
        if column.width == column.thin:
            yield measured("mechanics", f"3D {name}, bent", lambda column=column: bent(column), True)
        yield measured("mechanics", f"3D {name}, half its load", lambda column=column: pressed(column), True)
        yield measured("mechanics", f"3D {name}, twice its load", lambda column=column: fallen(column))


def bent(column: Column) -> Row:
    """Return how far a column's end moves aside, by a fiftieth of its height, beside a beam's."""
    (EI, GA), L = column.bending, 1e-3 * column.height
    found = block_pad(column.sensor, 1e-2).equilibrium(Wrench(F_x=0.02 * L / (L**3 / (3.0 * EI) + L / GA)))
    return _row(column, found.report, float(found.pose.d_h) / (0.02 * L) - 1.0)


def pressed(column: Column) -> Row:
    """Return how far a column sinks under half of what it carries, beside a bar's."""
    F, L = 0.5 * column.carried, 1e-3 * column.height
    found = block_pad(column.sensor, 1e-2).equilibrium(Wrench(F_z=F))
    return _row(column, found.report, (L - float(found.pose.d_v)) * column.modulus * column.area / (F * L) - 1.0)


def fallen(column: Column) -> Row:
    """Return the force that a column is said to carry beside a beam's, under twice as much."""
    try:
        found = block_pad(column.sensor, 1e-2).equilibrium(Wrench(F_z=2.0 * column.carried))
    except SolveFailed as failed:
        if failed.carried is None:
            return Row("", "", "no load is told", remark=str(failed))
        most, error = (one.F_z / column.carried for one in failed.carried)
        row = _row(column, failed.report, most - 1.0, error)
        return Row("", "", failed.report.status, row.min_J, row.violation, row.allowed, error, remark=str(failed))
    return Row("", "", "stands", remark=f"{found.pose}")


def _row(column: Column, report: SolveReport, away: float, stated: float | None = None) -> Row:
    """Row of what is off a beam by some share."""
    least = np.nan if report.min_J is None else report.min_J
    allowed = column.allowed(report.estimated_error if stated is None else stated)
    return Row("", "", DONE, least, abs(away), allowed, report.estimated_error, remark=f"{away:+.1%} beside a beam")
