"""Left for later by the published study: nearby metal, arrays, the target's thickness and material, layers, curvature.

`biorob2018-w15`, the width that D. Jones et al., BioRob 2018 (doi:10.1109/BIOROB.2018.8487666) find best, one thing
changed at a time; each in space (`sheets`), a curved substrate in section (`planar-fem`, against the flat one there).
The sensor is calibrated as it is; a changed one is moved to where the same loads bring the target, and read through
that calibration as a tared one would be,

    L = L0 (p(rest) + p'(load) - p'(rest)),    p, p' = L / L0 of the calibrated and the changed sensor,

so that the forces misread are those of a change that the calibration does not know. A coil layer or material is chosen,
not unknown: beside it stands what 1e-5 of L0 in both coils, as noise, is of each force by the changed sensor's slopes.
Metal nearby is also read as it comes, untared: L = L0 p'(load). "outside" is a reading that belongs to no load of the
table; "resolved to" is the changed model's own error as a force, dotted in the pictures: what is less is not resolved.
The effect of metal nearby is the difference to the sensor with metal 40 mm away, whose target is divided alike: there
only the model's relative error of that effect counts.

Run ``python studies/paper_outlook.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common.accuracy import forget
from common.outputs import study_arguments, write_rows

from sits_mech.analysis.readings.bench import sensor_calibration
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.models import magnetic_model
from sits_mech.quantities import POSE, Array, Pose
from sits_mech.readout.calibration import Calibration
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import Sensor, load_sensor

SENSOR = "biorob2018-w15"
SHEAR, NORMAL = 1.0, 4.0  # [N]
LOAD = (0.5, 2.0)  # F_x, F_z [N]
SMALL = 1e-5  # of L0: noise of a reading
PLATE = (
    'conductors=[{{name="metal", material="copper", shape="rectangle", centre=["{x} mm", "{z} mm"], width="18 mm", '
    'length="18 mm", thickness="0.5 mm"}}]'
)
SCREW = (
    'conductors=[{{name="metal", material="{metal}", shape="disc", diameter="6 mm", thickness="2 mm", '
    'centre=["{x} mm", "1.5 mm"]}}]'
)
NEIGHBOUR = (  # the target of a second sensor of an array, at the pitch
    'conductors=[{{name="next target", material="copper", shape="rectangle", centre=["{x} mm", "2.11 mm"], '
    'width="15 mm", length="8 mm", thickness="0.2 mm"}}]'
)
CHANGES = {
    "copper plate below [mm]": {f"{z}": [PLATE.format(x=0, z=-z)] for z in (20, 10, 5, 2)},
    "brass screw beside, its centre at [mm]": {f"{x}": [SCREW.format(x=x, metal="brass")] for x in (22, 16, 14)},
    "pitch of an array [mm]": {f"{x}": [NEIGHBOUR.format(x=x)] for x in (24, 20, 18)},
    "target thickness [mm]": {f"{t}": [f'target.thickness="{t} mm"'] for t in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)},
    "target material": {
        **{m: [f'target.material="{m}"'] for m in ("copper", "aluminium", "brass")},
        "stainless": ['target.conductivity="1.4 MS/m"'],  # 0.72 uohm m, austenitic steel (AISI 304)
    },
    "coil layers": {f"{n}": [f"coils.{coil}.layers={n}" for coil in ("C1", "C2")] for n in (1, 2, 3, 4, 6)},
    "substrate radius [mm] (section)": {
        **{f"{r}": [f'substrate_radius="{r} mm"'] for r in (25, 50, 100, 200)}, "flat": [],
    },
}
COARSE = ("copper plate below [mm]", "target thickness [mm]", "substrate radius [mm] (section)")
NOISES = tuple(CHANGES)[:3]  # what comes after the calibration
FAR = [NEIGHBOUR.format(x=40)]  # changes L by less than 1e-7: metal near is told from the same division of the target


@dataclass(frozen=True)
class Base:
    """The sensor as it is.

    Attributes
    ----------
    known : Calibration
        In henry.
    poses : ndarray, shape (6, 6)
        At rest, under the load, and with more and less of each force.
    steps : ndarray, shape (2,)
        How much more or less [N].
    L0 : ndarray, shape (2,)
        Of the table [H].
    share : dict
        By model, or "far" with metal far away at the first two poses: L over L0, shape (6, 2); L0, shape (2,); and the
        estimated error of the first.
    """

    known: Calibration
    poses: Array
    steps: Array
    L0: Array
    share: dict[str, tuple[Array, Array, Array]]


def base(tolerance: float, coarse: bool) -> Base:
    """Calibrate the sensor and find where the load brings its target."""
    sensor = load_sensor(SENSOR)
    F_x, F_z = np.linspace(-SHEAR, SHEAR, 5), np.linspace(0.0, NORMAL, 5)
    data = calibrate(sensor, F_x=F_x.tolist(), F_z=F_z.tolist(), tolerance=tolerance,
                     mechanics="linear" if coarse else "auto", magnetics="sheets")
    places = [data[name] if name in data else 0.0 * data["d_v"] for name in POSE]
    table = np.stack([part.transpose("F_x", "F_z").to_numpy() for part in places], -1)
    poses = np.array([table[2, 0], table[3, 2], table[4, 2], table[2, 2], table[3, 3], table[3, 1]])
    share = {model: shown(sensor, model, poses, tolerance) for model in ("sheets", "planar-fem")}
    share["far"] = shown(load_sensor(SENSOR, FAR), "sheets", poses[:2], tolerance)
    known = sensor_calibration(sensor, data)
    return Base(known, poses, np.array([0.5, 1.0]), np.diagonal(data["L0"].to_numpy()), share)


def shown(sensor: Sensor, model: str, poses: Array, tolerance: float) -> tuple[Array, Array, Array]:
    """Return L over L0 at poses (p, 6), shape (p, 2), L0, and the estimated error of the first."""
    found = magnetic_model(sensor, model, max(tolerance, 5e-3))[0].impedance(Pose.of(poses), sensor.frequency)
    L0 = np.diagonal(found.L0)
    share, error = (np.diagonal(part, axis1=-2, axis2=-1) / L0 for part in (found.L, found.error_L))
    return share, L0, error


def answer(it: Base, what: str, name: str, changes: list[str], tolerance: float) -> dict[str, object]:
    """Return a line of a changed sensor."""
    model = "planar-fem" if "substrate" in what else "sheets"
    places = it.poses[:2] if what in NOISES else it.poses
    share, L0, error = shown(load_sensor(SENSOR, changes), model, places, tolerance)
    own, own_L0, own_error = it.share["far" if what in NOISES else model]
    if what in NOISES and np.allclose(error, own_error, rtol=0.05):  # one division: what is common is gone
        error = error * np.abs((share - own) / (1.0 - own))
    load = it.known.forward(LOAD)
    moved = it.L0 * (share[1] - share[0] - own[1] + own[0])
    tared = it.known.inverse(load + moved).forces - np.array(LOAD)
    forget()  # plates are not kept: memory
    row: dict[str, object] = {
        "changed": what, "to": name, "model": model, "L0 changed by [%]": float(100.0 * np.mean(L0 / own_L0 - 1.0)),
        "L_v, rest to load [%]": float(100.0 * np.sum(share[1] - share[0])),
        "L_h, rest to load [%]": float(100.0 * (share[1, 0] - share[1, 1] - share[0, 0] + share[0, 1])),
        "F_x misread, tared [N]": _shown(tared[0]), "F_z misread, tared [N]": _shown(tared[1]),
    }
    resolved = it.known.force_error(LOAD, it.L0 * error[1])
    row |= {"F_x resolved to [mN]": float(1e3 * resolved[0]), "F_z resolved to [mN]": float(1e3 * resolved[1])}
    if what in NOISES:
        alone = it.known.inverse(load + it.L0 * (share[1] - own[1])).forces - np.array(LOAD)
        row |= {"F_x misread, as it comes [N]": _shown(alone[0]), "F_z misread, as it comes [N]": _shown(alone[1])}
        return row | {"F_x by noise [mN]": "", "F_z by noise [mN]": ""}
    slopes = np.stack([share[2] - share[3], share[4] - share[5]], -1) / (2.0 * it.steps)
    noise = SMALL * np.sqrt(np.sum(np.linalg.inv(slopes) ** 2, axis=1))
    row |= {"F_x misread, as it comes [N]": "", "F_z misread, as it comes [N]": ""}
    row |= {"F_x by noise [mN]": float(1e3 * noise[0]), "F_z by noise [mN]": float(1e3 * noise[1])}
    return row


def _shown(force: float) -> object:
    """Return a force, or that the reading belongs to no load."""
    return float(force) if np.isfinite(force) else "outside"


def draw(what: str, rows: list[dict[str, object]], path: Path) -> None:
    """Draw the forces misread over what was changed, and what noise is, or what is misread untared."""
    names, nearby = [str(row["to"]) for row in rows], what in NOISES
    below = "misread, as it comes [N]" if nearby else "by noise [mN]"
    with new_figure(height=1.1, rows=2) as (figure, axes):
        for spot, key in zip(axes, ("misread, tared [N]", below), strict=True):
            scale, most = (1e3 if key.endswith("[N]") else 1.0), 0.0
            for force, style in (("F_x", "o-"), ("F_z", "s-")):
                values = [row[f"{force} {key}"] for row in rows]
                sizes = np.array([scale * abs(value) if isinstance(value, float) else np.nan for value in values])
                line = spot.plot(range(len(names)), sizes, style, label=f"${force}$")[0]
                most = max(most, float(np.max(sizes, initial=0.0, where=np.isfinite(sizes))))
                if scale > 1.0:  # below it the models do not resolve a force
                    resolved = [float(row[f"{force} resolved to [mN]"]) for row in rows]
                    spot.plot(range(len(names)), resolved, ":", marker="_" if len(names) == 1 else "",
                              color=line.get_color(), linewidth=0.8, label=f"${force}$ resolved to")
                    most = max(most, *resolved)
            spot.set_xticks(range(len(names)), names)
            spot.set_xlim(-0.3, len(names) - 0.7)
            if scale > 1.0:
                spot.set_yscale("symlog", linthresh=0.1)
            spot.set_ylim(0.0, (3.0 if scale > 1.0 else 1.15) * most)
            for place in np.flatnonzero(~np.isfinite(sizes)):
                spot.text(place, most, "outside\nthe table", ha="center", va="top", fontsize=6)
        axes[0].set_ylabel("misread, tared [mN]")
        axes[1].set_ylabel("misread, untared [mN]" if nearby else "noise of 1e-5 $L_0$ [mN]")
        axes[1].set_xlabel(what)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.suptitle(f"{SENSOR} under {LOAD[0]} N of shear, {LOAD[1]} N down", fontsize=8)
    save_figure(figure, path)


def main() -> None:
    """Change one thing at a time, tabulate and draw."""
    coarse, folder = study_arguments(__doc__ or "")
    tolerance = 0.1 if coarse else 2e-2
    it, rows = base(tolerance, coarse), []
    for number, (what, changes) in enumerate(CHANGES.items(), 1):
        if coarse and what not in COARSE:
            continue
        chosen = list(changes.items())[:1] if coarse else list(changes.items())
        found = [answer(it, what, name, keys, tolerance) for name, keys in chosen]
        draw(what, found, folder / f"{number}_{what.split(' [')[0].split(',')[0].replace(' ', '_')}.png")
        rows += found
    print(write_rows(rows, folder / "paper_outlook.csv"))


if __name__ == "__main__":
    main()
