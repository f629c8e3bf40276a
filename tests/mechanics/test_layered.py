"""Poses of pads of layers: series and thin limits, layers of one silicone, an independent code."""

import numpy as np
import pytest

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.closed_form import free_rise, pad_moduli, thin_share
from sits_mech.mechanics.histories import LoadHistory
from sits_mech.mechanics.layer import axisymmetric_pad, planar_layer
from sits_mech.mechanics.linear import linear_layer, linear_pad
from sits_mech.mechanics.models import strain_bound
from sits_mech.notes import NoteKind
from sits_mech.quantities import Wrench
from sits_mech.scene.parameters import parameter
from sits_mech.scene.sensor import SceneError, load_sensor, scene_table, sensor_from, silicone_of
from sits_mech.scene.thermal import at_temperature

SOFT, STIFF = 20e3, 80e3  # shear moduli [Pa]


def neo_hooke(mu, bulk=1e8):
    return f'{{law="neo-hookean", shear_modulus={mu}, bulk_modulus={bulk * mu}}}'


def sensor(layers, pad='width="12 mm", length="10 mm"', target='width="8 mm", length="6 mm"', more=""):
    """A target on a pad of layers, each a silicone and a thickness [mm]."""
    tables = ", ".join(f'{{material={made}, thickness="{t} mm"}}' for made, t in layers)
    shape = 'shape="disc"' if "diameter" in target else 'shape="rectangle"'
    return load_sensor("biorob2018", [
        f'elastomer={{{pad}, contact="never", layers=[{tables}]{more}}}',
        f'target={{material="copper", {shape}, {target}, thickness="0.2 mm", load_height="0.2 mm"}}',
    ])


def flush(layers, width):
    """A flush strip, a metre long."""
    return sensor(layers, *[f'width="{width} mm", length="1 m"'] * 2)


LAYERS = [(neo_hooke(STIFF), 0.5), (neo_hooke(SOFT), 0.7), (neo_hooke(3 * SOFT), 0.3)]
MU, T = np.array([STIFF, SOFT, 3 * SOFT]), 1e-3 * np.array([0.5, 0.7, 0.3])


def test_wide_layers_are_sheared_in_series():
    """Edges shorten both strips alike: what 15 mm more are worth is w L/sum(t_i/mu_i), exactly but for exp(-w/t)."""
    wide, narrow = (linear_layer(flush(LAYERS, width), 1e-4).stiffness[0] for width in (30.0, 15.0))
    assert wide[0, 0] - narrow[0, 0] == pytest.approx(15e-3 / float(np.sum(T / MU)), rel=1e-3)


def test_wide_layers_are_pressed_out_as_a_film_of_several_viscosities():
    """k = L (w + c)**3/(12 D), with D by its double integral: the flow between plates (closed_form.py).

    Edges add c to each width, and columns terms of (t/w)**2 to either; three widths tell both from what is asked.
    """
    z, dz = np.linspace(0.0, T.sum(), 15_001, retstep=True)
    soft = 1.0 / MU[np.minimum(np.searchsorted(np.cumsum(T), 0.5 * (z[1:] + z[:-1])), 2)]
    middle = 0.5 * (z[1:] + z[:-1])
    u = np.concatenate([[0.0], np.cumsum((middle - (middle * soft).sum() / soft.sum()) * soft) * dz])  # mu u' = z - z_0
    D = -float(np.sum(0.5 * (u[1:] + u[:-1])) * dz)
    widths = np.array([20.0, 30.0, 45.0])
    k = [linear_layer(flush(LAYERS, width), 1e-4).stiffness[0][1, 1] for width in widths]
    x = 1e-3 * widths
    slope = np.linalg.solve(np.stack([x, np.ones(3), 1.0 / x], axis=1), np.cbrt(k))[0]
    assert slope**3 == pytest.approx(1.0 / (12.0 * D), rel=1e-3)
    pad = flush(LAYERS, 30.0).elastomer
    assert thin_share(pad) * pad.shear_modulus == pytest.approx(T.sum() ** 3 / (12.0 * D), rel=1e-6)


