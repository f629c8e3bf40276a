"""Sensitivity, crosstalk and rotation error of responses whose derivatives are known."""

import numpy as np
import pytest
import xarray as xr

from sits_mech.readout.crosstalk import (
    crosstalk,
    largest_rotation,
    rotation_error,
    sensitivity,
    signals_of,
    slope,
    slope_doubt,
    slope_error,
)

F_X = np.array([-1.0, -0.4, 0.0, 0.4, 1.0])
F_Z = np.array([0.0, 1.0, 2.5, 4.0])


def made(mixing: float = 0.0) -> xr.Dataset:
    """L_v = 200 - 3 F_z - 0.25 F_z^2 + mixing F_x^2, L_h = (5 + mixing F_z) F_x, of which a tenth is by rotation."""
    data = xr.Dataset(coords={"F_x": F_X, "F_z": F_Z})
    F_x, F_z = data.F_x, data.F_z
    data["L_v_percent"] = (200.0 - 3.0 * F_z - 0.25 * F_z**2 + mixing * F_x**2).transpose("F_x", "F_z")
    data["L_h_percent"] = ((5.0 + mixing * F_z) * F_x).transpose("F_x", "F_z")
    data["L_h_untilted_percent"] = 0.9 * data["L_h_percent"]
    data["d_h"] = 2e-4 * F_x + 0.0 * F_z
    return data


def three() -> xr.Dataset:
    """dL_v = -F_z, dL_x = (5 + F_z / 2) F_x + F_y / 5, dL_y = 4 F_y, a tenth of both by rotation; errors 0.01."""
    data = xr.Dataset(coords={"F_x": F_X, "F_z": F_Z, "F_y": np.array([-0.5, 0.0, 0.5])})
    F_x, F_z, F_y = data.F_x, data.F_z, data.F_y
    formulas = {"dL_v": -F_z, "dL_x": (5.0 + 0.5 * F_z) * F_x + 0.2 * F_y, "dL_y": 4.0 * F_y}
    formulas |= {"d_h": 2e-4 * F_x, "d_y": 1e-4 * F_y}
    data = data.assign({name: xr.broadcast(values, F_x + F_z + F_y)[0] for name, values in formulas.items()})
    data = data.assign({f"{name}_untilted": 0.9 * data[name] for name in ("dL_x", "dL_y")})
    data = data.assign({f"error_{name}": 0.01 + 0.0 * data["dL_v"] for name in ("dL_v", "dL_x", "dL_y")})
    return data.transpose("F_x", "F_z", "F_y")


def test_sensitivity_of_quadratics_is_exact() -> None:
    """Second-order differences are exact for second degree, on any grid, ends included."""
    S = sensitivity(made(0.5))
    assert S.dims == ("signal", "force", "F_x", "F_z")
    for (signal, force), expected in {
        ("L_v", "F_z"): -3.0 - 0.5 * F_Z + 0.0 * F_X[:, None],
        ("L_v", "F_x"): F_X[:, None] + 0.0 * F_Z,
        ("L_h", "F_z"): 0.5 * F_X[:, None] + 0.0 * F_Z,
        ("L_h", "F_x"): 5.0 + 0.5 * F_Z + 0.0 * F_X[:, None],
    }.items():
        np.testing.assert_allclose(S.sel(signal=signal, force=force), expected, atol=1e-12)


def test_crosstalk_by_hand() -> None:
    """Full scales 10 and 16; the largest strays are 0.5 * 4 * 1 of 10 and 0.5 of 16."""
    found = crosstalk(made(0.5))
    assert found.attrs["full_scale_L_h"] == pytest.approx(10.0)
    assert found.attrs["full_scale_L_v"] == pytest.approx(16.0)
    assert found.attrs["largest_L_h_from_F_z"] == pytest.approx(20.0)
    assert found.attrs["largest_L_v_from_F_x"] == pytest.approx(100.0 * 0.5 / 16.0)
    assert found["L_h_from_F_z"].dims == found["L_v_from_F_x"].dims == ("F_x", "F_z")
    np.testing.assert_allclose(found["L_v_from_F_x"], 100.0 / 16.0 * 0.5 * F_X[:, None] ** 2 + 0.0 * F_Z, atol=1e-12)
    np.testing.assert_allclose(found["L_h_from_F_z"], 10.0 * 0.5 * F_X[:, None] * F_Z, atol=1e-12)


def test_no_mixing_no_crosstalk() -> None:
    """Signals that each answer one force alone."""
    found = crosstalk(made())
    assert float(np.abs(found["L_h_from_F_z"]).max()) < 1e-12
    assert float(np.abs(found["L_v_from_F_x"]).max()) < 1e-12


