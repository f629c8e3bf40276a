"""How thick should the silicone be, which one, and how wide the target? Four requirement files and what each tells.

A fingertip wants to feel little forces in little room: the softest silicone that its overload does not stretch beyond
its data, as thick as tolerances call for and no thicker. A sole must carry: stiff silicone, and its price in error. A
gripper's pad reads shear, fast: coils and silicone trade noise for crosstalk.

The published study chose the target's width by moving it by hand. Here the layer answers a range of forces: a wider
target is held by more silicone and moves less, but covers more of the coils. The best width is that of the least sum of
both resolutions at the worst load; the landscape beside it shows how sharp the optimum is.

Each file stands in ``requirements/``; its answer, scenes, pictures and page go to a folder of its name.

Run ``python studies/thickness_design.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from common.outputs import study_arguments
from common.stories import answer_stories

if __name__ == "__main__":
    answer_stories(("fingertip", "foot_sole", "gripper_pad", "target_width"), *study_arguments(__doc__ or ""))
