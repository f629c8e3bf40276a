"""Pictures of the field: what they show is the solution; plates lie where the pose puts them; axes have units."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from sits_mech.magnetics.field import PlanarField, planar_fem
from sits_mech.quantities import Pose
from sits_mech.report.pictures.fields import CURRENT_HEIGHT, draw_current, draw_potential, potential_height
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.sensor import load_sensor


@pytest.fixture(scope="module")
def field() -> PlanarField:
    found = planar_fem(load_sensor("biorob2018"), 1e-2).field(Pose(1e-3, 2e-3, 0.2), 5e6)
    assert found is not None
    return found


@pytest.mark.slow
def test_flux_lines(field: PlanarField, tmp_path: Path, collisions: Callable[[Figure], list[str]]) -> None:
    with new_figure(potential_height(field)) as (figure, (axes,)):
        draw_potential(axes, field, np.array([0.0, 1e-3]))
    plate = axes.collections[-1].get_paths()[0].vertices
    assert plate[:4].mean(axis=0) == pytest.approx([1 + 0.1 * np.sin(0.2), 2 + 0.1 * np.cos(0.2)])  # middle [mm]
    assert "[mm]" in axes.get_xlabel() and "[mm]" in axes.get_ylabel() and "Wb/m" in figure.axes[1].get_xlabel()
    assert collisions(figure) == [] and "flux lines" in axes.get_title()
    save_figure(figure, tmp_path / "field.png")
    assert (tmp_path / "field.png").stat().st_size > 1000


def test_current_density_integrates_to_no_net_current(field: PlanarField) -> None:
    """Over the drawn section; the loop that the currents close carries 100 times more."""
    currents = np.array([0.0, 1e-3])
    with new_figure(CURRENT_HEIGHT) as (figure, (axes,)):
        draw_current(axes, field, currents)
    assert "[mm]" in figure.axes[0].get_xlabel() and "A/mm" in figure.axes[1].get_xlabel()
    plate = field.plates[0]
    ends = [0.5 * length * (1 - np.cos(np.linspace(0, np.pi, n))) for length, n in ((plate.width, 400), (0.2e-3, 80))]
    x, z = ((s[1:] + s[:-1]) / 2 for s in ends)
    area = np.outer(np.diff(ends[1]), np.diff(ends[0]))
    places = plate.placed(x - plate.width / 2 + 1j * z[:, None])
    J = field.current_density(0, places.ravel(), currents.astype(complex)).reshape(places.shape)
    assert abs(np.sum(J * area)) < 0.01 * np.sum(np.abs(J) * area)
