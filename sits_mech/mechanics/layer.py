"""From wrench to pose: the silicone layer in plane strain or about an axis, at finite strain.

`planar` takes plane strain (small strain is linear.py), `axisymmetric` a cylinder under a coaxial disc that F_z alone
presses, whose half meridian is meshed as a section is.

The layer of width W and thickness t, bonded to the rigid ground over its whole width, carries an exactly rigid target
bonded over the middle of its top face; the wrench is a dead load in newtons, in the plane spread over the elastomer's
length in y.
Equations: element/kernel.py (layer), element/target.py (rigid target), faces/contact.py (free faces); solution:
equilibrium/. Pose: ``d_v = standoff + t - sink``. Any mix of forces and places of the target can be given
(equilibrium/control.py).

Meshes. One family (pad/planar.py), and a tougher, less accurate one for loads that it does not carry; J is positive at
every quadrature point and node. Pose and error are extrapolated from the levels of a family (levels/family.py).

Contact of the free faces with the ground and the target (scene key `elastomer.contact`) is "never" solved, "always",
or, "auto", where a free face touches one of them (levels/settle.py). The notes say which. With friction on them
(`elastomer.friction`) the answer is that of a path of loads, straight from rest where no other is given
(levels/load_path.py).

Range: plane strain (the true pad is softer by its ends), or about an axis, where no end is missing. Neglected: gravity.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sits_mech.cases import Progress, no_progress
from sits_mech.mechanics.closed_form import coaxial_refusal
from sits_mech.mechanics.element.kernel import deformation, most_stretched
from sits_mech.mechanics.element.mesh import DeformedSection
from sits_mech.mechanics.equilibrium.control import Control, Controlled, under
from sits_mech.mechanics.foil.bent import Bending
from sits_mech.mechanics.histories import LoadHistory, Motion
from sits_mech.mechanics.levels.family import Line
from sits_mech.mechanics.levels.gradient import PoseSlopes, equilibrium_slopes, solved_family
from sits_mech.mechanics.levels.in_time import motion_in_time
from sits_mech.mechanics.levels.settle import last_equilibrium, path_failure
from sits_mech.mechanics.pad.planar import Edges, edge_effect, edge_notes, section_families
from sits_mech.mechanics.pad.section import layer_parts, layer_scales
from sits_mech.quantities import Array, Equilibrium, Pose, refuse_out_of_plane
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.threads import one_thread, single_thread


@dataclass(frozen=True)
class PlanarLayer(Controlled):
    """The layer at finite strain; made by `planar_layer` and `axisymmetric_pad`."""

    sensor: Sensor
    tolerance: float  # asked error of the pose over the displacement
    line: Line  # meshes in the order they are tried
    edges: Edges | None = None  # effect of `elastomer.edge_radius`; None for sharp edges
    axial: bool = False  # about an axis, else in plane strain
    bends: Bending | None = None

    @property
    def name(self) -> str:
        """Name of the model."""
        return "axisymmetric" if self.axial else "planar"

    @property
    def rough(self) -> PlanarLayer:
        """The same model restricted to the first two levels."""
        return replace(self, tolerance=1.0, line=replace(self.line, deepest=2))

    def towards(self, goal: Array | None, tolerance: float, deepest: int = 99) -> PlanarLayer:
        """Return the model refined to a goal: in the plane all meshes cost little."""
        return replace(self, tolerance=tolerance, line=replace(self.line, asked=tolerance, goal=goal))

    def bending(self, bends: Bending) -> PlanarLayer:
        """Return the model of a target that bends, about an axis."""
        return replace(self, bends=bends)

    def controlled(
        self, control: Control, *, start: Equilibrium | None = None, via: Sequence[Control] = ()
    ) -> Equilibrium:
        """Return the equilibrium with forces or places given, reached from `start` or rest, via `via`.

        Its `wrench` holds the forces, given or found, and `report.estimated_error` covers those found; raises as
        `equilibrium`.
        """
        began, controls = time.process_time(), (*via, control)
        for each in controls:
            self._check(each)
        with single_thread():
            solved = last_equilibrium(self.line, start, controls)
            found, notes = solved.found, solved.found.report.notes
            if self.axial:
                found = replace(found, error=Pose(0.0, found.error.d_v, 0.0))
            if self.edges is not None and solved.part == 1.0:
                notes += edge_notes(self.edges, self.line.scales.load(found.wrench)[:3], self.line.scales.thickness)
            report = replace(found.report, model=self.name, seconds=time.process_time() - began, notes=notes)
            solved = solved._replace(found=replace(found, report=report))
            if solved.part < 1.0:
                raise path_failure(control, solved, "layer")
            found = solved.found if self.bends is None else self.bends.bent(self.line, control, solved.found)
            judged = self.line.goal is None
            return replace(found, report=found.report.judged(self.tolerance)) if judged else found

    @one_thread
    def in_time(self, history: LoadHistory, progress: Progress = no_progress) -> Motion:
        """Return the target's motion under a history of loads; see `TimedModel`."""
        self._check(under(history.farthest))
        began = time.process_time()
        found = motion_in_time(self.line, history, progress)
        report = replace(found.report, model=self.name, seconds=time.process_time() - began)
        return replace(found, report=report)

    @one_thread
    def slopes(self, found: Equilibrium, parameters: Sequence[Parameter], *, sideways: bool = False) -> PoseSlopes:
        """Return the derivatives of a pose by its load and by scene parameters; raises as `equilibrium_slopes`.

        Out-of-plane derivatives are unknown, whatever `sideways` says.
        """
        scales = partial(layer_scales, axial=self.axial)
        return equilibrium_slopes(solved_family(self.line, found, scales), found, parameters)

    def _check(self, control: Control) -> None:
        """Refuse what leaves the plane, or the axis."""
        if not self.axial:
            refuse_out_of_plane(self.name, control)
        elif others := [name for name, value in control.given.items() if value and name not in ("F_z", "sink")]:
            names = ", ".join(others)
            raise ValueError(f"wrench: {names} must be zero for the model {self.name}, which takes F_z alone")


