"""One division for many frequencies: equal to the direct solution, direct current below, skin depth above."""

from pathlib import Path

import numpy as np
import pytest
from common.track_losses import coil_losses, track_spectrum
from scipy.constants import mu_0

from sits_mech.disk_cache import VARIABLE
from sits_mech.geometry.tracks import coil_bars
from sits_mech.magnetics.coils import resistance
from sits_mech.magnetics.coils.resistance import rough_alone, track_conductivity, track_resistance
from sits_mech.magnetics.section.kernels import mean_log
from sits_mech.memory import SECONDS
from sits_mech.scene.sensor import Coil, SceneError

MM = 1e-3
COIL = Coil(
    name="C", centre=(0.0, 0.0), layers=1, turns=4, inner_diameter=2.2e-3, track_width=0.1e-3, track_gap=0.1e-3,
    track_thickness=35e-6, layer_pitch=85e-6,
)


def test_equals_the_direct_solution() -> None:
    """At the frequency the division is made for, to rounding; at a lower one within both errors."""
    found, high, low = track_spectrum(COIL, [1e6, 5e6]), coil_losses(COIL, 5e6), coil_losses(COIL, 1e6)
    assert found.R[1] == pytest.approx(high.R, rel=1e-10)
    assert abs(found.R[0] - low.R) < found.error_R[0] + low.error_R


def test_the_second_command_finds_no_modes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are kept, and say the same to the bit; those of another coil are others."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    wider = COIL.model_copy(update={"inner_diameter": 3e-3})
    first = [track_spectrum(coil, [1e6, 5e6]) for coil in (COIL, wider)]
    monkeypatch.setattr(resistance, "eddy_modes", None)
    for coil, before in zip((COIL, wider), first, strict=True):
        after = track_spectrum(coil, [1e6, 5e6])
        for name in ("R", "shift", "error_R"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    assert np.all(first[0].R < first[1].R)


def test_cases_of_one_coil_share_its_rough_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every scene and frequency asks for them; two filaments along a side give half and more of the shift."""
    fine = track_spectrum(COIL, [1e6, 5e6]).shift
    rough_alone(COIL, 5e6)
    monkeypatch.setattr(resistance, "eddy_modes", None)
    for frequency, shift in zip((1e6, 5e6), fine, strict=True):
        assert 0.5 < rough_alone(COIL.model_copy(), frequency).imag / (2 * np.pi * frequency * shift) < 1.0


def test_limits() -> None:
    """Direct current: R of rings (J as 1/r), the shift that of this J from an even one; both vary as f^2 from there."""
    found = track_spectrum(COIL, [1.0, 1e4, 2e4, 1e7])
    assert found.R[0] == pytest.approx(track_resistance(COIL), rel=1e-6)
    assert found.shift[0] == pytest.approx(-4.7e-11, rel=2e-2)
    assert (found.R[2] - found.R[0]) / (found.R[1] - found.R[0]) == pytest.approx(4.0, rel=1e-2)
    rise = found.shift - found.shift[0]
    assert rise[2] / rise[1] == pytest.approx(4.0, rel=1e-2)
    inner = coil_losses(COIL, 1e7).L - coil_losses(COIL, 1.0).L
    assert rise[3] == pytest.approx(inner, rel=3e-2)


def test_the_current_of_a_wide_track_keeps_to_its_inner_side() -> None:
    """A ring three times as wide outside as inside: t sigma R = 2 pi / ln 3, a tenth below that of uniform current."""
    wide = COIL.model_copy(update={"turns": 1, "inner_diameter": 4e-3, "track_width": 4e-3})
    own = track_resistance(wide)
    assert own * track_conductivity(wide) * wide.track_thickness == pytest.approx(2 * np.pi / np.log(3), rel=1e-12)
    assert track_spectrum(wide, [1.0]).R[0] == pytest.approx(own, rel=1e-6)


def test_so_many_filaments_are_refused_before_they_are_paired(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SECONDS.variable, "1e-3")
    with pytest.raises(SceneError, match="^uneven current in a coil of .* must take at most 0.001 s"):
        track_spectrum(COIL, [1e6])


def _section_ratio(coil: Coil, frequency: float, cells: tuple[int, int]) -> float:
    """R over R_dc of a coil's bars at y = 0, endless: filaments with logarithmic inductances, bars in series."""
    bars, sigma = coil_bars(coil), 5.8e7
    edges = [-np.cos(np.pi * np.arange(n + 1) / n) / 2 for n in cells]
    x, z = np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in edges), indexing="ij")
    w, h = np.meshgrid(*(np.diff(e) for e in edges), indexing="ij")
    x, z = ((p[:, None] + s * q.ravel()).ravel() for p, q, s in ((bars.x, x, bars.width), (bars.z, z, bars.thickness)))
    w, h = (np.tile(s * q.ravel(), bars.x.size) for q, s in ((w, bars.width), (h, bars.thickness)))
    L = -mu_0 / (2 * np.pi) * mean_log(x - x[:, None], z - z[:, None], (w[:, None], h[:, None]), (w, h))
    share = np.kron(np.eye(bars.x.size), np.ones((cells[0] * cells[1], 1)))
    Y = share.T @ np.linalg.solve(np.diag(1 / (sigma * w * h)) + 2j * np.pi * frequency * L, share)
    Z = bars.sign @ np.linalg.inv(Y) @ bars.sign
    return float(Z.real * sigma * bars.width * bars.thickness / bars.x.size)


@pytest.mark.slow
@pytest.mark.parametrize(("width", "length", "layers"), [(2, 100, 1), (6, 6, 1), (6, 6, 2)])
def test_straight_tracks_as_rings(width: float, length: float, layers: int) -> None:
    """What uneven current adds to the resistance of rectangles at 5 MHz, by their section: within a third of it."""
    sizes = {"track_width": 0.127 * MM, "track_gap": 0.127 * MM, "track_thickness": 35e-6, "layer_pitch": 0.2 * MM}
    coil = Coil(name="R", shape="rectangle", centre=(0.0, 0.0), layers=layers, turns=6, inner_width=width * MM,
                inner_length=length * MM, **sizes)
    found = float(track_spectrum(coil, [5e6]).R[0]) / track_resistance(coil)
    expected = _section_ratio(coil, 5e6, (10, 4))
    assert found - 1 == pytest.approx(expected - 1, rel=1 / 3) and found == pytest.approx(expected, rel=0.06)
