"""The subcircuit: its nodal equations, and ngspice where it is installed, give the impedance matrix it was made of."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sits_mech.analysis.spectrum import at_terminals
from sits_mech.chain.models import magnetic_model
from sits_mech.export.formats import export
from sits_mech.export.source import Source
from sits_mech.export.spice import netlist
from sits_mech.quantities import Impedance, Pose, SolveReport, Wrench
from sits_mech.report.folder import read_calibration
from sits_mech.scene.sensor import load_sensor

HERTZ = 5e6


def made(L: list[list[float]], R: list[list[float]]) -> Impedance:
    """An impedance of given numbers."""
    size = np.zeros(np.shape(L))
    report = SolveReport("by hand", 0, 0, 0.0, 0.0, 0.0)
    return Impedance(HERTZ, np.array(L), np.array(R), np.array(L), np.zeros(len(L)), size, size, "H", report)


def solved(text: str, hertz: float) -> np.ndarray:
    """Return the impedance matrix of a subcircuit by modified nodal analysis: V, R, L, H and K elements alone."""
    lines = [line.split() for line in text.splitlines() if line and line[0] not in "*."]
    pins = re.search(r"^\.subckt \S+ (.*)$", text, re.M)[1].split()
    elements = [line for line in lines if line[0][0] in "VRLH"]
    nodes = sorted({node for line in elements for node in line[1:3]})
    row = {node: i for i, node in enumerate(nodes)}
    branch = {line[0]: len(nodes) + i for i, line in enumerate(elements)}
    A = np.zeros((len(nodes) + len(elements),) * 2, dtype=complex)
    omega = 2.0 * np.pi * hertz
    L = {line[0]: float(line[3]) for line in elements if line[0][0] == "L"}
    for line in elements:
        k, (a, b) = branch[line[0]], (row[node] for node in line[1:3])
        A[a, k] += 1.0
        A[b, k] -= 1.0
        A[k, a], A[k, b] = A[k, a] + 1.0, A[k, b] - 1.0
        if line[0][0] == "R":
            A[k, k] -= float(line[3])
        elif line[0][0] == "L":
            A[k, k] -= 1j * omega * L[line[0]]
        elif line[0][0] == "H":
            A[k, branch[line[3]]] -= float(line[4])
    for name, one, other, k in (line for line in lines if line[0][0] == "K"):
        mutual = float(k) * np.sqrt(L[one] * L[other])
        assert name.startswith("K")
        A[branch[one], branch[other]] -= 1j * omega * mutual
        A[branch[other], branch[one]] -= 1j * omega * mutual
    count = len(pins) // 2
    Z = np.zeros((count, count), dtype=complex)
    for j in range(count):  # 1 A into the first pin of coil j, out of its second; each second pin is grounded
        B, b = A.copy(), np.zeros(len(A), dtype=complex)
        b[row[pins[2 * j]]] = 1.0
        for i in range(count):
            ground = row[pins[2 * i + 1]]
            B[ground], B[ground, ground] = 0.0, 1.0
            b[ground] = 0.0
        Z[:, j] = np.linalg.solve(B, b)[[row[pins[2 * i]] for i in range(count)]]
    return Z


PAIR = made([[2.3e-6, -4.1e-8], [-4.1e-8, 2.5e-6]], [[0.10, -0.006], [-0.006, 0.12]])
THREE = made(
    [[2.3e-6, -4e-8, -1e-8], [-4e-8, 2.5e-6, -5e-8], [-1e-8, -5e-8, 2.2e-6]],
    [[0.10, -0.006, 0.002], [-0.006, 0.12, -0.004], [0.002, -0.004, 0.09]],
)
ONE = made([[2.3e-6]], [[0.1]])


@pytest.mark.parametrize("found", [ONE, PAIR, THREE], ids=["one", "pair", "three"])
def test_nodal_equations(found: Impedance) -> None:
    """Z = R + R_dc + j omega L, to the nine digits that are written."""
    Z = solved(netlist([f"C{i}" for i in range(len(found.L))], found), HERTZ)
    np.testing.assert_allclose(Z, found.R + np.diag(found.R_dc) + 2j * np.pi * HERTZ * found.L, rtol=1e-8, atol=1e-8)


def simulated(netlist_text: str, lines: list[str], folder: Path) -> dict[int, complex]:
    """Return the voltages that ngspice finds at the pins p1, p2 of two coils, driven as some lines say."""
    (folder / "coils.cir").write_text(netlist_text)
    bench = ["bench", ".include coils.cir", "X1 p1 0 p2 0 sits_coils", *lines, f".ac lin 1 {HERTZ} {HERTZ}"]
    control = [".control", "set numdgt=12", "run", "print v(p1) v(p2)", ".endc", ".end"]
    (folder / "bench.cir").write_text("\n".join([*bench, *control, ""]))
    done = subprocess.run(["ngspice", "-b", "bench.cir"], cwd=folder, capture_output=True, text=True, timeout=60)
    numbers = re.findall(r"v\(p(\d)\) = (\S+),(\S+)", done.stdout)
    assert len(numbers) == 2, done.stdout + done.stderr
    return {int(pin): complex(float(real), float(imaginary)) for pin, real, imaginary in numbers}


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
def test_ngspice_agrees(tmp_path: Path) -> None:
    """One ampere through each coil in turn, the other open: the voltages are the matrix's columns."""
    Z = np.zeros((2, 2), dtype=complex)
    for j in range(2):
        drive = [f"I{i} 0 p{i} AC {int(i == j + 1)}" for i in (1, 2)]
        for pin, voltage in simulated(netlist(["C1", "C2"], PAIR), drive, tmp_path).items():
            Z[pin - 1, j] = voltage
    expected = PAIR.R + np.diag(PAIR.R_dc) + 2j * np.pi * HERTZ * PAIR.L
    np.testing.assert_allclose(Z, expected, rtol=1e-6, atol=1e-7)


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
def test_the_circuit_shows_what_inductance_shows_at_the_terminals(tmp_path: Path) -> None:
    """Skin and proximity effect, target and idle coil included: L to 1e-4, R to 1e-3."""
    sensor, pose = load_sensor("biorob2018"), Pose(0.3e-3, 1.5e-3)
    found = magnetic_model(sensor, "sheets", 1e-1, [pose])[0].impedance(pose, HERTZ)
    seen, _ = at_terminals(sensor, found)
    Z = simulated(netlist(["C1", "C2"], found), ["I1 0 p1 AC 1", "R9 p2 0 1e-9"], tmp_path)[1]
    assert seen is not None and seen.L[0] < found.L[0, 0]
    assert Z.imag / (2.0 * np.pi * HERTZ) == pytest.approx(seen.L[0], rel=1e-4)
    assert Z.real == pytest.approx(seen.R[0], rel=1e-3)