@one_thread
def planar_layer(sensor: Sensor, tolerance: float = 1e-2) -> PlanarLayer:
    """Return the finite-strain model of a sensor's layer; `tolerance`: error of the pose over the displacement.

    Raise ValueError for a scene without target or elastomer, or a tolerance outside (0, 1).
    """
    return PlanarLayer(sensor, tolerance, section_families(sensor, tolerance), edge_effect(sensor))


@one_thread
def axisymmetric_pad(sensor: Sensor, tolerance: float = 1e-2) -> PlanarLayer:
    """Return the finite-strain model of a cylinder under a coaxial disc, for F_z alone; `tolerance` as of the layer's.

    Raise ValueError for another scene, or a tolerance outside (0, 1).
    """
    if refusal := coaxial_refusal(sensor):
        raise SceneError(f"{sensor.name}: {refusal}")
    line = section_families(sensor, tolerance, axial=True)
    return PlanarLayer(sensor, tolerance, line, edge_effect(sensor, axial=True), axial=True)


def deformed_mesh(model: PlanarLayer, equilibrium: Equilibrium) -> DeformedSection:
    """Return the deformed layer for pictures: nodes, and corners of the cells counter-clockwise."""
    _, elastomer = layer_parts(model.sensor)
    fine = model.line[int(equilibrium.state[0])].fine
    mesh, u = fine.mesh, equilibrium.state[1 : 1 + fine.mesh.nodes.size]
    points, rest = (
        each * elastomer.thickness + (0.0, elastomer.standoff) for each in (mesh.nodes + u.reshape(-1, 2), mesh.nodes)
    )
    corners = mesh.nodes[mesh.cells[:, :4]]
    turn = np.argsort(np.arctan2(*(corners - corners.mean(axis=1, keepdims=True)).T[::-1]).T, axis=1)
    quads = np.take_along_axis(mesh.cells[:, :4], turn, axis=1)
    every = [deformation(mesh, u, at)[1] for at in (mesh.inside, mesh.nodal) if at is not None]
    J = np.concatenate(every, axis=1).min(axis=1)
    found = DeformedSection(points, quads, J, most_stretched(mesh, u).max(axis=1), rest)
    return found.mirrored if model.axial else found
