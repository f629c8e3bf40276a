"""Which loads and poses does a model refuse? Those that are no numbers, and those that leave its plane."""

from __future__ import annotations

import numpy as np

from sits_mech.quantities import Pose, Wrench


def refuse_infinite(wrench: Wrench) -> None:
    """Refuse a load that is not a number.

    Raises
    ------
    ValueError
        For a component that is not finite.
    """
    if not np.all(np.isfinite(wrench.components)):
        raise ValueError(f"wrench: must be finite numbers, got {wrench}")


def refuse_beside(model: str, given: Wrench | Pose, other: str) -> None:
    """Refuse components that leave the plane y = 0, by name, for a model that cannot; `other` is the one that can.

    Raises
    ------
    ValueError
        One line.
    """
    if given.beside:
        kind, names = ("wrench" if isinstance(given, Wrench) else "pose"), ", ".join(given.beside)
        raise ValueError(f"{kind}: {names} must be zero for the model {model}, which is plane: ask for {other}")
