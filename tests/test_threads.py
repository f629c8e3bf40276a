"""Linear algebra inside a model has one thread, outside as many as before."""

import threading
from collections.abc import Callable, Iterator

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from sits_mech.chain.models import MECHANICS
from sits_mech.geometry.collision import Collision
from sits_mech.magnetics import answer
from sits_mech.magnetics.bars import planar_bars
from sits_mech.magnetics.field import planar_fem
from sits_mech.magnetics.rings import axisymmetric
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Pose, Wrench
from sits_mech.scene.sensor import load_sensor
from sits_mech.threads import one_thread

FLUSH = ['target.width="20 mm"', 'elastomer.width="20 mm"']


def most() -> int:
    """Return the largest number of threads of a BLAS library."""
    return max(library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas")


@pytest.fixture(autouse=True)
def two() -> Iterator[None]:
    """Two threads outside, whatever the machine."""
    with threadpool_limits(2, "blas"):
        yield


def test_one_inside_and_as_many_as_before_outside() -> None:
    """Also after an error, and where one such function calls another."""

    @one_thread
    def asked(deeper: Callable[[], int] | None = None) -> tuple[int, int]:
        return (most() if deeper is None else deeper()[0]), most()

    @one_thread
    def failing() -> None:
        raise ValueError

    assert asked() == asked(asked) == (1, 1)
    assert most() == 2
    with pytest.raises(ValueError):
        failing()
    assert most() == 2


def test_a_call_that_ends_leaves_the_others_alone() -> None:
    """A limit belongs to the process: the first to begin ends first here, and the number comes back with the last."""
    begun, ended, seen = threading.Event(), threading.Event(), []

    @one_thread
    def long() -> None:
        begun.set()
        ended.wait(10.0)
        seen.append(most())

    @one_thread
    def first() -> threading.Thread:
        other = threading.Thread(target=long)
        other.start()
        begun.wait(10.0)
        return other

    other = first()
    assert most() == 1
    ended.set()
    other.join()
    assert seen == [1] and most() == 2


def test_magnetic_models_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number is asked in the middle of an answer."""
    seen, check = [], answer.check_clearance
    monkeypatch.setattr(answer, "check_clearance", lambda *given: seen.append(most()) or check(*given))
    sensor = load_sensor("biorob2018")
    disc = sensor.target.model_copy(update={"shape": "disc", "width": None, "length": None, "diameter": 8e-3})
    round_ = sensor.model_copy(update={"coils": sensor.coils[:1], "target": disc})
    for model in (planar_bars(sensor), planar_fem(sensor), axisymmetric(round_), sheets(sensor, 0.1)):
        with pytest.raises(Collision):
            model.impedance(Pose(0.0, -1e-3), 5e6)
    assert seen == [1, 1, 1, 1] and most() == 2


@pytest.mark.parametrize("name", MECHANICS)
def test_mechanical_models_are_limited(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The number is asked by the load itself, wherever a model first looks at it."""
    seen, components = [], Wrench.components.fget
    monkeypatch.setattr(Wrench, "out_of_plane", property(lambda wrench: seen.append(most()) or ()))
    monkeypatch.setattr(Wrench, "components", property(lambda wrench: seen.append(most()) or components(wrench)))
    disc = [
        'elastomer={material="ecoflex-00-30", diameter="8 mm", thickness="4 mm"}',
        'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}',
    ]
    scene = load_sensor("biorob2018-w15", disc if name == "axisymmetric" else FLUSH)
    MECHANICS[name](scene, 0.1).equilibrium(Wrench(F_z=0.1))
    assert seen and set(seen) == {1} and most() == 2
