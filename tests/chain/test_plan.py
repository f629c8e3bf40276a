"""Requests: choices, and that what is left out changes the answer by no more than is promised."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from sits_mech.chain.interpolate import solved_likely
from sits_mech.chain.models import MECHANICS, magnetic_model, mechanical_model, plan
from sits_mech.chain.omissions import Omission, beside_errors, history_share, omissions, skin_depths, strain_bound
from sits_mech.chain.plan import choose_magnetics, choose_mechanics
from sits_mech.chain.prices import REACHED, cost
from sits_mech.chain.propagation import poses_of, read_poses
from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.closed_form import finite_strain_model
from sits_mech.quantities import Bounded, Pose, Wrench
from sits_mech.scene.sensor import SceneError, Sensor, load_sensor

LONG = ("elastomer.length=0.2", "target.length=0.2")
SQUARE = [f"{part}.{side}=0.02" for part in ("target", "elastomer") for side in ("width", "length")]
COAXIAL = (
    'coils=[{name="C", centre=["0 mm", "0 mm"], layers=2, turns=12, inner_diameter="2.2 mm", track_width="0.1 mm", '
    'track_gap="0.1 mm", track_thickness="35 um", layer_pitch="85 um"}]',
    'target={material="copper", shape="disc", diameter="8 mm", thickness="0.2 mm"}',
)
BACKING = (
    'conductors=[{name="backing", material="ferrite", shape="disc", centre=["0 mm", "-1 mm"], diameter="18 mm", '
    'thickness="0.5 mm"}]',
)
SHEET = (BACKING[0].replace('"disc"', '"rectangle"').replace("diameter", 'width="18 mm", length'),)


def test_choices_have_reasons() -> None:
    """What was asked for is taken; auto says why."""
    sensor, long = load_sensor("biorob2018"), load_sensor("biorob2018", LONG)
    assert choose_mechanics(sensor, "linear", ("planar", "linear")).reason == "asked for"
    assert choose_mechanics(sensor, "auto", ("planar", "linear")).name == "planar"
    assert choose_mechanics(sensor, "auto", ("planar", "block")).name == "block"
    assert choose_mechanics(long, "auto", ("planar", "block")).name == "planar"
    loads = [Wrench(0.01, 0.02)]
    assert choose_mechanics(long, "auto", ("planar", "linear", "block"), loads).name == "linear"
    bare = sensor.model_copy(update={"target": None})
    assert "no target" in choose_magnetics(bare, "auto", ("planar",)).reason


def test_free_tracks_are_solved_in_space() -> None:
    """A square loop that crosses y = 0 straight is no endless pair of wires; the section is for who asks for it."""
    z, loop = -17.5e-6, [(3e-3, -3e-3), (3e-3, 3e-3), (-3e-3, 3e-3), (-3e-3, -3e-3), (2.9e-3, -3e-3)]
    points = ", ".join(f"[{x}, {y}, {z}]" for x, y in loop)
    coils = f'coils=[{{name="L1", shape="path", track_width=1e-4, track_thickness=35e-6, path=[[{points}]]}}]'
    sensor, known = load_sensor("biorob2018", [coils]), ("planar", "sheets")
    choice = choose_magnetics(sensor, "auto", known, [Pose(0.0, 2e-3)])
    assert choice.name == "sheets" and "coils.L1: free tracks" in choice.reason
    assert choose_magnetics(sensor, "planar", known).name == "planar"
    steel = 'target={conductivity=7e6, relative_permeability=100, shape="rectangle", width=8e-3, length=8e-3, '
    magnetic = load_sensor("biorob2018", [coils, steel + "thickness=2e-4}"])
    with pytest.raises(SceneError, match=r"target: permeable parts .* got free tracks of coils.L1"):
        choose_magnetics(magnetic, "auto", known)


def test_pillars_are_solved_in_space_alone() -> None:
    """No section, no strip and no small-strain bound stands for them."""
    keys = ['elastomer.shape="pillars"', 'elastomer.pitch="2.5 mm"', 'elastomer.diameter="1.5 mm"', *LONG]
    sensor, known = load_sensor("biorob2018", keys), ("planar", "linear", "block")
    assert choose_mechanics(sensor, "auto", known, [Wrench(1e-6)]).name == "block"
    assert math.isinf(strain_bound(sensor, [Wrench(1e-6)]))
    with pytest.raises(SceneError, match=r"model \(mechanics\) must be block for pillars; got linear"):
        choose_mechanics(sensor, "linear", known)


@pytest.mark.slow
def test_five_scenes_have_five_plans() -> None:
    """No target, one coil under a disc, a symmetric load, ferrite behind the coils, thin and thick skin."""
    sensor = load_sensor("biorob2018")
    requests = [
        (sensor.model_copy(update={"target": None}), []), (load_sensor("biorob2018", COAXIAL), []),
        (sensor, [Wrench(0.0, 2.0)]), (load_sensor("biorob2018", BACKING), []), (sensor, [Wrench(0.5, 2.0)]),
    ]
    plans = [plan(scene, loads) for scene, loads in requests]
    told = [(found.mechanics, found.magnetics, found.left_out) for found in plans]
    assert len({str(item) for item in told}) == 5
    assert [found.magnetics.name for found in plans] == ["planar", "axisymmetric", "sheets", "planar-fem", "sheets"]
    whats = [{item.what for item in found.left_out} for found in plans]
    assert "eddy currents" in whats[0] and "out-of-plane displacement and rotation" in whats[2]
    assert "mesh of the air" not in whats[3]
    assert skin_depths(sensor) > 6.0 > 1.0 > skin_depths(load_sensor("biorob2018", ["frequency=5e3"]))
    assert all(found.seconds > 0.0 and found.error > 0.0 for found in plans)
    strip = next(item for item in omissions(requests[1][0], (), None, "planar-fem") if item.what == "ends along y")
    assert "a disc as a strip of its diameter" in strip.reason and math.isnan(strip.size)  # no pose, no size
    assert {item.what for item in omissions(sensor, (), None, "sheets")} >= {"mechanics", "interior of the target"}


@pytest.mark.slow
def test_a_sheet_of_ferrite_is_magnetised_in_space() -> None:
    """A rectangle that does not conduct; one that does, or a target with free net current, in section."""
    choice = plan(load_sensor("biorob2018", SHEET), [Wrench(0.5, 2.0)]).magnetics
    assert choice.name == "sheets" and "conductors.backing: ferrite that does not conduct" in choice.reason
    free = ['target.net_current="free"', "target.planar_boundary_radius=1"]
    for keys in (['conductors.0.conductivity="1 MS/m"'], free):
        assert plan(load_sensor("biorob2018", [*SHEET, *keys]), []).magnetics.name == "planar-fem"


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [
        pytest.param([], id="8"), pytest.param(["target.width=0.015"], id="15", marks=pytest.mark.slow),
        pytest.param(["elastomer.thickness=0.006"], id="tall", marks=pytest.mark.slow),
        pytest.param(SQUARE, id="square", marks=pytest.mark.slow),
        pytest.param([*SQUARE, "elastomer.thickness=0.001"], id="thin square", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("wrench", [(0.0, 1.0), (1.0, 0.0), (0.5, 1.0)], ids=["press", "shear", "both"])
def test_one_compliance_misses_less_than_its_bound(keys: list[str], wrench: tuple[float, float]) -> None:
    """The nonlinear layer against the linear one, at a load whose bound is 1 %."""
    sensor = load_sensor("biorob2018", [*LONG, *keys])
    part = _along(sensor, Wrench(*wrench), 1e-2)
    load = Wrench(*(part * force for force in wrench))
    finite = finite_strain_model(sensor.elastomer)
    full, small = (mechanical_model(sensor, name, 1e-3)[0].equilibrium(load) for name in (finite, "linear"))
    rest = sensor.elastomer.thickness if sensor.elastomer else 0.0
    reach = 0.5 * sensor.target.extent[0] if sensor.target else 0.0

    def moved(pose: Pose) -> np.ndarray:
        return np.array([pose.d_h, rest - pose.d_v, reach * pose.alpha])

    size = np.abs(moved(full.pose)).max()
    missed = float(np.abs(moved(full.pose) - moved(small.pose)).max() / size)
    assert missed < 1e-2 + full.report.estimated_error
    assert missed > 5e-6  # the promise is about something


@pytest.mark.parametrize("bound", [0.1, pytest.param(0.3, marks=pytest.mark.slow)])
def test_a_thin_pad_of_a_stiffening_law_is_within_the_bound(bound: float) -> None:
    """Pressed, its silicone shears by ten times what it sinks: one compliance is up to 1.7 times 3 sink/t off."""
    thin = ["elastomer.width=0.02", "target.width=0.02", "elastomer.thickness=0.001"]
    sensor = load_sensor("biorob2018", [*LONG, *thin, 'elastomer.material="dragon-skin-10"'])
    load, t = Wrench(0.0, _along(sensor, Wrench(0.0, 1.0), bound)), 1e-3
    full, formula = (mechanical_model(sensor, name, 1e-2)[0].equilibrium(load) for name in ("planar", "closed-form"))
    linear = mechanical_model(sensor, "linear", 1e-2)[0].equilibrium(load)
    sink = t - full.pose.d_v
    assert 3.0 * sink / t < abs(t - linear.pose.d_v - sink) / sink + 0.02 < bound
    assert abs(full.pose.d_v - formula.pose.d_v) < formula.error.d_v


def _along(sensor: Sensor, load: Wrench, bound: float) -> float:
    """Return the multiple of a load at which small strain's bound is reached."""
    return brentq(lambda m: strain_bound(sensor, [Wrench(*(m * load.components))]) - bound, 0.0, 1e4)


