"""What the package shows: every name is what it says, whichever file was imported before."""

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sits_mech

ROOT = Path(__file__).parents[1]


def test_functions_are_not_hidden_by_their_files() -> None:
    """A file of the same name, imported before or after, would stand where the function stood.

    One interpreter, in which the package is imported anew for each order.
    """
    looked = (
        "import sits_mech\nfrom sits_mech import plan, simulate, sweep\n"
        "from sits_mech.batch.sweep import sweep as same\nfrom sits_mech.chain.simulate import simulate as other\n"
        "assert sits_mech.sweep is sweep is same and sits_mech.simulate is simulate is other and callable(plan)\n"
        "assert all(hasattr(sits_mech, name) for name in sits_mech.__all__) and len(sits_mech.__all__) <= 38\n"
    )
    own = "[name for name in sys.modules if name.startswith('sits_mech')]"
    forget = f"import sys\nfor name in {own}: del sys.modules[name]\n"
    orders = ("", "import sits_mech.chain\n", "import sits_mech.batch.sweep, sits_mech.chain.plans.plan\n")
    code = "".join(f"{forget}{before}{looked}" for before in orders)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


def test_no_file_or_room_has_the_name_of_a_function() -> None:
    """Importing it would put the file in the function's place."""
    names = {path.stem for path in (ROOT / "sits_mech").iterdir()}
    assert not names & set(sits_mech.__all__)


def test_pages_import_the_public_names_alone() -> None:
    """But for the page of plug-ins; what a bench's stand-in or a law over time is made of has no public name."""
    within = {"bench.md": {"analysis.built.prior"}, "tensile.md": {"analysis.material.uniaxial", "silicone.material"}}
    for page in sorted({*(ROOT / "docs" / "howto").glob("*.md")} - {ROOT / "docs" / "howto" / "plugin.md"}):
        found = re.findall(r"^(?:from|import) sits_mech\.(\S+)", page.read_text(encoding="utf-8"), re.MULTILINE)
        assert {*found} <= within.get(page.name, set()), page.name


LONG = ("cell_crosstalk", "design", "envelope", "mechanical_model", "SolveFailed")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG))
     for name in sorted(set(sits_mech.__all__) - {"__version__"})],
)
def test_every_name_has_an_example_that_runs(name: str) -> None:
    """What its documentation shows is what it does; a name without an example has none to be held to."""
    known = {"sm": sits_mech, "np": np}
    found = doctest.DocTestFinder(recurse=False).find(getattr(sits_mech, name), name, globs=known)
    assert sum(len(each.examples) for each in found) > 0
    runner, said = doctest.DocTestRunner(), []
    for each in found:
        runner.run(each, out=said.append)
    assert runner.failures == 0, "".join(said)
