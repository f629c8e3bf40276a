"""What is known of a built sensor beforehand: by the silicone's sources, by the scene's sizes, by what a user says."""

import numpy as np
import pytest

from sits_mech.analysis.bench.unknowns import priors, usual_unknowns
from sits_mech.scene.sensor import SceneError, load_sensor


def test_the_modulus_is_as_uncertain_as_its_sources() -> None:
    """Whose largest is 2.32 times the least; without a source 0.3; the user's word counts."""
    sensor = load_sensor("biorob2018")
    assert priors(sensor, ["modulus"])[0].deviation == pytest.approx(np.log(2.32) / 1.693)
    own = 'elastomer.material={law="neo-hookean", shear_modulus="20 kPa", bulk_modulus="20 MPa"}'
    assert priors(load_sensor("biorob2018", [own]), ["modulus"])[0].deviation == 0.3
    gap, thickness = priors(sensor, ["gap=10+-20 um", "thickness"])
    assert (gap.value, gap.deviation) == pytest.approx((1e-5, 2e-5)) and thickness.deviation == pytest.approx(5e-5)


def test_what_a_model_does_not_hold_is_not_unknown() -> None:
    """Poses out of a plane, or beside an axis; a load cell turns only forces that are read."""
    sensor = load_sensor("biorob2018")
    assert {"d_y", "alpha_x"} <= {*usual_unknowns(sensor, ("block", "sheets"), ("F_x", "F_z"))}
    assert not {"d_y", "alpha_x", "frame_x"} & {*usual_unknowns(sensor, ("planar", "planar"), ("F_x", "F_z"))}
    assert not {"d_h", "alpha", "frame"} & {*usual_unknowns(sensor, ("block", "axisymmetric"), ("F_z",))}
    assert not {"thickness", "stiffening"} & {*usual_unknowns(sensor, ("closed-form", "sheets"), ("F_z",))}
    with pytest.raises(SceneError, match="fit: must be modulus, .* got \"colour\""):
        priors(sensor, ["colour"])


def test_a_turn_about_the_normal_is_known_as_well_as_others() -> None:
    """It is not unknown by default, but may be asked for."""
    sensor = load_sensor("biorob2018")
    assert "alpha_z" not in usual_unknowns(sensor, ("block", "sheets"), ("F_x", "F_z"))
    assert priors(sensor, ["alpha_z"])[0].deviation == priors(sensor, ["alpha"])[0].deviation


def test_a_scene_states_its_tolerances() -> None:
    """Before the usual ones; zero is known, and what a user says counts more; bounds with one line."""
    scene = load_sensor("biorob2018", ['tolerances={modulus="5 %", gap="20 um", thickness=0.0, alpha="0.5 deg"}'])
    names = usual_unknowns(scene, ("block", "sheets"), ("F_x", "F_z"))
    assert "thickness" not in names and {"modulus", "gap", "stiffening"} <= {*names}
    found = {each.name: each for each in priors(scene, ["modulus", "gap=0+-0.1 mm", "alpha", "cell"])}
    assert (found["modulus"].value, found["modulus"].deviation) == (1.0, pytest.approx(0.05))
    assert found["gap"].deviation == pytest.approx(1e-4) and found["cell"].deviation == 0.01
    assert found["alpha"].deviation == pytest.approx(np.radians(0.5))
    for text, why in (("gap=-1e-6", "tolerances.gap: must be zero or a length"), ("colour=1", "tolerances.colour")):
        with pytest.raises(SceneError, match=why):
            load_sensor("biorob2018", [f"tolerances={{{text}}}"])
