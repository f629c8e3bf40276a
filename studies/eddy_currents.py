"""Where do eddy currents run in a plate close to a coil, and where is steel magnetised? Skin and rim, in two pictures.

By the three-dimensional model's cells, as they are: one coil of the published sensor under the middle of its plate. By
axisymmetric finite elements: the same coil under a steel disc, current and magnetisation M = (1 - 1 / mu_r) B / mu0.

    python studies/eddy_currents.py [--coarse] --output DIR
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from common.outputs import study_arguments
from matplotlib.figure import Figure
from scipy.constants import mu_0

from sits_mech.magnetics.axis.coaxial import coaxial_discs
from sits_mech.magnetics.axis_fem import axisymmetric_fem, solved_axis
from sits_mech.magnetics.space.classes import driven
from sits_mech.magnetics.space.divisions import prepared_near
from sits_mech.magnetics.space.rungs import LADDER, PlateRung
from sits_mech.magnetics.space.sources import Posed
from sits_mech.scene.sensor import load_sensor


def draw_currents(path: Path, rung: PlateRung) -> None:
    """Current density of a plate of 8 x 8 x 0.2 mm, 0.2 mm above a coil, 5 MHz: on its lower face, and in a section."""
    places = [f'coils.{name}.centre=["{x} mm", "0 mm"]' for name, x in (("C1", 0), ("C2", 30))]
    sensor = load_sensor("biorob2018", ['target.width="8 mm"', *places])
    gap, omega = 2e-4, 1e7 * np.pi
    plate = prepared_near(sensor.target, rung, (gap, 5e6, (5e-3, 5e-3), 1.5e-3))[0]
    cells = plate.cells
    driving = cells.means(cells.along(Posed(sensor.coils[:1], "rings", np.eye(3)[None], np.array([[0.0, 0.0, gap]]))))
    middles = (cells.levels[1:] + cells.levels[:-1]) / 2
    corners = cells.plan.nodes[cells.plan.cells].mean(axis=1)
    places = np.column_stack([np.repeat(corners, middles.size, axis=0), np.tile(middles, len(corners))])
    images = np.stack([[places * (*np.diag(g), s) for s in (1.0, -1.0)] for g in cells.plan.group])
    J = np.zeros(images.shape, dtype=complex)
    for part in plate.classes:
        answer = part.reduced.answer(part.reduced.induced(driven(part.problem, driving) * part.unit), omega)[0]
        found = part.reduced.coupling @ answer * part.unit
        moments = np.column_stack([m @ found for m in part.problem.loops.moments])
        J += omega * np.einsum("gsab,nb->gsna", part.problem.factors(), moments / part.problem.loops.volume[:, None])
    size = np.linalg.norm(np.abs(J), axis=-1)
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    below, cut = figure.subplots(1, 2)
    face = np.isclose(images[..., 2], images[..., 2].min())
    x, y, z = (images * 1e3).transpose(3, 0, 1, 2)
    shown = below.tripcolor(x[face], y[face], size[face], cmap="magma")
    figure.colorbar(shown, ax=below, label="|J| of 1 A in the coil [A/m2]")
    below.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title="lower face: a ring above the coil")
    line = np.isclose(np.abs(y), np.abs(y).min())
    shown = cut.scatter(x[line], z[line], c=np.log10(size[line]), s=10, cmap="magma")
    figure.colorbar(shown, ax=cut, label="log10 of |J| [A/m2]")
    cut.set(xlabel="x [mm]", ylabel="z from the middle [mm]", title="cells next to y = 0: most at the lower face")
    figure.savefig(path, dpi=150)


def draw_steel(path: Path, tolerance: float) -> None:
    """Draw current density and magnetisation in a section of a steel disc, 8 mm wide and 0.5 mm thick, at 50 kHz."""
    gap, radius, thickness, frequency, mu = 5e-4, 4e-3, 5e-4, 5e4, 150.0
    steel = f"conductivity=5e6, relative_permeability={mu}"
    target = f'target={{shape="disc", diameter={2 * radius}, thickness={thickness}, {steel}}}'
    places = 'coils.C1.centre=["0 mm", "0 mm"]', 'coils.C2.centre=["30 mm", "0 mm"]'
    sensor = load_sensor("biorob2018", [target, *places])
    alone = sensor.model_copy(update={"coils": sensor.coils[:1], "elastomer": None, "frequency": frequency})
    field = solved_axis(axisymmetric_fem(alone, tolerance), coaxial_discs(alone, gap), frequency).of_order_4
    k = np.flatnonzero((field.z >= gap) & (field.z <= gap + thickness))
    i = np.flatnonzero((field.r > 0.0) & (field.r <= radius))
    r, z = ((at[1:] + at[:-1]) / 2 for at in (field.r[i], field.z[k]))
    grid = np.stack(np.meshgrid(r, z, indexing="ij"))
    M = (1.0 - 1.0 / mu) / mu_0 * np.linalg.norm(np.abs(field.reaction(*grid.reshape(2, -1))), axis=1)
    J = 2 * np.pi * frequency * 5e6 * np.abs(field.u[np.ix_(i, k)])
    figure = Figure(figsize=(9.0, 4.4), layout="constrained")
    titles = "current: a ring at the lower face, and at the rim", "magnetisation: the skin carries the flux"
    shown = (field.r[i], field.z[k], J, "|J| of 1 A in the coil [A/m2]"), (r, z, M.reshape(grid[0].shape), "|M| [A/m]")
    for axes, title, (x, y, values, label) in zip(figure.subplots(2, 1), titles, shown, strict=True):
        drawn = axes.pcolormesh(1e3 * x, 1e3 * (y - gap), values.T, cmap="magma", shading="gouraud")
        figure.colorbar(drawn, ax=axes, label=label)
        axes.set(xlabel="r [mm]", ylabel="z from the face [mm]", title=title)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Draw the pictures."""
    coarse, folder = study_arguments(__doc__ or "")
    draw_steel(folder / "steel_disc.png", 1e-2 if coarse else 1e-3)
    draw_currents(folder / "eddy_currents.png", LADDER[0 if coarse else 2][1])


if __name__ == "__main__":
    main()
