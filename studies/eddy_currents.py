"""Where do eddy currents run in a plate close to a coil? The skin at its faces, the crowding at its rim, in a picture.

By the three-dimensional model's cells, as they are: one coil of the published sensor under the middle of its plate.

    python studies/eddy_currents.py [--coarse] --output DIR
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from common.outputs import study_arguments
from matplotlib.figure import Figure

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
        answer = part.reduced.answer(part.induced(driven(part.problem, driving) * part.unit), omega)[0]
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


def main() -> None:
    """Draw the picture."""
    coarse, folder = study_arguments(__doc__ or "")
    draw_currents(folder / "eddy_currents.png", LADDER[0 if coarse else 2][1])


if __name__ == "__main__":
    main()
