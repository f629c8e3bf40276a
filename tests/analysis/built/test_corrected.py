"""Scene and table of the sensor that was found: they read its forces, and say how well."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.corrected import corrected
from sits_mech.analysis.built.prior import HALF, Prior, prior_of
from sits_mech.analysis.readings.bench import sensor_calibration, table_inductances, terminals
from sits_mech.chain.calibrate import calibrate
from sits_mech.chain.omitted import mechanical
from sits_mech.notes import NoteKind, Omission, OmissionKind, Relative, unpacked, unpacked_omissions
from sits_mech.quantities import Array
from sits_mech.scene.sensor import load_sensor, scene_text
from tests.analysis.conftest import OTHERWISE, bench_of, unknowns


@pytest.mark.slow
def test_the_corrected_table_reads_the_built_sensor(prior: Prior) -> None:
    """Its forces within their errors, from what the terminals show; loads are those of the table times the modulus."""
    found = adapt(prior, bench_of(prior))
    sensor, table = corrected(found)
    assert table.attrs["scene"] == scene_text(sensor)
    s = found.values[0]
    assert table["F_z"].to_numpy() == pytest.approx(s * prior.data["F_z"].to_numpy())
    known, loads = sensor_calibration(sensor, table), np.array([[0.1, 0.8], [-0.2, 1.1]])
    true = unknowns(prior, **{name: value for name, value in OTHERWISE.items() if name != "cell"})
    shown = prior.bench(loads).model(true[None])[0]
    scale = prior.sensor.readout.parallel_capacitance / sensor.readout.parallel_capacitance
    own = terminals(sensor, table)[0]["L"].to_numpy().reshape(-1, 2)[0]
    own = own - known.forward(F_x=float(table["F_x"][0]), F_z=0.0)
    read = known.inverse(shown * scale - own)
    assert np.all(read.status == "ok")
    assert np.all(np.abs(read.forces - loads) <= read.error_by_model + read.error + 0.02)
    assert np.all(np.abs(read.forces - loads) < [0.02, 0.06])


def test_the_corrected_table_is_known_as_the_posterior_has_it(
    numerics_alone: Callable[[], AbstractContextManager[None]]
) -> None:
    """What mechanics leave out, an unknown of the fit, is not added again; what gap and leads do alike cancels."""
    sensor, axes = load_sensor("biorob2018-w15"), {"F_x": [-0.5, 0.0, 0.5], "F_z": [0.0, 1.0, 2.0]}
    bent = Omission(OmissionKind.BENDING, 0.03, Relative.DISPLACEMENT, parts=(0.0, 0.03, 0.0, 0.0, 0.0, 0.0))
    with numerics_alone(), pytest.MonkeyPatch.context() as patch:  # in this order they are taken back
        patch.setattr(mechanical, "bending", lambda *_: (bent,))
        prior = prior_of(sensor, calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02))
        found = adapt(prior, bench_of(prior))
        built, table = corrected(found)
    assert [item.included for item in unpacked_omissions(table.attrs["left_out"]) if item.weighs] == [True]
    loads = found.values[0] * np.array(list(product(*axes.values())))
    by = prior.bench(loads).derivatives(prior.used(found.values))[0] * prior.in_use
    posterior = np.sqrt(np.einsum("mnp,pq,mnq->mn", by, found.covariance, by))
    parts = table_inductances(built, table)["shared_L"].transpose("part", "F_x", "F_z", "coil").to_numpy()
    np.testing.assert_allclose(0.5 * np.sqrt(np.sum(parts**2, axis=0)).reshape(-1, 2), posterior, rtol=0.01)


@pytest.mark.slow
def test_the_corrected_table_is_moved_by_each_factor_as_the_fit_is() -> None:
    """Of the errors of poses, and of the inductances by the magnetic model: by a deviation each, at every load."""
    sensor, axes = load_sensor("biorob2018-w15"), {"F_x": [-0.5, 0.0, 0.5], "F_z": [0.0, 1.0, 2.0]}
    prior = prior_of(sensor, calibrate(sensor, **axes, mechanics="linear", magnetics="planar", tolerance=0.02))
    found = adapt(prior, bench_of(prior))
    loads = found.values[0] * np.array(list(product(*axes.values())))
    assert np.abs(prior.table.parts_at(loads[None])[1]).max() > 1e-9  # what a section leaves out

    def shown(values: Array) -> tuple[Array, Array]:
        """Return what the corrected table has at its terminals, and what the fit shows, (m, n) [H]."""
        built, table = corrected(replace(found, values=values))
        own = terminals(built, table)[0]["L"].to_numpy().reshape(-1, 2)
        return own, prior.bench(loads).model(prior.used(values)[None])[0]

    before = shown(found.values)
    for k in range(prior.table.shared):
        values = found.values.copy()
        values[len(prior.setup.parameters) + k] += HALF
        by_table, by_fit = (now - own for now, own in zip(shown(values), before, strict=True))
        assert np.abs(by_fit).max() > 1e-12
        assert by_table == pytest.approx(by_fit, abs=0.02 * np.abs(by_fit).max())


def test_the_scene_holds_what_it_has_keys_for(prior: Prior) -> None:
    """Modulus, thickness, film, leads and capacitance; the target's place stands in the notes of the table."""
    found = adapt(prior, bench_of(prior))
    sensor, table = corrected(found)
    names = list(found.names)
    old, new = prior.sensor.elastomer, sensor.elastomer
    assert new.silicone.shear_modulus == pytest.approx(found.values[0] * old.silicone.shear_modulus)
    assert new.thickness == pytest.approx(old.thickness + found.values[names.index("thickness")])
    assert sensor.readout.lead_inductance == pytest.approx(found.values[names.index("lead")])
    adapted_to, placed = unpacked(table.attrs["notes"])[-2:]
    assert adapted_to.kind is NoteKind.ADAPTED and adapted_to.known["source"] == "bench.csv"
    assert placed.kind is NoteKind.PLACED and placed.known["d_h"] == found.values[names.index("d_h")]
