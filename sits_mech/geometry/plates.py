"""Return the conducting plates that the plane y = 0 cuts: the target at its pose, and the scene's other metal.

A plate's own coordinates are ``xi + j eta`` from the middle of its bottom face; it lies at ``bottom + (xi + j eta)
exp(-j alpha)`` in the plane x + j z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sits_mech.description import Refusal
from sits_mech.quantities import Complex, Pose
from sits_mech.scene.sensor import Conductor, Sensor, metal_parts


@dataclass(frozen=True)
class PlateSection:
    """One conducting or permeable part in the section."""

    name: str
    bottom: complex  # middle of the bottom face x + j z [m]
    alpha: float  # clockwise rotation [rad]
    width: float  # [m]
    thickness: float  # [m]
    conductivity: float  # [S/m]
    relative_permeability: float
    isolated: bool  # whether its net current is zero; else it returns at the grounded circle

    def placed(self, local: NDArray[np.complexfloating]) -> Complex:
        """Return places x + j z of local coordinates xi + j eta [m]."""
        return np.asarray(self.bottom + local * np.exp(-1j * self.alpha))

    @property
    def corners(self) -> Complex:
        """Corners counter-clockwise from the lower left, shape (4,) [m]."""
        a, t = self.width / 2, self.thickness
        return self.placed(np.array([-a, a, a + 1j * t, -a + 1j * t]))


def section_plates(sensor: Sensor, pose: Pose) -> tuple[PlateSection, ...]:
    """Return the plates that the plane y = 0 cuts, the target at `pose` first."""
    plates = []
    if sensor.target is not None:
        target, metal = sensor.target, sensor.target.metal
        place, width = complex(float(pose.d_h), float(pose.d_v)), target.extent[0]
        plates.append(
            PlateSection("target", place, float(pose.alpha), width, target.thickness, metal.conductivity,
                         metal.relative_permeability, target.net_current == "zero")
        )
    for part in sensor.conductors:
        width, metal = cut_width(part), part.metal
        if width > 0.0:
            middle = complex(part.centre[0], part.centre[2])
            bottom = middle - 0.5j * part.thickness * np.exp(-1j * part.alpha)
            plates.append(
                PlateSection(f"conductors.{part.name}", complex(bottom), part.alpha, width, part.thickness,
                             metal.conductivity, metal.relative_permeability, True)
            )
    return tuple(plates)


def cut_width(part: Conductor) -> float:
    """Return the width of a fixed plate, of an outline's box, where y = 0 cuts it; 0 where it does not [m]."""
    offset = abs(part.centre[1])
    if part.diameter is not None:
        return float(np.sqrt(max(part.diameter**2 - 4 * offset**2, 0.0)))
    width, length = part.extent
    return width if offset <= length / 2 else 0.0


def outline_refusal(sensor: Sensor) -> Refusal | None:
    """Return which plate, of any outline or turned, has no section that stands for it; None if there is none."""
    for name, part in metal_parts(sensor):
        if part.loops:
            got = "a ring" if part.shape == "ring" else "an outline"
            return Refusal(f"{name}.shape", "be a rectangle or a disc for a section", got)
        if isinstance(part, Conductor) and part.is_turned and (part.alpha_x, part.alpha_z) != (0.0, 0.0):
            key = "alpha_x" if part.alpha_x else "alpha_z"
            return Refusal(f"{name}.{key}", "be 0 for a section", f"{np.degrees(getattr(part, key)):.4g} deg")
    return None


def not_cut(sensor: Sensor) -> list[str]:
    """Return the names of the fixed plates that the section misses."""
    return [part.name for part in sensor.conductors if cut_width(part) == 0.0]


def return_radius(sensor: Sensor) -> float | None:
    """Return R_b, where the net current of a target returns [m]; None where it has no net current."""
    target = sensor.target
    return target.planar_boundary_radius if target is not None and target.net_current == "free" else None


def distance(first: Complex, second: Complex) -> float:
    """Return the distance of two convex polygons given by their corners; 0 where they touch or overlap [m]."""
    import shapely

    shapes = [shapely.Polygon(np.column_stack([corners.real, corners.imag])) for corners in (first, second)]
    return float(shapes[0].distance(shapes[1]))
