#!/usr/bin/env bash
# A sensor that no catalogue has, from its scene to firmware: three coils, a round target, three forces.
# Run `tests/three_axis.sh [DIR]`: needs sits-mech and a C compiler on the path; what it makes stays in DIR, if given.
# Ends with exit code 0 when the compiled header and Python tell the same forces of the same codes.
set -euo pipefail
here=${1:-$(mktemp -d)}
mkdir -p "$here"
[ $# -gt 0 ] || trap 'rm -rf "$here"' EXIT
cd "$here"

{
    echo 'name = "three coils around a round target"'
    echo 'frequency = "5 MHz"'
    while read -r name x y; do
        cat <<COIL
[[coils]]
name = "$name"
centre = ["$x mm", "$y mm"]
layers = 2
turns = 12
inner_diameter = "2 mm"
track_width = "0.1 mm"
track_gap = "0.1 mm"
track_thickness = "35 um"
layer_pitch = "85 um"
COIL
    done <<<'east 4.2 0
north -2.1 3.637
south -2.1 -3.637'
    cat <<'REST'
[target]
material = "copper"
shape = "disc"
diameter = "11 mm"
thickness = "0.2 mm"
[elastomer]
material = "ecoflex-00-30"
diameter = "18 mm"
thickness = "2 mm"
[readout]
converter = "LDC1614"
parallel_capacitance = "330 pF"
REST
} >scene.toml

loads=(--fx "-0.4 N:0.4 N:5" --fy "-0.4 N:0.4 N:5" --fz "0 N:1.5 N:5")
sits-mech calibrate scene.toml "${loads[@]}" --tolerance 0.1 -o calibration --accept >loads.txt
sits-mech quality calibration --json >quality.json
sits-mech export calibration --to c -o sensor.h

python - <<'MADE'
"""Write codes to ask both for: of loads within, at and beyond the table, and of coils that contradict each other."""
from pathlib import Path

import numpy as np

import sits_mech as sm
from sits_mech.report.folder import read_calibration

known = sm.sensor_calibration(*read_calibration(Path("calibration")))
rng = np.random.default_rng(14)
share = rng.uniform(-0.2, 1.2, (5000, len(known.forces)))
codes = np.rint(known.codes(known.low + share * (known.high - known.low), beyond=True))
low, high = codes.min(axis=0), codes.max(axis=0)
codes = np.vstack([codes, np.rint(rng.uniform(low, high, (5000, len(known.coils))))]).astype(np.int64)
np.savetxt("codes.txt", codes, fmt="%d")
MADE

cat >main.c <<'MAIN'
#include <inttypes.h>
#include <stdio.h>

#include "sensor.h"

int main(void)
{
    uint32_t code[SITS_COILS];
    while (scanf("%" SCNu32 " %" SCNu32 " %" SCNu32, &code[0], &code[1], &code[2]) == SITS_COILS) {
        int32_t force[SITS_FORCES] = {0};
        int status = sits_forces(code, force);
        printf("%d %" PRId32 " %" PRId32 " %" PRId32 "\n", status, force[0], force[1], force[2]);
    }
    return 0;
}
MAIN
"${CC:-cc}" -std=c99 -O2 -Wall -Wextra -Wconversion -Wpedantic -Werror -o firmware main.c
./firmware <codes.txt >forces.txt

python - <<'HELD'
"""Hold the compiled header against Python's inverse of the same codes; print what was found."""
import json
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np

import sits_mech as sm
from sits_mech.report.folder import read_calibration

known = sm.sensor_calibration(*read_calibration(Path("calibration")))
codes, answers = np.loadtxt("codes.txt"), np.loadtxt("forces.txt")
python = known.code_calibration.inverse(codes)
names = ("ok", "outside", "ambiguous", "no solution")
status = np.array(names)[answers[:, 0].astype(int)]
good = status == "ok"
off = 1e6 * np.abs(1e-6 * answers[good, 1:] - python.forces[good])
counts = ", ".join(f"{count} {name}" for name, count in Counter(status.tolist()).items())
print(f"status: {counts}; different: {int(np.sum(status != python.status))}")
print(f"forces differ by at most {off.max():.2g} uN over {good.sum()} readings")

row = int(np.flatnonzero(good)[0])
words = [word for coil, code in zip(known.coils, codes[row], strict=True) for word in ("--code", f"{coil}={code:.0f}")]
told = json.loads(subprocess.check_output(["sits-mech", "invert", "calibration", *words, "--json"]))
shown = ", ".join(f"{name} = {value:.4f} +- {told['error'][name]:.4f} N" for name, value in told["forces"].items())
print(f"one reading by the command: {shown}")
asked = np.array([told["forces"][name] for name in known.forces])
assert np.all(status == python.status) and off.max() < 5.0, "the header and Python must agree"
assert np.abs(asked - python.forces[row]).max() < 5e-6, "the command and Python must agree"
quality = json.loads(Path("quality.json").read_text())
low, high = quality["condition"]
print(f"condition: {low:.2f} to {high:.2f}")
assert 1.0 <= low <= high < 20.0, "three coils must resolve three forces"
HELD
