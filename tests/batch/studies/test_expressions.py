"""Conditions and derived keys: what their texts say, and what is refused without being executed."""

import pytest

from sits_mech.batch.studies.expressions import expression, names_of
from sits_mech.units import SceneError

VALUES = {"target.width": 0.008, "dv": 2e-3, "alpha": 0.1, "moment": 1e-3, "target.material": "copper", "n": 3.0}


@pytest.mark.parametrize(
    ("text", "true"),
    [
        ("target.width <= 8 mm", True),
        ("target.width<8mm", False),
        ("1 mm < dv - 0.5 * 1e-3 < 1.6 mm", True),
        ("alpha > 5 deg", True),
        ("moment >= '2 N*mm'", False),
        ('target.material == "copper"', True),
        ("target.material != 'brass'", True),
        ("-dv < +0.0", True),
        ("target.width / dv == 4", True),
    ],
)
def test_a_condition_holds_or_not(text: str, true: bool) -> None:
    """In SI, by hand."""
    assert expression("where", text, condition=True)(VALUES) is true


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true') < 1", "dv", "dv < 1 and n < 2", "dv ** 2 < 1", "[dv] < 1", "dv < (n := 3)",
        "dv.__class__() < 1", "lambda: 1 < 2", "dv[0] < 1", "f'{dv}' < 1", "dv < 1 if n else 2", "dv < True", "", 1,
        "(dv < 1) < 2", "dv <", "dv in n", "n < " + "-" * 5000 + "1", "\0",
    ],
)
def test_what_is_no_condition(text: object) -> None:
    """Refused in one line before any point is looked at."""
    with pytest.raises(SceneError, match="where: must be a comparison of names of keys") as caught:
        expression("where", text, condition=True)
    assert "\n" not in str(caught.value)


def test_bad_names_units_and_kinds() -> None:
    """The nearest name; a unit that does not exist; a word where a number must be; a division by zero."""
    with pytest.raises(SceneError, match=r'where: must name .*; got "target.widht" \(did you mean "target.width"\?\)'):
        expression("where", "target.widht < 1 mm", condition=True)(VALUES)
    with pytest.raises(SceneError, match='units that exist; got "8 mmm"'):
        expression("where", "dv < 8 mmm", condition=True)
    for text in ("target.material < 1", "dv / 0 < 1"):
        with pytest.raises(SceneError, match="where: must be of numbers"):
            expression("where", text, condition=True)(VALUES)
    with pytest.raises(SceneError, match="derive.dv: must be made of"):
        expression("derive.dv", "dv < 1")


def test_names_of_tables() -> None:
    """Dots join them, entries of lists go by their names."""
    table = {"a": 1, "target": {"width": 2}, "coils": [{"name": "C1", "turns": 3}, {"name": "C2", "turns": 4}]}
    found = names_of(table)
    assert found["target.width"] == 2 and found["coils.C2.turns"] == 4 and found["a"] == 1
    assert expression("derive.x", "coils.C1.turns + target.width")(found) == 5
