"""Sound files of every kind that commands read, small ones: what malformed inputs and command lines are made of."""

from __future__ import annotations

import csv
import math
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np

from sits_mech.analysis.material.uniaxial import uniaxial_stress
from sits_mech.cli.main import run
from sits_mech.scene.files import written
from sits_mech.scene.sensor import load_sensor, scene_text
from sits_mech.silicone.material import silicone_from

MESHES = Path(__file__).parents[2] / "meshes"
SOFT = {
    "law": "yeoh", "c10": 7.5e3, "c20": 250.0, "c30": 0.0, "bulk_modulus": 15e6, "mullins": {"r": 4.0},
    "prony": [{"weight": 0.1, "time": 0.5}],
}
STUDY = {"scene": "biorob2018", "request": "inductance", "vary": {"dv": ["1 mm", "2 mm"]}, "fixed": {"model": "planar"}}
REQUIREMENTS = {
    "scene": "biorob2018", "tolerance": 0.05, "loads": {"F_z": [0.0, 1.0]},
    "vary": {"elastomer.thickness": ["2 mm", "3 mm"]}, "require": {"error_F_z": 0.5}, "goal": {"minimise": "thickness"},
}
LOADS = "t [s],F_z [N],F_x [N]\n0,0,0\n0.5,1,0\n1,1,0.2\n1.5,0,0\n"


