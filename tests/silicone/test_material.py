"""Materials: constants with their source, laws with a positive stiffness, tables that survive a round trip."""

import math
from pathlib import Path

import pytest

from sits_mech.scene.materials import metals, silicones
from sits_mech.scene.sensor import SceneError, load_sensor, save_sensor
from sits_mech.silicone.laws import LAWS
from sits_mech.silicone.material import Silicone, Softening, implausible, silicone_from, table_of

TABLES = {
    "neo-hookean": ({"shear_modulus": "30 kPa"}, 30e3),
    "mooney-rivlin": ({"c10": 10e3, "c01": "5 kPa"}, 30e3),
    "yeoh": ({"c10": "15 kPa", "c20": -100.0, "c30": 10}, 30e3),
    "ogden": ({"mu": ["20 kPa", 10e3], "alpha": [2, -2.5]}, 30e3),
    "gent": ({"shear_modulus": 30e3, "j_m": 40}, 30e3),
}


@pytest.mark.parametrize("law", LAWS)
def test_shear_modulus_at_small_strain(law: str) -> None:
    """mu = 2 (dW/dI1 + dW/dI2) at rest; for Ogden's sum 2 mu_i/alpha_i^2 (...) it is the sum of mu_i."""
    constants, modulus = TABLES[law]
    silicone = silicone_from({"law": law, "bulk_modulus": "30 MPa"} | constants)
    assert silicone.shear_modulus == pytest.approx(modulus)
    assert silicone.bulk_modulus == 30e6
    assert set(silicone.constants) == set(LAWS[law].units)
    assert silicone_from(table_of(silicone)) == silicone


def test_metals_have_sources_and_known_numbers() -> None:
    """Copper: IACS, 58 MS/m. Brass C26000: 28 % of it. Aluminium 1350: 60 % of it."""
    known = metals()
    assert set(known) == {"copper", "aluminium", "brass", "ferrite", "iron-rubber"}
    assert known["copper"].conductivity == 58e6
    assert known["brass"].conductivity == pytest.approx(0.28 * 58e6, rel=0.01)
    assert known["aluminium"].conductivity == pytest.approx(0.60 * 58e6, rel=0.01)
    assert known["ferrite"].relative_permeability > 1.0
    assert known["iron-rubber"].relative_permeability == pytest.approx((1 + 2 * 0.3) / (1 - 0.3), rel=3e-3)
    assert all(metal.source for metal in known.values())


def test_silicones_stand_in_order() -> None:
    """A softer grade is softer, law by law: the manufacturer's order of the grades."""
    order = ["ecoflex-00-10", "ecoflex-00-30", "ecoflex-00-50", "dragon-skin-10", "dragon-skin-20", "dragon-skin-30"]
    moduli = [silicones()[f"{name}-neo-hookean"].shear_modulus for name in order]
    assert moduli == sorted(moduli)
    tested = [silicones()[name].shear_modulus for name in order if name != "dragon-skin-20"]
    assert tested == sorted(tested)


@pytest.mark.parametrize("silicone", silicones().values(), ids=lambda silicone: silicone.name)
def test_every_silicone_says_where_it_comes_from(silicone: Silicone) -> None:
    """Source, range and residual; K is a thousand times mu, as the catalogue says."""
    assert silicone.source
    assert silicone.bulk_modulus == pytest.approx(1000.0 * silicone.shear_modulus, rel=1e-3)
    if "fit to" in silicone.source:
        assert silicone.fitted_range is not None and 0.0 < silicone.fitted_range[0] < silicone.fitted_range[1] <= 1.0
        assert silicone.rms is not None and silicone.rms < 0.12 * silicone.shear_modulus
    if silicone.law == "yeoh":
        c30 = silicone.constants["c30"]
        assert isinstance(c30, float) and c30 >= 0.0


def test_the_catalogue_holds_both_laws_of_each_silicone() -> None:
    """The plain name, and a neo-Hookean companion."""
    plain = {
        "ecoflex-00-10",
        "ecoflex-00-30",
        "ecoflex-00-50",
        "dragon-skin-10",
        "dragon-skin-20",
        "dragon-skin-30",
        "rtv615",
    }
    assert set(silicones()) == plain | {f"{name}-neo-hookean" for name in plain}
    assert {name for name in plain if silicones()[name].law != "yeoh"} == {"dragon-skin-20"}


