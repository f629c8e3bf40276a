"""Scene files: what is accepted, what is refused and how, and that nothing is lost on the way out and in again."""

import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from sits_mech.scene.files import overridden, written
from sits_mech.scene.sensor import (
    Coil,
    Elastomer,
    Readout,
    SceneError,
    Sensor,
    Target,
    catalogue,
    changed,
    load_sensor,
    quantity,
    save_sensor,
    scene_hash,
    scene_text,
    sensor_from,
)

BIOROB = load_sensor("biorob2018")
COIL = {
    "name": "C1",
    "centre": [0.0, 0.0],
    "layers": 1,
    "turns": 5,
    "inner_diameter": 2e-3,
    "track_width": 1e-4,
    "track_gap": 1e-4,
    "track_thickness": 35e-6,
}
PLATE = {"name": "backing", "material": "ferrite", "shape": "rectangle", "width": "18 mm", "length": "18 mm"}


def scene(**changes: Any) -> dict[str, Any]:
    """Return a small scene with some keys changed."""
    return {"name": "one coil", "frequency": 1e6, "coils": [COIL]} | changes


# ---- quantities


@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [
        ("2 mm", "m", 2e-3),
        ("5 MHz", "Hz", 5e6),
        ("30 kPa", "Pa", 3e4),
        ("10 deg", "rad", math.pi / 18),
        ("-0.5 N", "N", -0.5),
        ("3 N*mm", "N*m", 3e-3),
        ("3 N·mm", "N*m", 3e-3),
        ("5.8e7 S/m", "S/m", 5.8e7),
        ("330pF", "F", 3.3e-10),
        ("1 kg*m/s^2", "N", 1.0),
        ("0.5", "N", 0.5),
        (3, "m", 3.0),
        ("85 um", "m", 85e-6),
        ("1 inch", "m", 0.0254),
    ],
)
def test_quantity_in_si(written: object, unit: str, value: float) -> None:
    """By the definitions of the units; fifteen digits."""
    assert quantity(written, unit, "x") == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    "written",
    ["2 N", "mm", "", "2 mmm", "nan", "inf", math.nan, math.inf, True, None, [1], "1e999 m", "2 mm; 3", "9**9**9 m"]
    + ["2 m^3", "2 degC", "2 m^-1", "__import__('os') m", "2 \0m", 10**400],
)
def test_quantity_refuses(written: object) -> None:
    """One line: the name, what it must be, what came."""
    with pytest.raises(SceneError, match=r"^--dv: must be a length.*; got .*$") as caught:
        quantity(written, "m", "--dv")
    assert "\n" not in str(caught.value)


# ---- the catalogue


def test_biorob2018_is_the_published_sensor() -> None:
    """Numbers from Jones and others 2018: two layers of twelve turns, 0.1 mm tracks and gaps, 8 mm apart."""
    assert [coil.name for coil in BIOROB.coils] == ["C1", "C2"]
    assert [coil.centre for coil in BIOROB.coils] == [(-4e-3, 0.0), (4e-3, 0.0)]
    coil, target = BIOROB.coils[0], BIOROB.target
    assert (coil.layers, coil.turns, coil.track_width, coil.track_gap) == (2, 12, 1e-4, 1e-4)
    assert coil.outer_diameter == pytest.approx(6.8e-3)  # 2.2 + 2 (12 + 11) 0.1 mm; the paper rounds to 7 mm
    assert coil.height == pytest.approx(120e-6)
    assert target is not None and (target.width, target.thickness, target.load_height) == (8e-3, 2e-4, 2e-4)
    assert target.metal.conductivity == 5.8e7
    assert BIOROB.frequency == 5e6


def test_every_catalogued_sensor_loads() -> None:
    """With the widths of the published study: 8, 15 and 22 mm; the others say that they are designs."""
    published = ["biorob2018", "biorob2018-w15", "biorob2018-w22"]
    assert list(catalogue()) == [*published, "square-4", "triaxial-3", "triaxial-4"]
    targets = [load_sensor(name).target for name in published]
    assert [target.width for target in targets if target] == [8e-3, 15e-3, 22e-3]
    assert all("design" in name for key, name in catalogue().items() if key not in published)


