"""Define what commands have in common: the app, the kinds of their options, how a scene or a pose is written."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from sits_mech.cli.console import warn
from sits_mech.disk_cache import keep_nothing
from sits_mech.memory import MEMORY, SECONDS
from sits_mech.plugins import plugged
from sits_mech.units import SceneError, checked_tolerance, quantity, quantity_or_range, quantity_range, si_value
from sits_mech.version import __version__

if TYPE_CHECKING:
    from sits_mech.mechanics.depth import TouchLoad
    from sits_mech.quantities import Pose, Wrench
    from sits_mech.scene.sensor import Sensor

_LINES = 5  # slips of a scene, one line each; of more, their number
app = App(
    name="sits-mech", version=__version__, suppress_keyboard_interrupt=False,
    help="Force in, inductance out: soft inductive tactile sensors. With --quiet a command tells errors alone, with -v "
         "what it solves, step by step; --log FILE writes these steps with their times.",
)
app.register_install_completion_command(help="Install completion of commands and options in this shell.")


def flag(help: str) -> Parameter:
    """Return an option without value that has no opposite."""
    return Parameter(negative="", help=help)


def output_of(help: str) -> Parameter:
    """Return the option of where a result goes."""
    return Parameter(name=["--output", "-o"], help=help)


Quantity = Annotated[str, Parameter(allow_leading_hyphen=True)]
Scene = Annotated[str, Parameter(help="Path of a scene file, or name of a catalogued sensor.")]
Folder = Annotated[Path, Parameter(help="Folder of a calibration (sits-mech calibrate -o FOLDER).")]
Case = Annotated[int | None, Parameter(help="For the folder of a sweep: number of the case in its table.")]
Frequency = Annotated[str, Parameter(allow_leading_hyphen=True, help='One frequency, or a range "first:last:count".')]
Ratio = Annotated[float, Parameter(converter=lambda _, tokens: si_value(tokens[0].value, ""))]
Tolerance = Annotated[Ratio, Parameter(help='Requested relative error, 0.01 or "1 %".')]
Best = Annotated[bool, Parameter(help="Whether to take the smallest error within reach where the tolerance is not.")]
Accept = Annotated[bool, flag("Exit code 0 also for answers above the tolerance or beyond the data.")]
_OTHERS = {half: tuple(entry.name for entry in plugged(half)) for half in ("mechanics", "magnetics")}
MECHANICS = ("auto", "closed-form", "linear", "planar", "axisymmetric", "block", *_OTHERS["mechanics"])
MAGNETICS = ("auto", "axisymmetric", "planar", "sheets", "axisymmetric-fem", "planar-fem", *_OTHERS["magnetics"])
# where one physics is meant, --model says the same
Mechanics = Annotated[str, Parameter(name=["--mechanics", "--model"], help=", ".join(MECHANICS))]
Magnetics = Annotated[str, Parameter(name=["--magnetics", "--model"], help=", ".join(MAGNETICS))]
Clock = Annotated[Quantity | None, Parameter(help="External clock of the codes; the part's largest.")]
Idle = Annotated[
    Literal["open", "shorted", "live"] | None,
    Parameter(help="What the other coils are while one is read; by default as the scene says."),
]
Warmth = Annotated[Quantity | None, Parameter(help="Temperature of all parts; by default the scene's (20 degC).")]
Warmths = Annotated[Quantity | None, Parameter(help='Of all parts: one temperature, or a range "first:last:count".')]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]
Output = Annotated[Path | None, output_of("File or folder to write.")]
Picture = Annotated[Path | None, Parameter(help="Picture to write: .png, .pdf or .svg.")]
Fx = Annotated[Quantity, Parameter(help="Shear force, along +x.")]
Fy = Annotated[Quantity, Parameter(help="Shear force, along +y.")]
Fz = Annotated[Quantity, Parameter(help="Normal force, pressing down.")]
Mx = Annotated[Quantity, Parameter(help="Moment about the x axis, right-handed.")]
Moment = Annotated[Quantity, Parameter(help="Moment about the y axis; positive lifts the left edge.")]
Mz = Annotated[Quantity, Parameter(help="Moment about the z axis, right-handed.")]


@Parameter(name="*")
@dataclass(frozen=True)
class Overrides:
    """What a command changes in its scene."""

    keys: Annotated[
        tuple[str, ...], Parameter(name="--set", negative="", help='Change a key of the scene: target.width="15 mm".')
    ] = ()
    weld: Annotated[bool, flag("Merge duplicated nodes of elastomer.mesh, which would cut it.")] = False
    memory: Annotated[
        float | None, Parameter(help="Memory limit of a solution in GiB; SITS_MECH_MEMORY or 4 by default.")
    ] = None
    seconds: Annotated[
        float | None, Parameter(help="Time limit of a step in seconds; SITS_MECH_SECONDS or 200 by default.")
    ] = None
    no_cache: Annotated[bool, flag("Neither read nor write the cache of prepared plates (sits-mech doctor).")] = False
    strict: Annotated[bool, flag("Refuse implausible values too, such as a layer 2 m thick.")] = False
    si: Annotated[bool, flag("Take lengths without a unit as metres.")] = False

    def note(self, where: str, lines: Sequence[str]) -> None:
        """Say on stderr what is implausible, or refuse it; raise SceneError with the first line then."""
        if lines and self.strict:
            raise SceneError(f"{where}: {lines[0]}")
        for line in lines[:_LINES]:
            warn(f"{where}: {line}")
        if len(lines) > _LINES:
            warn(f"{where}: implausible: {len(lines) - _LINES} more numbers")

    def check_bare(self, options: Sequence[str]) -> None:
        """Refuse options of the command line that give a length without a unit, unless asked for SI."""
        if options and not self.si:
            raise SceneError(f'{options[0]}: must be a length with a unit, such as "2 mm"; --si takes it as metres')

    @property
    def all(self) -> tuple[str, ...]:
        """The keys with their values; the limits of memory and time, and what is kept, hold from here on."""
        if self.no_cache:
            keep_nothing()
        if self.seconds is not None:
            SECONDS.set(self.seconds)
        if self.memory is not None:
            MEMORY.set(self.memory)
        return (*self.keys, *(("elastomer.weld=true",) if self.weld else ()))


@Parameter(name="*")
@dataclass(frozen=True)
class Load:
    """The load on the target, or of what touches it; with F_y, M_x or M_z the pad is solved whole, in space."""

    fx: Fx = "0 N"
    fy: Fy = "0 N"
    fz: Fz = "0 N"
    mx: Mx = "0 N*m"
    moment: Moment = "0 N*m"
    mz: Mz = "0 N*m"

    def wrench(self, sensor: Sensor | None = None) -> Wrench:
        """Return the load in SI; where none was written, the force of a scene's touch, which must not be a depth."""
        from sits_mech.quantities import LOAD_ARGUMENTS, Wrench

        touch = None if self != Load() or sensor is None else sensor.touch
        if touch is not None and (touch.force or touch.depth) is not None:
            from sits_mech.mechanics.touch import check_force

            check_force(touch, "a command that takes a force")
            return Wrench(F_z=touch.force or 0.0)
        return Wrench(**_in_si(self, LOAD_ARGUMENTS, quantity))

    def solved(
        self, sensor: Sensor, mechanics: str = "auto", tolerance: float = 1e-2, *, rough: bool = False
    ) -> TouchLoad:
        """Return the load in SI; where none was written that of a scene's touch, to whose depth a force is solved."""
        plain = self != Load() or sensor.touch is None or sensor.touch.depth is None
        wrench = self.wrench(sensor if plain else None)
        check_request(sensor, vars(wrench), tolerance, mechanics=mechanics)
        if plain:
            from sits_mech.mechanics.depth import TouchLoad

            return TouchLoad(wrench)

        from sits_mech.chain.pressing import touch_load
        from sits_mech.cli.console import announcing

        warn("touch.depth: the force that leads to it is solved first")
        with announcing():
            return touch_load(sensor, mechanics=mechanics, tolerance=tolerance, rough=rough)


