"""Does anything that the loader accepts get a consistent answer, or a refusal by its name? Random scenes asked.
"""

from __future__ import annotations

import traceback
import warnings
from dataclasses import dataclass, replace

import numpy as np
from extreme.any_scene import Case, random_case

from sits_mech.chain.models import magnetic_model, mechanical_model
from sits_mech.chain.simulate import at_rest, simulate
from sits_mech.geometry.collision import Collision, check_clearance
from sits_mech.quantities import Equilibrium, Impedance, Pose, SolveFailed, Wrench
from sits_mech.scene.sensor import SceneError, Sensor


@dataclass(frozen=True)
class Answer:
    status: str
    violation: float = np.nan
    estimated: float = np.nan
    remark: str = ""
    found: tuple = ()


def solved(case: Case, tolerance: float):
    """Return equilibrium or None, impedance or None."""
    if case.kind == "inductance":
        model, _ = magnetic_model(case.sensor, case.model, tolerance, [case.given])
        check_clearance(case.sensor, case.given)
        return None, model.impedance(case.given, case.sensor.frequency)
    if case.kind == "pose":
        layer, _ = mechanical_model(case.sensor, case.model, tolerance, [case.given])
        return at_rest(case.sensor, layer, case.given), None
    found = simulate(case.sensor, case.given, tolerance=tolerance)
    return found.equilibrium, found.impedance


def answer(case: Case, tolerance: float | None = None) -> Answer:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            rest, z = solved(case, tolerance or case.tolerance)
    except SolveFailed as failed:
        return Answer(f"refused: {failed.report.status}", remark=str(failed))
    except Collision as error:
        return Answer("refused: collision", remark=str(error))
    except SceneError as error:
        return Answer("refused: scene", remark=str(error))
    except ValueError as error:
        import re
        inner = traceback.extract_tb(error.__traceback__)[-1]
        if re.match(r"[\w.\-' ]+: ", str(error)) and "\n" not in str(error) and "/sits_mech/" in inner.filename:
            return Answer("refused: bad input", remark=str(error))
        return Answer("ERROR ValueError", remark=traceback.format_exc()[-1500:])
    except BaseException as error:
        return Answer(f"ERROR {type(error).__name__}", remark=traceback.format_exc()[-1500:])
    problems = []
    if rest is not None:
        problems += check_rest(case.sensor, rest)
    if z is not None:
        problems += check_field(case.sensor, z)
    est = (rest or z).report.estimated_error
    notes = [r.report.model for r in (rest, z) if r is not None]
    return Answer("converged" if not problems else "WRONG " + problems[0][0], estimated=est, remark="; ".join(f"{n} {v:.2g}" for n, v in problems) + " by " + ",".join(notes), found=(rest, z))


def check_rest(sensor: Sensor, rest: Equilibrium):
    p, e = rest.pose.components, rest.error.components
    bad = []
    if rest.report.status != "converged": bad.append(("status " + rest.report.status, 1))
    if not (np.isfinite(p).all() and np.isfinite(e).all() and np.isfinite(rest.report.estimated_error)):
        return [("nan", np.nan)]
    if rest.report.min_J is not None and not rest.report.min_J > 0: bad.append(("min_J", rest.report.min_J))
    elastomer = sensor.elastomer
    move = p - [0, elastomer.standoff + elastomer.thickness, 0, 0, 0, 0]
    move[1] *= -1
    # of the load's point: load_height above bottom
    h = sensor.target.load_height
    w = rest.wrench.components
    from sits_mech.turns import rotation_matrix
    R = rotation_matrix(p[[4, 2, 5]])
    lever = (R - np.eye(3)) @ [0, 0, h]
    d = np.array([move[0] + lever[0], move[1] - lever[2], p[2], move[3] + lever[1], p[4], p[5]])
    work = float(w @ d)
    size = float(np.abs(w) @ np.abs(d))
    doubt = float(np.abs(w) @ (e + np.array([h*(e[2]), h*(e[2]+e[4]), 0, h*e[4], 0, 0])))
    if work < -1e-9 * size - doubt: bad.append(("work", work / size))
    return bad


def check_field(sensor: Sensor, z: Impedance):
    bad = []
    for n in ("L", "R", "L0", "R_dc", "error_L", "error_R"):
        if not np.isfinite(getattr(z, n)).all(): return [("nan in " + n, np.nan)]
    if not np.isfinite(z.report.estimated_error): return [("nan estimate", np.nan)]
    if (z.error_L < 0).any() or (z.error_R < 0).any(): bad.append(("negative error", 1))
    size = np.abs(z.L0).max()
    for n in ("L", "R"):
        m = getattr(z, n)
        off = np.abs(m - m.T).max() / max(np.abs(m).max(), 1e-300)
        if off > 1e-9: bad.append(("reciprocity " + n, off))
    least = np.linalg.eigvalsh(z.R).min()
    if least < -1e-9 * np.abs(z.R).max() - np.abs(z.error_R).sum(): bad.append(("R < 0", least / np.abs(z.R).max()))
    if np.linalg.eigvalsh(z.L0).min() <= -1e-9*size: bad.append(("L0 not positive", np.linalg.eigvalsh(z.L0).min() / size))
    if np.linalg.eigvalsh(z.L).min() < -np.abs(z.error_L).sum() - 1e-9*size: bad.append(("L not positive", np.linalg.eigvalsh(z.L).min() / size))
    metals = [p.metal for p in ([sensor.target] if sensor.target else []) + list(sensor.conductors)]
    if all(m.relative_permeability == 1 for m in metals):
        up = np.linalg.eigvalsh(z.L - z.L0).max()
        if up > np.abs(z.error_L).sum() + 1e-9 * size: bad.append(("L > L0", up / size))
    if not metals and np.abs(z.L - z.L0).max() > 1e-12*size: bad.append(("L != L0", 1))
    return bad
