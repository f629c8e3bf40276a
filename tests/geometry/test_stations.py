"""Stations along tracks: what is interpolated from nodes to turns, all around, of every shape of coil."""

import numpy as np
import pytest

from sits_mech.geometry.stations import stations
from sits_mech.geometry.tracks import coil_tracks, standing_rings
from sits_mech.geometry.windings import turn_radii
from sits_mech.scene.sensor import Coil

MM = 1e-3
TRACK = {"name": "C", "centre": (0.0, 0.0), "track_width": 1e-4, "track_gap": 1e-4, "track_thickness": 35e-6}
ROUND = Coil(**TRACK, layers=2, turns=12, inner_diameter=2.2 * MM, layer_pitch=85e-6)
SQUARE = Coil(
    **TRACK, shape="rectangle", layers=2, turns=6, inner_width=3 * MM, inner_length=5 * MM, layer_pitch=85e-6,
)


def linear(points: np.ndarray) -> np.ndarray:
    """B that changes linearly in space, at points (k, 3); shape (1, k, 3, 1)."""
    x, y, z = points.T
    return np.stack([x, y, 1.0 + 3.0 * np.hypot(x, y) + 40.0 * z], axis=1)[None, :, :, None]


@pytest.mark.parametrize("gap", [2 * MM, 0.2 * MM])
def test_a_linear_field_is_exact_at_every_turn(gap: float) -> None:
    """Up and outwards, on every layer where nodes are across the height, else on the middle of them."""
    own, rings = stations(ROUND, gap), standing_rings(ROUND)
    b = own.by_turns(own.across(linear(own.points.reshape(-1, 3)).astype(complex)))[0, 0]
    up, out = np.split(b.real, 2, axis=1)
    np.testing.assert_allclose(up, np.broadcast_to(1.0 + 3.0 * rings.radius + 40.0 * rings.z.mean(), up.shape))
    np.testing.assert_allclose(out, np.broadcast_to(rings.radius, out.shape), rtol=1e-12)
    assert own.share.sum() == pytest.approx(1.0) and np.ptp(own.share) < 1e-15


def test_close_metal_has_more_of_them_and_tall_coils_nodes_over_their_height() -> None:
    far, near = stations(ROUND, 2 * MM), stations(ROUND, 0.1 * MM)
    assert far.points.shape[:2] == (16, 4) and near.points.shape[:2] == (32, 12)
    tall = ROUND.model_copy(update={"layer_pitch": 1.0 * MM})
    assert np.unique(stations(tall, 2 * MM).points[..., 2]).size == 2


def test_a_rectangle_has_its_tracks_own_places() -> None:
    """From the middle out as its rings, on their layer, outward across the nearest track."""
    own, rings = stations(SQUARE, 1 * MM), standing_rings(SQUARE)
    assert own.points.shape[1] == rings.radius.size and own.share.sum() == pytest.approx(1.0)
    np.testing.assert_array_equal(own.turns, np.eye(rings.radius.size))
    np.testing.assert_allclose(own.points[..., 2], np.broadcast_to(rings.z, own.points.shape[:2]))
    for layer in (slice(0, 6), slice(6, 12)):
        away = np.abs(own.points[:, layer, :2]).max(axis=-1)
        assert np.all(np.einsum("smk,smk->sm", own.outward, own.points[..., :2]) > 0.0) and away.min() > 1.5 * MM
    tracks = coil_tracks(SQUARE)
    ends = np.minimum(tracks.start, tracks.end), np.maximum(tracks.start, tracks.end)
    for place in own.points.reshape(-1, 3):
        assert np.any(np.all((place > ends[0] - 1e-9) & (place < ends[1] + 1e-9), axis=1))


def test_few_turns_are_their_own_nodes() -> None:
    one = ROUND.model_copy(update={"turns": 2, "layers": 1})
    np.testing.assert_allclose(np.hypot(*stations(one, 1 * MM).points[0, :, :2].T), turn_radii(one))
