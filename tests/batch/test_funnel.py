"""Which cases go on: conditions on all parts, the worst part in order, cases without an answer."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from sits_mech.batch.funnel import following, going_on
from sits_mech.batch.studies.asked import Stage, Study
from sits_mech.batch.studies.samples import expression
from sits_mech.units import SceneError

STATES = ["ok", "above tolerance", "failed", "interpolated", "ok", "unfinished"]
TABLE = xr.Dataset(
    {
        "resolution": (("width", "dv", "force"), np.array([[[1, 9], [5, 4], [2, 2]], [[3, 8], [6, 7], [1, 1]]]) * 1e-3),
        "both": (("width", "dv", "force"), np.array([[[1, 9], [5, 4], [2, 2]], [[3, 8], [6, 7], [1, 1]]]) * 2e-3),
        "stretch": (("width", "dv"), np.array([[1.5, 2.5, 1.0], [1.8, np.nan, 1.0]])),
        "status": (("width", "dv"), np.array(STATES, dtype=object).reshape(2, 3)),
        "unit_L": (("width", "dv"), np.full((2, 3), "H", dtype=object)),
    },
    {"width": [8e-3, 9e-3], "dv": [1e-3, 2e-3, 3e-3], "force": ["F_x", "F_z"]},
)


def stage(*where: str, least: str = "", largest: str = "", count: int | None = None) -> Stage:
    """A stage of conditions and an order."""
    tests = tuple(expression("then.1.where", text, condition=True) for text in where)
    order = expression("then.1.least", least or largest) if least or largest else None
    return Stage(tests, order, bool(largest), count, None)


@pytest.mark.parametrize(
    ("asked", "numbers"),
    [
        (stage(), [0, 1, 3, 4]),
        (stage("resolution <= 5 mN"), [1]),
        (stage("resolution.F_x <= 5 mN"), [0, 1, 3]),
        (stage("stretch < 2"), [0, 3]),
        (stage("stretch < 2", "dv > 0.5 mm", "width == 9 mm"), [3]),
        (stage("2 * resolution == both", "1 < stretch < 2"), [0, 3]),
        (stage('unit_L == "H"'), [0, 1, 3, 4]),
        (stage("resolution.F_x / resolution.F_z > 0.8"), [1, 4]),
        (stage(least="resolution"), [1, 4, 3, 0]),
        (stage(least="resolution", count=2), [1, 4]),
        (stage(largest="resolution"), [4, 1, 3, 0]),
        (stage(least="resolution.F_x"), [0, 3, 1, 4]),
        (stage(least="stretch"), [0, 3, 1]),
        (stage(largest="resolution.F_z / 1 mN - stretch", count=9), [0, 3, 1]),
        (stage("stretch > 9"), []),
    ],
)
def test_what_goes_on(asked: Stage, numbers: list[int]) -> None:
    """The numbers, best first."""
    assert going_on(TABLE, asked) == numbers


def test_coils_of_another_case_are_none_of_a_case() -> None:
    """Two coils beside three: both go on, by their own coils; without a number, or any, a case does not."""
    L, L0 = np.full((4, 3), np.nan), np.ones((4, 3))
    L[:3], L0[0, 2], L0[3] = [[2.0, 5.0, np.nan], [4.0, 1.0, 3.0], [np.nan, 9.0, 9.0]], np.nan, np.nan
    columns = {"L": (("case", "coil"), L), "L0": (("case", "coil"), L0), "status": ("case", ["ok"] * 4)}
    table = xr.Dataset(columns)
    assert going_on(table, stage("L > 0.5")) == [0, 1]
    assert going_on(table, stage(largest="L")) == [0, 1] and going_on(table, stage(least="2 * L")) == [1, 0]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (stage("strech < 2"), 'then.1.where: must be one of .*stretch.*; got "?strech"? .did you mean "stretch"'),
        (stage(least="resolution.F_y"), "then.1.least: must be one of .*resolution"),
        (stage("status < 2"), "then.1.where: must be of numbers"),
    ],
)
def test_what_no_table_has(asked: Stage, said: str) -> None:
    """One line that names the nearest variable."""
    with pytest.raises(SceneError, match=said):
        going_on(TABLE, asked)


def test_the_next_study_has_their_values_side_by_side() -> None:
    """As they were written."""
    vary: dict[str, list[Any]] = {"width": ["8 mm", "9 mm"], "dv": ["1 mm", "2 mm", "3 mm"]}
    found = following(Study({}, "quality", {}, {}), Study({}, "calibrate", vary, {}), [3, 1])
    assert found.vary == {"width": ["9 mm", "8 mm"], "dv": ["1 mm", "2 mm"]} and found.combine == "zip"