@pytest.mark.parametrize(("name", "count"), [("triaxial-3", 3), ("triaxial-4", 4)])
def test_three_axis_designs_are_even_around_the_centre(name: str, count: int) -> None:
    """A turn by a full angle over the number of coils maps every coil on the next; neighbours are 8 mm apart."""
    sensor = load_sensor(name)
    x, y = np.transpose([coil.centre for coil in sensor.coils])
    at = x + 1j * y
    np.testing.assert_allclose(at * np.exp(2j * np.pi / count), np.roll(at, -1), atol=1e-7)
    np.testing.assert_allclose(np.abs(at - np.roll(at, 1)), 8e-3, atol=1e-7)
    assert {coil.model_copy(update={"name": "", "centre": (0.0, 0.0)}) for coil in sensor.coils} == {
        BIOROB.coils[0].model_copy(update={"name": "", "centre": (0.0, 0.0)})
    }


# ---- round trip, overrides


@pytest.mark.parametrize(
    "sensor",
    [
        BIOROB,
        sensor_from(scene()),
        changed(BIOROB, ['elastomer.material={law="ogden", mu=[1e4, "2 kPa"], alpha=[2, -3.5], bulk_modulus=1e7}']),
        changed(BIOROB, ["target.load_height=0", "substrate_radius=0.03", "target.conductivity=1e6"]),
        sensor_from(scene(conductors=[PLATE | {"centre": [0, "-1 mm"], "thickness": "1 mm"}])),
        sensor_from(scene(name='quotes " \\ and µ')),
    ],
    ids=["biorob2018", "small", "ogden", "overridden", "conductor", "letters"],
)
def test_save_and_load_give_the_same_sensor(sensor: Sensor, tmp_path: Path) -> None:
    """Bit for bit, and by hash, through a file and through pickle."""
    save_sensor(sensor, tmp_path / "scene.toml")
    again = load_sensor(tmp_path / "scene.toml")
    assert again == sensor
    assert scene_hash(again) == scene_hash(sensor)
    assert hash(again) == hash(sensor)
    assert pickle.loads(pickle.dumps(sensor)) == sensor
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


def test_what_a_file_of_a_mesh_holds_counts_in_the_hash(tmp_path: Path) -> None:
    """Loads kept by it are of that mesh, not of another one written to the same path."""
    found = []
    for words in ("one", "another"):
        (tmp_path / "pad.msh").write_text(words)
        found.append(scene_hash(changed(BIOROB, [f'elastomer.mesh="{tmp_path / "pad.msh"}"'])))
    assert found[0] != found[1]


def test_overrides_reach_every_key() -> None:
    """Tables by key; coils by number and by name; strings with and without quotes."""
    sensor = load_sensor(
        "biorob2018",
        ["coils.0.turns=10", "coils.C2.turns = 9", 'target.width="7 mm"', "elastomer.thickness=3 mm", "name=other"],
    )
    assert [coil.turns for coil in sensor.coils] == [10, 9]
    assert sensor.target is not None and sensor.elastomer is not None
    assert (sensor.target.width, sensor.elastomer.thickness, sensor.name) == (7e-3, 3e-3, "other")
    assert scene_hash(sensor) != scene_hash(BIOROB)


def test_changing_the_thickness_moves_the_default_load() -> None:
    """The force acts on the top face unless the scene says otherwise."""
    thicker = changed(BIOROB, ["target.thickness=1e-3"]).target
    told = changed(changed(BIOROB, ["target.load_height=0"]), ["target.thickness=1e-3"]).target
    assert thicker is not None and told is not None
    assert (thicker.load_height, told.load_height) == (1e-3, 0.0)


def test_overriding_leaves_its_input_alone() -> None:
    """Nothing changes its inputs."""
    table = scene()
    overridden(table, ["coils.0.turns=1", "readout.idle_coil=open"])
    assert table == scene()


def test_a_sensor_is_frozen() -> None:
    """Attributes cannot be set."""
    with pytest.raises(ValidationError):
        BIOROB.frequency = 1.0


# ---- refusals

