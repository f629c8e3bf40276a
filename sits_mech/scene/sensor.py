"""Define the sensor: a scene of coils, target, elastomer, other conductors and readout that fit together.

`load_sensor` reads one from a scene file or from the catalogue; whatever cannot be built is refused with one line:
file, key, what it must be, what came.
"""

from __future__ import annotations

import hashlib
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import BaseModel, model_validator

from sits_mech.arguments import checked_arguments
from sits_mech.inputs import FORM, checked, unknown
from sits_mech.scene.apart import check_parts
from sits_mech.scene.bounds import Frequency, Length, Name, Temperature
from sits_mech.scene.files import overridden, read_toml, write_text, written
from sits_mech.scene.materials import Metal
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.parts.cover import Cover, check_cover
from sits_mech.scene.parts.elastomer import Elastomer, Layer
from sits_mech.scene.parts.metal import Conductor, Target
from sits_mech.scene.parts.readout import Readout, Tolerances
from sits_mech.scene.parts.touch import Touch, check_touch
from sits_mech.silicone.material import Silicone
from sits_mech.units import SceneError, quantity, shown
from sits_mech.version import __version__

__all__ = [
    "Coil", "Conductor", "Cover", "Elastomer", "Metal", "Readout", "SceneError", "Sensor", "Silicone", "Target",
    "Tolerances", "Touch", "catalogue", "changed", "load_sensor", "quantity", "save_sensor", "scene_hash", "scene_text",
    "sensor_from",
]

REFERENCE = 293.15
"""Temperature that the numbers of a scene hold at, 20 degC [K]."""
_UNSAID: Mapping[str, Mapping[str, Any]] = {  # keys of each part that are left out where they have their defaults
    "elastomer": {"weld": False, "free_stretch": 1.0},
    "cover": {"free_stretch": 1.0},
    "target": {"holes": ()},
    "conductors": {"holes": (), "alpha": 0.0, "alpha_x": 0.0, "alpha_z": 0.0},
    "readout": {"capacitance_coefficient": 0.0, "clock_coefficient": 0.0},
    "touch": {"x": 0.0, "y": 0.0, "friction": "none"},
}
_PARTS: Mapping[str, type[BaseModel]] = {
    "coils": Coil,
    "target": Target,
    "elastomer": Elastomer,
    "cover": Cover,
    "conductors": Conductor,
    "readout": Readout,
    "tolerances": Tolerances,
    "touch": Touch,
}


