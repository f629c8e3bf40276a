"""Nested meshes: levels of a family (family.py) are refined (refine.py) to an answer with errors (answer.py)."""
