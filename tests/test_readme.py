"""What a first look shows is true: files that README names are there, its Python runs."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_what_it_links_to_is_there() -> None:
    """Pictures and pages, from the root of the project."""
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10 and [link for link in links if not (ROOT / link).exists()] == []


@pytest.mark.slow
def test_its_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """The example, as it stands: a force comes back from what it would read."""
    (code,) = re.findall(r"```python\n(.*?)```", README, re.S)
    exec(compile(code, "README.md", "exec"), {})  # noqa: S102  it is what users would run
    said = capsys.readouterr().out.splitlines()
    forces = [float(number) for number in re.findall(r"[\d.]+", said[-1])]
    assert abs(forces[0] - 0.2) < 1e-3 and abs(forces[1] - 1.5) < 1e-3