def test_the_closed_moduli_are_those_of_the_model_in_space():
    """Square pads, S = 4: within the 8 % of one silicone (closed_form.py)."""
    scene = sensor(LAYERS, *['width="12 mm", length="12 mm"'] * 2)
    area, E_c, _ = pad_moduli(scene.target, scene.elastomer)
    found = block_pad(scene, 1e-2).equilibrium(Wrench(F_z=1e-3))
    assert E_c == pytest.approx(1e-3 * T.sum() / area / (T.sum() - found.pose.d_v), rel=0.08)


ONE = [(neo_hooke(SOFT, 100.0), 2.0)]
SPLIT = [(neo_hooke(SOFT, 100.0), 1.0)] * 2
UNEVEN = [(neo_hooke(SOFT, 100.0), 0.7), (neo_hooke(SOFT, 100.0), 1.3)]
DISC = ('diameter="10 mm"', 'diameter="8 mm"')
LOAD = Wrench(F_x=0.2, F_z=0.8, M=1e-3)


def test_one_layer_is_the_pad_without_layers_digit_by_digit():
    one = sensor(ONE)
    table = scene_table(one)
    (layer,) = table["elastomer"].pop("layers")
    plain = sensor_from(table | {"elastomer": table["elastomer"] | layer})
    assert not plain.elastomer.layers and one.elastomer.layers
    poses = [block_pad(pad, 0.1).equilibrium(Wrench(F_x=0.05, F_z=0.2)).pose for pad in (one, plain)]
    assert poses[0] == poses[1]


def test_layers_of_one_silicone_on_the_same_lines_are_one_to_rounding():
    """Near the sides a pad has a line at half its height anyway."""
    near = 'width="9 mm", length="7 mm"'
    one, two = (block_pad(sensor(layers, near), 0.1).equilibrium(Wrench(F_x=0.05, F_z=0.2)) for layers in (ONE, SPLIT))
    assert two.pose.components == pytest.approx(one.pose.components, rel=1e-9, abs=1e-14)
    assert two.error.components == pytest.approx(one.error.components, rel=1e-6, abs=1e-14)


@pytest.mark.parametrize(("make", "shape", "load"), [
    pytest.param(block_pad, (), LOAD, marks=pytest.mark.slow), (block_pad, DISC, LOAD),
    (axisymmetric_pad, DISC, Wrench(F_z=0.8)),
    (planar_layer, ('width="12 mm", length="1 m"', 'width="8 mm", length="1 m"'), Wrench(F_x=30.0, F_z=120.0)),
])
def test_layers_of_one_silicone_are_one_within_the_stated_errors(make, shape, load):
    one, two = (make(sensor(layers, *shape), 1e-2).equilibrium(load) for layers in (ONE, UNEVEN))
    away = np.abs(one.pose.components - two.pose.components)
    assert np.all(away <= one.error.components + two.error.components + 1e-12)
    assert np.max(away[:2]) < 0.01 * max(one.pose.d_h, 2e-3 - one.pose.d_v)


# NGSolve 6.2, Q5 to Q7 with pressures in Q3 to Q5 on meshes graded geometrically to edges and interface: a neo-Hooke
# layer of 1 mm, mu 80 kPa, K 4 MPa, under a Mooney-Rivlin one of 1.5 mm, c10 7 kPa, c01 3 kPa, K 1 MPa; target 8 mm on
# a pad of 12 mm, the load 0.2 mm above its lower face. Orders and meshes differ by less than 5e-4 of each.
PAIR = [
    ('{law="neo-hookean", shear_modulus=80e3, bulk_modulus=4e6}', 1.0),
    ('{law="mooney-rivlin", c10=7e3, c01=3e3, bulk_modulus=1e6}', 1.5),
]
STRIP = [  # N/m, N/m, N; d_h, sink [mm], alpha [rad]
    ((0.0, 300.0, 0.0), (0.0, 0.15350, 0.0)), ((60.0, 100.0, 0.0), (0.50752, 0.053912, -0.002618)),
    ((40.0, 250.0, 0.15), (0.33090, 0.13017, 0.02454)),
]
PRESSED = [(0.4, 0.05595), (1.0, 0.13196), (-0.8, -0.12964)]  # N, mm


