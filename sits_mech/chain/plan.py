"""Choose the cheapest models that can hold a scene, with the reasons; what a request does not need is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sits_mech.chain.omissions import Omission, keeps_axis, strain_bound
from sits_mech.geometry.tracks import section_refusal
from sits_mech.magnetics.rings import on_axis
from sits_mech.magnetics.sheets import not_representable as sheets_refuse
from sits_mech.mechanics.closed_form import LONG, finite_strain_model
from sits_mech.mechanics.symmetry import symmetry_of
from sits_mech.quantities import Pose, Wrench
from sits_mech.scene.materials import check_model
from sits_mech.scene.sensor import Sensor, Target
from sits_mech.units import SceneError


@dataclass(frozen=True)
class Choice:
    """A model and the reason for it."""

    name: str  # as on the command line
    reason: str  # one sentence
    notes: tuple[str, ...] = ()  # where conductors change the model from the bare sensor's
    left_out: tuple[Omission, ...] = ()  # conductors that are too far to matter
    by_name: bool = False  # asked for by name: errors of a section do not hold what it leaves out


_SPACE = ("block", "three dimensions", ": the pad is too short for plane strain")
_PLANE = (
    "planar", "plane strain", ", the force spread over the elastomer's length; "
    "a pad or a target shorter than that is softer: compare with block",
)
_ASKED = "asked for"
_LEAVES = "no other model has out-of-plane displacements, and one model answers all loads of a request"


def leaving(given: Sequence[Wrench] | Sequence[Pose]) -> tuple[str, ...]:
    """Return the names of the components of loads or poses that leave the plane y = 0."""
    return tuple(sorted({name for each in given for name in each.out_of_plane}))


def choose_mechanics(
    sensor: Sensor, asked: str, known: tuple[str, ...], loads: Sequence[Wrench] = (), tolerance: float = 1e-2
) -> Choice:
    """Return the mechanical model for a scene with target and elastomer; "auto" chooses from `known`.

    Raises SceneError when the model is unknown or the scene has no layer.
    """
    check_model("mechanics", asked, ("auto", *known))
    beside, own, rough = ", ".join(leaving(loads)), _of_its_own(sensor), _is_rough(sensor)
    _check_mechanics(sensor, asked, beside)
    if asked != "auto":
        return Choice(asked, _ASKED, by_name=True)
    if beside:
        return Choice("block", f"{beside}: {_LEAVES}")
    if own:
        return Choice("block", f"no plane section represents {own}")
    model, where, reason = _SPACE if "block" in known and _is_finite(sensor) else _PLANE
    bound = strain_bound(sensor, loads) if loads and "linear" in known and not rough else tolerance
    if bound < tolerance:
        return Choice("linear", f"small strain in {where}: the error of one constant compliance is below {bound:.1g}")
    return Choice(model, f"finite strain in {where}{reason}")


def _check_mechanics(sensor: Sensor, asked: str, beside: str) -> None:
    """Refuse a scene without a layer, and a model that does not hold its loads beside the plane, friction or pad."""
    for part in ("target", "elastomer"):
        if getattr(sensor, part) is None:
            raise SceneError(f"{sensor.name}: {part}: must be given for a force to move the target; it is missing")
    own, flat = _of_its_own(sensor), asked not in ("auto", "block")
    if beside and flat:
        raise SceneError(f"model (mechanics) must be auto or block for {beside}; got {asked}")
    if _is_rough(sensor) and asked in ("linear", "closed-form"):
        raise SceneError(f"model (mechanics) must be auto, block or planar with elastomer.friction; got {asked}")
    if own and flat:
        raise SceneError(f"{sensor.name}: model (mechanics) must be block for {own}; got {asked}")


def _is_rough(sensor: Sensor) -> bool:
    """Return whether the pad has friction."""
    return sensor.elastomer is not None and sensor.elastomer.friction > 0.0


def _of_its_own(sensor: Sensor) -> str:
    """Name a layer that the 3D model alone holds; empty for others."""
    elastomer = sensor.elastomer
    if elastomer is None or (elastomer.mesh is None and elastomer.kind != "pillars"):
        return ""
    return "pillars" if elastomer.mesh is None else "an elastomer.mesh"


def _is_finite(sensor: Sensor) -> bool:
    """Return whether the 3D model holds a pad and the planar one does not."""
    target, elastomer = sensor.target, sensor.elastomer
    if target is None or elastomer is None or target.shape == "outline":
        return False
    return finite_strain_model(sensor.elastomer) == "block"


def _in_space(sensor: Sensor, target: Target) -> bool:
    """Return whether loads move a plate that its section does not stand for."""
    short = target.extent[1] < LONG * target.extent[0] and target.net_current == "zero"
    return short and _is_finite(sensor)


def _is_free(target: Target | None) -> bool:
    """Return whether the net current of a target is free."""
    return target is not None and target.net_current == "free"


def choose_magnetics(
    sensor: Sensor, asked: str, known: tuple[str, ...], given: Sequence[Wrench] | Sequence[Pose] = (),
    loaded: bool = False,
) -> Choice:
    """Return the cheapest magnetic model for a scene, all of whose conductors matter.

    Components that leave the plane are solved in space. Poses that come of loads on a finite pad (`loaded`) are solved
    in space like the pad; poses that are given, in section where the scene has one: their change of inductance is quick
    to see and relative. Conductors are solved in space, as are fixed rectangles of ferrite; other permeable parts in
    section: no other model has them. Raises SceneError when the model is unknown, or none can hold the scene.
    """
    check_model("magnetics", asked, ("auto", *known))
    coaxial, permeable = _is_coaxial(sensor, given, loaded), _permeable(sensor)
    about = ("M_z", "alpha_z") if coaxial else ()
    beside = tuple(name for name in leaving(given) if name not in about)
    if beside and asked not in ("auto", "sheets"):
        raise SceneError(f"model (magnetics) must be auto or sheets for {', '.join(beside)}; got {asked}")
    if asked != "auto":
        return Choice(asked, _ASKED, by_name=True)
    if permeable:
        return _of_permeable(sensor, permeable, known, beside)
    if beside:
        return Choice("sheets", f"{', '.join(beside)}: {_LEAVES}")
    if sensor.substrate_radius is not None:
        return Choice("planar-fem", "coils on a curved substrate")
    if sensor.conductors:
        return _beside_conductors(sensor)
    return _of_target(sensor, known, loaded, coaxial)


def _of_permeable(
    sensor: Sensor, permeable: tuple[str, ...], known: tuple[str, ...], beside: tuple[str, ...]
) -> Choice:
    """Return the model of permeable parts."""
    if "sheets" in known and not _is_free(sensor.target) and sheets_refuse(sensor) is None:
        return Choice("sheets", f"{', '.join(permeable)}: ferrite that does not conduct, magnetised in space")
    _check_in_section(sensor, permeable, beside)
    return Choice("planar-fem", f"{', '.join(permeable)}: permeable, the air around is meshed")


def _beside_conductors(sensor: Sensor) -> Choice:
    """Return the model of fixed conductors beside a target."""
    names = ", ".join(f"conductors.{part.name}" for part in sensor.conductors)
    if _is_free(sensor.target):
        return Choice("planar-fem", f"{names} beside a target with free net current")
    return Choice("sheets", f"{names} can be near enough to matter")


def _of_target(sensor: Sensor, known: tuple[str, ...], loaded: bool, coaxial: bool) -> Choice:
    """Return the model of coils on a flat board and, at most, a target: on an axis or of a section where these hold."""
    target = sensor.target
    if coaxial:
        return Choice("axisymmetric", "one coil under a disc on its axis")
    if section_refusal(sensor.coils) is not None:
        return Choice("sheets", "coils off the plane y = 0, or not perpendicular to it, have no planar model")
    if free_tracks := _free_tracks(sensor):
        return Choice("sheets", f"{free_tracks}: free tracks, which no plane section represents")
    if target is None:
        return Choice("planar", "no target: free space alone")
    if target.shape != "rectangle":
        return Choice("sheets", "neither a plane section nor an axisymmetric model represents the target at every pose")
    if loaded and "sheets" in known and _in_space(sensor, target):
        return Choice("sheets", "three-dimensional like the pad: the plate is too short along y for a plane section")
    return Choice("planar", "no permeable parts: no mesh of the air")


def _is_coaxial(sensor: Sensor, given: Sequence[Wrench] | Sequence[Pose], loaded: bool) -> bool:
    """Return whether a disc stays on the one round coil's axis, as far as poses are known; of loads all must be."""
    coil, shape = sensor.coils[0], sensor.target and sensor.target.shape
    if (len(sensor.coils), coil.is_round, sensor.substrate_radius, shape) != (1, True, None, "disc"):
        return False
    if loaded:
        upright = all(isinstance(load, Wrench) and keeps_axis(load) for load in given)
        return bool(given) and upright and (symmetry_of(sensor).mirrored, coil.centre) == (True, (0.0, 0.0))
    return all(isinstance(pose, Pose) and on_axis(coil, pose) for pose in given)


