"""What plates see of each other through few combinations: against more of them, and close and far targets as one."""

import numpy as np
import pytest

from sits_mech.magnetics.sheets import sheets
from sits_mech.magnetics.space import far, neighbours, plates
from sits_mech.magnetics.space.divisions import prepared, prepared_near
from sits_mech.magnetics.space.far import _weights, seen_from
from sits_mech.magnetics.space.fields import Blocks
from sits_mech.quantities import Pose
from sits_mech.scene.sensor import load_sensor

MM = 1e-3
PLANE = '{name="p%s",shape="rectangle",width="12 mm",length="9 mm",thickness="0.2 mm",material="copper",centre=[%s]}'
TARGET = 'target={material="copper",shape="rectangle",width="8 mm",length="6 mm",thickness="0.2 mm"}'
POSES = Pose(np.array([0.0, 0.6]) * MM, np.array([1.5, 1.4]) * MM, np.array([0.0, 0.06]), np.array([0.0, 0.3]) * MM)


def over(*places: str) -> object:
    """Return coarse sheets of biorob2018 with planes at some places."""
    planes = ",".join(PLANE % (k, place) for k, place in enumerate(places))
    return load_sensor("biorob2018", [TARGET, f"conductors=[{planes}]"])


def found(sensor: object) -> tuple[np.ndarray, np.ndarray]:
    """Return Delta L and R from the beginning on."""
    for each in (prepared, prepared_near):
        each.cache_clear()
    answer = sheets(sensor, 1e-1).impedance(POSES, 2e6)
    return answer.L - answer.L0, answer.R


@pytest.mark.slow
@pytest.mark.parametrize("places", [('"1 mm","0 mm","-1.2 mm"',), ('"0 mm","0 mm","-1.2 mm"', '"9 mm","0 mm","4 mm"')])
def test_few_combinations_tell_what_more_do(monkeypatch: pytest.MonkeyPatch, places: tuple[str, ...]) -> None:
    """Delta L to 2e-4, R to 3e-3 of the largest."""
    sensor = over(*places)
    L, R = found(sensor)
    monkeypatch.setattr(neighbours, "_MOVING", 4e-4)
    monkeypatch.setattr(neighbours, "_FIXED", 4e-4)
    whole = found(sensor)
    for few, all_, error in ((L, whole[0], 2e-4), (R, whole[1], 3e-3)):
        np.testing.assert_allclose(few, all_, rtol=0, atol=error * np.abs(all_).max())
        assert np.abs(few - all_).max() > 0.0


@pytest.mark.slow
def test_a_target_seen_cell_by_cell_is_that_of_polynomials(monkeypatch: pytest.MonkeyPatch) -> None:
    """In company too: 1e-3 of the largest."""
    sensor = over('"1 mm","0 mm","-1.2 mm"')
    L, R = found(sensor)
    monkeypatch.setattr(plates, "is_near", lambda *_: True)
    near = found(sensor)
    np.testing.assert_allclose(near[0], L, rtol=0, atol=1e-3 * np.abs(L).max())
    np.testing.assert_allclose(near[1], R, rtol=0, atol=5e-3 * np.abs(R).max())
    assert np.abs(near[0] - L).max() > 0.0


@pytest.mark.slow
def test_random_currents_are_added_to_those_that_were_too_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plate is asked about as many fields as it has combinations at most; about half as many more anew each time."""
    columns, asked, whole, parts = list[int](), list[tuple](), far.seen, neighbours.seen_from
    monkeypatch.setattr(far, "seen", lambda plate, field, r: columns.append(field.shape[2]) or whole(plate, field, r))
    monkeypatch.setattr(neighbours, "seen_from", lambda *given: asked.append(given) or parts(*given))
    found(over('"0 mm","0 mm","-1.2 mm"'))
    columns.clear()
    plate, _, omega, *_ = asked[0]
    seen_from(plate, plate.box.clearance, omega, 1e-9)
    assert len(columns) > 1 and sum(columns) == plate.seen


def test_weights_do_not_hang_on_what_spans_a_class() -> None:
    """Combinations turned among themselves, as another processor may find them: the same weights, turned."""
    rng = np.random.default_rng(0)
    R, X = (np.linalg.qr(rng.normal(size=(5, 5)))[0] for _ in range(2))
    Y, turn = R @ np.diag([3.0, 1.0, 0.5, 0.1, 0.01]) @ R.T - 1j * X @ np.diag([9.0, 4.0, 2.0, 0.3, 0.1]) @ X.T, X @ R
    rows = np.arange(5)
    (((_, W),), ((_, inverse),)) = _weights(Blocks(5, ((rows, Y),)), 0)
    (((_, turned),), _) = _weights(Blocks(5, ((rows, turn.T @ Y @ turn),)), 0)
    np.testing.assert_allclose(turned, turn.T @ W @ turn, atol=1e-12)
    np.testing.assert_allclose(W @ inverse, np.eye(5), atol=1e-12)
