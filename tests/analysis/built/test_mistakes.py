"""Slips in a bench file are named: columns, signs, units; honest readings have none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sits_mech.analysis.bench.force_maps import force_maps_of
from sits_mech.analysis.built.adaptation import Adaptation, adapt
from sits_mech.analysis.built.mistakes import as_read, mistake, refuse_unlikely
from sits_mech.analysis.built.prior import Prior, prior_of
from sits_mech.analysis.readings.bench import absolute, loads_over, table_impedance, with_idle
from sits_mech.analysis.readings.measured import Measured
from sits_mech.cli.main import run
from sits_mech.readout.loads import varied
from sits_mech.scene.sensor import SceneError, Sensor, save_sensor
from sits_mech.store import save_table
from tests.analysis.conftest import LOADS, bench_of

GRAVITY = 9.80665


def _swapped(bench: Measured) -> Measured:
    """Two columns of coils."""
    return replace(bench, L=bench.L[:, ::-1])


def _signed(bench: Measured) -> Measured:
    """Shear the other way."""
    return replace(bench, forces=bench.forces * [-1.0, 1.0])


def _kilograms(bench: Measured) -> Measured:
    """Masses in place of weights."""
    return replace(bench, forces=bench.forces / GRAVITY)


@pytest.mark.parametrize(
    ("slip", "words"),
    [(_swapped, "C1 and C2 seem swapped"),
     pytest.param(_signed, "other sign|swapped", marks=pytest.mark.slow),
     pytest.param(_kilograms, "factor of 9.81: kilograms", marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_slips_are_named(prior: Prior, slip, words: str) -> None:
    """Of readings that are far likelier without."""
    bench = slip(bench_of(prior, modulus=1.0, gap=4e-5, d_h=1e-4, alpha=0.02, lead=1e-8))
    try:
        found = adapt(prior, bench)
    except SceneError:
        found = None
    assert found is None or found.p_value < 0.01
    assert np.any([word in mistake(prior, bench, found) for word in words.split("|")])


def _nanohenries(bench: Measured) -> Measured:
    """Numbers of nH under uH."""
    return replace(bench, L=1e3 * bench.L)


def _of_another(bench: Measured) -> Measured:
    """Two thirds of the turns."""
    return replace(bench, L=0.45 * bench.L)


@pytest.mark.parametrize(
    ("slip", "words"),
    [(_swapped, "row [1-5], C[12]: must be what .* by the numbers before it between .* C1 and C2 seem swapped"),
     (_signed, "F_x seems to have the other sign"), (_nanohenries, "row [1-5], C[12]: .* uH: .* nH given as uH"),
     (_of_another, "row [1-5], C[12]: .* shows, between .* a unit is wrong, or the readings are of another sensor")],
)
def test_what_no_sensor_shows_is_refused_before_any_fit(prior: Prior, slip, words: str) -> None:
    """In one line, with the number and its range; the readings as they are pass."""
    bench = bench_of(prior, modulus=1.0, gap=4e-5, d_h=1e-4, alpha=0.02, lead=1e-8)
    refuse_unlikely(prior, bench)
    with pytest.raises(SceneError, match=words) as refused:
        refuse_unlikely(prior, slip(bench))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))])
def test_sensors_as_known_beforehand_are_never_refused(prior: Prior, seed: int) -> None:
    """Two deviations off in all that is unknown, far softer than the table, or with a load that is not known."""
    sign = np.random.default_rng(seed).choice([-2.0, 2.0], len(prior.setup.parameters))
    built = {each.name: (each.value or 0.0) + k * each.deviation
             for each, k in zip(prior.setup.parameters, sign.tolist(), strict=True)}
    built["modulus"] = float(np.exp(built["modulus"] - 1.0))
    bench = bench_of(prior, seed=seed, **built)
    refuse_unlikely(prior, bench)
    refuse_unlikely(prior, replace(bench, forces=np.where(LOADS == 1.2, np.nan, LOADS)))


@pytest.fixture(scope="module")
def coupled(cheap: tuple[Sensor, xr.Dataset]) -> Prior:
    """The same sensor in henry, its coils coupled by a tenth: shorted ones take 1 % of each other."""
    sensor, data = cheap
    found, _ = absolute(sensor, table_impedance(data))
    L, root = found.L.copy(), np.sqrt(np.diagonal(found.L, axis1=-2, axis2=-1))
    L[..., 0, 1] = L[..., 1, 0] = -0.1 * root[..., 0] * root[..., 1]
    dims = (*varied(data), "coil", "coil_2")
    parts = {name: (dims, values) for name, values in (("L", L), ("R", found.R), ("error_L", found.error_L),
                                                       ("error_R", found.error_R))}
    scale = float(found.L0[0, 0] / data["L0"].to_numpy()[0, 0])
    parts |= {name: scale * data[name] for name in ("shared_L", "alone_L")}
    henry = data.assign(**parts, L0=(dims[-2:], found.L0))
    return prior_of(sensor, henry.assign_attrs(unit_L="H", tracks="uneven"), ["modulus=1+-0.1", "lead=0+-5e-9"])


def read(prior: Prior, bench: Measured) -> Adaptation:
    """What readings tell, with idle coils as the prior has them."""
    return as_read(prior.sensor, prior.data, bench.source, lambda idle: adapt(prior.read_by(idle), bench))


@pytest.mark.parametrize("idle", ["open", "shorted"])
def test_idle_coils_the_other_way_are_found(coupled: Prior, idle: str) -> None:
    """A bench of open coils is none of the scene's shorted ones; its own way nothing is said."""
    own, names = coupled.sensor, coupled.forces
    L = force_maps_of(with_idle(own, idle), coupled.data, names).at(LOADS[None])[0][0]
    noise = coupled.noise * np.random.default_rng(2).standard_normal(L.shape)
    bench = Measured(LOADS, L + noise, "bench.csv")
    assert own.readout.idle_coil == "shorted"
    assert read(coupled.read_by(idle), bench).p_value > 0.01
    if idle == "open":
        with pytest.raises(SceneError, match="the readings are rather with idle coils open than shorted: --idle open"):
            read(coupled, bench)


