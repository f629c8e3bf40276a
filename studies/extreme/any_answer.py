"""Does anything that the loader accepts get a consistent answer, or a refusal by its name? Random scenes, asked apart.

Each scene of any_scene.py is asked in a process of its own with a limit of processor time, steps of 3 s each
(SITS_MECH_SECONDS), and of 4 GiB. It holds if it

    is refused by name    SceneError, SolveFailed, Collision, or one line that begins with what it is about, in 10 s
    or is answered        numbers and errors finite, J > 0; L and R symmetric, R and L without negative eigenvalues,
                          Delta L without positive ones where nothing is permeable; the load's work not negative;
                          and within both stated errors of the same model asked a fifth of the tolerance,

the last where the first answer was quick. A warning, any other exception, and a process that is stopped fail.
"""

from __future__ import annotations

import re
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from common.children import asked_apart
from extreme.any_scene import Case, random_case
from extreme.rows import DONE, Row

from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.chain.omitted.mechanical import mechanical_omissions
from sits_mech.chain.rests import at_rest
from sits_mech.chain.simulate import simulate
from sits_mech.geometry.collision import Collision
from sits_mech.memory import SECONDS
from sits_mech.quantities import Array, Equilibrium, Impedance, Pose, SolveFailed
from sits_mech.rotations import rotation_matrix
from sits_mech.scene.sensor import SceneError, Sensor

REFUSAL = 10.0
"""Seconds of processor time that a refusal may take."""
ANSWER, STEP, MEMORY = 10.0, 3.0, 4.0  # seconds for an answer, and for a step of it, GiB
QUICK = 0.5  # seconds up to which a second answer is asked
FINER = 0.2  # of the tolerance
ROUNDING = 1e-9
COUNT, FEW = 500, (0, 4, 7, 26, 54, 270, 490)  # the few of coarse runs: two are refused, four judged by a finer answer
_NAMED = re.compile(r"[\w.\-' ]+: ")
Found = tuple[Equilibrium | None, Impedance | None]


def any_scenes(coarse: bool) -> Iterator[Row]:
    """Yield the rows of random scenes."""
    for number in FEW if coarse else range(COUNT):
        yield any_row(random_case(number))


def any_row(case: Case) -> Row:
    """Return the row of a random scene, asked in a process of its own."""

    def in_steps() -> Row:
        """Ask it, refusing steps that take long."""
        SECONDS.set(STEP)
        return asked(case)

    ended = asked_apart(in_steps, seconds=ANSWER, gib=MEMORY)
    row = ended.value if isinstance(ended.value, Row) else Row("", "", ended.killed or "no answer")
    if row.status not in (DONE, *FAILURES) and ended.seconds > REFUSAL and not ended.killed:
        row = replace(row, status="refused late", remark=f"{ended.seconds:.1f} s: {row.remark}")
    return replace(row, physics="any scene", case=case.words, seconds=ended.seconds)


FAILURES = ("exception", "inconsistent")


def asked(case: Case) -> Row:
    """Return the row of a scene: how its question ended, and how far its answer is from a finer one."""
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = solved(case, case.tolerance)
        except Exception as error:  # told of by its kind
            return refusal(error)
        wrong = [*rest_wrong(case.sensor, found[0]), *field_wrong(case.sensor, found[1])]
        report = next(each.report for each in found if each is not None)
        least = np.nan if report.min_J is None else report.min_J
        row = Row("", "", DONE, least, 0.0, 1.0, report.estimated_error, remark=f"by {report.model}")
        if wrong:
            return replace(row, status="inconsistent", remark="; ".join(wrong))
        if time.process_time() - began > QUICK or case.tolerance < 2e-5:
            return replace(row, compared=False)
        try:
            finer = solved(case, FINER * case.tolerance)
        except (SolveFailed, ValueError):
            return replace(row, compared=False)
    away = apart(found, finer)
    return replace(row, violation=away, compared=away > 0.0)  # the finer one may be the same rung


def solved(case: Case, tolerance: float) -> Found:
    """Return what is found of a scene: where the target rests, what the coils show, as it is asked."""
    if isinstance(case.given, Pose):
        field, _ = magnetic_model(case.sensor, case.model, tolerance, [case.given])
        return None, field.impedance(case.given, case.sensor.frequency)
    if case.kind == "pose":
        layer, choice = mechanical_model(case.sensor, case.model, tolerance, [case.given])
        left_out = mechanical_omissions(case.sensor, choice.name, [case.given])
        return at_rest(case.sensor, layer, case.given, left_out), None
    shown = simulate(case.sensor, case.given, tolerance=tolerance)
    return shown.equilibrium, shown.impedance


