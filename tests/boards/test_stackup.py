"""Heights of copper: from the file, summed by hand, or evenly over the thickness, which is told."""

from typing import Any

import pytest

from sits_mech.boards.expressions import parse_expression
from sits_mech.boards.stackup import permittivity, stack
from sits_mech.units import SceneError


def test_heights_of_a_stackup(draw: Any) -> None:
    """35 um copper, 200 um, 17.5 um, 600 + 400 um in two sublayers, 17.5 um, 200 um, 35 um; the mask counts not."""
    path = draw.board([], four=True)
    layers, notes = stack(parse_expression(path.read_text()), "board")
    assert notes == () and list(layers) == ["F.Cu", "In1.Cu", "In2.Cu", "B.Cu"]
    expected = [(0.0, 0.035), (-0.235, 0.0175), (-1.2525, 0.0175), (-1.47, 0.035)]  # top face and thickness [mm]
    for (top, thickness), layer in zip(expected, layers.values(), strict=True):
        assert layer.z == pytest.approx(1e-3 * (top - thickness / 2), abs=1e-12)
        assert layer.thickness == pytest.approx(1e-3 * thickness, rel=1e-12)


def test_dielectrics_are_in_series(draw: Any) -> None:
    """0.6 mm of 4.8 and 0.4 mm of 4 are 1 mm of 1/(0.6/4.8 + 0.4/4); below them it is not given."""
    layers, _ = stack(parse_expression(draw.board([], four=True).read_text()), "board")
    between = {(a, b): permittivity([layers[a], layers[b]]) for a, b in (("In2.Cu", "In1.Cu"), ("F.Cu", "In2.Cu"))}
    assert between["In2.Cu", "In1.Cu"] == pytest.approx(1.0 / 0.225, rel=1e-12)
    assert between["F.Cu", "In2.Cu"] == pytest.approx(1.2 / (0.225 + 0.2 / 4.5), rel=1e-12)
    assert permittivity([layers["F.Cu"], layers["B.Cu"]]) is None and permittivity([layers["F.Cu"]]) is None


def test_without_a_stackup_evenly(draw: Any) -> None:
    """Outer faces at the board's: middles 1.6 mm less one copper apart, told."""
    layers, notes = stack(parse_expression(draw.board([]).read_text()), "board")
    assert [layer.z for layer in layers.values()] == pytest.approx([-17.5e-6, -1.5825e-3], abs=1e-12)
    assert len(notes) == 1 and "copper of 35 um assumed on F.Cu, B.Cu, 1.565 mm apart" in notes[0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(kicad_pcb)", "must have copper layers"),
        ('(kicad_pcb (general (thickness 0.05)) (layers (0 "F.Cu" signal) (2 "B.Cu" signal)))', "above 2 times 35 um"),
        (
            '(kicad_pcb (layers (0 "F.Cu" signal)) (setup (stackup (layer "F.Cu" (type "copper") (thickness 0)))))',
            "F.Cu must have a thickness above 0 mm; got 0 mm",
        ),
    ],
)
def test_boards_that_cannot_be(text: str, expected: str) -> None:
    """No copper, or none of any thickness."""
    with pytest.raises(SceneError, match=expected):
        stack(parse_expression(text), "board")