@Parameter(name="*")
@dataclass(frozen=True)
class Way:
    """Where the load passes on its way from rest; by default it grows straight."""

    via: Annotated[
        tuple[str, ...], Parameter(negative="", help='With elastomer.friction: load on the way, "fz=4 N, fx=0 N".')
    ] = ()

    def loads(self) -> list[Wrench]:
        """Return the loads in SI, in their order; components that are not written are zero."""
        return [_written_load(text) for text in self.via]


@Parameter(name="*")
@dataclass(frozen=True)
class LoadGrid:
    """The loads of a grid; each one quantity, the same for all, or a range "first:last:count"."""

    fx: Annotated[Quantity | None, Parameter(help="Shear force, along +x; up to -1 N:1 N:9.")] = None
    fy: Annotated[Quantity | None, Parameter(help="Along +y; by default only if all coils lie along y.")] = None
    fz: Annotated[Quantity | None, Parameter(help="Normal force, pressing; up to 0 N:4 N:9.")] = None
    mx: Mx = "0 N*m"
    moment: Moment = "0 N*m"
    mz: Mz = "0 N*m"
    touch: Annotated[
        str | None, Parameter(help="Places of the scene's touch, \"x=-2 mm:2 mm:5, y=0 mm\"; its own by default.")
    ] = None

    def components(self, sensor: Sensor) -> dict[str, Any]:
        """Return the components in SI that are not zero, ranges as lists of values.

        By default those that the coils resolve: no shear along an axis on which all have one place.
        """
        from sits_mech.quantities import LOAD_ARGUMENTS
        from sits_mech.scene.parts.coils import usual_loads

        usual = usual_loads(sensor.coils, slides=sensor.slides)
        if self.fx is not None:
            usual.pop("F_y", None)
        ranges = {f"f{name[2]}": f"{0.0 if name == 'F_z' else -most} N:{most} N:9" for name, most in usual.items()}
        left = {name: text for name, text in ranges.items() if getattr(self, name) is None}
        found = _in_si(replace(self, **left), LOAD_ARGUMENTS, quantity_or_range)
        found = {name: values for name, values in found.items() if values != 0.0}
        if self.touch is None:
            return found
        must = 'places such as "x=-2 mm:2 mm:5, y=0 mm", each once'
        pairs = _pairs("--touch", self.touch, ("x", "y"), must)
        if len(dict(pairs)) < len(pairs):
            raise SceneError(f"--touch: must be {must}; got {self.touch!r}")
        return found | {f"touch_{name}": quantity_or_range(value, "m", f"--touch {name}") for name, value in pairs}

    def borne(self, sensor: Sensor, components: Mapping[str, Any], mechanics: str) -> dict[str, Any]:
        """Return the components; where none was given, all of them smaller until the pad bears them."""
        if self != LoadGrid():
            return dict(components)
        from sits_mech.analysis.envelope import borne_share
        from sits_mech.quantities import Wrench
        from sits_mech.readout.loads import load_words

        corner = {name: max(values) for name, values in components.items()}
        share = borne_share(sensor, Wrench(**corner), mechanics)
        if share < 1.0:
            words = load_words({name: share * value for name, value in corner.items()})
            warn(f"loads: up to {words} by default: larger loads are beyond the limits of the pad (sits-mech envelope)")
        return {name: [share * value for value in values] for name, values in components.items()}


