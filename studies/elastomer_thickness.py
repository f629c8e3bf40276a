"""How thick should the silicone be, and which one? Three requirement files and the story that each tells.

A fingertip wants to feel little forces in little room: the softest silicone that its overload does not tear, as thick
as tolerances call for and no thicker. A sole must carry: stiff silicone, and its price in error. A gripper's pad reads
shear, fast: coils and silicone trade noise for crosstalk. Each file stands in ``requirements/``; its answer, scenes,
pictures and page go to a folder of its name.

Run ``python studies/elastomer_thickness.py [--coarse] --output DIR``.
"""

from __future__ import annotations

import time
from pathlib import Path

from common.outputs import study_arguments

from sits_mech.report.design import write_design
from sits_mech.report.folder import cases_folder, prepare_folder
from sits_mech.report.tables.design import figure_cells, price_words
from sits_mech.synthesis.requirements import read_requirements
from sits_mech.synthesis.run import design

STORIES = ("fingertip", "foot_sole", "gripper_pad")
REQUIREMENTS = Path(__file__).parent / "requirements"
FEW = 1  # designs of a coarse run, beside the round one


def main() -> None:
    """Answer each file, write its folder, print what is recommended and what binds."""
    coarse, folder = study_arguments(__doc__ or "")
    for story in STORIES[:1] if coarse else STORIES:
        asked, began = read_requirements(REQUIREMENTS / f"{story}.toml"), time.process_time()
        own = prepare_folder(folder / story)
        found = design(asked, folder=cases_folder(own), most=FEW) if coarse else design(asked, folder=cases_folder(own))
        write_design(asked, found, own)
        print(f"{story}: {'recommended' if found.feasible else 'nearest'} {found.values}")
        for each in found.figures:
            if each.limit is not None:
                print("  ", "  ".join(cell for cell in figure_cells(each) if cell))
        for price in found.binding:
            print(f"   limits it: {price.name}, {price_words(price.excess, price.gain)}")
        for each in found.lost:
            print(f"   not {each.value}: {each.why}")
        print(f"   {found.solves} designs, {time.process_time() - began:.0f} s of processor time")


if __name__ == "__main__":
    main()