class Sensor(BaseModel):
    """A whole scene.

    Attributes
    ----------
    name : str
        Title.
    frequency : float
        Of the coils' current [Hz].
    coils : tuple of Coil
        At least one; they must not overlap.
    target : Target or None
        Centred on the elastomer at rest, smaller or larger than it.
    elastomer : Elastomer or None
        The layer that a force acts against.
    cover : Cover or None
        Silicone bonded on target and pad, under which the target is a rigid inclusion.
    conductors : tuple of Conductor
        Fixed metal or ferrite nearby, clear of all other parts and of each other.
    readout : Readout
        The electronics.
    temperature : float
        Of all parts, where the sensor is used [K]. The scene's numbers are those at 20 degC: see scene/thermal.py.
    tolerances : Tolerances or None
        What a built sensor may be off by, for `sits-mech adapt`.
    substrate_radius : float or None
        Radius of the cylinder, its axis along y and below, on which the coils lie [m]; None where they lie flat.
    touch : Touch or None
        What presses on the target, and where; by default forces act in the middle of its top face. Wrenches on it are
        about the touched point; one with moments touches elsewhere, at x + M/F_z, y - M_x/F_z (mechanics/touch.py).

    Examples
    --------
    >>> sensor = sm.load_sensor("biorob2018")
    >>> sensor.target.width, sensor.elastomer.thickness, [coil.name for coil in sensor.coils]
    (0.008, 0.002, ['C1', 'C2'])
    """

    model_config = FORM
    name: Name
    frequency: Frequency
    coils: tuple[Coil, ...]
    target: Target | None = None
    elastomer: Elastomer | None = None
    cover: Cover | None = None
    conductors: tuple[Conductor, ...] = ()
    readout: Readout = Readout()
    substrate_radius: Length | None = None
    temperature: Temperature = REFERENCE
    tolerances: Tolerances | None = None
    touch: Touch | None = None

    @property
    def coil_names(self) -> list[str]:
        """The names of the coils in their order."""
        return [coil.name for coil in self.coils]

    @property
    def slides(self) -> bool:
        """Whether what touches the target takes no shear."""
        return self.touch is not None and self.touch.friction == "none"

    @property
    def touched_point(self) -> tuple[float, float]:
        """Where forces act on the target's top face at rest [m]."""
        return (0.0, 0.0) if self.touch is None else self.touch.place

    @model_validator(mode="before")
    @classmethod
    def _one_target(cls, given: Any) -> Any:
        """Refuse a scene of several targets."""
        if isinstance(given, Mapping) and "targets" in given:
            raise SceneError("targets must be left out here: `sits-mech cells` solves scenes of several targets")
        return given

    @model_validator(mode="before")
    @classmethod
    def _pillars_under_the_target(cls, given: Any) -> Any:
        """Let pillars fill what is under the target unless the scene says otherwise."""
        layer, target = (given.get(key) for key in ("elastomer", "target")) if isinstance(given, Mapping) else (0, 0)
        if not (isinstance(layer, Mapping) and isinstance(target, Mapping) and layer.get("shape") == "pillars"):
            return given
        sizes = ("width", "length")
        if any(layer.get(key) is not None for key in sizes):
            return given
        field = {key: target.get(key, target.get("diameter")) for key in sizes}
        return dict(given) | {"elastomer": dict(layer) | field}

    @model_validator(mode="after")
    def _fits_together(self) -> Sensor:
        """Refuse parts that cannot be in one place."""
        if not self.coils:
            raise SceneError("coils must be one or more; got none")
        for key, parts in (("coils", self.coils), ("conductors", self.conductors)):
            names = [part.name for part in parts]
            twice = [name for name in names if names.count(name) > 1]
            if twice:
                raise SceneError(f"{key} must have a name of their own each; got {shown(twice[0])} twice")
        windings = sorted({coil.winding for coil in self.coils if coil.is_round})
        if len(windings) > 1:
            raise SceneError(f"round coils must all have one winding; got {' and '.join(windings)}")
        if self.cover is not None:
            check_cover(self.cover, self.target, self.elastomer)
        check_parts(self.coils, self.target, self.elastomer, self.conductors, self.substrate_radius, self.cover)
        if self.touch is not None:
            check_touch(self.touch, self.target, self.cover, self.elastomer)
        return self


def silicone_of(sensor: Sensor) -> Silicone | None:
    """Return the silicone whose rate and softening stand for the pad as a whole, None without a pad.

    Raises SceneError for several silicones that do not relax alike, or that soften, each by its own strain.
    """
    made = silicones_of(sensor)
    if len(made) > 1 and (len({each.prony for each in made}) > 1 or any(each.mullins for each in made)):
        which = "cover" if sensor.cover is not None else "elastomer.layers"
        raise SceneError(
            f"{which}: must relax alike and have no mullins where the pad is taken as a whole; these do not: "
            "simulate --history --mechanics block follows every point"
        )
    return made[0] if made else None


def stack_of(sensor: Sensor) -> tuple[Layer | Cover, ...]:
    """Return the layers of a sensor's pad from the ground up, its cover last; none without a pad."""
    own = () if sensor.elastomer is None else sensor.elastomer.stack
    return own if sensor.cover is None else (*own, sensor.cover)


def shape_on_cover(sensor: Sensor) -> Touch | None:
    """Return what presses on a scene's cover, anywhere and by any force; None where nothing does."""
    if sensor.touch is None or sensor.cover is None:
        return None
    return sensor.touch.model_copy(update={"x": 0.0, "y": 0.0, "force": None, "depth": None})


