"""Refuse loads and poses that are no numbers, or that leave the plane of a model."""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Pose, Wrench


def refuse_infinite(wrench: Wrench) -> None:
    """Raise ValueError for a load with a component that is not finite."""
    if not np.all(np.isfinite(wrench.components)):
        raise ValueError(f"wrench: must be finite numbers, got {wrench}")


def refuse_out_of_plane(model: str, given: Wrench | Pose, other: str) -> None:
    """Raise ValueError for components that leave the plane y = 0 of a `model`; `other` is the model that can."""
    if given.out_of_plane:
        kind, names = ("wrench" if isinstance(given, Wrench) else "pose"), ", ".join(given.out_of_plane)
        raise ValueError(f"{kind}: {names} must be zero for the model {model}, which is plane: ask for {other}")