@Parameter(name="*")
@dataclass(frozen=True)
class Place:
    """A pose of the target, instead of a load; what is not given is zero."""

    dv: Annotated[Quantity | None, Parameter(help="Height of the target's bottom face above the coils.")] = None
    dh: Annotated[Quantity | None, Parameter(help="Displacement of the target's centre along x.")] = None
    dy: Annotated[Quantity | None, Parameter(help="Displacement along y.")] = None
    alpha: Annotated[Quantity | None, Parameter(help="Rotation about the y axis; positive lifts the left edge.")] = None
    alphax: Annotated[Quantity | None, Parameter(help="Rotation about the x axis, right-handed.")] = None
    alphaz: Annotated[Quantity | None, Parameter(help="Rotation about the z axis, right-handed.")] = None

    @property
    def given(self) -> bool:
        """Whether any of the options is there."""
        return self != Place()

    def pose(self) -> Pose:
        """Return the pose in SI; raise SceneError where the height is missing."""
        from sits_mech.quantities import POSE_ARGUMENTS, Pose

        if self.dv is None:
            raise SceneError("--dv: must be given for a pose of the target; it is missing")
        return Pose(**_in_si(self, POSE_ARGUMENTS, quantity))


@Parameter(name="*")
@dataclass(frozen=True)
class Models:
    """Which model takes each half, and to what error of the signals, over their full scale."""

    mechanics: Annotated[str, Parameter(help=", ".join(MECHANICS))] = "auto"
    magnetics: Annotated[str, Parameter(help=", ".join(MAGNETICS))] = "auto"
    tolerance: Annotated[Ratio, Parameter(help="Requested error of the signals, relative to full scale.")] = 1e-2


