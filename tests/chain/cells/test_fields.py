"""What coils of cells see of targets: plates moved one by one, third ones, gaps; alike cells and others."""

from dataclasses import replace

import numpy as np
import pytest

from sits_mech.chain.cells.crosstalk import cell_crosstalk, forces_read
from sits_mech.chain.cells.fields import signal_slopes
from sits_mech.magnetics.sheets import sheets
from sits_mech.mechanics.cells.targets import cells_pad
from sits_mech.quantities import Pose
from sits_mech.scene.cells import load_cells
from sits_mech.scene.parts.metal import Conductor, Plate

COIL = (
    '{{name="{}", centre=["{}", "{}"], turns=5, layers=2, inner_diameter="1 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}}'
)
ONE = f'coils=[{COIL.format("C", "0 mm", "0 mm")}]'
REST = Pose(0.0, 2e-3)


def cells(centres, *keys):
    each = zip("ABC", centres, strict=False)
    places = ", ".join(f'{{name="{name}", centre=[{x}, {y}]}}' for name, (x, y) in each)
    return load_cells("biorob2018", [f"targets=[{places}]", *keys])


def shape_of(found, k=0):
    return {key: getattr(found.plates[k], key) for key in Plate.model_fields}


def on_x(half, *keys):
    return cells([(-half, 0.0), (half, 0.0)], *keys)


SMALL = ('targets.B.width="6 mm"', 'targets.B.length="4 mm"', 'targets.B.thickness="0.5 mm"')


@pytest.mark.slow
@pytest.mark.parametrize("keys", [(), SMALL])
def test_targets_that_are_moved_by_hand_change_a_coil_as_its_crosstalk_says(keys):
    """B as a fixed plate in other places, alone by d_v, and both as a press and a shear on B move them, either way.

    A's coil is on the side of B. What comes through fields, 0.4 and 1.2 % of what is read, brings the whole nearer.
    """
    pair = on_x(4.8e-3, f'coils=[{COIL.format("C", "2 mm", "0 mm")}]', 'elastomer.width="30 mm"', *keys)
    S, off = (each[0, 0] for each in signal_slopes(pair, forces_read(pair)[1], 1e-2))

    def half_change(A, B):
        read = []
        for way in (1.0, -1.0):
            d_h, d_v, alpha, *_ = REST.components + way * B
            x, z = np.array([np.sin(alpha), np.cos(alpha)]) * pair.plates[1].thickness / 2.0
            plate = Conductor(name="B", centre=(9.6e-3 + d_h + x, 0.0, d_v + z), alpha=alpha, **shape_of(pair, 1))
            scene = pair.sensor.model_copy(update={"elastomer": None, "conductors": (plate,)})
            pose = Pose(*(REST.components + way * A))
            read.append(sheets(scene, 1e-3).impedance(pose, scene.frequency).L[0, 0])
        return (read[0] - read[1]) / 2.0

    sunk = 1e-4 * np.eye(6)[1]
    assert S[1, 1] == pytest.approx(half_change(0.0 * sunk, sunk) / 1e-4, abs=off[1, 1]) and off[1, 1] < 0.1 * S[1, 1]
    found, C = cell_crosstalk(pair), cells_pad(pair).compliances[-1]
    own = S[0] @ C[0, :, 0, 1]
    for force, load, size in ((0, 1, 1.0), (1, 0, 0.3)):  # F_z, F_x
        by_hand = half_change(size * C[0, :, 1, load], size * C[1, :, 1, load]) / (size * own)
        whole, silicone = (each[0, 0, 1, force] for each in (found.total, found.mechanical))
        assert whole == pytest.approx(by_hand, rel=0.01) and abs(whole - by_hand) < 0.6 * abs(silicone - by_hand)


@pytest.mark.slow
@pytest.mark.parametrize(("widths", "beyond"), [((8.0, 8.0, 8.0), 0.05), ((12.0, 4.5, 12.0), 0.0)])
def test_third_targets_change_slopes_by_no_more_than_their_share(widths, beyond):
    """In a row at gaps of 1.6 mm the first one moves: seen by the next, and by the one beyond, among all and in pairs.

    Of alike ones the one beyond shows that a share is needed, and which.
    """
    x = np.cumsum([0.0, *(0.5 * (a + b) + 1.6 for a, b in zip(widths, widths[1:], strict=False))])
    sizes = [f'targets.{name}.width="{w} mm"' for name, w in zip("ABC", widths, strict=True)]
    row = cells([(1e-3 * at, 0.0) for at in x - x.mean()], ONE, 'elastomer.width="50 mm"', *sizes)
    S, off = (each[:, 0, 0, 1] for each in signal_slopes(row, forces_read(row)[1], 1e-2))
    plates = tuple(Conductor(name=f"P{k}", centre=(1e-3 * x[k], 0.0, 2.1e-3), **shape_of(row, k)) for k in (1, 2))
    among = np.zeros(3)
    for seen in (1, 2):
        coils = row.coils_at(seen, np.array([1e-3 * x[seen], 0.0]))
        scene = row.sensor.model_copy(update={"elastomer": None, "conductors": plates, "coils": coils})
        model = replace(sheets(scene, 1e-2), single=True)
        down, up = (model.impedance(Pose(0.0, 2e-3 + dz), scene.frequency).L[0, 0] for dz in (-2e-5, 2e-5))
        among[seen] = (up - down) / 4e-5
    assert np.all(np.abs(among - S)[1:] < off[1:])
    assert abs(among[2] / S[2] - 1.0) > beyond and abs(among[1] / S[1] - 1.0) < 0.05


@pytest.mark.slow
def test_slopes_go_on_where_another_preparation_serves_a_gap():
    """At 2 mm, as wide as coils are deep: change of preparation has no part in differences, which was a slope twice."""
    wide, one = ONE.replace("turns=5", "turns=12"), np.ones((2, 1, 1))
    each = [signal_slopes(on_x(half, wide, 'elastomer.width="30 mm"'), one, 0.1)[0] for half in (5e-3, 5.02e-3)]
    before, after = (S[0, 0, 1, :3] for S in each)
    assert np.all(np.abs(after / before - 1.0) < 0.05)
