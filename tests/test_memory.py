"""The limit of memory: what is set holds, what is no number is refused; no more of an input is read than may come."""

import gc
import weakref
from pathlib import Path

import numpy as np
import pytest

from sits_mech.memory import (
    GIB,
    MEMORY,
    SECONDS,
    array_bytes,
    beyond_memory,
    check_seconds,
    give_back,
    input_text,
    latest,
)


def test_limit_is_four_gib_unless_it_is_set(monkeypatch):
    monkeypatch.delenv(MEMORY.variable, raising=False)
    assert MEMORY.get() == 4.0
    monkeypatch.setenv(MEMORY.variable, "0.5")
    assert MEMORY.get() == 0.5
    MEMORY.set(2.0)
    assert MEMORY.get() == 2.0


def test_what_is_beyond_the_limit_is_said_with_it(monkeypatch):
    monkeypatch.setenv(MEMORY.variable, "1")
    assert beyond_memory(GIB) == ""
    assert beyond_memory(2.5 * GIB) == "some 2.5 GiB, more than the limit of 1 GiB (--memory, or SITS_MECH_MEMORY)"


def test_what_was_used_last_is_kept_as_far_as_memory_holds(monkeypatch):
    monkeypatch.setenv(MEMORY.variable, "1e-3")
    asked = []

    @latest(9)
    def made(share):
        asked.append(share)
        return np.zeros(int(share * 1e-3 * GIB / 8))

    for share in (0.5, 0.25, 0.5, 0.4, 0.5, 0.25, 3.0, 3.0, 0.5):
        made(share)
    assert asked == [0.5, 0.25, 0.4, 0.25, 3.0, 0.5]  # 0.4 put 0.25 out, which was used before 0.5
    made.cache_clear()
    made(0.5)
    assert len(asked) == 7


def test_no_more_is_kept_than_was_said():
    asked = []

    @latest(2)
    def made(number):
        asked.append(number)
        return (number,)

    for number in (1, 2, 1, 3, 1, 2):
        assert made(number) == (number,)
    assert asked == [1, 2, 3, 2]


def test_arrays_are_held_once_wherever_they_are():
    """Views are their array's, what is a buffer's own counts, and what holds itself is no endless way."""

    class Part:
        pass

    whole, part = np.zeros(100), Part()
    part.own, part.views, part.itself = {"at": [whole, whole.T]}, (whole[:10], whole[10:].reshape(9, 10)), part
    assert array_bytes(part) == array_bytes((part, [part])) == whole.nbytes
    assert array_bytes((whole, np.frombuffer(b"12345678"), "text", None, 1.0)) == whole.nbytes + 8
    assert array_bytes(whole[:1]) == whole.nbytes


def test_what_a_plate_keeps_goes_with_it():
    """An object of its own each: what was asked of it before is known, two at a time, and nobody else holds it."""
    asked = []

    class Plate:
        pass

    @latest(2, owned=True)
    def made(plate, omega):
        asked.append(omega)
        return [plate, omega]

    one, other = Plate(), Plate()
    for omega in (1.0, 2.0, 1.0, 3.0, 3.0, 2.0):
        assert made(one, omega) == [one, omega]
    assert asked == [1.0, 2.0, 3.0, 2.0]
    assert made(other, 2.0)[0] is other and len(asked) == 5
    gone = weakref.ref(one)
    del one
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize("text", ["much", "0", "-1", "nan"])
def test_what_is_no_limit_is_refused(monkeypatch, text):
    monkeypatch.setenv(MEMORY.variable, text)
    with pytest.raises(ValueError, match="positive number of GiB"):
        MEMORY.get()


def test_a_limit_must_be_positive():
    with pytest.raises(ValueError, match="got -1"):
        MEMORY.set(-1.0)


def test_input_with_a_byte_order_mark_is_its_text(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes("\ufeffname = 'µ'".encode())
    assert input_text(path, "a scene") == "name = 'µ'"


def test_input_that_is_too_long_or_does_not_end_is_refused(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(ValueError, match=r"scene\.toml: must be a scene of at most 1 MiB; got more"):
        input_text(path, "a scene", most=1)
    if Path("/dev/zero").exists():
        with pytest.raises(ValueError, match="/dev/zero: must be a scene of at most 1 MiB"):
            input_text("/dev/zero", "a scene", most=1)


def test_input_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ValueError, match="must be a scene; got: No such file"):
        input_text(tmp_path / "none", "a scene")
    with pytest.raises(ValueError, match="must be a scene; got: embedded null byte"):
        input_text("\0", "a scene")


def test_step_that_takes_too_long_is_refused_before_it_begins(monkeypatch):
    monkeypatch.delenv(SECONDS.variable, raising=False)
    check_seconds(99.0, "the step")
    with pytest.raises(ValueError, match=r"the step must take at most 200 s .* it takes some 3.6e\+03 s"):
        check_seconds(3600.0, "the step")
    monkeypatch.setenv(SECONDS.variable, "4000")
    check_seconds(3600.0, "the step")
    SECONDS.set(1.0)
    with pytest.raises(ValueError, match="at most 1 s"):
        check_seconds(2.0, "the step")
    with pytest.raises(ValueError, match="got 0"):
        SECONDS.set(0.0)


def test_freed_memory_is_given_back_where_there_is_a_call_for_it(monkeypatch):
    give_back()
    monkeypatch.setattr("ctypes.CDLL", lambda name: object())  # another C library has none
    give_back()