REFUSED = {
    'target.width="2 N"': r'target.width: must be a length.*got "2 N"',
    "target.width=nan": r"target.width: must be a length.*got nan",
    "target.width=inf": r"target.width: must be a length.*got inf",
    "target.width=0": r"target.width: must be a length from 1 nm.*got 0",
    "target.width=-1e-3": r"target.width: must be a length.*got -0.001",
    "target.width=1e200": r"target.width: must be a length.*got 1e\+200",
    "target.widht=3": r'target.widht: the key must be one of .*did you mean "width"',
    "target.diameter=3 mm": r"target: diameter must not be given for a rectangle",
    "target.shape=disc": r"target: width must not be given for a disc",
    'target={material="copper", shape="ring", diameter="6 mm", thickness="1 mm"}':
        r"target: inner_diameter must be given for a ring; it is missing",
    'target={material="copper", shape="ring", diameter="6 mm", inner_diameter="7 mm", thickness="1 mm"}':
        r"target: inner_diameter must be smaller than the diameter, 6 mm; got 7 mm",
    "target.shape=oval": r"target.shape: must be 'rectangle', 'disc', 'ring' or 'outline'; got \"oval\"",
    "target.material=coper": r'target.material: must be one of .*got "coper" \(did you mean "copper"\?\)',
    "target.net_current=free": r"target: planar_boundary_radius must be given",
    "target=3": r"target: must be a table; got 3",
    "coils=[]": r"coils must be one or more",
    "coils=3": r"coils: must be a list of tables, as under \[\[coils\]\]; got 3",
    "coils.0=5": r"coils.0: must be a table; got 5",
    "coils.0.turns=0": r"coils.C1.turns: must be a whole number.*got 0",
    "coils.0.turns=2.5": r"coils.C1.turns: must be a whole number.*got 2.5",
    "coils.0.turns=true": r"coils.C1.turns: must be a whole number.*got True",
    "coils.0.turns=20": r"coils.C1 and coils.C2 overlap",
    "coils.1.centre=[-4e-3, 0]": r"coils.C1 and coils.C2 overlap",
    "coils.1.name=C1": r"coils must have a name of their own",
    "coils.0.layer_pitch=10 um": r"coils.C1: layer_pitch must be at least track_thickness",
    "coils.0.track_gap=0": r"coils.C1.track_gap: must be a length",
    "coils.0.centre=[1, 2, 3]": r"coils.C1.centre: must be a list of two",
    "coils.C3.turns=3": r"--set coils.C3.turns: C3 must be one of C1, C2",
    "coils.0.centre.x.y=3": r"--set coils.0.centre.x.y: x must be",
    "name=": r"name: must be a printable text",
    "nonsense": r"--set \"nonsense\": must be key=value",
    "frequency=0": r"frequency: must be a frequency",
    "frequency=5 mm": r"frequency: must be a frequency",
    "elastomer.thickness=0 mm": r"elastomer.thickness: must be a length",
    "elastomer.standoff=-1 mm": r"elastomer.standoff: must be zero or a length",
    "elastomer.standoff=2.1 mm": r"elastomer: standoff must be a film no thicker than .*2 mm.; got 2.1 mm",
    "elastomer.pitch=3 mm": r"elastomer: pitch must not be given for a box; got 0.003",
    "elastomer.shape=pillars": r"elastomer: diameter must be given for pillars; it is missing",
    "elastomer.material=ecoflex": r'elastomer.material: must be one of .*got "ecoflex"',
    'elastomer.material={law="yeoh", c10=1e4}': r"elastomer.material: bulk_modulus: must be given; it is missing",
    'elastomer.material={law="hooke"}': r"elastomer.material: law: must be one of neo-hookean, .*got .hooke.",
    'elastomer.material={law="gent", shear_modulus=-1, j_m=10, bulk_modulus=1e6}': r"positive shear modulus",
    'elastomer.material={law="gent", shear_modulus=1, j_m=0, bulk_modulus=1e6}': r"j_m must be positive",
    'elastomer.material={law="ogden", mu=[1, 2], alpha=[2], bulk_modulus=1e6}': r"mu and alpha must be lists of one",
    'elastomer.material={law="neo-hookean", shear_modulus="2 mm", bulk_modulus=1}': "shear_modulus: must be a",
    'elastomer.material={law="neo-hookean", shear_modulus=1, bulk_modulus=-1}': "bulk_modulus: must be a positive",
    "elastomer.diameter=20 mm": r"elastomer: width must not be given for a cylinder",
    "readout.idle_coil=loose": r"readout.idle_coil: must be 'shorted', 'open' or 'live'",
    "substrate_radius=1 mm": r"substrate_radius must be at least",
    'target.centre=["1 mm", "0 mm"]': "target.centre: must be left out: .*coils.NAME.centre; got .'1 mm', '0 mm'.",
    "colour=red": r"colour: the key must be one of",
    "elastomer.idle_coil=open": r'the key must be one of .*; got "idle_coil", which stands in \[readout\]$',
    "target.frequency=3": r'got "frequency", which stands above the first table$',
    "elastomer.law=ogden": r'elastomer.law: must be left out: constants of a silicone stand in a table, .*got "ogden"$',
}


