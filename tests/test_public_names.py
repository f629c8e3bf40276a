"""What the package shows: every name is what it says, whichever file was imported before."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("before", ["pass", "import sits_mech.chain", "import sits_mech.sweep, sits_mech.chain.plan"])
def test_functions_are_not_hidden_by_their_files(before: str) -> None:
    """`sweep` and `plan` are functions in files of the same name."""
    code = (
        f"{before}\nimport sits_mech\nfrom sits_mech import plan, simulate, sweep\n"
        "from sits_mech.sweep import sweep as same\n"
        "assert sits_mech.sweep is sweep is same and callable(plan) and callable(simulate)\n"
        "assert all(hasattr(sits_mech, name) for name in sits_mech.__all__) and len(sits_mech.__all__) <= 20\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
