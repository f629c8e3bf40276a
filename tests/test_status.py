"""Status of an answer: which words hold, which is the worst, what exit code that makes."""

import math

import pytest

from sits_mech.status import ANSWERED, WORDS, counted, exit_code, flags_of, joined, marked

WITHIN = {"error": 0.005, "tolerance": 0.01, "stretch": 1.5, "known": 2.0}


@pytest.mark.parametrize(
    ("changed", "flags"),
    [
        ({}, ("ok",)),
        ({"error": 0.01, "stretch": 2.0}, ("ok",)),
        ({"interpolated": True}, ("interpolated",)),
        ({"error": 0.0101}, ("above tolerance",)),
        ({"error": math.nan}, ("above tolerance",)),
        ({"stretch": 2.001}, ("beyond data",)),
        ({"stretch": 1.99, "changed": 0.05}, ("ok",)),
        ({"stretch": 1.99, "changed": 0.2}, ("beyond data",)),
        ({"stretch": None, "known": 2.0}, ("ok",)),
        ({"stretch": 9.0, "known": math.nan}, ("ok",)),
        (
            {"error": 0.12, "stretch": 3.65, "interpolated": True},
            ("beyond data", "above tolerance", "interpolated"),
        ),
    ],
)
def test_flags_follow_from_the_figures(changed: dict[str, float], flags: tuple[str, ...]) -> None:
    """On the limit is within; an error that is not known is above; what is not known of a stretch is not beyond."""
    assert flags_of(**WITHIN | changed) == flags


def test_the_worst_word_is_the_status() -> None:
    """Flags of many loads are told once each, worst first."""
    row = marked(["ok", "above tolerance", "interpolated", "failed", "ok"])
    assert row == {"status": "failed", "flags": "failed; above tolerance; interpolated; ok"}
    assert all(marked([word]) == {"status": word, "flags": word} for word in WORDS)


def test_what_holds_of_any_row_holds_of_all() -> None:
    """Ok alone is ok; beside others it says nothing."""
    assert joined(["ok", "beyond data; above tolerance", "not bounded", "interpolated"]) == ANSWERED[:0:-1]
    assert joined(["ok", "ok"]) == joined([]) == ("ok",)


def test_what_has_no_size_is_not_bounded() -> None:
    """Beside any error; data that end are worse."""
    assert flags_of(0.1, 0.2, bounded=False) == ("not bounded",)
    assert flags_of(0.3, 0.2, bounded=False) == ("not bounded", "above tolerance")
    assert flags_of(0.3, 0.2, 2.1, 2.0, bounded=False)[:2] == ("beyond data", "not bounded")


def test_exit_codes_are_those_of_the_worst_row() -> None:
    """Answers that need a look have a code of their own, which a user may accept; what is missing is never accepted."""
    assert [exit_code([word]) for word in WORDS] == [0, 0, 4, 4, 4, 3, 3]
    assert [exit_code([word], accept=True) for word in WORDS] == [0, 0, 0, 0, 0, 3, 3]
    assert exit_code(["ok", "beyond data", "ok"]) == 4 and exit_code([*ANSWERED, "not carried"]) == 3
    assert exit_code([]) == 0


def test_statuses_are_counted_worst_first() -> None:
    """Many with their number, one by its word."""
    assert counted(["ok", "beyond data", "ok"]) == "1 of 3 beyond data, 2 of 3 ok" and counted(["failed"]) == "failed"
