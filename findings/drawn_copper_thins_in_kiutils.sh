#!/usr/bin/env bash
# Guess:    kiutils reads the lines and arcs that draw a coil on a copper layer of a KiCad 7 board as wide as they are,
#           and writes them so.
# Happens:  since KiCad 7 their width stands in (stroke (width ...)), which kiutils passes over without a word: each is
#           0.12 mm wide, its own default, and written back as that. Tracks (segments) keep their width.
# Version:  kiutils 1.4.8, file version 20221018.
# Users:    whoever makes or changes spiral coils by a script: resistance and gaps of the board that is ordered are others.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install -q --disable-pip-version-check kiutils==1.4.8
cat >show.py <<'PYTHON'
from pathlib import Path

from kiutils.board import Board

BOARD = """(kicad_pcb (version 20221018) (generator pcbnew) (general (thickness 1.6)) (paper "A4")
  (layers (0 "F.Cu" signal) (31 "B.Cu" signal) (44 "Edge.Cuts" user)) (net 0 "") (net 1 "A")
  (gr_line (start 0 0) (end 9 0) (stroke (width 0.2) (type solid)) (layer "F.Cu") (tstamp 00000000-0000-4000-8000-000000000001))
  (gr_arc (start 9 0) (mid 10 1) (end 9 2) (stroke (width 0.2) (type solid)) (layer "F.Cu") (tstamp 00000000-0000-4000-8000-000000000002))
  (segment (start 0 0) (end 0 5) (width 0.2) (layer "F.Cu") (net 1) (tstamp 00000000-0000-4000-8000-000000000003))
)
"""
Path("coil.kicad_pcb").write_text(BOARD)
board = Board.from_file("coil.kicad_pcb")
for each in board.graphicItems:
    print(type(each).__name__, "of width 0.2 mm is read with", each.width)
print("Segment of width 0.2 mm is read with", board.traceItems[0].width)
board.to_file("again.kicad_pcb")
text = Path("again.kicad_pcb").read_text()
print("written again:", text.count("(width 0.12)"), "of width 0.12;", text.count("stroke"), "strokes")
PYTHON
env/bin/python show.py | tee seen
diff seen - <<'SEEN'
GrLine of width 0.2 mm is read with 0.12
GrArc of width 0.2 mm is read with 0.12
Segment of width 0.2 mm is read with 0.2
written again: 2 of width 0.12; 0 strokes
SEEN
