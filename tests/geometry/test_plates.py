"""Do plates in the section touch?"""

import pytest

from sits_mech.geometry.plates import Plate, check_apart


@pytest.mark.parametrize(
    "place, alpha, apart",
    [(9e-3 + 0j, 0.0, True), (0.3e-3j, 0.0, True), (7e-3 + 0j, 0.0, False), (0.3e-3j, 0.1, False), (1j, 1.0, True)],
)
def test_plates_apart_or_not(place: complex, alpha: float, apart: bool) -> None:
    """Beside, above, overlapping, crossing, far."""
    first = Plate("first", 0j, 0.0, 8e-3, 0.2e-3, 5.8e7, 1.0, True)
    second = Plate("second", place, alpha, 8e-3, 0.2e-3, 5.8e7, 1.0, True)
    for pair in ((first, second), (second, first)):
        if apart:
            check_apart(pair)
        else:
            with pytest.raises(ValueError, match="must not touch"):
                check_apart(pair)
