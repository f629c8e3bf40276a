"""Tables say what they hold: a unit that others read, a name for an axis, coordinates as coordinates."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pint
import pytest
import xarray as xr

import sits_mech as sm
from sits_mech.batch.run import run_study
from sits_mech.batch.studies.study import read_study
from sits_mech.labels import described, labelled, unit_of
from sits_mech.store import read_table, save_table

_MODELS = {"mechanics": "linear", "magnetics": "planar", "tolerance": 0.1}


_UDUNITS = set("1 % N m s rad H ohm Hz K".split())  # all that names of units here are made of, by its database


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a calibration with slopes by temperature."""
    path = tmp_path_factory.mktemp("labels") / "result.nc"
    loads = {"F_x": [-0.2, 0.0, 0.2], "F_z": [0.0, 1.0], "M": 1e-3}
    save_table(sm.calibrate(sm.load_sensor("biorob2018"), **loads, **_MODELS, drift=True), path)
    return path


@pytest.fixture(scope="module")
def table(path: Path) -> xr.Dataset:
    """The same, as it is read back."""
    return read_table(path)


def _check(data: xr.Dataset) -> None:
    """Every variable has a name, every number a unit, and pint reads it."""
    assert data.attrs["Conventions"] == "CF-1.11"
    for name, item in data.variables.items():
        assert item.attrs["long_name"], name
        assert ("units" in item.attrs) == (item.dtype.kind == "f"), name
        pint.Unit(item.attrs.get("units", "").replace(" ", "*").replace("%", "percent"))


def test_every_variable_of_a_calibration_has_unit_and_name(table: xr.Dataset) -> None:
    """Loads, one that is the same throughout as well, are coordinates; errors belong to what they are of."""
    _check(table)
    assert set(table.coords) == {"F_x", "F_z", "M", "coil", "coil_2", "thermal_cause"}
    found = {name: table[name].attrs["units"] for name in ("M", "L_v", "dL_x", "slope_T_alpha", "error_L_h_turned")}
    assert found == {"M": "N m", "L_v": "H/m", "dL_x": "%", "slope_T_alpha": "rad/K", "error_L_h_turned": "%"}
    assert table["L"].attrs["ancillary_variables"] == "error_L"
    assert table["flags"].attrs["long_name"] == "all that holds of the answer, worst first"


def test_a_file_keeps_the_rules_of_cf(path: Path) -> None:
    """Of its chapters 2.3 (names), 3.1 (units), 3.4 (ancillary variables), 3.5 (flags) and 5 (coordinates)."""
    with xr.open_dataset(path, engine="netcdf4", decode_cf=False) as data:
        _check(data)
        assert all(re.fullmatch("[A-Za-z][A-Za-z0-9_]*", str(name)) for name in {*data.variables, *data.dims})
        for name, item in data.variables.items():
            assert set(re.split("[ /]", item.attrs.get("units", "1"))) <= _UDUNITS, name
            for other in f"{item.attrs.get('ancillary_variables', '')} {item.attrs.get('coordinates', '')}".split():
                assert set(data[other].dims) <= set(item.dims), (name, other)
            assert item.dtype.kind in "fU" or {"flag_values", "flag_meanings"} <= set(item.attrs), name
            if item.dims == (name,) and item.dtype.kind == "f":
                steps = np.diff(item.to_numpy())
                assert np.all(steps > 0.0) or np.all(steps < 0.0), name
                assert "_FillValue" not in item.attrs, name


def test_a_plot_has_axes_with_units(table: xr.Dataset) -> None:
    """Without a word of explanation."""
    table["L_v"].plot()
    drawn, bar = plt.gcf().axes
    texts = [text.replace("\n", " ") for text in (drawn.get_xlabel(), drawn.get_ylabel(), bar.get_ylabel())]
    plt.close()
    assert texts == ["normal force, pressing down [N]", "shear force along x [N]", "sum of the inductances [H/m]"]


@pytest.mark.parametrize(("request_", "asked"), [
    ("simulate", 'mechanics = "linear"\nmagnetics = "planar"\ntolerance = 0.1\nfz = "1 N"'),
    pytest.param(
        "quality",
        'mechanics = "linear"\nmagnetics = "planar"\ntolerance = 0.1\nfx = "-0.2 N:0.2 N:3"\nfz = "0 N:1 N:3"',
        marks=pytest.mark.slow,
    ),
])
def test_every_variable_of_a_study_has_them(request_: str, asked: str, tmp_path: Path) -> None:
    """What varies as well, in the unit of its values."""
    head = f'scene = "biorob2018"\nrequest = "{request_}"\n'
    text = f'{head}[vary]\n"target.width" = ["8 mm", "9 mm"]\n[fixed]\n{asked}\n'
    (tmp_path / "study.toml").write_text(text)
    data = run_study(read_study(tmp_path / "study.toml"), tmp_path / "out")
    _check(data)
    assert data["target.width"].attrs["units"] == "m"


def test_units_of_columns_and_of_what_is_mixed() -> None:
    """By the name of a column; a table of models in space and in the plane has no one unit of inductance."""
    assert [unit_of(name, "H") for name in ("L[C1][C2]", "error_R[C1][C1]", "fz", "nothing")] == ["H", "ohm", "N", ""]
    mixed = xr.Dataset({"L": ("case", np.ones(2)), "unit_L": ("case", ["H", "H/m"])})
    assert "units" not in labelled(mixed)["L"].attrs and "units" not in mixed["L"].attrs
    assert labelled(mixed.isel(case=[0]))["L"].attrs["units"] == "H"


def test_the_page_of_keys_reads_here_what_a_table_holds_too() -> None:
    assert described("error_dL_x").startswith("Estimated error of the first moment of the inductances along x over L0")
    assert described("min_J") == "Smallest volume ratio in the layer." and described("R_dc").endswith("[ohm].")
    assert described("foo") == described("error_foo") == ""
