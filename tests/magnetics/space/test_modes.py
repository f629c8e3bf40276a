"""The modes of a plate: all divisions on one set of fields, which tells each what its own would."""

from __future__ import annotations

import numpy as np
import pytest

from sits_mech.geometry.sheet_plan import Grading, disc_plan
from sits_mech.magnetics.space import classes, modes
from sits_mech.magnetics.space.divisions import prepared
from sits_mech.magnetics.space.fields import Box
from sits_mech.magnetics.space.near import prepare_near
from sits_mech.magnetics.space.rungs import LADDER, ImpedanceLimit, PlateRung
from sits_mech.magnetics.space.sources import Posed
from sits_mech.scene.sensor import load_sensor

SCALE = (1.5e-3, 2.5e7, (12e-3, 12e-3), 2e-3)


@pytest.mark.slow
def test_divisions_share_their_fields() -> None:
    target = load_sensor("biorob2018").target
    assert target is not None
    fine, coarse = prepared(target, LADDER[0][1], (2.0**-9, 1e6, (12e-3, 12e-3), 2e-3))[:3:2]
    assert fine.bases == coarse.bases and fine.unknowns > 2 * coarse.unknowns
    assert [part.coupling.shape[0] for part in fine.classes] == [part.coupling.shape[0] for part in coarse.classes]


@pytest.mark.slow
def test_a_division_answers_alike_on_fields_of_its_own_and_of_a_finer_one() -> None:
    """Fields are kept to 1e-5; with their gradients they would answer 1e-3 of Delta L apart."""
    sensor = load_sensor("biorob2018")
    assert sensor.target is not None
    shared = prepared(sensor.target, PlateRung((3, 4, 5), (2, 2, 2), 8.0), SCALE)[1]
    own = prepared(sensor.target, PlateRung((4, 4, 4), (2, 2, 2), 8.0), SCALE)[0]
    seen = Posed(sensor.coils, "rings", np.eye(3)[None], np.array([[0.0, 0.0, 2e-3]]))
    one, two = (plate.reactions([plate], seen, 5e6)[0][0] for plate in (shared, own))
    assert shared.unknowns == own.unknowns
    np.testing.assert_allclose(one.imag, two.imag, rtol=0.0, atol=3e-5 * np.abs(two.imag).max())
    np.testing.assert_allclose(one.real, two.real, rtol=0.0, atol=1e-3 * np.abs(two.real).max())


def test_each_division_of_a_disc_sees_coils_beside_it_by_polynomials_as_by_its_cells(
    monkeypatch: pytest.MonkeyPatch
) -> None:
    """With gradients, of which cells see a little; by the first division's fields alone the others were 2e-3 off."""
    monkeypatch.setattr(modes, "without_gradients", lambda box, rows, seen: seen)
    levels, grading = np.array([0.0, 0.1e-3]), Grading(0.3e-3, 1.5, 0.5e-3)
    divisions = [(disc_plan(8e-3, grading.coarser(5.5, m), orders=12), levels) for m in (4, 3, 2)]
    box = Box(np.array([4e-3, 4e-3, 1e-4]), (22, 22, 4), (1.45, 1.45, 40.0), 1.5e-3)
    coils = load_sensor("biorob2018").coils
    seen = Posed(coils, "rings", np.eye(3)[None], np.array([[5e-4, 3e-4, 1.5e-3]]))
    made = list[classes.Problem]()
    problem = classes.Problem
    monkeypatch.setattr(classes, "Problem", lambda *given: made.append(problem(*given)) or made[-1])
    few = modes.prepare_sheets(divisions, 5.8e7, box)
    assert len(made) <= 3 * len(few[0].bases), "a division's classes were made again for its combinations"
    cells = prepare_near(divisions, (5.8e7, 0.0), box)
    for own, whole in zip(few[0].reactions(few, seen, 1e6)[0], cells[0].reactions(cells, seen, 1e6)[0], strict=True):
        np.testing.assert_allclose(own, whole, rtol=0.0, atol=2e-4 * np.abs(whole).max())


@pytest.mark.slow
def test_one_preparation_answers_all_frequencies() -> None:
    """Prepared up to 25 MHz or up to 4 MHz: what few modes and other cells leave, at 1 MHz and at 10 kHz."""
    sensor, rung = load_sensor("biorob2018"), LADDER[2][1]
    assert sensor.target is not None
    seen = Posed(sensor.coils, "rings", np.eye(3)[None], np.array([[0.0, 0.0, 2e-3]]))
    wide, narrow = (prepared(sensor.target, rung, (1.5e-3, top, (12e-3, 12e-3), 2e-3)) for top in (2.5e7, 4e6))
    for f, thick in ((1e6, 3.0), (1e4, 0.3)):
        one, two = (
            plates[0].reactions(plates, seen, f, ImpedanceLimit(rung, thick, 0.1))[0][0] for plates in (wide, narrow)
        )
        assert abs(one - two).max() < 5e-3 * abs(two).max()
        assert abs(one.real - two.real).max() < 1e-2 * abs(two.real).max()