def test_rotation_error_by_hand() -> None:
    """A tenth of L_h = 5 F_x: e = F_x / 2, that is F_x / 10 newtons, or e 2e-4 / 4.5 metres."""
    found = rotation_error(made())
    np.testing.assert_allclose(found["F_x_error"], 0.1 * F_X[:, None] + 0.0 * F_Z, atol=1e-12)
    np.testing.assert_allclose(found["d_h_error"], 0.5 * F_X[:, None] * 2e-4 / 4.5 + 0.0 * F_Z, atol=1e-16)


def test_every_force_into_every_signal_by_hand() -> None:
    """Full scales 4, 10 and 4; into dL_x F_z strays by 0.5 * 4 * 1, F_y by 0.2 * 0.5, both of 10."""
    found = crosstalk(three()).attrs
    assert {name: found[f"full_scale_{name}"] for name in ("dL_v", "dL_x", "dL_y")} == pytest.approx(
        {"dL_v": 4.0, "dL_x": 10.0, "dL_y": 4.0}
    )
    strays = {key.removeprefix("largest_"): value for key, value in found.items() if key.startswith("largest_")}
    assert strays == pytest.approx({
        "dL_v_from_F_x": 0.0, "dL_v_from_F_y": 0.0, "dL_x_from_F_z": 20.0, "dL_x_from_F_y": 1.0, "dL_y_from_F_z": 0.0,
        "dL_y_from_F_x": 0.0,
    }, abs=1e-12)
    assert found["error_full_scale_dL_x"] == pytest.approx(0.02)
    assert found["error_largest_dL_x_from_F_z"] == pytest.approx((2.0 + 20.0 * 0.02) / (10.0 - 0.02))
    assert crosstalk(three())["dL_x_from_F_y"].dims == ("F_x", "F_z", "F_y")


def test_sensitivity_of_three_signals_is_exact() -> None:
    """By every force, those with a signal of their own first; a moment too, which has none."""
    S = sensitivity(three())
    assert S.coords["signal"].to_numpy().tolist() == ["dL_v", "dL_x", "dL_y"]
    assert S.coords["force"].to_numpy().tolist() == ["F_z", "F_x", "F_y"]
    np.testing.assert_allclose(S.sel(signal="dL_x", force="F_y"), 0.2, atol=1e-12)
    np.testing.assert_allclose(S.sel(signal="dL_y", force="F_y"), 4.0, atol=1e-12)
    np.testing.assert_allclose(S.sel(signal="dL_x", force="F_z").isel(F_x=4), 0.5, atol=1e-12)
    turned = three().rename(F_y="M")
    assert sensitivity(turned).coords["force"].to_numpy().tolist() == ["F_z", "F_x", "M"]
    assert "largest_dL_x_from_M" in crosstalk(turned).attrs and "full_scale_dL_y" not in crosstalk(turned).attrs


def test_rotation_error_along_both_axes() -> None:
    """A tenth of dL_y = 4 F_y: 0.4 F_y, that is F_y / 10, or 0.4 F_y 1e-4 / 3.6 metres."""
    found = largest_rotation(three())
    assert found["F_y"][0] == pytest.approx(0.05) and found["d_y"][0] == pytest.approx(0.4 * 0.5 * 1e-4 / 3.6)
    # by three values a half apart the slope at an end is (-3 y_0 + 4 y_1 - y_2): an error of 0.01 each makes 0.08
    assert found["F_y"][1] == pytest.approx((0.02 + 0.05 * 0.08) / (4.0 - 0.08))
    assert set(found) == {"F_x", "d_h", "F_y", "d_y"}
    assert largest_rotation(made().drop_vars("L_h_untilted_percent")) == {}


def test_which_signal_belongs_to_which_force() -> None:
    """A pair on x shows its published signals, one on y none along x, coils in a row none along y."""
    pair = made()
    assert signals_of(pair) == {"F_z": "L_v_percent", "F_x": "L_h_percent"}
    moments = {name: pair["L_h_percent"] for name in ("dL_v", "dL_x")} | {"dL_y": 0.0 * pair["L_h_percent"]}
    assert signals_of(pair.assign(moments)) == {"F_z": "L_v_percent", "F_x": "L_h_percent"}
    upright = pair.assign(moments | {"dL_x": moments["dL_y"], "dL_y": moments["dL_x"]})
    assert signals_of(upright) == {"F_z": "dL_v", "F_y": "dL_y"}
    row = pair.drop_vars(["L_v_percent", "L_h_percent", "L_h_untilted_percent"]).assign(moments)
    row["dL_y"][0, 0] = np.nan  # a load that failed
    assert signals_of(row) == {"F_z": "dL_v", "F_x": "dL_x"}


