"""Write the coupled coils at one pose for a circuit simulator: inductors, couplings, resistors as a subcircuit.

    V_i = (R_dc,i + j omega L_i) I_i + sum_j (R_ij + j omega M_ij) I_j,    k_ij = M_ij / sqrt(L_i L_j)

R_ij is what the eddy currents put into the coils, into the diagonal and between them; between coils it is written as
current-controlled voltage sources. The numbers hold at the sensor's frequency; off it the eddy currents are others.

A circuit needs henry and ohm. The coils are computed at the pose of the load by the calibration's model, or by the 3D
model (`sheets`) where that one is per metre of depth. R and L have skin and proximity effect in the tracks.
Leads and the capacitor across each coil are the circuit's own.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np

from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.models import magnetic_model
from sits_mech.export.source import Source, interpolated_pose, resting_load
from sits_mech.quantities import UNITS, Array, Impedance
from sits_mech.readout.loads import load_words, varied
from sits_mech.scene.files import write_text
from sits_mech.scene.sensor import SceneError


def write_spice(source: Source, path: Path) -> tuple[str, ...]:
    """Write the subcircuit of the coils at the pose of the source's load.

    Raise SceneError when the load is outside the table, a scene does not fit the 3D model or the write fails;
    SolveFailed.
    """
    pose = interpolated_pose(source)
    name = source.request["magnetics"]
    if source.data.attrs["unit_L"] != "H":
        name = "sheets"
    model, _ = magnetic_model(source.sensor, name, source.request["tolerance"])
    found = model.impedance(pose, source.sensor.frequency)
    made = f"{source.about}; coils by {name}, error of L {float(np.max(found.error_L)):.1e} H"
    load = vars(resting_load(source))
    shown = {name: value for name, value in load.items() if value != 0.0 or name in varied(source.data)}
    place = {name: value for name, value in asdict(pose).items() if value != 0.0 or name in ("d_h", "d_v", "alpha")}
    state = ", ".join(f"{name} = {value:.6g} {UNITS[name]}" for name, value in place.items())
    write_text(path, netlist(source.sensor.coil_names, found, (made, f"{load_words(shown)}: {state}")))
    return at_terminals(source.sensor, found)[1]


def netlist(names: list[str], found: Impedance, remarks: tuple[str, ...] = ()) -> str:
    """Return a subcircuit ``sits_coils``, two pins for each coil, a positive current entering at the first.

    Raise SceneError when the inductances are not in henry or not positive definite.
    """
    L, R = np.asarray(found.L), np.asarray(found.R)
    if found.unit_L != "H" or np.any(np.linalg.eigvalsh(0.5 * (L + L.T)) <= 0.0):
        raise SceneError(f"L: must be a positive definite matrix in H for --to spice; got {L.tolist()} {found.unit_L}")
    count = len(names)
    lines = [f"* {line}" for line in (*remarks, f"numbers hold at {found.frequency:.6g} Hz; L in H, R in ohm")]
    lines.append("* " + ", ".join(f"{name}: pins a{i} b{i}" for i, name in enumerate(names, 1)))
    lines.append(".subckt sits_coils " + " ".join(f"a{i} b{i}" for i in range(1, count + 1)))
    for i in range(count):
        n = i + 1
        own = found.R_dc[i] + R[i, i]
        lines += [f"V{n} a{n} s{n} 0", f"R{n} s{n} r{n} {own:.9g}", f"L{n} r{n} e{n}_0 {L[i, i]:.9g}"]
        lines += _resistive(i, R)
    for i in range(count):
        for j in range(i + 1, count):
            k = 0.5 * (L[i, j] + L[j, i]) / np.sqrt(L[i, i] * L[j, j])
            lines.append(f"K{i + 1}_{j + 1} L{i + 1} L{j + 1} {k:.9g}")
    return "\n".join([*lines, ".ends sits_coils", ""])


def _resistive(i: int, R: Array) -> list[str]:
    """Return the sources of what the other coils' currents drop in coil i by the eddy currents' losses."""
    others = [j for j in range(len(R)) if j != i]
    nodes = [f"e{i + 1}_{step}" for step in range(len(others))] + [f"b{i + 1}"]
    lines = []
    for step, j in enumerate(others):
        value = 0.5 * (R[i, j] + R[j, i])
        lines.append(f"H{i + 1}_{j + 1} {nodes[step]} {nodes[step + 1]} V{j + 1} {value:.9g}")
    return lines if others else [f"V{i + 1}e e{i + 1}_0 b{i + 1} 0"]
