"""What does a requirement file tell? Its answer in a folder of its name, and in a few lines."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from sits_mech.report.design import write_design
from sits_mech.report.folder import cases_folder, prepare_folder
from sits_mech.report.tables.design import figure_cells, price_words
from sits_mech.synthesis.required.requirements import read_requirements
from sits_mech.synthesis.run import design
from sits_mech.synthesis.search import MOST

REQUIREMENTS = Path(__file__).parents[1] / "requirements"
QUICK, FEW = "low_profile", 1  # what a coarse run answers: sizes alone; so many designs


def answer_stories(stories: Sequence[str], coarse: bool, folder: Path) -> None:
    """Answer requirement files, write their folders, print what is recommended, what binds, why others lost.

    Parameters
    ----------
    stories : sequence of str
        Names of files in ``studies/requirements``; a coarse run reads them all and answers a flat pad instead.
    coarse : bool
        Whether a search ends with its first design.
    folder : Path
        Of the study.
    """
    requirements = {story: read_requirements(REQUIREMENTS / f"{story}.toml") for story in stories}
    if coarse:
        requirements = {QUICK: read_requirements(REQUIREMENTS / f"{QUICK}.toml")}
    for story, asked in requirements.items():
        began = time.process_time()
        own = prepare_folder(folder / story)
        found = design(asked, folder=cases_folder(own), most=FEW if coarse else MOST)
        write_design(asked, found, own)
        print(f"{story}: {'recommended' if found.feasible else 'nearest'} {found.values}")
        for each in found.figures:
            if each.limit is not None:
                print("  ", "  ".join(cell for cell in figure_cells(each) if cell))
        for price in found.binding:
            print(f"   limits it: {price.name}, {price_words(price, list(found.task.minimised))}")
        for lost in found.lost:
            print(f"   not {lost.value}: {lost.why}")
        print(f"   {found.solves} designs, {time.process_time() - began:.0f} s of processor time")
