"""Previews: exact where a table is known, within what they leave open between, none where nothing tells."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sits_mech.scene.sensor import changed
from sits_mech.studio.previews import SolvedScene, _newton, _of_both, preview

NAMES = ("d_h", "d_v", "L_v_percent", "L_h_percent")


def worst(found: object, true: SolvedScene) -> tuple[float, float]:
    """Return the largest error over what is left open, and over the range, of pose, signals and inductances."""
    shares, offs = [], []
    for name in (*NAMES, "L"):
        off = np.abs(found[name] - true.data[name]).to_numpy()
        left = found[f"error_{name}"].to_numpy() + true.data[f"error_{name}"].to_numpy()
        if name == "L":
            off, left = (np.einsum("...ii->...i", part) for part in (off, left))
        scale = float(np.ptp(true.data[name].to_numpy()))
        shares.append(np.max(off / (left + 1e-3 * scale)))
        offs.append(off.max() / scale)
    return float(max(shares)), float(max(offs))


def test_newton_s_form_is_exact_for_its_degree() -> None:
    """A cubic by its slope at zero and two places; what is left open is zero at the places."""
    def cubic(x: float) -> np.ndarray:
        """A cubic without constant term."""
        return np.array([2.0 * x - x**2 + 3.0 * x**3])

    for x in (-0.3, 0.1, 0.5):
        found, (*terms, left) = _newton(x, [0.4, -0.2], [cubic(0.4), cubic(-0.2)], np.array([2.0]))
        np.testing.assert_allclose(np.ravel(terms), np.abs([0.0, 2.0 * x, x**2, 3.0 * x**3]), atol=1e-12)
        assert found == pytest.approx(cubic(x), abs=1e-12) and left > 0.0
    found, (*_, left) = _newton(0.4, [0.4, -0.2], [cubic(0.4), cubic(-0.2)], None)
    assert found == pytest.approx(cubic(0.4)) and left == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("keys", [
    ("elastomer.thickness=0.0023",), pytest.param(("elastomer.thickness=0.0017",), marks=pytest.mark.slow),
    pytest.param(("target.width=0.0165",), marks=pytest.mark.slow),
    pytest.param(("elastomer.thickness=0.0021", "target.width=0.0145"), marks=pytest.mark.slow),
])
def test_slopes_alone_are_within_what_they_leave_open(
    base: SolvedScene, solved: Callable[..., SolvedScene], keys: tuple[str, ...]
) -> None:
    """Thickness and width by a fifth, alone and together."""
    true = solved(*keys)
    share, off = worst(preview(base, [], true.sensor), true)
    assert share < 1.0 and off < 0.6


@pytest.mark.slow
def test_tables_beside_make_it_good(base: SolvedScene, solved: Callable[..., SolvedScene]) -> None:
    """Two of the thickness: between them within one percent, at them exact."""
    others = [solved("elastomer.thickness=0.0017"), solved("elastomer.thickness=0.0023"), base]
    true = solved("elastomer.thickness=0.0021")
    share, off = worst(preview(base, others, true.sensor), true)
    assert share < 1.0 and off < 0.01
    again = preview(base, others, others[0].sensor)
    for name in (*NAMES, "L", "R"):
        np.testing.assert_allclose(again[name], others[0].data[name], rtol=1e-9, atol=1e-12)


def test_where_nothing_tells_there_is_none(base: SolvedScene) -> None:
    """Another number of turns, another silicone, a number without slope or table."""
    for key in ("coils.0.turns=10", 'elastomer.material="dragon-skin-10"', "target.thickness=0.0003"):
        assert preview(base, [base], changed(base.sensor, [key])) is None
    bare = replace(base, slopes=None)
    assert preview(bare, [bare], changed(base.sensor, ["elastomer.thickness=0.0021"])) is None
    same = preview(base, [], base.sensor)
    np.testing.assert_allclose(same["L"], base.data["L"], rtol=1e-14)


def test_terms_of_two_numbers_of_what_hangs_on_their_sum() -> None:
    """Exact for a square and a cube of one combination; none where one of the numbers does nothing."""
    for n in (2, 3):
        for a, b in ((0.3, 0.2), (0.7, 0.0)):
            one, other = ([np.zeros(1)] * n + [np.array([part**n])] for part in (a, b))
            assert _of_both(one, other) == pytest.approx((a + b) ** n - a**n - b**n)
