"""What a history takes, before it is solved."""

import numpy as np
import pytest

from sits_mech.analysis.histories.price import history_price, peak_load
from sits_mech.analysis.histories.response import in_time
from sits_mech.chain.plans.plan import planned_seconds
from sits_mech.cli.main import run
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.scene.sensor import load_sensor

TIMES = np.linspace(0.0, 1.0, 201)
PULSE = LoadHistory(TIMES, np.outer(np.sin(np.pi * TIMES), [0, 1, 0, 0, 0, 0]))


@pytest.mark.slow
def test_a_history_is_priced_by_the_times_that_are_solved() -> None:
    """Of a smooth pulse of 201 rows far fewer, no more than the history then takes, and more for a finer tolerance."""
    sensor, models = load_sensor("biorob2018"), {"mechanics": "linear", "magnetics": "planar"}
    assert np.isclose(peak_load(sensor, PULSE).F_z, 1.0)
    seconds, _ = planned_seconds(sensor, [peak_load(sensor, PULSE)], tolerance=0.1, **models)
    price = history_price(sensor, PULSE, tolerance=0.1, **models)
    data = in_time(sensor, PULSE, tolerance=0.1, **models)
    solved = data.sizes["time"] - int(np.sum(data["flags"].str.contains("interpolated")))
    assert price.rows == 201
    assert price.solved < 100
    assert price.solved <= solved
    assert price.seconds >= price.solved * dict(seconds)["linear"]
    assert history_price(sensor, PULSE, tolerance=1e-3, **models).solved > price.solved


@pytest.mark.slow
def test_a_history_is_explained_without_a_load(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    """In place of one, and with its rows."""
    path = tmp_path / "press.csv"
    path.write_text("t [s],F_z [N]\n0,0\n1,1\n2,0\n")
    words = ["explain", "biorob2018", "--history", str(path), "--mechanics", "linear", "--magnetics", "planar"]
    assert run([*words, "--fz", "1 N"]) == 2
    assert "--history: must be given without a load or --ladder" in capsys.readouterr().err
    assert run([*words, "--json"]) == 0
    assert '"rows": 3' in capsys.readouterr().out
