"""From wrench to pose in three dimensions: a box or a cylinder of silicone under a plate, at finite strain (`block`).

The pad is bonded to the rigid ground over its whole lower face and carries an exactly rigid target, a rectangle or a
disc, bonded centred on its upper face. A wrench (F_x, F_z, M) leaves the plane y = 0 a plane of symmetry: half the pad
is meshed, the target moves by (d_h, d_z) and turns by alpha about y. Half a pad cannot fall sideways, so that its
stability against that is checked by itself. F_y, M_x or M_z take the whole pad, the same cells and their mirror image.
Equations: element/kernel.py (pad), element/target.py (rigid target), equilibrium/ (solution). Pose:
``d_v = standoff + t - sink``.

Meshes: one nested sequence, a base whose cells are divided, with further layers at the bonded edges (pad/shapes.py).
If the load is not reached on them, they are tried again with a guard that keeps J positive (levels/settle.py).

Error. The pose is extrapolated from the levels, as many as the tolerance asks for and memory allows, with the error of
their limit (levels/family.py). `report.estimated_error` is the largest over the target's displacement, an angle counted
at the target's end. Deformation and `min_J` are those of the second level. A mesh of the user's own is the first level
of a family whose cells are each divided into eight, or, where that is too many, is solved again with constant pressures
(pad/user.py).

Contact of the free faces with ground, target (scene key `elastomer.contact`, faces/contact.py) and each other
(faces/folds.py) is "never" solved, "always", or, "auto", where a free face folds onto one of them. With friction on
ground and target the answer is that of a path of loads, straight from rest by default (levels/load_path.py).

Range: boxes, cylinders, pillars and meshes of the user's under rectangles and discs, every law. Neglected: gravity,
friction of faces on each other.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from sits_mech.cases import Progress, no_progress
from sits_mech.mechanics.equilibrium.body import Bonded, pack_state
from sits_mech.mechanics.equilibrium.control import Control, Controlled, under
from sits_mech.mechanics.foil.bent import Bending
from sits_mech.mechanics.histories import LoadHistory, Motion
from sits_mech.mechanics.levels.answer import starts
from sits_mech.mechanics.levels.beyond import overload_refusal
from sits_mech.mechanics.levels.family import Line
from sits_mech.mechanics.levels.gradient import PoseSlopes, equilibrium_slopes, solved_family
from sits_mech.mechanics.levels.in_time import motion_in_time
from sits_mech.mechanics.levels.load_path import depends_on_path
from sits_mech.mechanics.levels.settle import last_equilibrium, path_failure
from sits_mech.mechanics.pad.families import meshes_in_line
from sits_mech.mechanics.pad.solid import ignored_edge, mirrored, pad_parts, pad_scales
from sits_mech.mechanics.pad.user import mesh_notes
from sits_mech.quantities import Array, Equilibrium, Wrench
from sits_mech.scene.parameters import Parameter
from sits_mech.scene.sensor import Sensor
from sits_mech.threads import one_thread, single_thread
from sits_mech.units import checked_tolerance

_ROUGH = 1.0  # tolerance of the rough model: so large that it never notes a missed one


@dataclass(frozen=True)
class BlockPad(Controlled):
    """The pad at finite strain; made by `block_pad`."""

    sensor: Sensor
    tolerance: float  # asked error of the pose over the displacement; an answer that misses it says so
    unrestricted: BlockPad | None = None  # of a restricted model the one with all meshes
    deepest: int = 99  # most levels
    goal: Array | None = field(default=None, compare=False)  # (s, 6), derivatives of what is asked by the pose
    bends: Bending | None = field(default=None, compare=False)

    @cached_property
    def half(self) -> Line:
        """Meshes of half the pad in the order they are tried; of the whole one where the user's mesh is."""
        if self.unrestricted is not None:
            return self._like(self.unrestricted.half)
        return meshes_in_line(self.sensor, self.tolerance, whole=False)

    @cached_property
    def whole(self) -> Line:
        """Meshes of the whole pad."""
        if self.unrestricted is not None:
            return self._like(self.unrestricted.whole)
        return meshes_in_line(self.sensor, self.tolerance, whole=True)

    def _like(self, line: Line) -> Line:
        """Return a line of meshes with this model's tolerance and goal."""
        return replace(line, deepest=self.deepest, asked=self.tolerance, goal=self.goal)

    @cached_property
    def rough(self) -> BlockPad:
        """The same model restricted to the first two levels."""
        return replace(self, tolerance=_ROUGH, unrestricted=self, deepest=2)

    def towards(self, goal: Array | None, tolerance: float, deepest: int = 99) -> BlockPad:
        """Return the model on the same meshes, refined to a goal; see `RefinedModel`."""
        return replace(self, unrestricted=self, goal=goal, tolerance=tolerance, deepest=deepest)

    def bending(self, bends: Bending) -> BlockPad:
        """Return the model of a target that bends."""
        return replace(self, unrestricted=self, bends=bends)

    def controlled(
        self, control: Control, *, start: Equilibrium | None = None, via: Sequence[Control] = ()
    ) -> Equilibrium:
        """Return the equilibrium with forces or places given, reached from `start` or rest, via `via`.

        Its `wrench` holds the forces, given or found; raises as `equilibrium`. An out-of-plane load starts from that of
        its in-plane components, which half the pad reaches first.
        """
        began, controls = time.process_time(), (*via, control)
        out_of_plane = any(each.out_of_plane for each in controls)
        with single_thread():
            line = self.whole if out_of_plane else self.half
            if out_of_plane and not depends_on_path(self.sensor) and not self._is_whole(start):
                solved = last_equilibrium(self.half, start, [control.in_plane])
                if solved.part == 1.0:
                    solved = last_equilibrium(line, of_both_halves(self, solved.found), controls)
            else:
                solved = last_equilibrium(line, start, controls)
        notes = (*solved.found.report.notes, *ignored_edge(self.sensor), *mesh_notes(self.sensor))
        report = replace(solved.found.report, model="block", seconds=time.process_time() - began, notes=notes)
        solved = solved._replace(found=replace(solved.found, report=report))
        if solved.part < 1.0:
            raise path_failure(control, solved, "pad")
        found = solved.found if self.bends is None else self.bends.bent(line, control, solved.found)
        return found if self.goal is not None else replace(found, report=found.report.judged(self.tolerance))

    @one_thread
    def check_load(self, wrench: Wrench) -> None:
        """Raise SolveFailed for a load in the plane, without friction, that the first level refuses as far beyond."""
        if (beyond := overload_refusal(self.half, None, under(wrench))) is not None:
            raise path_failure(under(wrench), beyond, "pad")

    @one_thread
    def in_time(self, history: LoadHistory, progress: Progress = no_progress) -> Motion:
        """Return the target's motion under a history of loads; see `TimedModel`."""
        began, whole = time.process_time(), bool(history.farthest.out_of_plane)
        found = motion_in_time(self.whole if whole else self.half, history, progress)
        notes = (*found.report.notes, *ignored_edge(self.sensor), *mesh_notes(self.sensor))
        report = replace(found.report, model="block", seconds=time.process_time() - began, notes=notes)
        return replace(found, report=report)

    @one_thread
    def slopes(self, found: Equilibrium, parameters: Sequence[Parameter], *, sideways: bool = False) -> PoseSlopes:
        """Return the derivatives of a pose by its load and by scene parameters; raises as `equilibrium_slopes`.

        `sideways` adds those by F_y, M_x and M_z of half a pad.
        """
        number, size = int(found.state[0]), found.state.size - 1
        line = self.half if self.half[number].size == size else self.whole
        scales = partial(pad_scales, share=line.scales.share)
        return equilibrium_slopes(solved_family(line, found, scales, sideways), found, parameters)

    def _is_whole(self, start: Equilibrium | None) -> bool:
        """Whether a start is a state of the whole pad."""
        if start is None or not start.state.size:
            return False
        return self.whole[int(start.state[0])].size == start.state.size - 1


