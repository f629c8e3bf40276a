"""How thick should the silicone be, and which one? Three requirement files and the story that each tells.

A fingertip wants to feel little forces in little room: the softest silicone that its overload does not stretch beyond
its data, as thick as tolerances call for and no thicker. A sole must carry: stiff silicone, and its price in error. A
gripper's pad reads shear, fast: coils and silicone trade noise for crosstalk. Each file stands in ``requirements/``;
its answer, scenes, pictures and page go to a folder of its name.

Run ``python studies/elastomer_thickness.py [--coarse] --output DIR``.
"""

from __future__ import annotations

from common.outputs import study_arguments
from common.stories import answer_stories

if __name__ == "__main__":
    answer_stories(("fingertip", "foot_sole", "gripper_pad"), *study_arguments(__doc__ or ""))
