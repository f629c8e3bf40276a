"""Scene and table of the sensor that was found: they read its forces, and say how well."""

import numpy as np
import pytest

from sits_mech.analysis.bench import sensor_calibration, terminals
from sits_mech.analysis.built.adaptation import adapt
from sits_mech.analysis.built.corrected import corrected
from sits_mech.analysis.built.prior import Prior
from sits_mech.notes import NoteKind, unpacked
from sits_mech.scene.sensor import scene_text

from .conftest import OTHERWISE, bench_of, unknowns


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