def silicones_of(sensor: Sensor) -> tuple[Silicone, ...]:
    """Return the silicones of a sensor's pad from the ground up, its cover's last; none without a pad."""
    return tuple(layer.silicone for layer in stack_of(sensor))


def untested_notes(sensor: Sensor) -> tuple[str, ...]:
    """Return that errors of forces hold nothing of a silicone whose constants are given alone; else nothing."""
    words = ("the silicone's constants are given without source, spread or mode_spread: forces scale with its modulus, "
             "and their errors do not hold it; sits-mech adapt finds it by a few readings")
    return (words,) if any(made.is_untested for made in silicones_of(sensor)) else ()


def metal_parts(sensor: Sensor) -> list[tuple[str, Target | Conductor]]:
    """Return target and fixed parts by their keys."""
    target = [] if sensor.target is None else [("target", sensor.target)]
    return [*target, *((f"conductors.{part.name}", part) for part in sensor.conductors)]


def known_stretch(sensor: Sensor) -> float:
    """Return the largest stretch in the data behind the silicone's constants [-]; NaN where that is not known.

    Of layers the least one that is known.
    """
    known = [made.known_stretch for made in silicones_of(sensor)]
    return min((each for each in known if each == each), default=float("nan"))


def sensor_from(scene: Mapping[str, Any], where: str = "scene") -> Sensor:
    """Return the checked sensor that a scene's tables describe, in SI numbers or strings with units.

    Raises SceneError in one line: `where`, the key, what it must be, what came.
    """
    return checked(Sensor, scene, "scene", where)


@cache
def _catalogue_files() -> Mapping[str, Path]:
    """Return the scene files of the catalogue by name."""
    folder = Path(str(resources.files("sits_mech") / "scene" / "catalog"))
    return {path.stem: path for path in sorted(folder.glob("*.toml"), key=lambda path: path.stem)}


def catalogue() -> dict[str, str]:
    """Return the catalogue's sensors: name of each and its title.

    Examples
    --------
    >>> sm.catalogue()["biorob2018"]
    'BioRob 2018 two-axis SITS, target 8 mm wide'
    """
    return {name: str(read_toml(path)["name"]) for name, path in _catalogue_files().items()}


@checked_arguments
def load_sensor(source: str | Path, overrides: Sequence[str] = ()) -> Sensor:
    """Read a sensor from a scene file or from the catalogue.

    Parameters
    ----------
    source : str or Path
        Path of a scene file, or a name of the catalogue.
    overrides : sequence of str
        Keys to change, such as ``'target.width="15 mm"'`` or ``'coils.C1.turns=10'``.

    Returns
    -------
    Sensor
        Checked.

    Raises
    ------
    SceneError
        One line: file, key, what it must be, what came.

    Examples
    --------
    >>> sm.load_sensor("biorob2018", ['target.width="10 mm"']).target.width
    0.01
    """
    return sensor_from(scene_tables(source, overrides), str(source))