def _written_load(text: str) -> Wrench:
    """Return the load of ``--via "F_x=0 N, F_z=4 N"``, components by the names of their options or of a wrench."""
    from sits_mech.quantities import LOAD_ARGUMENTS, UNITS, Wrench

    names = {**LOAD_ARGUMENTS, **{name: name for name in LOAD_ARGUMENTS.values()}}
    found = {}
    for name, value in _pairs("--via", text, names, f'a load such as "fz=4 N, fx=0 N", of {", ".join(names)}'):
        if names[name] in found:
            raise SceneError(f"--via: must give {names[name]} once; got {text!r}")
        found[names[name]] = quantity(value, UNITS[names[name]], f"--via {name}")
    return Wrench(**found)


def _pairs(option: str, text: str, names: Collection[str], must: str) -> list[tuple[str, str]]:
    """Return names and values of "x=1 mm, y=2 mm"; refuse what has other names, and say what it must be."""
    pairs = [(name.strip(), value.strip()) for name, _, value in (part.partition("=") for part in text.split(","))]
    if any(not value or name not in names for name, value in pairs):
        raise SceneError(f"{option}: must be {must}; got {text!r}")
    return pairs


def _in_si(given: Any, arguments: Mapping[str, str], read: Callable[[str, str, str], Any]) -> dict[str, Any]:
    """Return the options of a load or a pose in SI by the names of its components, each as `read` takes it."""
    from sits_mech.quantities import UNITS

    written = {option: getattr(given, option) for option in arguments}
    return {
        name: 0.0 if written[option] is None else read(written[option], UNITS[name], f"--{option}")
        for option, name in arguments.items()
    }


def clock_of(text: str | None, part: str) -> float | None:
    """Return a clock [Hz]; "internal" is what the part's own oscillator is as a rule."""
    if text is None or text.strip().lower() != "internal":
        return si_of(text, "Hz", "--clock")
    from sits_mech.readout.converter import CONVERTERS

    own = CONVERTERS[part].internal if part in CONVERTERS else None
    if own is None:
        raise SceneError(f"--clock: must be a frequency, {part} has no oscillator of its own; got {text}")
    return own[1]


def si_of(text: str | None, unit: str, option: str) -> float | None:
    """Return the quantity of an option in SI, None where it is not there."""
    return None if text is None else quantity(text, unit, option)


def sensor_of(scene: str, overrides: Overrides, temperature: str | None = None) -> Sensor:
    """Return the scene a command is about, at one temperature; what is implausible is noted on stderr, or refused."""
    return sensors_of(scene, overrides, temperature, one=True)[0]


def sensors_of(scene: str, overrides: Overrides, temperature: str | None, *, one: bool = False) -> list[Sensor]:
    """Return the scene a command is about at each temperature that was written, its own by default."""
    from sits_mech.scene.plausible import bare_lengths, slips
    from sits_mech.scene.sensor import load_sensor, silicones_of
    from sits_mech.scene.thermal import at_each

    found = load_sensor(scene, overrides.all)
    overrides.check_bare([f"--set {each}" for each in bare_lengths(found, overrides.keys)])
    overrides.note(scene, slips(found))
    for made in silicones_of(found):
        if not made.name and made.spread:
            warn(f"{scene}: {made.source}: moduli of such silicones differ by a factor of {1.0 + made.spread:.2g}")
    if temperature is None:
        return at_each(found, [found.temperature])
    if one:
        return at_each(found, [quantity(temperature, "K", "--temperature")])
    return at_each(found, quantity_range(temperature, "K", "--temperature"))


def check_request(
    sensor: Sensor, loads: Mapping[str, Any], tolerance: float, mechanics: str = "auto", magnetics: str = "auto"
) -> None:
    """Refuse a load or a tolerance beyond any sense, and models that there are not, before solvers are imported."""
    from sits_mech.scene.materials import check_model
    from sits_mech.scene.plausible import check_loads

    for kind, name, known in (("mechanics", mechanics, MECHANICS), ("magnetics", magnetics, MAGNETICS)):
        check_model(kind, name, known)
    check_loads(sensor, loads)
    checked_tolerance(tolerance)


def check_readable(path: Path, what: str) -> None:
    """Refuse a file that cannot be read before what reads it is imported."""
    from sits_mech.memory import input_bytes

    input_bytes(path, what)


def pose_of(place: Place, overrides: Overrides) -> Pose:
    """Return the pose a command is about; what is implausible in it is noted on stderr, or refused."""
    from sits_mech.scene.plausible import is_bare, slips_of_pose

    lengths = (("dv", place.dv), ("dh", place.dh), ("dy", place.dy))
    overrides.check_bare([f"--{name} {text}" for name, text in lengths if is_bare(text)])
    found = place.pose()
    overrides.note("the pose", slips_of_pose(found))
    return found