@pytest.mark.parametrize("size", [(20, 20, 2), (8, 8, 4), (20, 8, 2), (8, 40, 2), (20, 0, 2)], ids=str)
def test_strains_of_pads_are_those_of_the_model_in_space(size: tuple[int, int, int]) -> None:
    """Pressed, tilted about either axis, sheared: squares, rectangles, a disc; at a bound of 1e-4 all is linear."""
    width, length, thickness = size
    sides = [f'{part}.{side}="{value} mm"' for part in ("target", "elastomer")
             for side, value in (("width", width), ("length", length))]
    disc = [f'target={{material="copper", shape="disc", diameter="{width} mm", thickness="0.2 mm"}}',
            f'elastomer={{diameter="{width} mm", thickness="{thickness} mm", material="ecoflex-00-30"}}']
    sensor = load_sensor("biorob2018", [*sides, f'elastomer.thickness="{thickness} mm"'] if length else disc)
    layer, t = block_pad(sensor, 0.1), 1e-3 * thickness
    w, b = (sensor.target.extent if sensor.target else (0.0, 0.0))
    rest = layer.equilibrium(Wrench()).pose

    def over_bound(component: str, strain: Callable[[Pose], float]) -> float:
        load = Wrench(**{component: _along(sensor, Wrench(**{component: 1.0}), 1e-4)})
        return strain(layer.equilibrium(load).pose) / 1e-4

    assert over_bound("F_z", lambda pose: 3.0 * (rest.d_v - pose.d_v) / t) == pytest.approx(1.0, abs=0.08)
    tilts = [over_bound("M", lambda pose: 0.25 * pose.alpha * w / t),
             over_bound("M_x", lambda pose: 0.25 * pose.alpha_x * b / t)]
    assert 0.45 < min(tilts) and 0.84 < max(tilts) < 1.0
    assert 1.0 < over_bound("F_x", lambda pose: (0.5 * pose.d_h + 0.25 * pose.alpha * w) / t) < 1.25


