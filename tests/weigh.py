"""How heavy is the package? Counts beside their ceilings; exit code 1 when one is above its own.

    lines, tokens           of sits_mech; tokens without comments, line ends and indents
    core lines              those of the rooms that a scene needs to be calibrated and read
    named numbers           statements such as `_SMALL = 0.01`
    branching functions     more than ten branches: if, for, while, except, and, or, comprehensions, assert, case
    long signatures         more than six arguments
    skipped formats         lines that ask a formatter to pass by
    large files             those that `test_architecture.py` lists
    entered in space        files of which a function runs, no class body, in `simulate biorob2018`, by default
    entered in the plane    the same, by the models planar and planar

Who lowers a count lowers its ceiling; a capability may raise it, in a commit that says which. Run
``python tests/weigh.py``.
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys

from test_architecture import FILES, LARGE, PACKAGE, PLUGGED, ROOT, tokens_of

CEILINGS = {
    "lines": 70_960, "core lines": 41_100, "tokens": 612_565, "named numbers": 690, "branching functions": 87,
    "long signatures": 45, "skipped formats": 0, "large files": 3, "entered in space": 112, "entered in the plane": 120,
}
_NUMBER = re.compile(r"^_?[A-Z][A-Z_0-9]* *(?::[^=\n]*)?= *-?[0-9.]", re.MULTILINE)
_BRANCH = (ast.If, ast.For, ast.While, ast.ExceptHandler, ast.IfExp, ast.comprehension, ast.Assert, ast.match_case)
_ENTERED = """
import inspect, sys
entered = set()
def note(frame, event, _):
    code = frame.f_code
    if event == "call" and code.co_flags & inspect.CO_OPTIMIZED and code.co_filename.startswith(sys.argv[1]):
        entered.add(code.co_filename)
import sits_mech as sm
models = dict(zip(("mechanics", "magnetics"), sys.argv[2:]))
sensor = sm.load_sensor("biorob2018")
sys.setprofile(note)
sm.simulate(sensor, sm.Wrench(F_x=0.1, F_z=0.5), tolerance=0.05, **models)
sys.setprofile(None)
print(len(entered))
"""


def counts() -> dict[str, int]:
    """Count all but the files entered."""
    found = dict.fromkeys(list(CEILINGS)[:-2], 0)
    found["large files"] = len(LARGE)
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        found["lines"] += text.count("\n")
        found["core lines"] += text.count("\n") * (path.relative_to(PACKAGE).parts[0] not in PLUGGED)
        found["tokens"] += tokens_of(text)
        found["named numbers"] += len(_NUMBER.findall(text))
        found["skipped formats"] += text.count("# fmt: skip")
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                arguments = node.args.args + node.args.kwonlyargs + node.args.posonlyargs
                found["branching functions"] += branches(node) > 10
                found["long signatures"] += len(arguments) > 6
    return found


def branches(node: ast.AST) -> int:
    """Count the branches of a function, and one."""
    inner = list(ast.walk(node))
    joined = sum(len(each.values) - 1 for each in inner if isinstance(each, ast.BoolOp))
    return 1 + joined + sum(isinstance(each, _BRANCH) for each in inner)


def entered(*models: str) -> int:
    """Count files of which a function runs in a `simulate`."""
    here = os.environ | {"SITS_MECH_CACHE": "off", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", _ENTERED, str(PACKAGE), *models]
    return int(subprocess.run(command, env=here, capture_output=True, text=True, check=True).stdout)


def main() -> int:
    """Print counts beside ceilings."""
    found = counts() | {"entered in space": entered(), "entered in the plane": entered("planar", "planar")}
    for name, count in found.items():
        print(f"{name:22s} {count:>8d}   at most {CEILINGS[name]:>8d}{'   ABOVE' * (count > CEILINGS[name])}")
    return int(any(count > CEILINGS[name] for name, count in found.items()))


if __name__ == "__main__":
    sys.exit(main())
