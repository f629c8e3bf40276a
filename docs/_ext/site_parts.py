"""What do the pages need beside Sphinx? Blocks that run, equations as MathML, pages made of other files.

Equations are turned into MathML while the site is built: every present browser draws it, without script or network.
``python docs/_ext/site_parts.py`` runs the commands alone; a site that is built afterwards finds that they have run.
"""

from __future__ import annotations

import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive, directives
from executed import Mismatch, run_page, stamp
from latex2mathml.converter import convert
from made_pages import answer_keys, left_out, modules, numbers, schemas, studies
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util import logging
from warm import started

LOG = logging.getLogger(__name__)
HERE = Path(__file__).parents[1]
MADE = HERE / "_made"
RUN = ("start.md", "howto/*.md", "theory/*.md", "reference/status.md", "compare.md", "limits.md")
LIVE = {  # one-file reports that pages' commands write, and their names on the site
    "start/calibration/report.html": "calibration.html",
    "choose/button/report.html": "design.html",
}


class File(Directive):
    """A file that the page's commands use."""

    required_arguments, has_content = 1, True

    def run(self) -> list[nodes.Node]:
        """Show the file under its name."""
        text = "\n".join(self.content)
        suffix = Path(self.arguments[0]).suffix[1:]
        shown = nodes.literal_block(text, text, language={"py": "python", "csv": "text"}.get(suffix, suffix or "text"))
        shown["classes"].append("file")
        return [nodes.container("", nodes.caption("", self.arguments[0]), shown, classes=["file-block"])]


class Run(Directive):
    """Commands with what they print."""

    has_content, option_spec = True, {"exit": directives.nonnegative_int}  # noqa: RUF012

    def run(self) -> list[nodes.Node]:
        """Show commands and answers."""
        text = "\n".join(self.content)
        return [nodes.literal_block(text, text, language="console")]


def run_pages() -> None:
    """Run the blocks of every page whose blocks, or the package, have changed."""
    every = [page for pattern in RUN for page in sorted(HERE.glob(pattern))]
    pages = [page for page in every if re.search(r"^`{3,}\{run\}", page.read_text(), re.M)]
    with ThreadPoolExecutor(max_workers=2) as pool:
        for page, done in [(page, pool.submit(_run, page)) for page in pages]:
            try:
                LOG.info("%6.1f s  %s", done.result(), page.relative_to(HERE))
            except Mismatch as error:
                raise ExtensionError(str(error)) from None
    for name, title in LIVE.items():
        if (MADE / name).exists():
            (MADE / "extra" / "reports").mkdir(parents=True, exist_ok=True)
            shutil.copyfile(MADE / name, MADE / "extra" / "reports" / title)


def _run(page: Path) -> float:
    """Run a page, if it must, and return its seconds."""
    folder, kept = MADE / page.stem, MADE / f"{page.stem}.stamp"
    own = stamp(page, HERE.parent / "sits_mech")
    if kept.exists() and kept.read_text() == own:
        return 0.0
    seconds = run_page(page, folder)
    kept.write_text(own)
    return seconds


def mathml(latex: str, display: str) -> str:
    """Return an equation as MathML."""
    return convert(latex, display=display)


def inline_math(self: Any, node: nodes.math) -> None:
    """Write an equation of a line."""
    self.body.append(f'<span class="math">{mathml(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def block_math(self: Any, node: nodes.math_block) -> None:
    """Write an equation of its own."""
    latex = node.astext().strip()
    if r"\\" in latex and r"\begin" not in latex:
        latex = rf"\begin{{aligned}}{latex}\end{{aligned}}"
    self.body.append(f'<div class="math-block">{mathml(latex, "block")}</div>')
    raise nodes.SkipNode


def run_commands() -> None:
    """Run what pages and the keys of answers ask for, where it has not run yet."""
    (MADE / "extra").mkdir(parents=True, exist_ok=True)
    with started():
        run_pages()
        answer_keys(HERE, MADE)


def made(app: Sphinx) -> None:
    """Make what other files say into pages; one lists all commands, which are imported for it."""
    from sits_mech.cli.main import commands

    commands()
    run_commands()
    studies(HERE, MADE)
    schemas(HERE, MADE)
    modules(HERE)
    numbers(HERE)
    left_out(HERE)


def setup(app: Sphinx) -> dict[str, bool]:
    """Tell Sphinx."""
    app.add_directive("file", File)
    app.add_directive("run", Run)
    app.add_html_math_renderer("mathml", inline_renderers=(inline_math, None), block_renderers=(block_math, None))
    app.connect("builder-inited", made)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    run_commands()
