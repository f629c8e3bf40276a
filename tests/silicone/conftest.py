"""One silicone of each law."""

import pytest

from sits_mech.silicone.material import silicone_from

TABLES = {
    "neo-hookean": {"shear_modulus": 3e4},
    "mooney-rivlin": {"c10": 1e4, "c01": 5e3},
    "yeoh": {"c10": 1.5e4, "c20": -300.0, "c30": 40.0},
    "ogden": {"mu": [2e4, 1e4], "alpha": [1.7, -2.6]},
    "gent": {"shear_modulus": 3e4, "j_m": 20.0},
}


@pytest.fixture(params=[*TABLES])
def silicone(request):
    return silicone_from({"law": request.param, "bulk_modulus": 3e7} | TABLES[request.param])
