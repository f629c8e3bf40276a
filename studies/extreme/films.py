"""Films: pads hundreds of times wider than thick, pressed and sheared, against the thin-layer limit.

Silicone under a wide target cannot flow out but at its rim. With M = K + 4/3 mu and k^2 = 12 mu/(M t^2) the pressure is
p = M v/t (1 - f), f_xx + f_yy = k^2 f with f = 1 at the rim, and the force down

    F = M v A/t  mean(1 - f),    mean = 64/pi^4 sum_{m, n odd} 1/(m n)^2  k^2/(k^2 + (m pi/w)^2 + (n pi/l)^2)

on a rectangle of w by l, ``1 - 2 I_1(k a)/(k a I_0(k a))`` on a disc of radius a; in shear it is F = mu A d_h/t.
(Reynolds' equation of a compressible layer; A. N. Gent, P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111, for the
limit of incompressible ones.) What it leaves out is a rim about as wide as the film is thick: allowed is 1.5 t times
the perimeter over the area, and the estimated error. A row holds only below 1 GB, too; its remark has processor time.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from common.accuracy import forget
from extreme.rows import DONE, Row, measured
from extreme.solids import shaped
from scipy.special import ive

from sits_mech.mechanics.block import block_pad
from sits_mech.mechanics.element.memory import memory_of_box
from sits_mech.mechanics.pad.families import pad_family
from sits_mech.quantities import SolveReport, Wrench
from sits_mech.scene.sensor import Elastomer, Sensor, Target

MOST = 1e9  # bytes
PARTS = {
    "flush 20 x 20 mm": ('shape="rectangle", width="20 mm", length="20 mm"', 'width="20 mm", length="20 mm"'),
    "8 x 8 on 20 x 20 mm": ('shape="rectangle", width="8 mm", length="8 mm"', 'width="20 mm", length="20 mm"'),
    "flush disc of 20 mm": ('shape="disc", diameter="20 mm"', 'diameter="20 mm"'),
}


def parts(sensor: Sensor) -> tuple[Target, Elastomer]:
    """Return target and elastomer of a scene, which has both."""
    assert sensor.target is not None and sensor.elastomer is not None
    return sensor.target, sensor.elastomer


def rim(sensor: Sensor) -> tuple[float, float]:
    """Return area and perimeter of a target [m2, m]."""
    target, _ = parts(sensor)
    w, b = target.extent
    return (0.25 * np.pi * w * w, np.pi * w) if target.shape == "disc" else (w * b, 2.0 * (w + b))


def stiffness_down(sensor: Sensor) -> float:
    """Return the thin-layer limit of the force over the sink [N/m]."""
    target, elastomer = parts(sensor)
    mu, t = elastomer.silicone.shear_modulus, elastomer.thickness
    M = elastomer.silicone.bulk_modulus + 4.0 / 3.0 * mu
    k, (w, b) = np.sqrt(12.0 * mu / M) / t, target.extent
    if target.shape == "disc":
        ka = 0.5 * k * w
        mean = 1.0 - 2.0 * ive(1, ka) / (ka * ive(0, ka))
    else:
        m, n = (np.arange(1, 4001, 2)[part] for part in ((slice(None), None), (None, slice(None))))
        mean = 64.0 / np.pi**4 * np.sum(k**2 / (m * n) ** 2 / (k**2 + (m * np.pi / w) ** 2 + (n * np.pi / b) ** 2))
    return float(M * rim(sensor)[0] / t * mean)


def films(coarse: bool) -> Iterator[Row]:
    """Yield the rows of films, pressed by 1 % and sheared by 10 %; the coarse ones: one."""
    for name in list(PARTS)[:1] if coarse else PARTS:
        for t in (0.1,) if coarse else (0.1, 0.01):
            for way in ("pressed",) if coarse else ("pressed", "sheared"):
                case, sensor = f"3D film {name}, {t:g} mm, {way}", shaped(*PARTS[name], t)
                yield measured("mechanics", case, lambda sensor=sensor, way=way: limit_row(sensor, way), True)


def limit_row(sensor: Sensor, way: str) -> Row:
    """Return how far a film is from its limit, over what is allowed, or its memory over what it may take."""
    pressed, (_, elastomer) = way == "pressed", parts(sensor)
    t, (area, perimeter) = elastomer.thickness, rim(sensor)
    k = stiffness_down(sensor) if pressed else elastomer.silicone.shear_modulus * area / t
    goal = (0.01 if pressed else 0.1) * t
    forget()
    began = time.process_time()
    found = block_pad(sensor, 1e-2).equilibrium(Wrench(F_z=k * goal) if pressed else Wrench(F_x=k * goal))
    seconds, report = time.process_time() - began, found.report
    away = abs((t - found.pose.d_v if pressed else found.pose.d_h) / goal - 1.0)
    memory = taken(sensor, report)
    share = max(away / (1.5 * t * perimeter / area + report.estimated_error), memory / MOST)
    remark = f"{away:.2%} from the limit; {seconds:.1f} s of processor time, {memory / 1e9:.2f} GB"
    least = np.nan if report.min_J is None else report.min_J
    return Row("", "", DONE, least, float(share), 1.0, report.estimated_error, remark=remark)


def taken(sensor: Sensor, report: SolveReport) -> float:
    """Return the memory of the level that answered [bytes]."""
    levels, _ = pad_family(sensor)
    level = next(n for n in range(len(levels)) if len(levels.maker(n).free) + 3 >= report.unknowns)
    return float(sum(memory_of_box(levels.cells(level))))
