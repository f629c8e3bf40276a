"""What stress answers a given history of strain, by quadrature alone, for laws with a rate and a softening?

Paths of one material point, proportional and not, in plane strain and in space, and materials of every kind
(common/history_points.py says the model and the method). First Piola stresses at some forty times, and how much they
change when the pieces of the quadrature are halved. Paths stand in the file as corners of signals and as expressions
of these, so that a test can follow them with its own steps.

Run ``python -m benchmarks.reference_points [--coarse] --output DIR``; common/reference_points.json is its full run.
"""

from __future__ import annotations

import itertools

import numpy as np
from common.history_points import Path, Point, stresses
from common.outputs import study_arguments, write_references

MU, K = 30e3, 3e6
BRANCHES = ((0.2, 0.5), (0.1, 10.0))
SOFT = {"r": 2.5, "m": 0.0, "beta": 1.0}
LAWS = {
    "neo-hookean": {"shear_modulus": MU},
    "yeoh": {"c10": 0.5 * MU, "c20": 0.05 * MU, "c30": 0.01 * MU},
    "ogden": {"mu": [0.7 * MU, 0.3 * MU], "alpha": [3.3, -2.4]},
}
PATHS = {
    "plane, simple shear, held and back": Path(
        (0.0, 0.4, 3.0, 3.4, 6.0), {"s": (0.0, 1.0, 1.0, 0.0, 0.0)},
        (("1", "0", "0.4*s"), ("0", "1", "0"), ("0", "0", "1")),
    ),
    "plane, pressed, held, sheared, half back": Path(
        (0.0, 0.5, 1.5, 2.0, 2.6, 4.0), {"a": (0.0, 1.0, 1.0, 1.0, 0.4, 0.4), "b": (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)},
        (("1/(1 - 0.15*a) - 0.002*a", "0", "0.3*b"), ("0", "1", "0"), ("0.05*a*b", "0", "1 - 0.15*a")),
    ),
    "space, pulled twice, further the second time": Path(
        (0.0, 1.0, 2.0, 3.5, 5.0), {"s": (0.0, 1.0, 0.0, 1.5, 0.0)},
        (("(1 + 0.4*s)**-0.5", "0", "0"), ("0", "(1 + 0.4*s)**-0.5", "0"), ("0", "0", "1 + 0.4*s")),
    ),
    "space, pulled, sheared both ways, turned, volume changed": Path(
        (0.0, 0.6, 1.2, 1.8, 3.0), {"a": (0.0, 1.0, 0.2, 0.6, 0.0), "b": (0.0, 0.3, 1.0, -0.5, 0.0)},
        (("1 + 0.2*a", "0.25*b", "0.1*a"), ("-0.1*b", "1 - 0.1*a", "0.2*b"), ("0.15*b", "-0.05*a", "1 - 0.09*a")),
    ),
}
ABOUT = (
    "First Piola stress P [Pa] at `time` [s] of one material point of a law with Prony branches (weight, time) and "
    "Ogden-Roxburgh softening (r, m, beta), F(t) given: rows of F are expressions of signals, linear between the "
    "corners. Axes x, y, z, y out of plane. W_max: the largest isochoric elastic energy so far [Pa]. error: largest "
    "change of any P, over the largest P without its mean pressure, when the quadrature's pieces are halved. Made by "
    "benchmarks/reference_points.py by complex steps and Gauss' rule; model: J. C. Simo 1987, Ogden and Roxburgh 1999."
)


def row(law: str, soft: bool, viscous: bool, name: str, count: int) -> dict[str, object]:
    """Return the stresses of one material on one path."""
    path = PATHS[name]
    point = Point(law, LAWS[law], K, BRANCHES if viscous else (), SOFT if soft else None)
    time = sorted({*np.round(np.linspace(0.0, path.time[-1], count), 9).tolist(), *path.time})
    P, largest = stresses(point, path, time)
    finer, _ = stresses(point, path, time, parts=8.0)
    size = float(np.abs(P - np.trace(P, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3.0).max())
    return {
        "name": f"{law}{', softened' if soft else ''}{', viscous' if viscous else ''}: {name}",
        "law": law, "constants": LAWS[law], "bulk_modulus": K,
        "prony": [{"weight": w, "time": tau} for w, tau in point.prony], "mullins": SOFT if soft else None,
        "corners": path.time, "signals": path.signals, "F": path.F, "time": time,
        "P": [[float(f"{x:.11g}") for x in one.ravel()] for one in finer],
        "W_max": [float(f"{x:.11g}") for x in largest], "error": float(f"{np.abs(finer - P).max() / size:.2g}"),
    }


def main() -> None:
    """Integrate and write."""
    coarse, output = study_arguments(__doc__ or "")
    kinds = [(True, True), (False, True), (True, False)]
    every = list(itertools.product(LAWS, kinds, PATHS))[:: 13 if coarse else 1]
    rows = [row(law, soft, viscous, name, 7 if coarse else 31) for law, (soft, viscous), name in every]
    for one in rows:
        print(f"{one['name']}: {one['error']:.1e}", flush=True)
    write_references(rows, ABOUT, output / "reference_points.json")


if __name__ == "__main__":
    main()
