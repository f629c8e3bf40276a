"""Left for later by the published study: target thickness, coil layers, nearby metal, curved substrate.

The scene of D. Jones et al., BioRob 2018 (doi:10.1109/BIOROB.2018.8487666), one key changed at a time. Each line gives
the two signals' ranges in percent of its own L0: difference over d_h from -5 to 5 mm at 2 mm, sum from 2 to 1.2 mm.
Planar integral model, and planar FEM where the substrate is curved; inductances per metre, relative to their value
without target, the fixed metal in place.

Run ``python studies/paper_outlook.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import numpy as np
from common.outputs import study_arguments, write_rows

from sits_mech.chain.models import magnetic_model
from sits_mech.quantities import Pose
from sits_mech.report.pictures.curves import new_figure, save_figure
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
PLATE = (
    'conductors=[{{name="metal", material="copper", shape="rectangle", centre=["0 mm", "{} mm"], width="18 mm", '
    'length="18 mm", thickness="0.5 mm"}}]'
)
CHANGES = {
    "target thickness": {
        f"{t} mm": [f'target.thickness="{t} mm"'] for t in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
    },
    "coil layers": {
        f"{n}": [f"coils.{coil}.layers={n}" for coil in ("C1", "C2")] for n in (1, 2, 3, 4, 6)
    },
    "copper plate below at": {
        f"{-z} mm": [PLATE.format(z)] for z in (-0.8, -1.0, -2.0, -5.0, -10.0)
    },
    "substrate radius": {
        **{f"{r} mm": [f'substrate_radius="{r} mm"'] for r in (15, 25, 50, 100)}, "flat": [],
    },
}  # fmt: skip


def ranges(changes: list[str], tolerance: float) -> tuple[float, float, str, float]:
    """Return the shear and the normal range [%] of a changed scene, the model that gave them, and its error."""
    sensor = load_sensor("biorob2018", changes)
    name = "planar" if sensor.substrate_radius is None else "auto"  # in section like the paper's, metal as well
    model, choice = magnetic_model(sensor, name, tolerance)
    pose = Pose(np.array([0.0, 2.5, 5.0, 0.0]) * MM, np.array([2.0, 2.0, 2.0, 1.2]) * MM, np.zeros(4))
    found = model.impedance(pose, sensor.frequency)
    percent = 100.0 * np.diagonal(found.L, axis1=-2, axis2=-1) / np.diagonal(found.L0)
    difference, total = percent[:, 0] - percent[:, 1], percent.sum(axis=-1)
    return (
        float(2 * np.max(np.abs(difference[:3]))), float(abs(total[0] - total[3])), choice.name,
        found.report.estimated_error,
    )  # fmt: skip


def main() -> None:
    """Change one thing at a time, tabulate and draw."""
    coarse, folder = study_arguments(__doc__ or "")
    rows = []
    with new_figure(height=1.1, columns=2, rows=2) as (figure, axes):
        for (what, changes), spot in zip(CHANGES.items(), axes, strict=True):
            kept = dict(list(changes.items())[:: 2 if coarse else 1])
            found = {name: ranges(keys, 1e-2 if coarse else 1e-3) for name, keys in kept.items()}
            for name, (shear, normal, model, error) in found.items():
                rows.append(
                    {"changed": what, "to": name, "shear range [%]": shear, "normal range [%]": normal, "model": model,
                     "estimated error": error}
                )  # fmt: skip
            spot.plot(list(found), [values[0] for values in found.values()], "o-", label="shear")
            spot.plot(list(found), [values[1] for values in found.values()], "s-", label="normal")
            spot.set_xlabel(what)
            spot.tick_params(axis="x", rotation=60, labelsize=6)
        axes[0].legend()
        axes[0].set_ylabel("range [%]")
        axes[2].set_ylabel("range [%]")
        save_figure(figure, folder / "paper_outlook.png")
    print(write_rows(rows, folder / "paper_outlook.csv"))


if __name__ == "__main__":
    main()