@pytest.mark.parametrize("override", REFUSED)
def test_refusal_names_key_and_cause(override: str) -> None:
    """One clear line: where, key, what it must be, what came."""
    with pytest.raises(SceneError, match=REFUSED[override]) as caught:
        load_sensor("biorob2018", [override])
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(("biorob2018: ", "--set "))


@pytest.mark.parametrize(
    "key", ["name", "frequency", "coils", "coils.0.turns", "target.thickness", "elastomer.material"]
)
def test_missing_key_is_named(key: str) -> None:
    """Required keys have no silent default."""
    table = tomllib.loads(scene_text(BIOROB))
    *way, last = key.split(".")
    here: Any = table
    for step in way:
        here = here[int(step)] if step.isdigit() else here[step]
    del here[last]
    with pytest.raises(SceneError, match=f"^mine: {key.replace('coils.0', 'coils.C1')}: must be given; it is missing$"):
        sensor_from(table, "mine")


@pytest.mark.parametrize(
    ("shape", "elastomer", "fits"),
    [
        ({"shape": "disc", "diameter": 15e-3}, {"diameter": 15e-3}, True),
        ({"shape": "disc", "diameter": 15.1e-3}, {"diameter": 15e-3}, True),
        ({"shape": "rectangle", "width": 12e-3, "length": 9e-3}, {"diameter": 15e-3}, True),
        ({"shape": "rectangle", "width": 22e-3, "length": 9e-3}, {"width": 20e-3, "length": 20e-3}, True),
        ({"shape": "outline", "points": [[0, 6e-3], [-5e-3, -3e-3], [5e-3, -3e-3]]}, {"diameter": 12e-3}, True),
        ({"shape": "outline", "points": [[0, 0], [1e-3, 1e-3], [2e-3, 2e-3]]}, {"diameter": 11e-3}, False),
    ],
)
def test_targets_of_every_shape_fit_or_not(shape: dict[str, Any], elastomer: dict[str, Any], fits: bool) -> None:
    """A target may be wider than its layer; an outline needs an area."""
    layer = {"material": "rtv615", "thickness": 2e-3} | elastomer
    table = scene(target={"material": "copper", "thickness": 1e-4} | shape, elastomer=layer)
    if fits:
        assert sensor_from(table).target is not None
    else:
        with pytest.raises(SceneError, match="target"):
            sensor_from(table)


@pytest.mark.parametrize(("z", "x", "clear"), [(-0.6e-3, 0.0, True), (-0.5e-3, 0.0, False), (0.0, 12e-3, True)])
def test_conductors_stay_clear_of_the_coils(z: float, x: float, clear: bool) -> None:
    """A 1 mm plate under a 35 um track layer must be lower than 0.535 mm; beside the coil any height will do."""
    table = scene(conductors=[PLATE | {"centre": [x, z], "thickness": 1e-3}])
    if clear:
        assert sensor_from(table).conductors[0].centre == (x, 0.0, z)
    else:
        with pytest.raises(SceneError, match="conductors.backing must be clear of coils.C1"):
            sensor_from(table)


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    """Missing, a folder, no TOML, no text, an empty name, a path that cannot be."""
    binary, words = tmp_path / "binary.toml", tmp_path / "words.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    words.write_text("this is no scene")
    nested = tmp_path / "nested.toml"
    nested.write_text("a = " + "[" * 5000)
    deep = tmp_path / "deep.toml"
    deep.write_text(".".join(["a"] * 2000) + " = 1")
    for source in (tmp_path / "none.toml", tmp_path, binary, words, nested, deep, "", "biorob", "a\0b"):
        with pytest.raises(SceneError) as caught:
            load_sensor(source)
        assert "\n" not in str(caught.value)
    with pytest.raises(SceneError, match=r'did you mean "biorob2018"'):
        load_sensor("biorob2019")


