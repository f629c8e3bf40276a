"""Do the tests see small faults in the core? Faults are put into a copy one by one; each should make a test fail.

`python tests/mutants.py [PATH ...] [--count N] [--seed N]` takes N of all the small faults that the files of the rooms
(chain, maps, readout and silicone by default) could have, always the same ones for a seed, and runs the tests that
answer for the file, then, where these pass, those of its room. It prints each fault with its line and whether a test
sees it, and the share of those seen; it ends with exit code 1 where that share is below `--least` by more than chance
does, two deviations of a sample of N.

Faults: a comparison that takes or leaves its end, or is turned round; another sign or operator; `and` for `or`; a `not`
or a minus less; least for largest; a number one larger or twice as large. Words of errors and numbers of 1e-6 and below
(guards against rounding, whose size is not promised) are left alone. Some faults change nothing that can be seen, such
as a twice as fine step where any fine step will do: all of them cannot be reached.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import copy
import os
import py_compile
import random
import resource
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from test_architecture import PACKAGE, ROOT, UNMIRRORED

COMPARED = {
    ast.Lt: (ast.LtE, ast.GtE), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.LtE), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,), ast.NotIn: (ast.In,),
}
CALCULATED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}
SWAPPED = {"min": "max", "max": "min", "any": "all", "all": "any", "minimum": "maximum", "maximum": "minimum"}
NO_TESTS = 5  # pytest's exit code where it ran none
GUARD = 1e-6  # numbers up to this size are left alone
KEPT = (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom)  # no faults below these


@dataclass(frozen=True)
class Mutant:
    """One fault: the text of an expression, and what stands for it."""

    path: Path
    line: int
    start: int
    end: int
    before: str
    after: str

    def source(self) -> str:
        """Return the file's text with the fault in it."""
        text = self.path.read_bytes()
        return (text[: self.start] + self.after.encode() + text[self.end :]).decode()

    def __str__(self) -> str:
        shorter = [" ".join(text.split()) for text in (self.before, self.after)]
        return f"{self.path.relative_to(ROOT)}:{self.line}  {shorter[0]}  ->  {shorter[1]}"


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may stand for an expression by mistake."""
    changed = copy.deepcopy(node)
    match changed:
        case ast.Compare(ops=[operator]):
            for other in COMPARED[type(operator)]:
                changed.ops = [other()]
                yield changed
        case ast.BinOp() if type(changed.op) in CALCULATED and not any(map(is_text, (changed.left, changed.right))):
            changed.op = CALCULATED[type(changed.op)]()
            yield changed
        case ast.BoolOp():
            changed.op = ast.And() if isinstance(changed.op, ast.Or) else ast.Or()
            yield changed
        case ast.UnaryOp(op=ast.Not() | ast.USub() | ast.Invert()):
            yield changed.operand
        case ast.Constant(value=bool()):
            yield ast.Constant(not changed.value)
        case ast.Constant(value=int()):
            yield ast.Constant(changed.value + 1)
        case ast.Constant(value=float()) if changed.value == 0.0 or abs(changed.value) > GUARD:
            yield ast.Constant(2.0 * changed.value or 1.0)
        case ast.Call(func=ast.Name(id=name)) if name in SWAPPED:
            changed.func = ast.Name(SWAPPED[name])
            yield changed
        case ast.Call(func=ast.Attribute(attr=name)) if name in SWAPPED:
            changed.func.attr = SWAPPED[name]
            yield changed


def is_text(node: ast.AST) -> bool:
    """Return whether an expression is a text as it stands."""
    return isinstance(node, ast.JoinedStr) or isinstance(node, ast.Constant) and isinstance(node.value, str)


def left_alone(node: object) -> bool:
    """Return whether nothing of a node is computed, or nothing of it can be seen while all is well."""
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id == "isinstance"
    return isinstance(node, KEPT) or isinstance(node, ast.keyword) and node.arg == "strict"


def expressions(node: ast.AST) -> Iterator[ast.AST]:
    """Yield every node that is computed: no annotations, docstrings, imports, or words of errors."""
    for name, below in ast.iter_fields(node):
        if name in ("annotation", "returns", "bases", "decorator_list"):
            continue
        for each in below if isinstance(below, list) else [below]:
            if isinstance(each, ast.AST) and not left_alone(each):
                yield each
                yield from expressions(each)


def mutants(path: Path) -> list[Mutant]:
    """Return the faults that a file could have."""
    text = path.read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node in expressions(ast.parse(text)):
        for changed in variants(node):
            start, end = starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset
            after = f"({ast.unparse(ast.fix_missing_locations(changed))})"
            found.append(Mutant(path, node.lineno, start, end, text[start:end].decode(), after))
    return found


def judges(path: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the tests that answer for a file, and the other ones of its room."""
    name = path.relative_to(PACKAGE)
    own = ROOT / "tests" / name.with_name(f"test_{name.name}")
    listed = [UNMIRRORED[str(name)].partition(":")[0]] if str(name) in UNMIRRORED else [str(own.relative_to(ROOT))]
    room = [str(each.relative_to(ROOT)) for each in (ROOT / "tests" / name.parts[0]).rglob("test_*.py")]
    return tuple(listed), tuple(sorted(set(room) - set(listed)))


