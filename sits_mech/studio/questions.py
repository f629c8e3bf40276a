"""What the studio asks its solving process: loads that a pad bears, tables, their slopes, figures of merit, searches.

Tables and slopes are kept between runs where the command line keeps what it prepares (disk_cache.py).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from sits_mech.disk_cache import kept
from sits_mech.quantities import WRENCH
from sits_mech.scene.sensor import Sensor, scene_hash, scene_text
from sits_mech.store import read_table, save_table

if TYPE_CHECKING:
    import xarray as xr

    from sits_mech.synthesis.required.requirements import Requirements

_ACROSS = 5  # loads along each force of the studio's table
Report = Callable[..., None]
"""Called with how far an answer is: done, of how many, and where there are some, words."""


@dataclass(frozen=True)
class StudioQuestion(ABC):
    """A scene under loads, by models: mechanical and magnetic one, tolerance of the signals."""

    sensor: Sensor
    loads: tuple[tuple[str, tuple[float, ...]], ...]
    models: tuple[str, str, float]

    @property
    def key(self) -> tuple[Any, ...]:
        """What tells it from others."""
        return type(self).__name__, scene_hash(self.sensor), self.loads, self.models, *self._more

    @property
    def _more(self) -> tuple[Any, ...]:
        """What else tells it from others of its kind."""
        return ()

    @property
    def _options(self) -> dict[str, Any]:
        """The models as arguments."""
        return dict(zip(("mechanics", "magnetics", "tolerance"), self.models, strict=True))

    @abstractmethod
    def answer(self, report: Report) -> Any:
        """Return the answer."""


class Borne(StudioQuestion):
    """Which of the loads that `calibrate` takes by default does the pad bear? Of no loads; answers with ranges."""

    def answer(self, report: Report) -> dict[str, tuple[float, float]]:
        """Return the ends of their ranges."""
        from sits_mech.analysis.envelope import borne_share
        from sits_mech.quantities import Wrench
        from sits_mech.scene.parts.coils import usual_loads

        most = usual_loads(self.sensor.coils, slides=self.sensor.slides)
        share = borne_share(self.sensor, Wrench(**most), self.models[0])
        return {name: ends_to(name, share * size) for name, size in most.items()}


class TableQuestion(StudioQuestion):
    """What does the sensor show?"""

    def answer(self, report: Report) -> xr.Dataset:
        """Return the table of `calibrate`."""
        from sits_mech.chain.calibrate import calibrate

        axes: dict[str, Any] = {name: list(values) for name, values in self.loads}
        return _kept(self, lambda: calibrate(self.sensor, **axes, **self._options, progress=report))


@dataclass(frozen=True)
class SlopesQuestion(StudioQuestion):
    """How does that change with numbers of the scene?"""

    numbers: tuple[str, ...]

    @property
    def _more(self) -> tuple[Any, ...]:
        """The numbers."""
        return self.numbers

    def answer(self, report: Report) -> xr.Dataset:
        """Return the derivatives."""
        from sits_mech.chain.derivatives.gradient_grid import gradient_on_grid

        return _kept(self, lambda: gradient_on_grid(self.sensor, self.numbers, dict(self.loads), **self._options))


@dataclass(frozen=True)
class Figures(StudioQuestion):
    """What are its figures of merit, by the loads of requirements?"""

    asked: Requirements

    @property
    def _more(self) -> tuple[Any, ...]:
        """What is required, of whatever scene."""
        asked = self.asked
        return str((asked.loads, asked.overload, asked.limits, asked.tolerance, asked.minimised, asked.least_yield)),

    def answer(self, report: Report) -> Any:
        """Return task and answer, as `design` solves one of its designs."""
        from sits_mech.synthesis.required.space import Design, Space
        from sits_mech.synthesis.solved.solve import Solver

        asked = replace(self.asked, scene=scene_text(self.sensor), space=Space(self.sensor, (), {}))
        solver = Solver(asked, self.models[2])
        return solver.task, solver.answered(Design((), ()))


@dataclass(frozen=True)
class SearchQuestion(StudioQuestion):
    """Which sensor holds requirements best? What was solved stands in a folder, for when it is stopped."""

    asked: Requirements
    folder: Path

    @property
    def _more(self) -> tuple[Any, ...]:
        """The requirements."""
        return self.asked.identity,

    def answer(self, report: Report) -> Any:
        """Return the answer of `design`."""
        from sits_mech.synthesis.run import design

        return design(self.asked, folder=self.folder, report=report)


def ends_to(name: str, most: float) -> tuple[float, float]:
    """Return the range of a force up to its largest: shear to both sides."""
    return 0.0 if name == "F_z" else -most, most


def ends_asked(asked: Mapping[str, str]) -> dict[str, tuple[float, float]]:
    """Return the ranges of loads that an address names, or by its largest load."""
    found = {}
    for name in filter(asked.get, WRENCH):
        with suppress(ValueError):
            text = asked[name]
            low, high = map(float, text.split(":")) if ":" in text else ends_to(name, float(text))
            if -np.inf < low < high < np.inf:
                found[name] = low, high
    return found


def grid_of(low: float, high: float) -> tuple[float, ...]:
    """Return the values of a force over its range."""
    return tuple(np.linspace(low, high, _ACROSS).tolist())


def _kept(question: StudioQuestion, make: Callable[[], xr.Dataset]) -> xr.Dataset:
    """Return a dataset that was made before, or make and keep it."""

    def pack(data: xr.Dataset) -> Mapping[str, Any]:
        """Return it as the bytes of its file."""
        with TemporaryDirectory() as folder:
            save_table(data, Path(folder) / "table.nc")
            return {"table": np.fromfile(Path(folder) / "table.nc", dtype=np.uint8)}

    def unpack(arrays: Mapping[str, Any]) -> xr.Dataset:
        """Return it from them."""
        with TemporaryDirectory() as folder:
            arrays["table"].tofile(Path(folder) / "table.nc")
            return read_table(Path(folder) / "table.nc")

    return kept(("studio", question.key), make, pack, unpack, __name__)