def test_own_numbers_replace_the_catalogue() -> None:
    """A target of copper with a lower conductivity, and one without a name."""
    alloy = load_sensor("biorob2018", ["target.conductivity=2e7"]).target
    assert alloy is not None
    assert (alloy.metal.conductivity, alloy.metal.relative_permeability, alloy.metal.source) == (2e7, 1.0, "the scene")


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"law": "neo-hookean", "shear_modulus": 1.0}, "bulk_modulus: must be given; it is missing"),
        (
            {"law": "neo-hookean", "shear_modulus": 1.0, "bulk_modulus": 1.0, "c10": 1.0},
            "c10: the key must be one of .*, shear_modulus; got .c10.",
        ),
        ({"law": "neo-hookean", "shear_modulus": 1.0, "bulk_modulus": 1.0, "source": 3}, "source: must be a printable"),
        ({"law": "neo-hookean", "shear_modulus": 1, "bulk_modulus": 1, "fitted_range": 3}, "fitted_range: must be"),
        ({"fitted_range": [1.0, -0.2]}, r"fitted_range: must be the smallest and largest strain; got \[1.0, -0.2\]"),
        ({"temperature_range": ["100 degC", 273.0]}, "temperature_range: must be the lowest and"),
        ({"rms": -5.0}, "rms: must be zero or positive; got -5"),
        ({"mode_spread": -0.1}, "mode_spread: must be zero or positive; got -0.1"),
        ({"law": "mooney-rivlin", "c10": 1.0, "c01": -2.0, "bulk_modulus": 1.0}, "positive shear modulus"),
        ({"law": "gent", "shear_modulus": 1.0, "j_m": 0.0, "bulk_modulus": 1.0}, "j_m must be positive; got 0"),
        ({"prony": [{"weight": 0.6, "time": 1.0}, {"weight": 0.4, "time": 2.0}]}, "prony: must have weights .* got 1"),
        ({"prony": [{"weight": 0.1, "time": "-1 s"}]}, "prony.0.time: must be positive; got .-1 s."),
        ({"prony": [{"weight": 0.1, "time": "1 mm"}]}, "prony.0.time: must be a time"),
        ({"prony": [{"weight": 0.1}]}, "prony.0.time: must be given; it is missing"),
        ({"prony": 0.1}, "prony: must be a list of tables"),
        ({"mullins": {"r": 1.0}}, "mullins.r: must be greater than 1; got 1"),
        ({"mullins": 2.0}, "mullins: must be a table; got 2"),
        ({"mullins": {"m": 2.0}}, "mullins.r: must be given; it is missing"),
        ({"mullins": {"r": 2.0, "depth": 1.0}}, "mullins.depth: the key must be one of r, m, beta; got .depth."),
        ({"mullins": {"r": 2.0, "m": "2 mm"}}, "mullins.m: must be"),
        ({"mullins": {"r": 2.0, "m": -1.0}}, "mullins.m: must be zero or positive; got -1"),
        ({"mullins": {"r": 2.0, "beta": 0.0}}, "mullins: m and beta must not be both zero; got 0 Pa and 0"),
        ({"law": ["yeoh"]}, "law: must be one of neo-hookean, "),
        ({}, "law: must be one of neo-hookean, "),
    ],
)
def test_impossible_materials_are_refused(table: dict[str, object], message: str) -> None:
    """Key first, then what it must be."""
    law = {"law": "neo-hookean", "shear_modulus": 1.0, "bulk_modulus": 1.0}
    with pytest.raises(SceneError, match=message):
        silicone_from(law | table if table and "law" not in table else table)


def test_sources_and_modes_make_one_deviation() -> None:
    """Squares add: a range of three sources is 1.693 deviations, 90 % of laws 1.645 to either side."""
    law = {"law": "neo-hookean", "shear_modulus": 1.0, "bulk_modulus": 1.0}
    both = silicone_from(law | {"spread": 0.5, "mode_spread": 0.29})
    assert both.modulus_deviation == pytest.approx(math.hypot(math.log(1.5) / 1.693, math.log(1.29) / 1.645))
    assert silicone_from(law | {"mode_spread": 0.29}).modulus_deviation == pytest.approx(math.log(1.29) / 1.645)
    assert silicone_from(law).modulus_deviation is None and silicone_from(table_of(both)) == both


@pytest.mark.parametrize(("mu", "bulk", "words"), [
    ("30 kPa", "30 MPa", ()), ("30 kPa", "50 kPa", ("bulk modulus",)), ("40 GPa", "80 TPa", ("shear modulus",)),
    ("50 Pa", "50 Pa", ("shear modulus", "bulk modulus")),
])
def test_slips_of_unit_are_named(mu: str, bulk: str, words: tuple[str, ...]) -> None:
    """A line for each constant that no silicone has; the catalogue has none."""
    table = {"law": "neo-hookean", "shear_modulus": mu, "bulk_modulus": bulk}
    found = implausible(silicone_from(table))
    assert len(found) == len(words) and all(word in line for word, line in zip(words, found, strict=True))
    assert not any(implausible(silicone) for silicone in silicones().values())


def test_rate_and_softening_survive_a_scene_file(tmp_path: Path) -> None:
    """Off unless given; in SI after a round trip."""
    history = 'prony=[{weight=0.1, time="500 ms"}, {weight=0.2, time=30.0}], mullins={r=2.5, m="0.3 kPa", beta=0.2}'
    law = f'elastomer.material={{law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="30 MPa", {history}}}'
    scene = load_sensor("biorob2018", [law])
    save_sensor(scene, tmp_path / "scene.toml")
    again = load_sensor(tmp_path / "scene.toml")
    assert again == scene and again.elastomer is not None
    assert again.elastomer.silicone.prony == ((0.1, 0.5), (0.2, 30.0))
    assert again.elastomer.silicone.mullins == Softening(2.5, 300.0, 0.2)
    assert all(silicone.prony == () and silicone.mullins is None for silicone in silicones().values())