def test_skin_depths_of_a_permeable_target() -> None:
    """delta = 1/sqrt(pi f mu sigma): four times the permeability, twice the depths."""
    sizes = 'shape="rectangle", width=8e-3, length=8e-3, thickness=2e-4'
    plate = f"target={{conductivity=7e6, relative_permeability=%g, {sizes}}}"
    one, four = (skin_depths(load_sensor("biorob2018", [plate % each, "frequency=1e6"])) for each in (1.0, 4.0))
    assert one == pytest.approx(2e-4 * math.sqrt(math.pi * 1e6 * 4e-7 * math.pi * 7e6), rel=1e-6)
    assert four == pytest.approx(2.0 * one)


def test_what_is_left_out_says_its_size_where_it_has_one() -> None:
    """In one line: nothing of none, that it is not known, at most so much, of the change or of L0."""
    sizes = (0.0, math.nan, 0.023)
    assert [Omission("x", "why", size).text for size in sizes] == [
        "x: why", "x: why (not estimated)", "x: why (at most 0.02)",
    ]
    assert Omission("x", "why", 0.023, of_change=False).text == "x: why (at most 0.02 of L0)"
    (ends,) = (item for item in omissions(load_sensor("biorob2018"), (), None, "planar") if item.what == "ends along y")
    assert not ends.in_error and ends.text.endswith("(not estimated)")