def test_what_is_no_inductance() -> None:
    """Per metre, or with a coupling above one."""
    for L, unit in (([[1.0, 1.1], [1.1, 1.0]], "H"), ([[1.0, 0.1], [0.1, 1.0]], "H/m")):
        found = made(L, [[0.0, 0.0], [0.0, 0.0]])
        with pytest.raises(ValueError, match="L: must be a positive definite matrix in H"):
            netlist(["C1", "C2"], Impedance(**(vars(found) | {"unit_L": unit})))


def test_from_a_calibration_per_metre(calibrated: Path, tmp_path: Path) -> None:
    """The coils in henry at the pose of the load: L below that of free space, 2.5076 uH, by rings of one turn each.

    Source of the free-space value: mutual inductances of coaxial rectangular rings, `reference` axisymmetric, 1e-3.
    """
    sensor, data = read_calibration(calibrated)
    request = json.loads(data.attrs["request"]) | {"tolerance": 0.1}
    source = Source(sensor, data.assign_attrs(request=json.dumps(request)), Wrench(0.25, 1.0))
    path, _ = export(source, "spice", tmp_path / "coils.cir")
    text = path.read_text()
    Z = solved(text, HERTZ)
    L = Z.imag / (2.0 * np.pi * HERTZ)
    assert 0.85 * 2.5076e-6 < L[1, 1] < L[0, 0] < 2.5076e-6  # the plate is over the right coil more
    assert -0.03 < L[0, 1] / L[0, 0] < -0.01 and "F_x = 0.25 N, F_z = 1 N" in text and "coils by sheets" in text


def test_a_load_in_space(three_forces: Path, tmp_path: Path) -> None:
    """The heading names every component of load and pose; the coils are those of that pose."""
    sensor, data = read_calibration(three_forces)
    request = json.loads(data.attrs["request"]) | {"tolerance": 0.1}
    data = data.assign_attrs(request=json.dumps(request))
    path, _ = export(Source(sensor, data, Wrench(0.5, 2.0, F_y=0.4)), "spice", tmp_path / "coils.cir")
    there = data.sel(F_x=0.5, F_z=2.0, F_y=0.4)
    state = path.read_text().splitlines()[1]
    assert "F_x = 0.5 N, F_z = 2 N, M = 0.001 N m, F_y = 0.4 N: d_h = " in state
    assert f"d_y = {float(there['d_y']):.6g} m, alpha_x = {float(there['alpha_x']):.6g} rad" in state
