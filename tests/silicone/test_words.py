"""Words of users for a silicone: moduli, hardness, what contradicts itself."""

import pytest

from sits_mech.silicone.material import silicone_from, table_of
from sits_mech.silicone.words import modulus_of_hardness
from sits_mech.units import SceneError


@pytest.mark.parametrize(
    ("table", "mu", "K"),
    [
        ({"E": "0.5 MPa", "nu": 0.49}, 5e5 / 2.98, 5e5 / 0.06),
        ({"young_modulus": "60 psi", "poisson_ratio": 0.4}, 60 * 6894.757293168361 / 2.8, 60 * 6894.757293168361 / 0.6),
        ({"mu": "20 kPa", "K": "20 N/mm2"}, 2e4, 2e7), ({"G": "2 kgf/cm2", "nu": 0.4}, 2 * 98066.5, 28 / 3 * 98066.5),
        ({"E": 1e5, "K": 1e6}, 3e11 / 8.9e6, 1e6), ({"law": "neo-hookean", "mu": 2e4, "D1": "0.1 1/MPa"}, 2e4, 2e7),
        ({"law": "yeoh", "c10": "8 kPa", "c20": 0, "c30": 0, "D1": "0.1 mm2/N"}, 1.6e4, 2e7),
        ({"law": "ogden", "mu": ["20 kPa"], "alpha": [2.0], "K": "20 MPa"}, 2e4, 2e7),
    ],
)
def test_moduli_are_those_of_elasticity(table: dict[str, object], mu: float, K: float) -> None:
    """Shear modulus and bulk modulus by the textbook; what is written is read back."""
    found = silicone_from(table)
    assert found.shear_modulus == pytest.approx(mu, rel=1e-12)
    assert found.bulk_modulus == pytest.approx(K, rel=1e-12)
    assert silicone_from(table_of(found)) == found


MEASURED = [  # neo-Hooke up to 60 % of strain on the tests of L. Marechal and others (2020) [Pa]
    ("shore_a", 10, 145070), ("shore_a", 30, 589790), ("shore_a", 16, 263663), ("shore_a", 44, 1071441),
    ("shore_a", 40, 864453), ("shore_00", 10, 22447), ("shore_00", 30, 46031), ("shore_00", 50, 63443),
]


def test_a_hardness_is_known_within_its_spread() -> None:
    """Of eight silicones in tension: none beyond the range that the spread says; the source says what it is."""
    shares = [E / modulus_of_hardness(scale, hardness) for scale, hardness, E in MEASURED]
    found = silicone_from({"shore_a": 30})
    assert found.spread is not None and max(shares) / min(shares) < 1.0 + found.spread
    assert 0.6 < min(shares) < 0.8 and 1.1 < max(shares) < 1.3
    assert 3.0 * found.shear_modulus == pytest.approx(modulus_of_hardness("shore_a", 30), rel=1e-3)
    assert found.source.startswith("Shore A 30")
    assert found.bulk_modulus == pytest.approx(1000 * found.shear_modulus, rel=1e-3)
    # Gent's of A 30 is 1.142 MPa; a ball of 1.19 mm pressed by 0.4754 N into E of 105.9 kPa goes 1.75 mm deep
    assert modulus_of_hardness("shore_a", 30) / 0.43 == pytest.approx(1.1424e6, rel=1e-3)
    assert modulus_of_hardness("shore_00", 30) / 0.43 == pytest.approx(105.9e3, rel=1e-3)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"E": 1e5, "shore_a": 30}, "must have one of E, mu, shore_a, shore_00; got young_modulus, shore_a"),
        ({"nu": 0.49}, "must have one of E, mu, .*; got none"),
        ({"E": 1e5, "nu": 0.5}, "nu must lie between 0 and 0.5"),
        ({"E": "-60 kPa"}, 'E must be above zero, such as "60 kPa"; got "-60 kPa"'), ({"mu": 0, "nu": 0.4}, "mu must"),
        ({"E": 1e5, "nu": 0.4, "D1": 1e-7}, "one of K, nu, D1; got poisson_ratio, D1"),
        ({"shore_a": 90}, "between 5 and 80"),
        ({"E": 1e5, "young_modulus": 1e5}, "young_modulus must be given once; got E, young_modulus"),
        ({"law": "yeoh", "E": 1e5}, "must be of neo-hookean"), ({"mu": 1e4, "D1": 0}, "D1 must be above zero"),
        ({"law": "mooney-rivlin", "c10": 1, "c01": 1, "nu": 0.49}, "nu must be of neo-hookean"),
        ({}, "law: must be one of"),
        ({"E": 1e6, "K": 1e5}, "K must be above E/9"),
    ],
)
def test_what_contradicts_itself_is_refused(table: dict[str, object], words: str) -> None:
    """In one line that says what there must be."""
    with pytest.raises(SceneError, match=words):
        silicone_from(table)