def test_saving_into_no_folder_leaves_nothing(tmp_path: Path) -> None:
    """Whole or not at all."""
    with pytest.raises(SceneError, match="must be writable"):
        save_sensor(BIOROB, tmp_path / "none" / "scene.toml")
    assert list(tmp_path.iterdir()) == []


# ---- anything at all

TEXTS = st.sampled_from(
    ["2 mm", "2 N", "", "copper", "rectangle", "disc", "C1", "nan", "1e400 m", "zero", "\x7f\ud800"]
)
LEAVES = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), TEXTS)
ANYTHING = st.recursive(
    LEAVES,
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=5), inner, max_size=3)),
)
PARTS = (Sensor, Coil, Target, Elastomer, Readout)
KEYS = [key for part in PARTS for key in part.model_fields]


@st.composite
def damaged_scenes(draw: st.DrawFn) -> dict[str, Any]:
    """A good scene with some entries replaced, removed or added anywhere."""
    table: dict[str, Any] = tomllib.loads(scene_text(BIOROB))
    places: list[Any] = [table, *table["coils"], table["target"], table["elastomer"], table["readout"]]
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.sampled_from(places))
        place[draw(st.sampled_from(KEYS) | st.text(max_size=5))] = draw(ANYTHING | st.floats(1e-5, 0.1))
    return table


def _accepted(table: dict[str, Any]) -> None:
    """Either a sensor that survives its own file, or a refusal on one line; nothing else."""
    try:
        sensor = sensor_from(table)
    except SceneError as error:
        assert "\n" not in str(error)
    else:
        assert sensor_from(tomllib.loads(scene_text(sensor))) == sensor


@given(damaged_scenes())
def test_damaged_scenes_are_valid_or_refused(table: dict[str, Any]) -> None:
    """Never another exception."""
    _accepted(table)


@given(st.dictionaries(st.sampled_from(KEYS) | st.text(max_size=5), ANYTHING, max_size=6))
def test_random_scenes_are_valid_or_refused(table: dict[str, Any]) -> None:
    """Never another exception."""
    _accepted(table)


@given(st.text(max_size=30), st.text(max_size=30))
def test_random_overrides_are_valid_or_refused(key: str, value: str) -> None:
    """Never another exception."""
    try:
        _accepted(overridden(tomllib.loads(scene_text(BIOROB)), [f"{key}={value}"]))
    except SceneError as error:
        assert "\n" not in str(error)


@given(st.text(max_size=20) | st.from_regex(r"-?[0-9.]+(e-?[0-9]+)? ?[a-zA-Z*/^0-9 ]{0,12}", fullmatch=True))
def test_random_quantities_are_finite_or_refused(text: str) -> None:
    """Never another exception, never NaN."""
    try:
        assert math.isfinite(quantity(text, "m", "x"))
    except SceneError as error:
        assert "\n" not in str(error)


@given(
    st.dictionaries(
        st.from_regex(r"[a-z]{1,4}", fullmatch=True),
        st.text(st.characters(exclude_categories=["Cs"]))
        | st.floats(allow_nan=False)
        | st.integers(-(2**63), 2**63 - 1),
    )
)
def test_written_toml_reads_back(table: dict[str, Any]) -> None:
    """The writer against the standard library's reader."""
    assert tomllib.loads(written(table)) == table


def test_losses_of_magnetisation_need_a_magnetic_part() -> None:
    """Of copper they were taken for those of ferrite, and its eddy currents left out."""
    part = ('{name="lid", material="copper", shape="rectangle", width="9 mm", length="9 mm", thickness="0.2 mm", '
            'centre=["0 mm", "6 mm"]')
    with pytest.raises(SceneError, match=r"conductors.lid: loss_tangent must be 0 where .* is 1; got 0\.02$"):
        load_sensor("biorob2018", [f"conductors=[{part}, loss_tangent=0.02}}]"])