def scene_tables(source: str | Path, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Return the tables of a scene file, or of one of the catalogue, with keys changed; raises as `load_sensor`."""
    files = _catalogue_files()
    path = files.get(str(source), Path(source))
    if path.suffix != ".toml" and "\0" not in str(source) and not path.exists():
        raise SceneError(
            f"{shown(str(source))[1:-1]}: no such file; a scene of the catalogue {unknown(str(source), files)}"
        )
    return overridden(_found(read_toml(path), path.parent), overrides)


def load_from(folder: Path, source: str, overrides: Sequence[str] = ()) -> Sensor:
    """Read a sensor from a scene file in the folder of a file that names it, or else as `load_sensor` does."""
    place = folder / source
    return load_sensor(place if place.is_file() else source, overrides)


def _found(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return a scene's tables with mesh paths, relative to the scene's folder, made absolute."""
    for key in ("target", "elastomer"):
        part = table.get(key)
        if isinstance(part, dict) and isinstance(part.get("mesh"), str):
            table = table | {key: part | {"mesh": str((folder / part["mesh"]).resolve())}}
    return table


def changed(sensor: Sensor, overrides: Sequence[str]) -> Sensor:
    """Return a copy of `sensor` with keys changed, such as ``'elastomer.thickness="3 mm"'``.

    Errors as `load_sensor`.
    """
    return sensor_from(overridden(scene_table(sensor), overrides), sensor.name)


def scene_table(sensor: Sensor) -> dict[str, Any]:
    """Return the scene's tables without unset keys."""
    table = sensor.model_dump(exclude_none=True)
    target = table.get("target")
    if target is not None and target["load_height"] == target["thickness"]:
        del target["load_height"]
    _drop_usual(table)
    if sensor.temperature == REFERENCE:
        del table["temperature"]
    layer, plate = sensor.elastomer, sensor.target
    if layer is not None and plate is not None and layer.kind == "pillars" and layer.extent == plate.extent:
        del table["elastomer"]["width"], table["elastomer"]["length"]
    return {key: item for key, item in table.items() if item != ()}


def _drop_usual(table: dict[str, Any]) -> None:
    """Leave out the keys of parts that need not be given: those with their usual values."""
    for part, usual in _UNSAID.items():
        own = table.get(part, {})
        for each in own if isinstance(own, tuple) else (own, *own.get("layers", ())):
            for key in [key for key, value in usual.items() if each.get(key) == value]:
                del each[key]


def key_unit(key: str) -> str:
    """Return the SI unit of a dotted key by the schema of its part, "" where it has none."""
    steps = key.split(".")
    schema = _PARTS.get(steps[0] if len(steps) > 1 else "", Sensor).model_json_schema()
    found = re.search(r'"x-unit": "([^"]+)"', json.dumps(schema["properties"].get(steps[-1])))
    return "" if found is None or found[1] == "1" else found[1]


def scene_text(sensor: Sensor) -> str:
    """Return the scene file of `sensor`: TOML in SI numbers that `load_sensor` reads back to an equal sensor."""
    return written(scene_table(sensor))


def scene_hash(sensor: Sensor) -> str:
    """Return sixteen hexadecimal digits that identify the whole scene, and what the file of a layer's mesh holds."""
    layer, found = sensor.elastomer, hashlib.sha256(scene_text(sensor).encode())
    if layer is not None and layer.mesh is not None and Path(layer.mesh).is_file():
        found.update(Path(layer.mesh).read_bytes())
    return found.hexdigest()[:16]


def provenance(sensor: Sensor) -> dict[str, str]:
    """Return the attributes by which a table names its scene and the version that made it."""
    text = {"scene": scene_text(sensor), "scene_hash": scene_hash(sensor)}
    return text | {"version": __version__, "name": sensor.name}


def check_provenance(sensor: Sensor, attributes: Mapping[str, Any]) -> None:
    """Refuse the attributes of a table of another sensor; how it is read, and what is known of it, may be another.

    So may the silicone: its rate, history and scatter are not in a table of slow loads.
    """
    if attributes.get("scene_hash") in (None, scene_hash(sensor)) or "scene" not in attributes:
        return
    own, other = (tomllib.loads(text) for text in (scene_text(sensor), str(attributes["scene"])))
    for each in (own, other):
        for made in (pad := each.get("elastomer", {}), *pad.get("layers", ()), each.get("cover", {})):
            made.pop("material", None)
    for part in ("frequency", "coils", "target", "elastomer", "cover", "conductors", "touch"):
        if own.get(part) != other.get(part):
            name = attributes.get("name", "another")
            raise SceneError(f"table: must be of {sensor.name}; its {part} differs: it is of {name}")


@checked_arguments
def save_sensor(sensor: Sensor, path: str | Path) -> None:
    """Write the scene file of `sensor`, whole or not at all.

    Parameters
    ----------
    sensor : Sensor
        What to write.
    path : str or Path
        The file; its folder must exist.

    Raises
    ------
    SceneError
        When it cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> sensor = sm.load_sensor("biorob2018", ['elastomer.thickness="3 mm"'])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sm.save_sensor(sensor, Path(folder) / "thick.toml")
    ...     sm.load_sensor(Path(folder) / "thick.toml") == sensor
    True
    """
    write_text(Path(path), scene_text(sensor))