def sound_files(folder: Path) -> Path:
    """Write a calibration, scenes, meshes, a board, tests of a silicone, tables, studies into a folder; return it."""
    asked = ["--fx", "-1 N:1 N:3", "--fz", "0 N:3 N:4", "--mechanics", "planar", "--magnetics", "planar"]
    run(["calibrate", "biorob2018-w15", *asked, "--tolerance", "0.1", "-o", str(folder / "calibration")])
    for name in ("dome.msh", "slotted_disc.msh"):
        shutil.copy(MESHES / name, folder)
    texts = {
        "scene.toml": scene_text(load_sensor("biorob2018")),
        "soft.toml": scene_text(load_sensor("biorob2018", [f"elastomer.material={_inline(SOFT)}"])),
        "dome.toml": _dome(), "probe.kicad_pcb": board(), "drawn.kicad_pcb": drawn_board(),
        "loads.csv": LOADS, "study.toml": written(STUDY),
        "requirements.toml": written(REQUIREMENTS), "bench.csv": _bench(folder / "calibration" / "result.csv"),
        "tensile.csv": _pulled([0.0, 10.0], [0.0, 1.0]), "hold.csv": _pulled([0.0, 1.0, 100.0], [0.0, 0.5, 0.5]),
        "cycles.csv": _pulled([0.0, 3.0, 6.0, 12.0, 18.0], [0.0, 0.3, 0.0, 0.6, 0.0]),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def board() -> str:
    """Return a board of KiCad 8: a square spiral on the net L1 and a filled pour below it."""
    reach = [0.5 * (k // 2 + 1) for k in range(17)]
    corners = [(20 + r * (1, -1, -1, 1)[k % 4], 20 + r * (1, 1, -1, -1)[k % 4]) for k, r in enumerate(reach)]
    tracks = [
        f'(segment (start {a} {b}) (end {c} {d}) (width 0.2) (layer "F.Cu") (net 1) (uuid "0-{k}"))'
        for k, ((a, b), (c, d)) in enumerate(zip(corners[:-1], corners[1:], strict=True))
    ]
    pour = '(filled_polygon (layer "B.Cu") (pts (xy 10 10) (xy 30 10) (xy 30 30) (xy 10 30)))'
    fill = f"(min_thickness 0.25) (filled_areas_thickness no) (fill yes) {pour}"
    zone = f'(zone (net 2) (net_name "GND") (layer "B.Cu") (hatch edge 0.5) {fill})'
    head = '(kicad_pcb (version 20240108) (generator "study") (general (thickness 1.6))'
    layers = '(layers (0 "F.Cu" signal) (31 "B.Cu" signal) (44 "Edge.Cuts" user)) (setup (pad_to_mask_clearance 0))'
    return "\n".join([head, layers, '(net 0 "") (net 1 "L1") (net 2 "GND")', *tracks, zone]) + ")\n"


def drawn_board() -> str:
    """Return a board of KiCad 5: a footprint of arcs and a custom pad, a strip as a polygon, drawn lines, two pours."""
    ends = [7.0]
    for k in range(6):
        ends.append(ends[-1] + 2 * (-1) ** k * (3 + 0.2 * k))
    arcs = [
        f"(fp_arc (start {(a + b) / 2:.3f} 10) (end {a:.3f} 10) (angle 180) (layer Top) (width 0.2))"
        for a, b in pairwise(ends)
    ]
    inside = "(gr_line (start 0 0) (end 0 1) (width 0.2)) (gr_arc (start 1 1) (end 0 1) (angle -90) (width 0.2))"
    pads = [
        f"(pad 1 smd rect (at {ends[-1]:.3f} 10) (size 0.4 0.4) (layers Top) (net 1 A))",
        f"(pad 2 smd custom (at 7 10 90) (size 0.4 0.4) (layers Top) (net 2 B) (primitives {inside}))",
    ]
    module = f"(module own:coil (layer Top) (at 0 0 0) (fp_text reference L1 (at 0 0)) {' '.join([*arcs, *pads])})"
    reach = [(30, 0), (40, 0), (40, 10), (31, 10), (31, 2), (38, 2), (38, 8), (33, 8)]
    rim = [*reach, *((x + (0.3 if x < 35 else -0.3), y + (0.3 if y < 5 else -0.3)) for x, y in reach[::-1])]
    strip = f"(gr_poly (pts {' '.join(f'(xy {x} {y})' for x, y in rim)}) (layer Top) (width 0))"
    lines = [
        f"(gr_line (start {a} {b}) (end {c} {d}) (layer Bottom) (width 0.2))"
        for (a, b), (c, d) in pairwise([(50, 0), (60, 0), (60, 10), (50, 10), (50, 1)])
    ]
    fills = [f"(filled_polygon (pts (xy {x} 20) (xy {x + 5} 20) (xy {x + 5} 40) (xy {x - 2} 40)))" for x in (10, 16)]
    zone = f"(zone (net 2) (net_name B) (layer Bottom) (min_thickness 0.25) (fill yes) {' '.join(fills)})"
    head = "(kicad_pcb (version 20171130) (host pcbnew 5.1.9) (general (thickness 1.6))"
    layers = '(layers (0 Top signal) (31 Bottom signal) (44 Edge.Cuts user)) (net 0 "") (net 1 A) (net 2 B)'
    return "\n".join([head, layers, module, strip, *lines, zone]) + ")\n"


def _dome() -> str:
    """A scene whose pad is a mesh and whose target is an outline."""
    sizes = ('target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}',
             f'elastomer={{material="ecoflex-00-50", diameter="16 mm", thickness="3 mm", mesh="{MESHES}/dome.msh"}}')
    return scene_text(load_sensor("biorob2018", sizes)).replace(f"{MESHES}/", "")


def _bench(result: Path) -> str:
    """A measurement: the loads of a calibration with its inductances, a percent off."""
    with result.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    loads = [f"{row['F_x [N]']},{row['F_z [N]']},{1.01 * (3 + 0.1 * k)},{3 + 0.1 * k}" for k, row in enumerate(rows)]
    return "\n".join(["F_x [N],F_z [N],L1 [uH],L2 [uH]", *loads, ""])


def _pulled(times: list[float], strains: list[float]) -> str:
    """A test of a soft silicone."""
    time = np.linspace(0.0, times[-1], 200)
    strain = np.interp(time, times, strains)
    stress = uniaxial_stress(silicone_from(SOFT), time, strain)
    rows = [f"{t:.4f},{e:.6f},{s:.2f}" for t, e, s in zip(time, strain, stress, strict=True) if math.isfinite(s)]
    return "\n".join(["time (s),engineering strain,engineering stress (Pa)", *rows, ""])


def _inline(value: object) -> str:
    """Return a value as TOML writes it within a line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_inline(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(value)