@pytest.mark.parametrize(("idle", "said", "code"), [("open", None, 2), ("shorted", "open", 2), ("open", "open", 0),
                                                    ("shorted", None, 0)])
def test_a_comparison_tests_the_other_convention(
    coupled: Prior, idle: str, said: str | None, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `adapt` does, and with the same words, noise known or not; what is read the right way names it first."""
    save_table(coupled.data, tmp_path / "result.nc")
    save_sensor(coupled.sensor, tmp_path / "scene.toml")
    loads = loads_over(np.array([-0.4, 0.1]), np.array([0.4, 1.8]), 4)
    L = coupled.read_by(idle).table.at(loads[None])[0][0] + 1e-11 * np.random.default_rng(4).standard_normal((16, 2))
    rows = [",".join(f"{number:.12g}" for number in row) for row in np.column_stack([loads, L])]
    (tmp_path / "bench.csv").write_text("\n".join(["F_x [N], F_z [N], L1 [H], L2 [H]", *rows]) + "\n")
    words = ["compare", str(tmp_path), str(tmp_path / "bench.csv"), "--free", "modulus"]
    for more in ([], ["--noise", "10 pH"]):
        assert run([*words, *more, *([] if said is None else ["--idle", said])]) == code
        shown = capsys.readouterr()
        if code:
            assert f"rather with idle coils {idle} than {said or 'shorted'}: --idle {idle}" in shown.err
        else:
            assert f"L at the terminals, idle coils {idle}" in shown.out.splitlines()[1]


def test_a_section_knows_no_idle_coils(prior: Prior) -> None:
    """Its tables are of coils alone: both ways are one, nothing is said, and nothing fitted for it."""
    found, asked = adapt(prior, bench_of(prior)), []
    assert as_read(prior.sensor, prior.data, "bench.csv", lambda idle: asked.append(idle) or found) is found
    assert asked == ["shorted"]