def refusal(error: Exception) -> Row:
    """Return the row of a question that raised: refused by name, or a failure with the end of its traceback."""
    words = str(error)
    if isinstance(error, SolveFailed):
        return Row("", "", error.report.status, estimated=error.report.estimated_error, remark=words)
    if isinstance(error, Collision):
        return Row("", "", "collision", remark=words)
    own = "sits_mech" in traceback.extract_tb(error.__traceback__)[-1].filename
    if isinstance(error, SceneError) or (isinstance(error, ValueError) and own and _NAMED.match(words)):
        return Row("", "", "bad input", remark=words)
    where = traceback.format_exception(error)[-3:]
    return Row("", "", "exception", remark=" ".join("".join(where).split())[-400:])


def rest_wrong(sensor: Sensor, rest: Equilibrium | None) -> list[str]:
    """Return what cannot be of a target at rest under a dead load: no numbers, J <= 0, or a load that was lifted."""
    if rest is None:
        return []
    pose, error = rest.pose.components, rest.error.components
    if not np.all(np.isfinite([*pose, *error, rest.report.estimated_error])):
        return ["no number in the pose"]
    assert sensor.target is not None and sensor.elastomer is not None
    found = [] if rest.report.min_J is None or rest.report.min_J > 0.0 else [f"J = {rest.report.min_J:.2g}"]
    h, load = sensor.target.load_height, rest.wrench
    arm = (rotation_matrix(rest.pose.rotation) - np.eye(3)) @ [0.0, 0.0, h]
    moved = rest.pose.centre - [0.0, 0.0, sensor.elastomer.standoff + sensor.elastomer.thickness] + arm
    parts = np.array([load.F_x, load.F_y, -load.F_z]) * moved
    turned = np.array([load.M_x, load.M, load.M_z]) * rest.pose.rotation
    slack = np.abs(load.components) @ error + h * float(np.abs(load.components[[0, 1, 3]]).sum() * error[[2, 4]].sum())
    size = float(np.abs(parts).sum() + np.abs(turned).sum())
    if parts.sum() + turned.sum() < -slack - ROUNDING * size:
        found.append(f"work {(parts.sum() + turned.sum()) / size:.2g} of its parts")
    return found


def field_wrong(sensor: Sensor, z: Impedance | None) -> list[str]:
    """Return what cannot be of passive coils and plates."""
    if z is None:
        return []
    if not all(np.all(np.isfinite(part)) for part in (z.L, z.R, z.L0, z.R_dc, z.error_L, z.error_R)):
        return ["no number in the impedance"]
    own, size = np.abs(z.error_L).sum() + ROUNDING * np.abs(z.L0).max(), np.abs(z.R).max()
    found = [f"{name} is not symmetric" for name, m in (("L", z.L), ("R", z.R)) if _lopsided(m) > ROUNDING]
    found += ["negative R"] if _least(z.R) < -np.abs(z.error_R).sum() - ROUNDING * size else []
    found += ["negative L0"] if _least(z.L0) < -ROUNDING * np.abs(z.L0).max() else []
    found += ["negative L"] if _least(z.L) < -own else []
    plates = [*([] if sensor.target is None else [sensor.target]), *sensor.conductors]
    if all(plate.metal.relative_permeability == 1.0 for plate in plates) and _least(z.L0 - z.L) < -own:
        found.append("L above L0")
    return found


def _lopsided(m: Array) -> float:
    """How far a matrix is from its transpose, of its largest entry."""
    return float(np.abs(m - m.T).max() / max(np.abs(m).max(), 1e-300))


def _least(m: Array) -> float:
    """Smallest eigenvalue of a matrix that is symmetric but for rounding."""
    return float(np.linalg.eigvalsh(0.5 * (m + m.T)).min())


def apart(found: Found, finer: Found) -> float:
    """Return how far two answers are apart, in sums of the errors they state; the largest of pose and inductance."""
    (rest, z), (other_rest, other_z) = found, finer
    away = [0.0]
    if rest is not None and other_rest is not None:
        gap = np.abs(rest.pose.components - other_rest.pose.components)
        error = rest.error.components + other_rest.error.components
        slack = ROUNDING * (np.abs(rest.pose.components) + np.abs(rest.pose.d_v))
        away.append(float(np.max(gap / np.maximum(error + slack, 1e-300))))
    if z is not None and other_z is not None:
        slack = ROUNDING * float(np.abs(z.L0).max())
        away.append(float(np.max(np.abs(z.L - other_z.L) / np.maximum(z.error_L + other_z.error_L + slack, 1e-300))))
    return max(away)