def test_slender_layers_have_no_small_strain() -> None:
    """They buckle at strains of any smallness, along x or y."""
    for keys in (["elastomer.length=0.0015"], ['elastomer.thickness="10 mm"']):
        assert math.isinf(strain_bound(load_sensor("biorob2018", keys), [Wrench(0.0, 0.01)]))
    assert math.isinf(strain_bound(load_sensor("biorob2018", ['elastomer.thickness="10 mm"']), [Wrench(0.0, 0.01)]))


@pytest.mark.slow
def test_a_long_pad_under_a_short_target_is_told_with_its_price() -> None:
    """Plane strain spreads the force over a length twenty times the target's, as whoever makes a pad long asks for."""
    short = load_sensor("biorob2018", LONG[:1])
    assert [plan(short, [Wrench(0.5, 1.0)]).mechanics.name] == ["planar"]  # type: ignore[union-attr]
    forced = omissions(short, [Wrench(0.5, 1.0)], "planar", None)
    size = next(item.size for item in forced if item.what.startswith("ends of pad"))
    assert size > 20.0 and beside_errors(forced) == (size, ())


@pytest.mark.parametrize(
    ("prony", "mullins", "share"),
    [
        ("[]", None, 0.0), ('[{weight=0.2, time="1 s"}, {weight=0.1, time="9 s"}]', None, 0.3),
        ("[]", "r=2.0", 0.7281), ("[]", "r=2.0, beta=2.0", 0.3518), ("[]", 'r=2.0, beta=0.0, m="1 kPa"', 1.0),
    ],
)
def test_what_rate_and_history_are_worth(prony: str, mullins: str | None, share: float) -> None:
    """A sudden load meets 1/(1 - sum w) times the stiffness; softening leaves 1 - erf(1/beta)/r of it: erf(1) = 0.8427,
    by default, erf(0.5) = 0.5205.
    """
    softening = "" if mullins is None else f", mullins={{{mullins}}}"
    law = f'law="neo-hookean", shear_modulus="30 kPa", bulk_modulus="30 MPa", prony={prony}{softening}'
    sensor = load_sensor("biorob2018", [f"elastomer.material={{{law}}}"])
    assert sensor.elastomer is not None
    assert history_share(sensor.elastomer.silicone) == pytest.approx(share, rel=1e-4)
    found = [item for item in omissions(sensor, [Wrench(F_z=1.0)], "block", None) if item.what.startswith("rate")]
    assert [item.size for item in found] == ([pytest.approx(share, rel=1e-4)] if share else [])
    assert not any(item.counts for item in found)  # another request's: no error of a slow first load


