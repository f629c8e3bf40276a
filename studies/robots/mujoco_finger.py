"""What does the sensor read while a finger presses and shears it? MuJoCo moves the pad, the twin gives the codes.

Needs mujoco, matplotlib and the folder that ``sits-mech export DIR --to twin -o FOLDER`` wrote, nothing else of the
project: pad.xml is the pad on compliant joints, twin.py with sensor.npz the sensor. A finger, a ball on two slides that
motors drive, comes down, presses, shears to both sides and lifts off. Every millisecond the forces on the target, which
are what springs and dampers of its joints hold (qfrc_passive), go through the twin: creep, inductances, codes; from the
codes comes the estimate that a controller would have. No plugin: one call a sample. Moments are left out, as the
calibration over F_x and F_z has none. The contact is stiff: MuJoCo's default lets a plate of 0.1 g sink in.
Run ``PYTHONPATH=FOLDER python studies/robots/mujoco_finger.py FOLDER PICTURE.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from twin import WRENCH, Twin

SAMPLE = 1e-3  # [s]
TIMES = (0.0, 0.1, 0.5, 0.8, 1.1, 1.7, 2.0, 2.4, 3.0)  # of the motors' forces [s]
PRESS = (0.05, 0.05, 0.6, 0.6, 0.6, 0.6, 0.6, -0.05, -0.05)  # down, of the largest F_z of the calibration
SHEAR = (0.0, 0.0, 0.0, 0.0, 0.6, -0.6, 0.0, 0.0, 0.0)  # of the largest F_x
SCENE = """
<mujoco>
  <include file="pad.xml"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="finger" pos="0 0 {height}">
      <joint name="finger_x" type="slide" axis="1 0 0" damping="20"/>
      <joint name="finger_z" type="slide" axis="0 0 1" damping="20" range="-0.01 0.0002" limited="true"/>
      <geom type="sphere" size="0.006" mass="0.02" friction="1.5" priority="1" solref="1e-3 1"
            solimp="0.999 0.999 1e-3"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="shear" joint="finger_x"/>
    <motor name="press" joint="finger_z" gear="-1"/>
  </actuator>
</mujoco>
"""


def pressed(folder: Path) -> dict[str, np.ndarray]:
    """Return time [s], the motors' forces and those on the target, the codes, and what they are taken for, by sample.

    Forces are (F_x, F_z) [N], of shape (samples, 2); codes (samples, coils); flags (samples,).
    """
    twin = Twin.load(folder / "sensor.npz")
    pad = (folder / "pad.xml").read_bytes()
    top = float(twin.numbers["rest_pose"][1] + twin.numbers["load_height"])
    model = mujoco.MjModel.from_xml_string(SCENE.format(height=top + 0.0062), assets={"pad.xml": pad})
    data, high = mujoco.MjData(model), dict(zip(twin.forces, twin.numbers["wrench_high"], strict=True))
    dofs, signs = [model.joint(f"sits_{name}").dofadr[0] for name in ("d_h", "d_v")], [-1.0, 1.0]  # F_z presses down
    columns, state, rows = [WRENCH.index(name) for name in ("F_x", "F_z")], twin.start(1), []
    every = round(SAMPLE / model.opt.timestep)
    for k in range(round(TIMES[-1] / model.opt.timestep)):
        motors = [high["F_x"] * np.interp(data.time, TIMES, SHEAR), high["F_z"] * np.interp(data.time, TIMES, PRESS)]
        data.ctrl[:] = motors
        mujoco.mj_step(model, data)
        if k % every == 0:
            wrench = np.zeros((1, 6))
            wrench[0, columns] = data.qfrc_passive[dofs] * signs
            state, shown = twin.step(state, wrench, SAMPLE)
            rows.append((data.time, motors, wrench[0, columns], shown.codes[0], shown.flags[0]))
    names = ("time", "motors", "forces", "codes", "flags")
    found = {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}
    return found | {"estimate": twin.estimate_codes(found["codes"]).wrench[:, columns]}


def draw(found: dict[str, np.ndarray], path: Path) -> None:
    """Draw forces and codes over time, each curve with its name at its peak."""
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, figsize=(6.0, 5.0), sharex=True, constrained_layout=True)
    figure.suptitle("A finger presses and shears: the codes give its forces back (dashed)")
    each = zip(("$F_x$, shear", "$F_z$, press"), found["forces"].T, found["estimate"].T, strict=True)
    for k, (name, forces, estimate) in enumerate(each):
        above.plot(found["time"], forces, color=f"C{k}", lw=4, alpha=0.5)
        above.plot(found["time"], estimate, "--", color="black", lw=1)
        _name(above, found["time"], forces, name, f"C{k}")
    start = int(np.argmax(found["forces"][:, 1] > 0.0))
    place = found["time"][start], found["forces"][start, 1]
    above.annotate("the finger hits the target", place, (0, -28), textcoords="offset points", fontsize=8)
    for k, codes in enumerate(found["codes"].T):
        change = (codes - codes[0]) / 1e3
        below.plot(found["time"], change, color=f"C{k + 2}")
        _name(below, found["time"], change, f"coil {k + 1}", f"C{k + 2}")
    above.set(ylabel="force on the target [N]")
    below.set(xlabel="time [s]", ylabel="change of code [thousand]")
    for axes in (above, below):
        axes.margins(y=0.2)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def _name(axes: Any, time: np.ndarray, values: np.ndarray, name: str, colour: str) -> None:
    """Name a curve above its peak."""
    peaks = np.flatnonzero(values >= values.max() - 0.01 * np.ptp(values))
    place = time[peaks[len(peaks) // 2]], values.max()
    axes.annotate(name, place, (0, 4), textcoords="offset points", ha="center", color=colour)


if __name__ == "__main__":
    draw(pressed(Path(sys.argv[1])), Path(sys.argv[2]))
