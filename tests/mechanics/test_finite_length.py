"""What plane strain makes of a pad of finite length: independent stiffnesses, the long limit, invariance."""

from pathlib import Path

import numpy as np
import pytest

from sits_mech.disk_cache import VARIABLE
from sits_mech.mechanics.linear import _factors, finite_length_factor, linear_pad
from sits_mech.scene.sensor import load_sensor

NEO_HOOKEAN = 'elastomer.material={law="neo-hookean", shear_modulus=3e4, bulk_modulus=3e7}'


def scene(length, *more, width=15):
    """A target as long as its pad, which is 20 mm wide and 2 mm thick."""
    sizes = [f'elastomer.length="{length} mm"', f'target.length="{length} mm"', f'target.width="{width} mm"']
    return load_sensor("biorob2018", [*sizes, NEO_HOOKEAN, *more])


@pytest.mark.slow
def test_stiffness_of_a_box_in_si():
    """NGSolve 6.2 and FElupe 11.3: 20 x 20 x 2 mm under 15 x 15 mm; on the diagonal within the references' errors."""
    found, error = linear_pad(scene(20, 'target.length="15 mm"'), 1e-3).stiffness
    known = {(1, 1): (120.67e3, 1e-3), (0, 0): (4.482e3, 1e-3), (0, 2): (6.915, 1.5e-3), (2, 2): (1.0695, 1.5e-3)}
    for (i, j), (value, bar) in known.items():  # off the diagonal over the root of both on it
        assert abs(found[i, j] - value) < bar * np.sqrt(known[i, i][0] * known[j, j][0])
    assert error < 5e-3
    np.testing.assert_allclose(found, found.T, atol=1e-6 * found[1, 1])


@pytest.mark.slow
def test_a_long_pad_is_plane_strain_but_for_its_ends():
    short, long = (finite_length_factor(scene(length)) for length in (100, 1000))
    for name in ("shear", "compression", "tilt"):
        assert 1.0 < getattr(long, name) < 1.02
        # what an end costs does not depend on the length
        loss = [length * (1.0 - 1.0 / getattr(found, name)) for length, found in ((100, short), (1000, long))]
        assert loss[0] == pytest.approx(loss[1], rel=0.05, abs=0.05)


@pytest.mark.slow
def test_a_short_target_is_far_softer_than_plane_strain_says():
    found = finite_length_factor(load_sensor("biorob2018", [NEO_HOOKEAN]))
    assert 2.0 < found.shear < 2.5 < found.compression  # the 8 mm target stands on 20 mm: 2.5 by length alone
    assert found.error < 0.03


@pytest.mark.slow
def test_the_modulus_scales_out():
    stiffer = NEO_HOOKEAN.replace("3e4", "3e5").replace("3e7", "3e8")
    one, two = (finite_length_factor(scene(20, law, width=8)) for law in (NEO_HOOKEAN, stiffer))
    assert one.compression == pytest.approx(two.compression, rel=1e-9)
    assert one.tilt == pytest.approx(two.tilt, rel=1e-9)


@pytest.mark.slow
def test_a_thin_pad_by_thicker_ones():
    """15 x 20 mm on 0.4 mm: the pad itself, meshed, against the line through two thicker ones."""
    sensor = scene(20, 'elastomer.thickness="0.4 mm"')
    found, (direct, error) = finite_length_factor(sensor), _factors(sensor)
    line = np.array([found.shear, found.compression, found.tilt])
    assert np.all(np.abs(line / direct - 1.0) < found.error + error) and found.error < 0.03


def test_no_target_is_refused():
    with pytest.raises(ValueError, match="target"):
        finite_length_factor(scene(20).model_copy(update={"target": None}))


def test_factors_are_kept_to_the_last_digit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For the next process; those of another silicone are others."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    sensor = load_sensor("biorob2018", [NEO_HOOKEAN])
    first = finite_length_factor.__wrapped__(sensor)
    monkeypatch.setattr("sits_mech.mechanics.linear._finite_length", lambda sensor: pytest.fail("solved again"))
    assert finite_length_factor.__wrapped__(sensor) == first
    with pytest.raises(pytest.fail.Exception):
        finite_length_factor.__wrapped__(load_sensor("biorob2018", ['elastomer.material="ecoflex-00-50"']))
