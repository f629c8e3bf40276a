"""Studies: each says what it asks and how it is run, and can be asked for help."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

FOLDERS = ("sits_mech", "benchmarks", "common", "elsewhere", "extreme")
FOLDER = Path(__file__).parents[1] / "studies"
STUDIES = [*sorted(FOLDER.glob("*.py")), *sorted(FOLDER.glob("benchmarks/*.py"))]


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_study_says_how_it_is_run(path: Path) -> None:
    """The docstring holds the command; the file is no longer than one sitting."""
    text = path.read_text(encoding="utf-8")
    doc = ast.get_docstring(ast.parse(text)) or ""
    command = f"python studies/{path.name}" if path.parent == FOLDER else f"python -m benchmarks.{path.stem}"
    assert re.search(rf"{re.escape(command)} \[--coarse\].*--output DIR", doc)
    assert len(text.splitlines()) <= 350


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_study_finds_what_it_imports(path: Path) -> None:
    """Names of the package and of the studies' own folders, wherever in the file they are imported."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in FOLDERS:
            module = import_module(str(node.module))
            names = [alias.name for alias in node.names]
            assert all(hasattr(module, name) or find_spec(f"{node.module}.{name}") for name in names), ast.unparse(node)


def test_help_costs_nothing() -> None:
    """What a study asks, without running it."""
    words = [sys.executable, str(STUDIES[0]), "--help"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "--coarse" in done.stdout
