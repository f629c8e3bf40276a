"""Cells at rims by themselves: at rest where the layer is, carried to another boundary, eliminated from steps."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sits_mech.mechanics.element.kernel import deformed, element_forces, element_stiffness
from sits_mech.mechanics.equilibrium.body import rest
from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.elimination import eliminated, relaxed
from sits_mech.mechanics.equilibrium.linearisation import factored, residuals_of, way_of
from sits_mech.mechanics.equilibrium.newton import SETTLED, newton
from sits_mech.mechanics.equilibrium.outcome import Path, aim_of
from sits_mech.mechanics.equilibrium.path import advance
from sits_mech.mechanics.levels.answer import scaled_control
from sits_mech.mechanics.levels.refine import nearly_at_rest
from sits_mech.mechanics.pad.families import meshes_in_line
from sits_mech.scene.sensor import load_sensor

HELD = np.zeros(3, dtype=bool)


@cache
def line():
    """The meshes of a pad, K/mu = 1000, no contact."""
    return meshes_in_line(load_sensor("biorob2018", ['elastomer.contact="never"']), 1e-2, whole=False)


def load_of(F_x, F_z):
    return scaled_control(line()[0].fine, line().scales, Control(F_x=F_x, F_z=F_z))[1]


@cache
def rested(level, F_x, F_z):
    """A level at rest under a load [N]."""
    body, load = line()[0].maker(level), load_of(F_x, F_z)
    found = advance(body, rest(body), Path((0.0 * load, load)))
    assert found.reached == 1.0
    return found.state


def inner_forces(body, u):
    mesh = body.patch.mesh
    return float(np.linalg.norm(element_forces(mesh, body.laws, u).forces[body.patch.inner]))


def test_a_patch_returns_to_the_rest_that_it_was_moved_from():
    """The boundary stays, the inside is displaced by a percent of the cells."""
    body, state = line()[0].fine, rested(1, 0.2, 0.8)
    u = state.u.copy()
    u[body.patch.inner] += 2e-3 * np.random.default_rng(0).normal(size=len(body.patch.inner))
    found = relaxed(body, body.patch, (u, state.p[body.patch.cells]), u, (1.0, 1e-10))
    assert found.part == 1.0
    np.testing.assert_allclose(found.u, state.u, atol=1e-8)
    np.testing.assert_allclose(found.p, state.p[body.patch.cells], atol=1e-5 * np.abs(state.p).max())


def test_a_patch_goes_with_its_boundary_from_the_undeformed_state():
    """To the boundary of a layer at rest: inside at rest, too, and stable."""
    body, state = line()[0].fine, rested(1, 0.5, 2.0)
    patch, begun = body.patch, rest(body)
    found = relaxed(body, patch, (begun.u, begun.p[patch.cells]), state.u, (0.05, 1e-9))
    assert found.part == 1.0 and inner_forces(body, found.u) <= 1e-9
    boundary = np.setdiff1d(patch.mesh.dofs, patch.inner)
    np.testing.assert_allclose(found.u[boundary], state.u[boundary], atol=1e-12)
    assert deformed(patch.mesh, found.u).J.min() > 0.1
    assert patch.pattern.factored((element_stiffness(patch.mesh, body.laws, found.u, found.p),)).negative == 0


def test_a_patch_that_cannot_follow_says_how_far_it_went():
    """A boundary that goes through itself: the target is pushed through the ground."""
    body = line()[0].fine
    patch, begun, u = body.patch, rest(body), rest(body).u
    u = u.copy()
    u[body.bonded] = body.with_target(np.array([0.0, -1.2, 0.0]))
    assert relaxed(body, patch, (begun.u, begun.p[patch.cells]), u, (0.05, 1e-9)).part < 1.0


def steps(body, load, most):
    """Newton's method from rest with the patch eliminated: residuals outside of it, and the last state."""
    here, left = replace(rest(body), load=load), []
    for _ in range(most):
        found = residuals_of(body, here)
        left.append(float(np.hypot(np.linalg.norm(found.free), np.linalg.norm(found.target)) / np.linalg.norm(load)))
        if left[-1] <= SETTLED:
            break
        factor = factored(body, here, found)
        way = way_of(body, here, found, factor, aim_of(here, load, HELD, None))
        here = eliminated(body, here, found, factor, way)[0]
    return left, here


@pytest.mark.parametrize("load", [(0.8, 1.6), pytest.param((1.0, 2.0), marks=pytest.mark.slow)])
def test_newton_goes_on_where_it_wandered(load):
    """From rest in one step of the load, at half a thickness of shear; by itself it is lost."""
    body = line()[0].fine
    assert newton(body, rest(body), load_of(*load)).state.residual > SETTLED
    left, there = steps(body, load_of(*load), 16)
    assert left[-1] <= SETTLED and there.min_J > 0.2


@pytest.mark.parametrize("load", [(0.2, 0.8), pytest.param((0.4, 1.6), marks=pytest.mark.slow)])
def test_a_level_that_is_cut_at_rims_takes_two_steps_from_the_level_before(load):
    """Where it took four and more from rest; the target is where it rests to a tenth of the change of levels."""
    levels, states = line()[0], [rested(level, *load) for level in (0, 1)]
    body, enough = levels.maker(2), 0.05 * line()[0].fine.length(states[1].q - states[0].q)
    asked = levels, 2, states[1], (HELD, load_of(*load)), enough
    found = nearly_at_rest(*asked)
    assert found.state.iterations == 2 and body.length(found.off) <= enough
    true = newton(body, found.state, load_of(*load)).state
    assert true.residual <= SETTLED
    assert body.length(found.state.q - true.q) < 0.1 * body.length(true.q - states[1].q)
    assert nearly_at_rest(*asked) is nearly_at_rest(*asked)  # found once
    again = nearly_at_rest(levels, 2, None, *asked[3:])
    assert again.state.iterations >= 4