def test_a_single_load_has_no_slope() -> None:
    """One value of a force gives NaN, not a guess; a missing point stays missing."""
    single = sensitivity(made().isel(F_x=[2]))
    assert np.all(np.isnan(single.sel(force="F_x")))
    assert np.all(np.isfinite(single.sel(force="F_z")))
    holed = made()
    holed["L_v_percent"][0, 0] = np.nan
    found = crosstalk(holed)
    assert np.isnan(found["L_v_from_F_x"][0, 0]) and np.isfinite(found.attrs["largest_L_v_from_F_x"])


def test_error_of_a_slope_is_the_worst_case() -> None:
    """Reached by errors of the worst signs, exceeded by none."""
    data, errors = made(0.5)["L_v_percent"], 0.01 * (1.0 + made()["d_h"] * 1e3)
    allowed = slope_error(errors, "F_z")
    worst = xr.zeros_like(data)
    for signs in np.ndindex(2, 2, 2, 2):
        moved = data + errors * xr.DataArray(2.0 * np.array(signs) - 1.0, dims="F_z")
        worst = np.maximum(worst, abs(slope(moved, "F_z") - slope(data, "F_z")))
    np.testing.assert_allclose(worst, allowed, rtol=1e-9)


def test_an_unknown_error_spreads_to_its_neighbours() -> None:
    """Infinite where a difference uses it, the others untouched, no warning."""
    errors = xr.DataArray([0.1, 0.1, 0.1, 0.1, np.inf], {"F_x": [0.0, 1.0, 2.0, 3.0, 4.0]}, ["F_x"])
    found = slope_error(errors, "F_x").to_numpy()
    assert found[:3] == pytest.approx([0.4, 0.1, 0.1]) and np.isinf(found[3:]).all()


def shared(kind: str, size: float, own: float) -> xr.Dataset:
    """The pair's signals with errors that all loads share, an offset or a gain of both, beside some of their own."""
    data = made(0.5)
    for name in ("L_v_percent", "L_h_percent", "L_h_untilted_percent"):
        part = size * (data[name] if kind == "gain" else xr.ones_like(data[name]))
        data[f"shared_{name}"] = part.expand_dims("part")
        data[f"error_{name}"] = abs(part) + own
    data["error_L_h_turned"] = xr.full_like(data["L_h_percent"], own)
    return data


def test_an_offset_of_all_loads_cancels() -> None:
    """In ranges, slopes, crosstalk and what the rotation does."""
    data = shared("offset", 0.3, 0.0)
    found = crosstalk(data).attrs
    errors = [value for name, value in found.items() if name.startswith("error_")]
    errors += [error for _, error in largest_rotation(data).values()]
    assert len(errors) == 6 and np.all(np.array(errors) < 1e-12)
    assert float(abs(slope_doubt(data, "L_v_percent", "F_z")).max()) < 1e-12


def test_a_gain_of_all_loads_is_one_of_full_scale_and_slope_not_of_crosstalk() -> None:
    data = shared("gain", 0.02, 0.0)
    found = crosstalk(data).attrs
    assert found["error_full_scale_L_v"] == pytest.approx(0.02 * 16.0)
    assert found["error_largest_L_h_from_F_z"] < 1e-12 and found["error_largest_L_v_from_F_x"] < 1e-12
    assert max(error for _, error in largest_rotation(data).values()) < 1e-12  # signal and slope have the same gain
    np.testing.assert_allclose(
        slope_doubt(data, "L_v_percent", "F_z"), 0.02 * abs(slope(data["L_v_percent"], "F_z")), atol=1e-12
    )


def test_what_loads_do_not_share_is_independent() -> None:
    """Root of the sum of squares: of a range sqrt(2), of a slope by the weights of its differences."""
    data = shared("gain", 0.0, 0.01)
    found = crosstalk(data).attrs
    error = 0.01 * np.sqrt(2.0)
    assert found["error_full_scale_L_h"] == pytest.approx(error)
    assert found["error_largest_L_h_from_F_z"] == pytest.approx((100.0 * error + 20.0 * error) / (10.0 - error))
    weights = np.gradient(np.eye(4), F_Z, axis=0, edge_order=2)
    allowed = slope_doubt(data, "L_v_percent", "F_z").transpose("F_x", "F_z")
    np.testing.assert_allclose(allowed, np.tile(0.01 * np.linalg.norm(weights, axis=1), (5, 1)))