def _free_tracks(sensor: Sensor) -> str:
    """Name the coils of free tracks; empty where there are none."""
    return ", ".join(f"coils.{coil.name}" for coil in sensor.coils if coil.shape == "path")


def _permeable(sensor: Sensor) -> tuple[str, ...]:
    """Return the names of the permeable parts."""
    parts = [(f"conductors.{part.name}", part.metal) for part in sensor.conductors]
    parts += [] if sensor.target is None else [("target", sensor.target.metal)]
    return tuple(name for name, metal in parts if metal.relative_permeability != 1.0)


def _check_in_section(sensor: Sensor, permeable: tuple[str, ...], beside: tuple[str, ...]) -> None:
    """Refuse permeable parts where planar-fem, the only model of them, does not apply."""
    hindered = [f"{', '.join(beside)} not zero"] if beside else []
    hindered += ["coils off it or not perpendicular to it"] if section_refusal(sensor.coils) is not None else []
    hindered += [f"free tracks of {free_tracks}"] if (free_tracks := _free_tracks(sensor)) else []
    plates = [("a target", sensor.target), *((f"conductors.{part.name}", part) for part in sensor.conductors)]
    hindered += [f"an outline for {name}" for name, plate in plates if plate is not None and plate.shape == "outline"]
    if hindered:
        names = ", ".join(permeable)
        raise SceneError(
            f"{names}: permeable parts that matter are modelled by planar-fem only, in the section y = 0; got "
            f"{' and '.join(hindered)}"
        )
