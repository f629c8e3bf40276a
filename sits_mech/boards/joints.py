"""Join tracks: each end gets the number of its joint; vias and pads are joints, too.

Ends within a distance are one: the board's rounding, 1 um, or more on a board drawn with less care. What is loose after
that is joined as copper joins it: with a via that it ends in, with another loose end within half the narrower track,
with what else ends in the same pad. Tracks that lie twice count once; those that begin and end in one via, and those
that end loose within the copper of the joint they start from, do not count.

Pads with a number end the path: where two tracks or more meet in one, each end is a joint of its own. A pad that joins
two layers of its own footprint's lines is a via.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sits_mech.boards.copper import Hole, Track
from sits_mech.quantities import Array
from sits_mech.units import SceneError
from sits_mech.units import millimetres as mm

ROUNDING = 1e-6  # of a board's places [m]
_WIDEST = 4.0  # of a joint's ends, over the distance within which two are one
End = tuple[int, int]  # number of a track, and 0 for its first point or 1 for its last


@dataclass(frozen=True, eq=False)
class Joints:
    """Tracks and where they meet."""

    tracks: tuple[Track, ...]  # those that count
    numbers: NDArray[np.int64]  # (n, 2) of the joints at the first and last point of each track
    holes: tuple[tuple[int, Hole], ...] = ()  # vias and pads that are joints, by number

    @cached_property
    def track_nets(self) -> frozenset[str]:
        """Return the nets of the tracks."""
        return frozenset(track.net for track in self.tracks) - {""}

    @cached_property
    def hole_nets(self) -> frozenset[str]:
        """Return the nets of vias and pads."""
        return frozenset(hole.net for _, hole in self.holes) - {""}

    def point(self, end: End) -> Array:
        """Return an end of a track [m]."""
        return np.asarray(self.tracks[end[0]].points[-end[1]])

    def meeting(self) -> dict[int, list[End]]:
        """Return the ends that meet at each joint."""
        found: dict[int, list[End]] = {}
        for k, row in enumerate(self.numbers.tolist()):
            for e in (0, 1):
                found.setdefault(row[e], []).append((k, e))
        return found

    def loose(self) -> list[End]:
        """Return the ends that meet no other."""
        return [ends[0] for ends in self.meeting().values() if len(ends) == 1]

    @cached_property
    def _named_first(self) -> dict[int, Hole]:
        """Return a via or pad of each joint that has some, one with a name before others."""
        return dict(sorted(self.holes[::-1], key=lambda pair: bool(pair[1].name)))

    def hole(self, number: int) -> Hole | None:
        """Return the via or pad at a joint, one with a name before others."""
        return self._named_first.get(number)


def connections(tracks: Sequence[Track], holes: Sequence[Hole], nearness: float = ROUNDING, where: str = "") -> Joints:
    """Return where tracks meet each other and holes, ends within `nearness` [m] being one.

    Raise SceneError, which begins with `where`, when tracks are so short that they would shrink to a point; without
    `where` they may.
    """
    found = _without_stubs(_near(tracks, holes, nearness, where))
    return _parted(_overlapping(_without_stubs(_in_holes(found))))


def _near(tracks: Sequence[Track], holes: Sequence[Hole], nearness: float, where: str) -> Joints:
    """Join ends that are near each other, holes at their middles; drop tracks without length and duplicates."""
    places = [(track.layer, track.points[e]) for track in tracks for e in (0, -1)]
    places += [(layer, hole.place) for hole in holes for layer in hole.layers]
    layers, points = map(np.array, zip(*places, strict=True))
    starts = np.cumsum([2 * len(tracks), *(len(hole.layers) for hole in holes)]).tolist()
    pairs = list(zip(np.repeat(starts[:-1], np.diff(starts)), range(starts[0], starts[-1]), strict=True))  # of holes
    for layer in np.unique(layers):
        members = np.flatnonzero(layers == layer)
        pairs += members[cKDTree(points[members]).query_pairs(nearness, output_type="ndarray")].tolist()
    label = merged(len(points), pairs)
    if where:
        _check_small(points, label, nearness, where)
    ends = label[: 2 * len(tracks)].reshape(-1, 2)
    kept = _different(tracks, ends, nearness)
    at = tuple((int(label[a]), hole) for a, hole in zip(starts[:-1], holes, strict=True))
    return Joints(tuple(tracks[k] for k in kept), ends[kept], at)


def _different(tracks: Sequence[Track], ends: NDArray[np.int64], nearness: float) -> list[int]:
    """Return the tracks with a length that lie nowhere twice, from the joints at their ends (n, 2)."""
    known, kept = set(), list[int]()
    for k, track in enumerate(tracks):
        a, b = sorted(ends[k].tolist())
        sagitta = track.points[1:-1] - track.points[[0, -1]].mean(axis=0)
        lies = (a, b, *np.round(sagitta.ravel() / nearness / 4.0).tolist())
        if lies not in known and (a != b or float(np.ptp(track.points, axis=0).max()) > 4.0 * nearness):
            kept.append(k)
        known.add(lies)
    return kept


def _check_small(points: Array, label: NDArray[np.int64], nearness: float, where: str) -> None:
    """Refuse a nearness at which tracks in short steps shrink to a point."""
    low, high = np.full((2, len(points), 2), np.inf) * [[[1.0]], [[-1.0]]]
    np.minimum.at(low, label, points)
    np.maximum.at(high, label, points)
    if (high - low).max() > _WIDEST * nearness:
        raise SceneError(
            f"{where}: tracks must be longer than {mm(nearness, 3)} for ends that near to be one; got shorter ones"
        )


def merged(count: int, pairs: Sequence[tuple[int, int]] | NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the numbers of the groups that pairs make of `count` things."""
    i, j = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _renumbered(joints: Joints, pairs: Sequence[tuple[int, int]]) -> Joints:
    """Return the joints, those of each pair made one."""
    most = max([int(joints.numbers.max(initial=0)), *(number for number, _ in joints.holes), *map(max, pairs)])
    label = merged(most + 1, pairs)
    holes = tuple((int(label[number]), hole) for number, hole in joints.holes)
    return replace(joints, numbers=label[joints.numbers], holes=holes)