def test_a_symmetric_load_needs_no_places_beside() -> None:
    """The same answer with and without them, from fewer poses."""
    sensor = load_sensor("biorob2018", LONG)
    poses = poses_of([mechanical_model(sensor, "linear", 3e-2)[0].equilibrium(Wrench(0.0, 1.0))])
    few, more = (
        read_poses(sensor, magnetic_model(sensor, "planar", 1e-2)[0], Bounded.of(poses.value, np.array([error])))
        for error in ([0.0, 1e-6, 0.0, 0.0, 0.0, 0.0], [1e-11, 1e-6, 1e-11, 0.0, 0.0, 0.0])
    )
    assert len(few.alone) == 1 and len(more.alone) == 3
    assert few.signals.L_v_percent == pytest.approx(more.signals.L_v_percent, rel=1e-12)
    assert few.signals.error_L_v_percent == pytest.approx(more.signals.error_L_v_percent, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("depths", [3.0, pytest.param(4.5, marks=pytest.mark.slow)])
def test_the_inside_of_a_thick_target_is_worth_what_passes_through(depths: float) -> None:
    """Surface impedance in finite elements against the bars that divide the whole thickness."""
    sensor = load_sensor("biorob2018")
    target = sensor.target
    assert target is not None
    frequency = sensor.frequency * (depths / skin_depths(sensor)) ** 2
    full, skins = (
        magnetic_model(sensor, name, 1e-3)[0].impedance(Pose(0.0, 2e-3), frequency) for name in ("planar", "planar-fem")
    )
    missed = abs((full.L - skins.L)[0, 0] / (full.L - full.L0)[0, 0])
    assert missed < math.exp(-depths) + 2e-3


def test_images_of_loads_are_left_out() -> None:
    """Only in scenes that are their own mirror image; the plan says how many stand for all."""
    sensor, loads = load_sensor("biorob2018"), [Wrench(-1.0, 1.0), Wrench(1.0, 1.0)]
    both = [omissions(scene, loads, "block", None) for scene in (sensor, _lopsided(sensor))]
    assert [any(item.what == "mirrored loads" for item in found) for found in both] == [True, False]
    assert any("1 of 2 loads" in item.reason for item in both[0])
    assert not any(item.what == "mirrored loads" for item in omissions(sensor, loads[1:], "block", None))


@pytest.mark.slow
def test_components_beside_the_plane_count_in_a_plan() -> None:
    """They break the symmetry of a normal load, mirror with their own signs, and strain the pad like those in it."""
    sensor = load_sensor("biorob2018")
    symmetric = {item.what for item in omissions(sensor, [Wrench(F_z=1.0)], "block", None)}
    beside = {item.what for item in omissions(sensor, [Wrench(F_z=1.0, F_y=0.2)], "block", None)}
    assert "out-of-plane displacement and rotation" in symmetric - beside
    square = load_sensor("biorob2018", ['elastomer.length="8 mm"'])
    one, other = ([Wrench(F_y=0.3, M_x=-1e-3)], [Wrench(0.3, M=1e-3)])
    assert strain_bound(square, one) == pytest.approx(strain_bound(square, other))
    assert "a large load for this pad" in plan(sensor, [Wrench(F_y=30.0)]).notes[0]


@pytest.mark.slow
def test_a_plan_promises_no_more_than_there_is() -> None:
    """Not below the finest rungs; loads beyond what pads have held, and slips of unit, are named."""
    sensor = load_sensor("biorob2018")
    fine = plan(sensor, [Wrench(0.1, 0.5)], tolerance=1e-9)
    assert fine.error >= REACHED["mechanics", "block"] + REACHED["magnetics", "sheets"]
    assert len(fine.notes) == 1 and "the tolerance 1e-09 cannot be reached at this load" in fine.notes[0]
    assert "a large load for this pad" in plan(sensor, [Wrench(0.0, 400.0)]).notes[0]
    material = 'elastomer.material={law="neo-hookean", shear_modulus="30 GPa", bulk_modulus="30 TPa"}'
    glassy = load_sensor("biorob2018", [material])
    assert "unit" in plan(glassy, [Wrench(0.1, 0.5)]).notes[0]


def test_a_grid_is_planned_by_what_is_solved_of_it() -> None:
    """Of 9 x 9 loads some 19, of which mirror images leave 12; a small grid, or loads on no grid, are solved whole."""
    sensor, forces = load_sensor("biorob2018"), np.linspace(-1.0, 1.0, 9).tolist()
    loads = [Wrench(x, z + 1.0) for x in forces for z in forces]
    whole, some = plan(sensor, loads), plan(sensor, [load for load in loads if load.F_x in forces[::4]])
    assert len(solved_likely(loads)) == 19 and len(solved_likely(loads[1:])) == 80
    between = next(item for item in whole.left_out if item.what == "loads between solved ones")
    assert "19 of 81" in between.reason and between.size == 1e-2
    assert "loads between solved ones" not in {item.what for item in some.left_out}
    expected = cost("mechanics", "block", 1e-2, 12) + cost("magnetics", "sheets", 1e-2, 81)
    assert whole.seconds == pytest.approx(expected, rel=1e-12)
    smaller = cost("mechanics", "block", 1e-2, 18) + cost("magnetics", "sheets", 1e-2, 27)
    assert some.seconds == pytest.approx(smaller, rel=1e-12)


def _lopsided(sensor: Sensor) -> Sensor:
    """Return a scene whose target is no mirror image of itself."""
    points = "points=[[-4e-3, -4e-3], [5e-3, 0], [-4e-3, 4e-3]]"
    return load_sensor("biorob2018", [f'target={{material="copper", shape="outline", {points}, thickness=2e-4}}'])


@pytest.mark.slow
def test_a_pose_among_conductors_costs_more() -> None:
    """Those that matter; a far one costs nothing."""
    nut = 'conductors=[{name="nut", material="copper", shape="rectangle", centre=["0 mm", "-3 mm"], width="2 mm", '
    near = load_sensor("biorob2018", [nut + 'length="2 mm", thickness="0.5 mm"}]'])
    far = near.model_copy(update={"conductors": (near.conductors[0].model_copy(update={"centre": (0.3, 0.0, 0.0)}),)})
    bare, some, more = (plan(sensor, [Wrench(0.3, 1.0)]) for sensor in (load_sensor("biorob2018"), far, near))
    assert bare.seconds == some.seconds < more.seconds - 0.5


def test_a_layer_with_friction_is_left_to_models_at_finite_strain() -> None:
    """However small the load: others know nothing of faces that touch."""
    load, names = [Wrench(F_z=1e-3)], tuple(MECHANICS)
    smooth, rough = load_sensor("biorob2018-w15"), load_sensor("biorob2018-w15", ["elastomer.friction=0.5"])
    assert choose_mechanics(smooth, "auto", names, load).name == "linear"
    assert choose_mechanics(rough, "auto", names, load).name == "block"
    for name in ("linear", "closed-form"):
        with pytest.raises(SceneError, match=f"must be auto, block or planar with elastomer.friction; got {name}"):
            choose_mechanics(rough, name, names, load)


FREE = 'target.net_current="free"', 'target.planar_boundary_radius="0.1 m"'
KNOWN = "planar", "planar-fem", "axisymmetric", "sheets"
PRESSED, SHEARED, MIDDLE, BESIDE = Wrench(F_z=1.0), Wrench(F_x=0.1), Pose(0.0, 2e-3), Pose(1e-4, 2e-3)


@pytest.mark.parametrize(("keys", "given", "loaded", "name"), [
    (COAXIAL, [PRESSED], True, "axisymmetric"), (COAXIAL, [], True, "sheets"), (COAXIAL, [], False, "axisymmetric"),
    (COAXIAL, [PRESSED, SHEARED], True, "sheets"), (COAXIAL, [MIDDLE, BESIDE], False, "sheets"),
    (COAXIAL, [MIDDLE], False, "axisymmetric"), (COAXIAL[1:], [MIDDLE], False, "sheets"),
    ((*COAXIAL, 'coils.C.centre=["0.1 mm", "0 mm"]'), [PRESSED], True, "sheets"),
    ((*COAXIAL, 'substrate_radius="20 mm"'), [MIDDLE], False, "planar-fem"),
    ((), [PRESSED], True, "sheets"), ((), [PRESSED], False, "planar"), (LONG, [PRESSED], True, "planar"),
    (('target.length="79 mm"',), [PRESSED], True, "sheets"), (('target.length="80 mm"',), [PRESSED], True, "planar"),
    (FREE, [PRESSED], True, "planar"),
])
def test_the_cheapest_model_that_holds_a_scene(
    keys: tuple[str, ...], given: list[Wrench] | list[Pose], loaded: bool, name: str
) -> None:
    """On an axis only where nothing leaves it, in section where it stands for the plate; by no one's wish."""
    found = choose_magnetics(load_sensor("biorob2018", keys), "auto", KNOWN, given, loaded)
    assert found.name == name and not found.by_name


def test_models_asked_for_are_taken_where_they_hold_what_leaves_the_plane() -> None:
    sensor, beside = load_sensor("biorob2018"), [Wrench(F_y=0.1)]
    for asked in ("planar", "sheets"):
        found = choose_magnetics(sensor, asked, KNOWN)
        assert found.name == asked and found.by_name
    assert choose_magnetics(sensor, "sheets", KNOWN, beside).by_name
    assert choose_magnetics(sensor, "auto", KNOWN, beside).name == "sheets"
    with pytest.raises(SceneError, match=r"model \(magnetics\) must be auto or sheets for F_y; got planar"):
        choose_magnetics(sensor, "planar", KNOWN, beside)
    assert choose_mechanics(sensor, "linear", ("planar", "linear")).by_name
    assert not choose_mechanics(sensor, "auto", ("planar", "linear")).by_name


def test_metal_beside_a_target_with_free_current_is_solved_in_section() -> None:
    """Which no model in space has; with none it is solved in space."""
    copper = BACKING[0].replace("ferrite", "copper")
    free, zero = (load_sensor("biorob2018", [copper, *keys]) for keys in (FREE, ()))
    assert [choose_magnetics(each, "auto", KNOWN).name for each in (free, zero)] == ["planar-fem", "sheets"]


def test_what_hinders_permeable_parts_in_section_is_named() -> None:
    outline = "shape=\"outline\", points=[[-4e-3, -4e-3], [4e-3, -4e-3], [0.0, 4e-3]], thickness=2e-4"
    steel = load_sensor("biorob2018", [f"target={{conductivity=7e6, relative_permeability=100, {outline}}}"])
    with pytest.raises(SceneError, match=r"target: permeable parts .*; got an outline for a target$"):
        choose_magnetics(steel, "auto", KNOWN)
    with pytest.raises(SceneError, match=r"got F_y not zero and an outline for a target$"):
        choose_magnetics(steel, "auto", KNOWN, [Wrench(F_y=0.1)])
    square = load_sensor("biorob2018", ["target.relative_permeability=100", "target.conductivity=7e6"])
    assert choose_magnetics(square, "auto", KNOWN).name == "planar-fem"


def test_an_outline_on_a_pad_is_pressed_in_the_plane_or_refused_there() -> None:
    """Its layer is that of a plane section by default, whatever its length."""
    shape = "target={shape=\"outline\", points=[[-4e-3, -4e-3], [4e-3, -4e-3], [0.0, 4e-3]], thickness=2e-4, %s}"
    outline = load_sensor("biorob2018", [shape % 'material="copper"'])
    assert choose_mechanics(outline, "auto", ("planar", "block")).name == "planar"
    assert choose_mechanics(load_sensor("biorob2018"), "auto", ("planar", "block")).name == "block"


def test_the_inside_of_plates_three_skin_depths_thick_is_left_out() -> None:
    """By models that take their surface, in the errors of one; others resolve it, and thin ones have no inside."""
    thick, thin = (load_sensor("biorob2018", [f"target.thickness={size}"]) for size in (1e-4, 8e-5))
    assert 3.0 < skin_depths(thick) < 4.0 and 2.0 < skin_depths(thin) < 3.0
    for scene, model, in_error in (
        (thick, "sheets", True), (thick, "planar-fem", False), (thick, "planar", None), (thin, "sheets", None),
    ):
        found = [item for item in omissions(scene, (), None, model) if item.what == "interior of the target"]
        assert [item.in_error for item in found] == ([] if in_error is None else [in_error])
        assert all(item.size == pytest.approx(math.exp(-skin_depths(scene))) for item in found)


def test_rings_stand_for_spirals_on_an_axis_alone() -> None:
    """Without an answer the size is not known; coils that are rings have no pitch."""
    spiral = load_sensor("biorob2018", [COAXIAL[0].replace("}]", ', winding="spiral"}]'), COAXIAL[1]])
    for scene, model, told in (
        (spiral, "axisymmetric", True), (spiral, "sheets", False),
        (load_sensor("biorob2018", COAXIAL), "axisymmetric", False),
    ):
        found = [item for item in omissions(scene, (), None, model) if item.what == "pitch of the spiral windings"]
        assert len(found) == told and all(math.isnan(item.size) for item in found)


def test_what_errors_do_not_hold_is_summed_for_a_half_or_both() -> None:
    items = [
        Omission("a", "", 0.1, half="mechanics"), Omission("b", "", 0.2), Omission("c", "", 0.4, in_error=True),
        Omission("d", "", math.nan), Omission("e", "", 0.8, asked=False), Omission("f", "", 1.6, of_change=False),
    ]
    assert beside_errors(items) == (pytest.approx(0.3), ("d",))
    assert beside_errors(items, "mechanics") == (0.1, ()) and beside_errors(items, "magnetics") == (0.2, ("d",))


def test_a_load_beside_others_that_shear_spares_no_place() -> None:
    """Symmetry holds a target in its place where no load of all moves it."""
    for loads, spared in (([PRESSED], True), ([PRESSED, SHEARED], False), ([SHEARED], False), ([], False)):
        found = omissions(load_sensor("biorob2018"), loads, "block", None)
        assert any(item.what.startswith("out-of-plane") for item in found) == spared
