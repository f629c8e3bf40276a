"""The limit of memory: what is set holds, what is no number is refused."""

import pytest

from sits_mech.memory import GIB, VARIABLE, limit_memory, memory_limit


def test_limit_is_four_gib_unless_it_is_set(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    assert memory_limit() == 4 * GIB
    monkeypatch.setenv(VARIABLE, "0.5")
    assert memory_limit() == GIB / 2
    limit_memory(2.0)
    assert memory_limit() == 2 * GIB


@pytest.mark.parametrize("text", ["much", "0", "-1", "nan"])
def test_what_is_no_limit_is_refused(monkeypatch, text):
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(ValueError, match="positive number of GiB"):
        memory_limit()


def test_a_limit_must_be_positive():
    with pytest.raises(ValueError, match="got -1"):
        limit_memory(-1.0)
