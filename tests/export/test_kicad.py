"""The footprint, read back from its file: copper that is connected, turns as often as it should, touches nothing."""

import math
import re
import shutil
import subprocess
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sits_mech.export.kicad import copper_layers, winding, write_kicad
from sits_mech.export.source import Source
from sits_mech.geometry.tracks import track_length
from sits_mech.scene.sensor import Sensor, changed, load_sensor, sensor_from


def parsed(text: str) -> list[Any]:
    """Return an s-expression as nested lists."""
    stack: list[list[Any]] = [[]]
    for token in re.findall(r'"[^"]*"|[()]|[^\s()]+', text):
        if token == "(":
            stack.append([])
        elif token == ")":
            stack[-2].append(stack.pop())
        else:
            stack[-1].append(token.strip('"'))
    assert len(stack) == 1 and len(stack[0]) == 1
    return stack[0][0]


def value(node: list[Any], key: str) -> list[Any]:
    """Return what stands behind a key of a node."""
    return next(item[1:] for item in node if isinstance(item, list) and item[0] == key)


def point(node: list[Any], key: str) -> np.ndarray:
    """Return a point, y up [mm]."""
    x, y = (float(text) for text in value(node, key))
    return np.array([x, -y])


def arc(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return points on the arc through three."""
    m = np.array([b - a, c - a])
    centre = np.linalg.solve(2.0 * m, (np.array([b, c]) ** 2).sum(axis=1) - (a**2).sum())
    angles = [math.atan2(*(p - centre)[::-1]) for p in (a, b, c)]
    angles = np.unwrap(angles)
    turn = np.linspace(angles[0], angles[2], 9)
    return centre + np.hypot(*(a - centre)) * np.column_stack([np.cos(turn), np.sin(turn)])


def runs(tree: list[Any]) -> dict[str, list[np.ndarray]]:
    """Return the runs of copper of each layer, pieces that meet joined, as points [mm]."""
    found: dict[str, list[np.ndarray]] = {}
    for node in tree:
        if not isinstance(node, list) or node[0] not in ("fp_arc", "fp_line"):
            continue
        a, c = point(node, "start"), point(node, "end")
        line = arc(a, point(node, "mid"), c) if node[0] == "fp_arc" else np.linspace(a, c, 9)
        layer = found.setdefault(value(node, "layer")[0], [])
        if layer and np.allclose(layer[-1][-1], line[0], atol=2e-6):
            layer[-1] = np.vstack([layer[-1], line[1:]])
        else:
            layer.append(line)
    return found


def footprint(sensor: Sensor, folder: Path) -> list[Any]:
    """Return the tree of a sensor's footprint."""
    write_kicad(Source(sensor, None), folder / "coils.kicad_mod")  # type: ignore[arg-type]
    return parsed((folder / "coils.kicad_mod").read_text())


def turned(line: np.ndarray, centre: np.ndarray) -> float:
    """Return how often a line goes round a centre, counter-clockwise."""
    angle = np.unwrap(np.arctan2(*(line - centre).T[::-1]))
    return float(angle[-1] - angle[0]) / (2.0 * math.pi)


SENSOR = load_sensor("biorob2018-w15")


def test_turns_and_length(tmp_path: Path) -> None:
    """Twelve turns counter-clockwise on each layer; the length of the tracks and leads, by `geometry.windings`."""
    tree = footprint(SENSOR, tmp_path)
    assert tree[0] == "footprint" and value(tree, "net_tie_pad_groups") == ["1,2", "3,4"]
    lines = runs(tree)
    assert set(lines) == {"F.Cu", "B.Cu"}
    for coil in SENSOR.coils:
        centre, length = 1e3 * np.asarray(coil.centre), 0.0
        for layer in lines.values():
            near = [line for line in layer if np.hypot(*(line[len(line) // 2] - centre)) < 4.0]
            assert sum(turned(line, centre) for line in near if len(line) > 100) == pytest.approx(12.0, abs=0.06)
            length += sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in near if len(line) > 100)
        assert length == pytest.approx(1e3 * track_length(coil), abs=2.5)  # leads and the way to the via


@pytest.mark.parametrize(("scene", "layers"), [
    *(("biorob2018-w15", layers) for layers in (1, 2, 3, 4, 6)), ("triaxial-4", 2), ("triaxial-4", 4), ("triaxial-3", 2)
])
def test_nothing_touches_that_should_not(scene: str, layers: int, tmp_path: Path) -> None:
    """On each layer copper of other runs, turns and holes keeps the gap, to 2 um; each end meets its hole."""
    sensor = load_sensor(scene)
    sensor = changed(sensor, [f"coils.{coil.name}.layers={layers}" for coil in sensor.coils])
    tree = footprint(sensor, tmp_path)
    width, gap = 1e3 * sensor.coils[0].track_width, 1e3 * sensor.coils[0].track_gap
    pads = [node for node in tree if isinstance(node, list) and node[0] == "pad"]
    assert sorted(pad[1] for pad in pads if pad[1]) == [str(k + 1) for k in range(2 * len(sensor.coils))]
    holes = [(point(pad, "at"), float(value(pad, "size")[0]) / 2) for pad in pads]
    for (p, r), (q, s) in combinations(holes, 2):
        assert np.hypot(*(p - q)) >= r + s + gap - 2e-3
    lines = runs(tree)
    assert tuple(lines) == copper_layers(layers)
    for layer in lines.values():
        for line in layer:
            step = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
            near = cKDTree(line).query_pairs(width + gap - 2e-3, output_type="ndarray")
            assert np.abs(np.diff(step[near], axis=1)).max() < 4 * (width + gap)  # neighbours along the line alone
            for place, radius in holes:
                away = np.hypot(*(line - place).T)
                at_end = min(away[0], away[-1]) < 1e-5
                assert at_end or away.min() >= radius + width / 2 + gap - 2e-3
            assert sum(min(np.hypot(*(line[end] - place)) for place, _ in holes) < 1e-5 for end in (0, -1)) == 2
        for one, other in combinations(layer, 2):
            ends = {tuple(np.round(line[end], 4)) for line in (one,) for end in (0, -1)}
            if not ends & {tuple(np.round(other[end], 4)) for end in (0, -1)}:
                assert cKDTree(one).query(other)[0].min() >= width + gap - 2e-3


def test_current_turns_one_way_through_all_layers() -> None:
    """Every spiral of a coil runs counter-clockwise from its start to its end, alternately inwards and outwards."""
    sensor = changed(SENSOR, ["coils.C1.layers=4", "coils.C2.layers=4"])
    spirals = [track.points for track in winding(sensor, 0).tracks if track.arcs]
    centre = np.asarray(sensor.coils[0].centre)
    for number, line in enumerate(spirals):
        radius = np.hypot(*(line - centre).T)
        assert turned(line, centre) == pytest.approx(12.0) and (radius[0] > radius[-1]) == (number % 2 == 0)


def test_target_is_drawn(tmp_path: Path) -> None:
    """The rim of a round target, about the sensor's centre, for whoever places it."""
    tree = footprint(load_sensor("triaxial-4"), tmp_path)
    rim = next(node for node in tree if isinstance(node, list) and node[0] == "fp_poly")
    corners = np.array([[float(x), float(y)] for _, x, y in value(rim, "pts")])
    assert value(rim, "layer") == ["Dwgs.User"] and len(corners) > 60
    np.testing.assert_allclose(np.hypot(*corners.T), 6.0, atol=1e-6)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("kicad-cli") is None, reason="kicad-cli (KiCad 7 or later) is not installed")
@pytest.mark.parametrize("scene", ["biorob2018", "triaxial-4", "triaxial-3"])
def test_kicad_opens_it(scene: str, tmp_path: Path) -> None:
    """KiCad reads the footprint and plots each copper layer: an arc for each of the file's, and its pads."""
    library = tmp_path / "coils.pretty"
    library.mkdir()
    tree = footprint(load_sensor(scene), library)
    arcs = [value(node, "layer")[0] for node in tree if isinstance(node, list) and node[0] == "fp_arc"]
    for layer in ("F.Cu", "B.Cu"):
        command = ["kicad-cli", "fp", "export", "svg", "--footprint", "coils", "--layers", layer, "-o", layer, library]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr
        picture = (tmp_path / layer / "coils.svg").read_text()
        assert len(re.findall(r"\bA\d", picture)) == arcs.count(layer) > 250
        assert picture.count("<circle") >= sum(isinstance(node, list) and node[0] == "pad" for node in tree)


@pytest.mark.parametrize(("change", "message"), [
    (["coils.C1.inner_diameter=0.0006"], r"coils.C1.inner_diameter: must be at least 0.8 mm for a via; got 0.6 mm"),
    (["coils.C1.layers=4"], "coils: must have one number of layers"),
    (["substrate_radius=0.05"], "substrate_radius: must not be given"),
    (["coils.C1.directions=[1, -1]"], "coils.C1.directions: must not be given for --to kicad"),
])
def test_what_is_no_footprint(change: list[str], message: str, tmp_path: Path) -> None:
    """No room for a via, boards of two stacks, a round board, layers wound against each other."""
    with pytest.raises(ValueError, match=message):
        footprint(changed(SENSOR, change), tmp_path)


SHAPES = {
    "rectangle": {"inner_width": 2e-3, "inner_length": 3e-3}, "hexagon": {"inner_diameter": 2e-3},
    "octagon": {"inner_diameter": 2e-3, "alpha_z": 0.2},
    "D": {"inner_width": 2e-3, "inner_length": 2.5e-3, "alpha_z": 2.0},
}


def drawn(shape: str, layers: int, turns: int = 5) -> Sensor:
    """Two coils of a shape with straight tracks."""
    track = {"track_width": 0.1e-3, "track_gap": 0.1e-3, "track_thickness": 35e-6, "layer_pitch": 85e-6}
    own = track | SHAPES[shape] | {"shape": shape, "layers": layers, "turns": turns}
    coils = [own | {"name": name, "centre": [x, 0.0]} for name, x in (("C1", -4e-3), ("C2", 4e-3))]
    return sensor_from({"name": shape, "frequency": 1e6, "coils": coils})


@pytest.mark.parametrize(("shape", "layers"), [(shape, layers) for shape in SHAPES for layers in (1, 2)])
def test_turns_of_lines_are_clear_of_each_other(shape: str, layers: int, tmp_path: Path) -> None:
    """Five turns counter-clockwise on each layer, as long as the scene's; copper keeps the gap to all else."""
    import shapely

    sensor = drawn(shape, layers)
    tree = footprint(sensor, tmp_path)
    pads = [node for node in tree if isinstance(node, list) and node[0] == "pad"]
    holes = [(point(pad, "at"), float(value(pad, "size")[0]) / 2) for pad in pads]
    for layer in runs(tree).values():
        lines = [shapely.LineString(line) for line in layer]
        for line, whole in zip(layer, lines, strict=True):
            ends = [min(np.hypot(*(line[end] - place)) for place, _ in holes) for end in (0, -1)]
            assert max(ends) < 1e-5 and whole.is_simple
            assert whole.buffer(0.0995).area > 0.97 * whole.length * 2 * 0.0995  # turns of 0.1 mm keep their gap
            for place, radius in holes:
                if min(np.hypot(*(line[end] - place)) for end in (0, -1)) > 1e-5:
                    assert whole.distance(shapely.Point(place)) >= radius + 0.05 + 0.1 - 2e-3
        assert all(a.distance(b) > 0.198 for a, b in combinations(lines, 2))
        for coil in sensor.coils:
            centre = 1e3 * np.asarray(coil.centre)
            (line,) = (line for line in layer if np.hypot(*(line[len(line) // 2] - centre)) < 3.5)
            assert turned(line, centre) == pytest.approx(5.0, abs=0.15)
            length = np.hypot(*np.diff(line, axis=0).T).sum()
            assert length == pytest.approx(1e3 * track_length(coil) / layers, abs=3.0)  # leads and the way to the via


def test_free_tracks_are_refused_by_name(tmp_path: Path) -> None:
    """And corners that are rounded."""
    line = [[0.0, 0.0, -1e-4], [2e-3, 0.0, -1e-4], [2e-3, 2e-3, -1e-4]]
    coil = {"name": "C1", "shape": "path", "path": [line], "track_width": 1e-4, "track_thickness": 35e-6}
    with pytest.raises(ValueError, match='coils.C1.shape: must have turns for --to kicad; got "path"'):
        footprint(sensor_from({"name": "free", "frequency": 1e6, "coils": [coil]}), tmp_path)
    with pytest.raises(ValueError, match="coils.C1.corner_radius: must not be given for --to kicad; got 0.0005"):
        footprint(changed(drawn("rectangle", 2), ["coils.C1.corner_radius=0.0005"]), tmp_path)
    with pytest.raises(ValueError, match="coils.C1.layers: must be at most 2 of a hexagon for --to kicad; got 4"):
        footprint(drawn("hexagon", 4), tmp_path)
    with pytest.raises(ValueError, match=r"coils.C1.inner_diameter: must be at least 0.8 mm for a via; got 0.7 mm"):
        footprint(changed(drawn("hexagon", 2), ["coils.C1.inner_diameter=0.0007"]), tmp_path)