def _without_stubs(joints: Joints) -> Joints:
    """Leave out tracks that end loose within the copper of the joint of three or more that they start from."""
    while True:
        meeting = joints.meeting()
        stubs = {k for k, e in joints.loose() if _is_stub(joints, meeting, (k, e))}
        stubs |= {k for k, (a, b) in enumerate(joints.numbers.tolist()) if a == b and joints.hole(a) is not None}
        if not stubs:
            return joints
        kept = [k for k in range(len(joints.tracks)) if k not in stubs]
        joints = replace(joints, tracks=tuple(joints.tracks[k] for k in kept), numbers=joints.numbers[kept])


def _is_stub(joints: Joints, meeting: dict[int, list[End]], end: End) -> bool:
    """Tell whether the track of a loose end is hidden in the copper that it starts from."""
    number = int(joints.numbers[end[0], 1 - end[1]])
    others = [joints.tracks[k].width / 2 for k, _ in meeting[number] if k != end[0]]
    hole = joints.hole(number)
    reach = max([0.0, *others, *((max(hole.size) / 2,) if hole is not None else ())])
    length = float(np.hypot(*(joints.point((end[0], 1)) - joints.point((end[0], 0)))))
    return len(others) > 1 and length <= reach


def _in_holes(joints: Joints) -> Joints:
    """Join the ends that are loose, and joints of three or more, with the vias and pads that they lie in."""
    if not joints.holes or not joints.tracks:
        return joints
    open_ends = [(number, ends[0]) for number, ends in joints.meeting().items() if len(ends) != 2]
    points = np.array([joints.point(end) for _, end in open_ends]).reshape(-1, 2)
    places = np.array([hole.place for _, hole in joints.holes])
    near = cKDTree(points).query_ball_point(places, [np.hypot(*hole.size) / 2 for _, hole in joints.holes])
    pairs = []
    for (number, hole), some in zip(joints.holes, near, strict=True):
        for i in np.array(some, dtype=np.int64)[hole.holds(points[some])].tolist():
            joint, end = open_ends[i]
            if joints.tracks[end[0]].layer in hole.layers:
                pairs.append((joint, number))
    return _renumbered(joints, pairs)


def _overlapping(joints: Joints) -> Joints:
    """Join loose ends of two tracks on one layer, each the other's nearest, within half the narrower of them."""
    by_layer: dict[str, list[End]] = {}
    for end in joints.loose():
        by_layer.setdefault(joints.tracks[end[0]].layer, []).append(end)
    near = dict(pair for ends in by_layer.values() for pair in _nearest(joints, ends))
    pairs = [(end, other) for end, other in near.items() if near.get(other) == end and end < other]
    return _renumbered(joints, [(int(joints.numbers[a]), int(joints.numbers[b])) for a, b in pairs])


def _nearest(joints: Joints, ends: Sequence[End]) -> Iterator[tuple[End, End]]:
    """Yield ends, each with the nearest one of another track where it is within half the narrower of them."""
    points = np.array([joints.point(end) for end in ends])
    nearest = np.atleast_2d(cKDTree(points).query(points, k=3)[1])  # itself, the track's other end, the next
    for end, which in zip(ends, nearest, strict=True):
        for other in [ends[k] for k in which if k < len(ends) and ends[k][0] != end[0]][:1]:
            gap = float(np.hypot(*(joints.point(other) - joints.point(end))))
            if gap <= min(joints.tracks[end[0]].width, joints.tracks[other[0]].width) / 2:
                yield end, other


def _is_via(joints: Joints, hole: Hole, ends: Sequence[End]) -> bool:
    """Tell whether a pad joins lines of its footprint on two layers, and no more."""
    tracks = [joints.tracks[k] for k, _ in ends]
    own = all(track.footprint == hole.footprint for track in tracks)
    return own and len(tracks) == 2 and tracks[0].layer != tracks[1].layer


def _parted(joints: Joints) -> Joints:
    """Give each end in a pad with a name, where several meet, a joint of its own, with the pad."""
    numbers, holes = joints.numbers.copy(), list(joints.holes)
    free = max([int(numbers.max(initial=0)), *(number for number, _ in holes)]) + 1
    for number, ends in joints.meeting().items():
        hole = joints.hole(number)
        if hole is None or not hole.name or len(ends) < 2 or _is_via(joints, hole, ends):
            continue
        for end in ends[1:]:
            numbers[end] = free
            holes.append((free, hole))
            free += 1
    return replace(joints, numbers=numbers, holes=tuple(holes))
