"""The space between outlines: area, conformity, exact vertices, refusals."""

import builtins
import subprocess
import sys

import numpy as np
import pytest

from sits_mech.geometry.meshing.unstructured import MesherMissing, fill_between, mesh_generator


def _square(half: float, edges: int, centre: complex = 0j) -> np.ndarray:
    corners = half * np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
    steps = np.arange(edges) / edges
    sides = [a + (b - a) * steps for a, b in zip(corners, np.roll(corners, -1), strict=True)]
    points = np.concatenate(sides) + centre
    return np.column_stack([points.real, points.imag])


def _area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def test_fills_the_space_and_keeps_the_outlines() -> None:
    outer, holes = _square(1.0, 5), [_square(0.1, 20, 0.5j), _square(1e-3, 3, -0.4 + 0j)]
    points, triangles = fill_between(outer, holes)
    given = np.vstack([outer, *holes])
    assert np.array_equal(points[: len(given)], given)
    assert np.abs(_area(points, triangles)).sum() == pytest.approx(4 - 0.04 - 4e-6, rel=1e-9)
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.max() == 2
    assert np.sum(uses == 1) == len(given)  # no edge of an outline is divided


def test_a_broken_pipe_is_told_afterwards() -> None:
    """Where gmsh left the signal to the system, a process ended without a word as a worker of its pool did."""
    code = (
        "import os\nimport numpy as np\nfrom sits_mech.geometry.meshing.unstructured import fill_between\n"
        "square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])\n"
        "fill_between(square, [0.1 * square])\n"
        "end, pipe = os.pipe()\nos.close(end)\n"
        "try:\n    os.write(pipe, b'x')\nexcept BrokenPipeError:\n    print('told')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "told\n")


def test_bears_edges_of_a_hundred_millionth() -> None:
    """Needed where a skin is 1e-7 of a plate and the circle five times as far."""
    ends = np.geomspace(1e-8, 0.1, 25)
    side = np.concatenate([[0.0], ends, 0.2 - ends[-2::-1]])
    hole = np.vstack([np.column_stack([side - 0.1, np.full(side.size, -0.1)]), [[0.1, 0.1], [-0.1, 0.1]]])
    points, triangles = fill_between(_square(1.0, 5), [hole])
    assert np.abs(_area(points, triangles)).sum() == pytest.approx(4 - 0.04, rel=1e-9)


def test_missing_libraries_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def broken(name: str, *rest: object, **more: object) -> object:
        if name.startswith("pygmsh"):
            raise OSError("libGLU.so.1: cannot open shared object file")
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", broken)
    with pytest.raises(MesherMissing, match="apt-get install libglu1-mesa"):
        mesh_generator()
