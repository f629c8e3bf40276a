"""How wide should the target be over a pair of coils, when forces, not poses, are what it has to resolve?

The published study chose the width by moving the target by hand. Here the layer answers a range of forces: a wider
target is held by more silicone and moves less, but covers more of the coils. The best width is that of the least sum of
both resolutions at the worst load (``requirements/target_width.toml``); the landscape beside it shows how sharp the
optimum is.

Run ``python studies/target_width.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from common.outputs import study_arguments
from common.stories import answer_stories

if __name__ == "__main__":
    answer_stories(("target_width",), *study_arguments(__doc__ or ""))
