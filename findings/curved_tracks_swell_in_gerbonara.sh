#!/usr/bin/env bash
# Guess:    gerbonara turns a KiCad board into Gerber layers on which a curved track runs where it runs in KiCad.
# Happens:  an arc that is a track (KiCad 6 and later) is drawn around its own middle instead of its centre: half a turn
#           of 5 mm radius, 15.71 mm long, becomes three quarters of a turn of 7.07 mm, 33.32 mm long, between the same
#           ends. An arc that is a drawing on the same layer is right, and nothing is reported.
# Version:  gerbonara 1.5.0, file version 20221018.
# Users:    whoever draws round spiral coils as tracks and makes Gerber files, or measures copper, by a script: the turns
#           swell into each other.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check gerbonara==1.5.0
cat >half_turns.kicad_pcb <<'BOARD'
(kicad_pcb (version 20221018) (generator pcbnew)
  (general (thickness 1.6))
  (paper "A4")
  (layers (0 "F.Cu" signal) (31 "B.Cu" signal) (44 "Edge.Cuts" user))
  (setup (pad_to_mask_clearance 0))
  (net 0 "")
  (net 1 "COIL")
  (arc (start 10 0) (mid 15 5) (end 10 10) (width 0.3) (layer "F.Cu") (net 1)
    (tstamp 00000000-0000-4000-8000-000000000001))
  (gr_arc (start 10 40) (mid 15 45) (end 10 50) (stroke (width 0.3) (type solid)) (layer "B.Cu")
    (tstamp 00000000-0000-4000-8000-000000000002))
)
BOARD
cat >show.py <<'PYTHON'
import re
from math import atan2, hypot, pi

from gerbonara import LayerStack
from gerbonara.cad.kicad.pcb import LAYER_MAP_K2G, Board

layers = LayerStack(board_name="board")
Board.open("half_turns.kicad_pcb").render(layers, LAYER_MAP_K2G)
layers.save_to_directory("gerber")
for what, side in (("track", "F"), ("drawing", "B")):
    x, y, way, points = 0.0, 0.0, "", None
    for line in open(f"gerber/board-{side}.Cu.gbr"):
        way = next((each for each in ("G02", "G03") if each in line), way)
        found = re.search(r"X(-?\d+)Y(-?\d+)(?:I(-?\d+)J(-?\d+))?D0([12])", line)
        if not found:
            continue
        end_x, end_y = (1e-5 * int(each) for each in found.group(1, 2))  # mm, format 4.5
        if found.group(5) == "1":
            i, j = (1e-5 * int(each) for each in found.group(3, 4))
            turn = atan2(end_y - y - j, end_x - x - i) - atan2(-j, -i)
            turn = turn % (2 * pi) if way == "G03" else -turn % (2 * pi)
            r = hypot(i, j)
            print(f"{what}: ({x:g}, {y:g}) to ({end_x:g}, {end_y:g}), radius {r:.2f} mm, {turn * r:.2f} mm long")
        x, y = end_x, end_y
PYTHON
env/bin/python show.py | tee printed
diff printed - <<'EXPECTED'
track: (10, 0) to (10, -10), radius 7.07 mm, 33.32 mm long
drawing: (10, -40) to (10, -50), radius 5.00 mm, 15.71 mm long
EXPECTED