@pytest.mark.parametrize(("load", "expected"), STRIP)
def test_a_strip_of_two_laws_is_within_a_percent_of_another_code(load, expected):
    pad = sensor(PAIR, 'width="12 mm", length="1 m"', 'width="8 mm", length="1 m"')
    found = planar_layer(pad, 1e-2).equilibrium(Wrench(F_x=load[0], F_z=load[1], M=load[2]))
    d_h, d_v, alpha = 1e3 * found.pose.d_h, 1e3 * found.pose.d_v, found.pose.alpha
    moved, known = np.array([d_h, 2.5 - d_v, 4.0 * alpha]), np.array(expected) * (1.0, 1.0, 4.0)
    assert np.max(np.abs(moved - known)) < 0.01 * np.max(np.abs(known))
    assert found.report.estimated_error < 0.01


@pytest.mark.parametrize("make", [axisymmetric_pad, pytest.param(block_pad, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("force", "expected"), PRESSED)
def test_a_disc_on_two_laws_is_within_a_percent_of_another_code(make, force, expected):
    found = make(sensor(PAIR, 'diameter="12 mm"', 'diameter="8 mm"'), 1e-2).equilibrium(Wrench(F_z=force))
    sink = 2.5 - 1e3 * found.pose.d_v
    assert sink == pytest.approx(expected, rel=0.01)
    assert abs(sink - expected) <= 1e3 * found.error.d_v + 5e-4 * abs(expected)


@pytest.mark.parametrize("number", [0, 1])
def test_each_layer_remembers_by_itself(number):
    """One silicone relaxes, the other does not: what is added under a held load is of the one, less than of both."""
    relaxing = '{law="neo-hookean", shear_modulus=20e3, bulk_modulus=1e6, prony=[{weight=0.3, time="0.1 s"}]}'
    plain, times = neo_hooke(SOFT, 50.0), np.array([0.0, 0.0, 10.0])
    history = LoadHistory(times, np.array([[0, 0, 0, 0, 0, 0], *[[30.0, 100.0, 0, 0, 0, 0]] * 2], dtype=float))
    strip = ('width="12 mm", length="1 m"', 'width="8 mm", length="1 m"')
    pads = [[(relaxing, 1.0)] * 2, [(relaxing, 1.0), (plain, 1.0)][:: 1 - 2 * number], [(plain, 1.0)] * 2]
    moved = []
    for layers in pads:
        motion = planar_layer(sensor(layers, *strip), 0.05).in_time(history)
        d_h = motion.pose.d_h[motion.given]
        moved.append(float(d_h[-1] - d_h[-2]))
    assert moved[2] == pytest.approx(0.0, abs=1e-3 * moved[0])
    assert 0.2 * moved[0] < moved[1] < 0.8 * moved[0]


@pytest.mark.slow
def test_layers_of_one_relaxing_silicone_relax_as_one():
    relaxing = '{law="neo-hookean", shear_modulus=20e3, bulk_modulus=1e6, prony=[{weight=0.3, time="0.1 s"}]}'
    history = LoadHistory(np.array([0.0, 0.0, 0.2]), np.array([[0.0] * 6, *[[0.02, 0.1, 0, 0, 0, 0]] * 2]))
    near = 'width="9 mm", length="7 mm"'
    each = ([(relaxing, 2.0)], [(relaxing, 1.0)] * 2)
    one, two = (block_pad(sensor(layers, near), 0.3).in_time(history).pose.components for layers in each)
    assert two == pytest.approx(one, rel=1e-7, abs=1e-12)


def test_layers_that_do_not_relax_alike_are_no_whole():
    relaxing = '{law="neo-hookean", shear_modulus=20e3, bulk_modulus=1e6, prony=[{weight=0.3, time="0.1 s"}]}'
    with pytest.raises(SceneError, match="elastomer.layers: must relax alike and have no mullins"):
        silicone_of(sensor([(relaxing, 1.0), (neo_hooke(SOFT), 1.0)]))
    assert silicone_of(sensor([(relaxing, 1.0)] * 2)).prony == ((0.3, 0.1),)


def test_warm_layers_lift_the_target_each_by_its_own_growth():
    """Linear: the rise with both is that with each alone; and it is the closed form's to a fifth."""
    known = 'expansion=3e-4, temperature_range=["250 K", "400 K"]'
    still = 'expansion=17e-6, temperature_range=["250 K", "400 K"]'  # as copper
    soft, firm = (
        [f'{{law="neo-hookean", shear_modulus={mu}, bulk_modulus={100 * mu}, {words}}}' for words in (known, still)]
        for mu in (20e3, 80e3)
    )
    rises = []
    for below, above in ((0, 0), (0, 1), (1, 0)):
        warm = at_temperature(sensor([(firm[below], 1.0), (soft[above], 1.0)]), 313.15)
        found = linear_pad(warm, 0.5).equilibrium(Wrench())
        rises.append(found.pose.d_v - warm.elastomer.thickness)
        assert free_rise(warm) == pytest.approx(rises[-1], rel=0.25)
    assert rises[1] + rises[2] == pytest.approx(rises[0], rel=1e-2)


@pytest.mark.slow
def test_derivatives_by_numbers_of_a_layer_are_those_of_solves():
    pad, load = sensor(PAIR), Wrench(F_x=0.1, F_z=0.2)
    model = block_pad(pad, 0.1)
    names = ("elastomer.layers.0.thickness", "elastomer.layers.1.material.c10", "elastomer.thickness", "modulus")
    each = [parameter(pad, name) for name in names]
    found = model.slopes(model.equilibrium(load), each)
    for column, one in enumerate(each):
        step = 1e-3 * one.value
        up, down = (block_pad(one.changed(way * step), 0.1).equilibrium(load).pose.components for way in (1, -1))
        assert found.pose[:3, column] == pytest.approx((up - down)[:3] / (2.0 * step), rel=1e-4, abs=1e-10)


def test_notes_name_the_layer_that_is_stretched_beyond_its_data():
    ranged = [f'{{law="neo-hookean", shear_modulus={mu}, bulk_modulus={50 * mu}, fitted_range=[0.0, {end}]}}'
              for mu, end in ((80e3, 0.5), (20e3, 0.1))]
    pad = sensor([(ranged[0], 1.0), (ranged[1], 1.0)])
    found = block_pad(pad, 0.1).equilibrium(Wrench(F_x=0.15)).report
    ends = [note.known["stretch"] for note in found.notes if note.kind is NoteKind.DATA_END]
    assert ends == [pytest.approx(1.1)] and found.stretch > 1.1


@pytest.mark.parametrize("moduli", [(20e3, 200e3), pytest.param((200e3, 20e3), marks=pytest.mark.slow)])
def test_what_small_strain_leaves_out_of_layers_is_within_its_bound(moduli):
    pad = sensor([(neo_hooke(mu, 100.0), 1.0) for mu in moduli], *['diameter="8 mm"'] * 2)
    for load in (Wrench(F_z=0.3), Wrench(F_x=0.1), Wrench(F_x=0.05, F_z=0.15, M=2e-4)):
        small, finite = (make(pad, 0.1).equilibrium(load) for make in (linear_pad, block_pad))
        rest, lever = np.array([0.0, 2e-3, 0.0]), np.array([1.0, 1.0, 4e-3])
        moved = (finite.pose.components[:3] - rest) * lever
        away = np.abs((small.pose.components - finite.pose.components)[:3] * lever)
        assert np.max(away) < strain_bound(pad, [load]) * np.max(np.abs(moved))