def passes(tests: tuple[str, ...], here: Path, limit: float) -> tuple[bool, float]:
    """Run tests in a copy, in a process that has what they import already; return whether none fails, and the seconds.

    Where all of them are slow ones, which are not run here, none fails.
    """
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit)))
        os.chdir(here)
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        sys.path.insert(0, str(here))
        os.environ["PYTHONPATH"] = str(here)
        code = 1
        try:
            import pytest

            code = pytest.main(["-x", "-q", "--assert=plain", "-p", "no:cacheprovider", "--rootdir", str(here), *tests])
        finally:
            os._exit(int(code))
    _, status, used = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status) in (0, NO_TESTS), used.ru_utime + used.ru_stime


def warm() -> None:
    """Import once what every run of tests would import, but nothing of the package."""
    import hypothesis.strategies  # noqa: F401
    import pytest  # noqa: F401
    import scipy.interpolate  # noqa: F401
    import scipy.optimize  # noqa: F401
    import xarray  # noqa: F401


class Bench:
    """A copy of the project in which faults are tried, and what its tests cost without any."""

    def __init__(self, here: Path) -> None:
        self.here = here
        for folder in ("sits_mech", "tests", "studies", "meshes"):
            shutil.copytree(ROOT / folder, here / folder, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", here)
        compileall.compile_dir(here, quiet=1, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH)
        sys.dont_write_bytecode = True  # what is compiled is told by its text, never by its time
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        self.costs: dict[tuple[str, ...], float] = {}

    def sees(self, tests: tuple[str, ...], fault: Mutant) -> bool:
        """Return whether one of the tests fails with a fault; it may take five times as long as without."""
        if not tests:
            return False
        if tests not in self.costs:
            green, self.costs[tests] = passes(tests, self.here, 1800.0)
            if not green:
                raise SystemExit(f"these fail without any fault: {' '.join(tests)}")
        place = self.here / fault.path.relative_to(ROOT)
        whole = place.read_text()
        try:
            place.write_text(fault.source())
            return not passes(tests, self.here, 5.0 * self.costs[tests] + 10.0)[0]
        finally:
            place.write_text(whole)


def main() -> None:
    """Try the faults; print those that no test sees, and the share of those seen by room."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    rooms = [str(PACKAGE / room) for room in ("chain", "maps", "readout", "silicone")]
    parser.add_argument("paths", nargs="*", default=rooms, help="files or folders of the package")
    parser.add_argument("--count", type=int, default=200, help="how many faults to try")
    parser.add_argument("--seed", type=int, default=1, help="which ones")
    parser.add_argument("--own", action="store_true", help="the tests that answer for the file only")
    parser.add_argument("--least", type=float, default=0.0, help="share of faults that must be seen")
    parser.add_argument("--list", action="store_true", help="print the faults and try none")
    asked = parser.parse_args()
    given = [Path(name).resolve() for name in asked.paths]
    files = [path for each in given for path in (sorted(each.rglob("*.py")) if each.is_dir() else [each])]
    known = [fault for path in files for fault in mutants(path)]
    chosen = random.Random(asked.seed).sample(known, min(asked.count, len(known)))
    print(f"{len(chosen)} of {len(known)} faults in {len(files)} files", flush=True)
    if asked.list:
        print(*chosen, sep="\n")
        return
    warm()
    with tempfile.TemporaryDirectory() as here:
        raise SystemExit(tried(chosen, Bench(Path(here)), asked.own, asked.least))


def tried(chosen: list[Mutant], bench: Bench, own_only: bool, least: float) -> int:
    """Try faults and print what is found; return the exit code."""
    seen, total = Counter[str](), Counter[str]()
    for number, fault in enumerate(chosen, 1):
        own, others = judges(fault.path)
        begun = time.perf_counter()
        found = bench.sees(own, fault) or (not own_only and bench.sees(others, fault))
        room = fault.path.relative_to(PACKAGE).parts[0]
        seen[room] += found
        total[room] += 1
        verdict = "seen" if found else "NOT SEEN"
        print(f"{number:4d} {time.perf_counter() - begun:5.1f} s  {verdict:8s}  {fault}", flush=True)
    print(*(f"{room}: {seen[room]} of {total[room]} seen" for room in sorted(total)), sep="\n")
    count = total.total()
    share, chance = seen.total() / count, 2.0 * (least * (1.0 - least) / count) ** 0.5
    print(f"{seen.total()} of {total.total()} faults seen: {100 * share:.1f} %")
    return int(share < least - chance)


if __name__ == "__main__":
    main()