@one_thread
def block_pad(sensor: Sensor, tolerance: float = 2e-2) -> BlockPad:
    """Return the finite-strain model of a box or cylinder under a rectangle or disc; levels are added to `tolerance`.

    Raise ValueError for a scene without target or elastomer, another target, or a tolerance outside (0, 1).
    """
    pad_parts(sensor)
    pad = BlockPad(sensor, checked_tolerance(tolerance))
    levels = pad.half[0]
    levels.check_memory(0)
    _ = levels.coarse  # refuses a pad that has no mesh
    return pad


def solved_body(model: BlockPad, equilibrium: Equilibrium) -> Bonded:
    """Return the finer meshed pad that an equilibrium of the model was solved on."""
    number, size = int(equilibrium.state[0]), equilibrium.state.size - 1
    pair = model.half[number]
    return (pair if pair.size == size else model.whole[number]).fine


def of_both_halves(pad: BlockPad, found: Equilibrium) -> Equilibrium:
    """Return an equilibrium of half a pad as one of the whole."""
    number = int(found.state[0])
    half, whole = pad.half[number], pad.whole[number]
    if half.size == whole.size:  # on a whole mesh of the user's
        return found
    states = starts(half, pad.half.scales, found.wrench, found.state)
    bodies = ((half.fine, whole.fine), (half.coarse, whole.coarse))
    both = [pack_state(mirrored(*pair, state)) for pair, state in zip(bodies, states, strict=True)]
    return replace(found, state=np.concatenate([[number], *both]))
