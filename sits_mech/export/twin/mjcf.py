"""Model the pad for MuJoCo (MJCF): joints with its stiffness at rest and its damping.

The target hangs on slides and hinges. With the stiffness K = C^-1 at rest, of forces and moments about the centre of
the target's bottom face, the hinges' axes pass at the heights

    h_alpha = K_{x,alpha}/K_xx,    h_{alpha_x} = -K_{y,alpha_x}/K_yy                  above that face,

where shear and rotation do not meet: a joint's spring holds one component alone. Slides take K_ii, hinges

    K_alpha - K_{x,alpha}^2/K_xx,    K_{alpha_x} - K_{y,alpha_x}^2/K_yy,    K_{alpha_z}.

Springs are those of slow load. A damper is one number where the pad has a spectrum: what the Prony series loses at
1 Hz, c = k sum_i w_i/(1 - sum w) tau_i/(1 + (2 pi tau_i 1 Hz)^2). A plate of 0.1 g on such springs rings at kilohertz,
beyond an engine's steps. So each joint has the inertia k/omega^2 besides (armature) and at least the damper of critical
motion 2 k/omega, omega = 2000/s: the pad follows within a millisecond or so, slow as the calibration is. Both are the
engine's, not the silicone's. The scene has no densities: the target counts as copper, 8960 kg/m^3 (CRC Handbook of
Chemistry and Physics, 97th ed., section 4).

Neglected: stiffening beyond small strain; coupling of shear and rotation beyond first order; the pad's own mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from sits_mech.quantities import POSE, Array
from sits_mech.scene.sensor import Sensor

_DENSITY = 8960.0  # [kg/m^3]
_RATE = 2.0 * np.pi  # [rad/s] of the loss
_RINGS = 2000.0  # [rad/s] of target and spring in the engine
_AXES = {"d_h": "1 0 0", "d_y": "0 1 0", "d_v": "0 0 1", "alpha_x": "1 0 0", "alpha": "0 1 0", "alpha_z": "0 0 1"}
_X, _Z, _ALPHA, _Y, _ALPHA_X = (POSE.index(name) for name in ("d_h", "d_v", "alpha", "d_y", "alpha_x"))


def bottom_stiffness(compliance: Array, load_height: float) -> Array:
    """Return the stiffness (6, 6) about the centre of the bottom face, all along the axes; NaN of what is not known.

    `compliance` (6, 6) is pose by wrench, F_z > 0 pressing down, forces at `load_height` above that face [m].
    """
    held = np.eye(6)  # wrench at the bottom face by the wrench as it is given, F_z upwards
    held[_Z, _Z], held[_ALPHA, _X], held[_ALPHA_X, _Y] = -1.0, load_height, -load_height
    known = np.flatnonzero(np.isfinite(np.diagonal(compliance)))
    block = np.ix_(known, known)
    C, K = compliance[block] @ np.linalg.inv(held[block]), np.full((6, 6), np.nan)
    K[block] = np.linalg.inv(0.5 * (C + C.T))
    return K


def joints(K: Array) -> dict[str, tuple[float, float]]:
    """Return stiffness [N/m, N m/rad] and height of the axis above the bottom face [m] of each joint that K knows."""
    found = {name: (float(K[k, k]), 0.0) for k, name in enumerate(POSE) if np.isfinite(K[k, k])}
    for turn, slide, sign in ((_ALPHA, _X, 1.0), (_ALPHA_X, _Y, -1.0)):
        if POSE[turn] in found and POSE[slide] in found:
            left = K[turn, turn] - K[turn, slide] ** 2 / K[slide, slide]
            found[POSE[turn]] = (float(left), float(sign * K[turn, slide] / K[slide, slide]))
    return {name: found[name] for name in _AXES if name in found}


def loss_time(prony: Array) -> float:
    """Return the damper over the spring [s] that loses at 1 Hz what a Prony series (branches, 2) does."""
    w, tau = prony[:, 0], prony[:, 1]
    return float(np.sum(w / (1.0 - w.sum()) * tau / (1.0 + (_RATE * tau) ** 2)))


def mjcf(sensor: Sensor, numbers: Mapping[str, Any]) -> str | None:
    """Return the pad as a model of MuJoCo, to be included in others; None where its compliance is not known."""
    rest, target = numbers["rest_pose"], sensor.target
    held = joints(bottom_stiffness(numbers["compliance"], float(numbers["load_height"])))
    if target is None or not held or not np.all(np.isfinite(rest)):
        return None
    half = (0.5 * target.extent[0], 0.5 * target.extent[1], 0.5 * target.thickness)
    mass = _DENSITY * 8.0 * float(np.prod(half))
    slow, lines, worth = loss_time(numbers["prony"]), [], "known" if len(numbers["prony"]) else "not known"
    for name, (k, height) in held.items():
        kind = "hinge" if name.startswith("alpha") else "slide"
        lines.append(
            f'        <joint name="sits_{name}" type="{kind}" axis="{_AXES[name]}" pos="0 0 {height:.6g}" '
            f'stiffness="{k:.6g}" damping="{k * max(slow, 2.0 / _RINGS):.6g}" armature="{k / _RINGS**2:.6g}"/>'
        )
    size = " ".join(f"{each:.6g}" for each in half)
    return _LAYOUT.format(
        model=quoteattr(sensor.name), worth=worth, mass=f"{mass:.6g}", joints="\n".join(lines), size=size,
        rest=f"{rest[_X]:.6g} {rest[_Y]:.6g} {rest[_Z]:.6g}", up=f"{half[2]:.6g}",
    )


_LAYOUT = """<!-- The compliant pad of a soft inductive sensor: x shear, z up, z = 0 the coils' plane; metres, newtons.
     Springs: slow load at small strain. Relaxation of the silicone: {worth}. Armature: for the engine, not the pad's.
     A load on sits_target moves its joints; less what springs and dampers do (qfrc_passive) is what presses on it. -->
<mujoco model={model}>
  <compiler angle="radian" autolimits="true"/>
  <option timestep="2e-4" integrator="implicitfast"/>
  <worldbody>
    <body name="sits_pad">
      <site name="sits_base" size="1e-4"/>
      <body name="sits_target" pos="{rest}">
{joints}
        <geom name="sits_target" type="box" pos="0 0 {up}" size="{size}" mass="{mass}" rgba="0.80 0.45 0.25 1"/>
        <site name="sits_face" size="1e-4"/>
      </body>
    </body>
  </worldbody>
  <sensor>
    <framepos name="sits_place" objtype="site" objname="sits_face" reftype="site" refname="sits_base"/>
    <framequat name="sits_turn" objtype="site" objname="sits_face" reftype="site" refname="sits_base"/>
  </sensor>
</mujoco>
"""
