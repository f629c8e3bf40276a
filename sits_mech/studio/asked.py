"""What is required of a scene: its figures beside their limits, as rows and as lines over the explorer."""

from __future__ import annotations

import html
import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.readings.bench import table_inductances
from sits_mech.quantities import UNITS, Array, tensor_grid
from sits_mech.readout.loads import request_of, several, varied
from sits_mech.report.page.explorer import RequiredLines
from sits_mech.scene.sensor import SceneError, Sensor
from sits_mech.synthesis.answer import Figure, Share, figures_of, made_share
from sits_mech.synthesis.required.kinds import kind_of, shown_as
from sits_mech.synthesis.required.requirements import Requirements, requirements_of
from sits_mech.synthesis.required.space import Design, size_of
from sits_mech.synthesis.solved.answered import Answered, Task
from sits_mech.synthesis.solved.figures import Judge, Table
from sits_mech.synthesis.solved.loads import Loads, Operator
from sits_mech.synthesis.solved.solve import Solver, figure_errors

_WIDEST = 1.5  # of a limit: what a bar is cut at
_ROW = '<tr class="{kind}"><td>{name}</td><td>{value}</td><td>{limit}</td><td>{bar}</td><td>{holds}</td></tr>'
_BAR = (
    '<svg viewBox="0 0 150 12" width="150" height="12" role="img" aria-label="{words}"><rect y="2" width="{size:.1f}" '
    'height="8" fill="{colour}"/><line x1="{low:.1f}" x2="{high:.1f}" y1="6" y2="6" stroke="#16213a"/>'
    '<line x1="100" x2="100" y1="0" y2="12" stroke="#c0392b" stroke-width="2"/></svg>'
)
_COLOURS = {"yes": "#2f9e6e", "no": "#c0392b"}
_OPEN = "#f5a623"


def read_asked(text: str, sensor: Sensor) -> Requirements:
    """Return the requirements of a file's text for the scene that is shown; SceneError for anything wrong."""
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"requirements: must be TOML; got: {error}") from None
    return requirements_of({key: part for key, part in table.items() if key != "scene"}, sensor=sensor)


def first_words(ends: dict[str, tuple[float, float]], sensor: Sensor) -> str:
    """Return requirements to begin with, as text: loads that are shown, a pad from half to twice of its thickness."""
    loads = "".join('{0} = ["{2:g} {1}", "{3:g} {1}"]\n'.format(name, UNITS[name], *ends[name]) for name in ends)
    thick = 0.0 if sensor.elastomer is None else 1e3 * sensor.elastomer.thickness
    resolution = ", ".join(f'{name} = "{"10 m" if UNITS[name] == "N" else "0.1 m"}{UNITS[name]}"' for name in ends)
    error = ", ".join(f'{name} = "5 %"' for name in ends)
    return (
        f"[loads]\n{loads}[vary]\n"
        f'"elastomer.thickness" = {{ from = "{0.5 * thick:.3g} mm", to = "{2.0 * thick:.3g} mm" }}\n'
        f'[require]\nresolution = {{ {resolution} }}\nerror = {{ {error} }}\n'
        f'height = "{2e3 * size_of(sensor)["height"]:.2g} mm"\n'
        '[tolerance]\n"elastomer.thickness" = "0.05 mm"\nmodulus = "5 %"\n[goal]\n'
        f'minimise = "error.{next(reversed(ends))}"\n'
    )


@dataclass(frozen=True)
class Judged:
    """A scene's figures, by a table alone (no error by tolerances, drift, strain) or solved as `design` does."""

    solved: bool
    asked: Requirements
    task: Task
    found: Answered

    @property
    def rows(self) -> tuple[Figure, ...]:
        """The figures with their limits, those that have one first."""
        rows = [each for each in figures_of(self.task, self.found) if self.solved or not each.name.startswith("error.")]
        return tuple(sorted(rows, key=lambda each: each.limit is None))

    @property
    def share(self) -> Share:
        """The share of the sensors made that hold every limit."""
        return made_share(self.task, self.found)


def glanced(asked: Requirements, sensor: Sensor, data: xr.Dataset, like: Judged | None = None) -> Judged | None:
    """Return the figures that a table gives, of a preview by those of its base; None where there are none."""
    try:
        return Judged(False, asked, *at_a_glance(asked, sensor, data, None if like is None else like.found))
    except (ValueError, ArithmeticError):
        return None


def lines(judged: Judged, sensor: Sensor, data: xr.Dataset) -> RequiredLines:
    """Return the requirements as lines over the explorer of a table."""
    asked, own = judged.asked, size_of(sensor)
    top = 0.0 if sensor.elastomer is None else sensor.elastomer.standoff + sensor.elastomer.thickness
    top += 0.0 if sensor.target is None else sensor.target.thickness
    height = asked.limits.get("height")
    return RequiredLines(asked.loads, None if height is None else top - own["height"] + height, _curves(judged, data))


def _curves(judged: Judged, data: xr.Dataset) -> list[dict[str, Any]]:
    """Return resolution and error over the loads of a table, those that have a limit."""
    table, judge, names = judged.found.table, judged.task.judge, varied(data)
    order, found = judge.operator.loads.names, []
    if table is None or not set(order) <= set(names):
        return []
    grid = tensor_grid(*(data[name].to_numpy() for name in names))
    points = grid.reshape(-1, len(names))[:, [names.index(name) for name in order]]
    low, high = np.array([axis[[0, -1]] for axis in judge.operator.loads.axes]).T
    inside = np.all((points >= low - 1e-9) & (points <= high + 1e-9), axis=1)
    resolution, error = judge.over_loads(table, points)
    each = {"resolution": resolution} | ({"error": error / judge.operator.loads.span} if judged.solved else {})
    for kind, values in each.items():
        for k, name in enumerate(order):
            limit = judged.asked.limits.get(f"{kind}.{name}")
            if limit is not None:
                own = np.where(inside, values[:, k], np.nan).reshape(grid.shape[:-1])
                found.append(_item(f"{kind}.{name}", name, own, limit))
    return found


def _item(figure: str, along: str, values: Array, limit: float) -> dict[str, Any]:
    """Return a curve of the explorer."""
    unit, scale = shown_as(figure)
    kind = figure.partition(".")[0]
    return {
        "name": figure.replace(".", "_"), "label": f"{kind} of {along}", "scale": scale, "digits": 3, "unit": unit,
        "values": values, "along": along, "limit": limit,
    }


def rows_html(judged: Judged) -> str:
    """Return the figures as a table: value with error, limit, a bar whose line is the limit, whether it holds."""
    rows, least = [_row(each, judged.solved) for each in judged.rows], judged.asked.least_yield
    share = judged.share.value if judged.solved else np.nan
    if np.isfinite(share):
        held, (now, limit) = "yes" if share >= least else "no", (f"{100.0 * each:.3g} %" for each in (share, least))
        name = "sensors that hold all"
        rows.append(_ROW.format(kind=held, name=name, value=now, limit=f"at least {limit}", bar="", holds=held))
    if judged.found.reason:
        rows.append(f'<tr class="no"><td colspan="5">{html.escape(judged.found.reason)}</td></tr>')
    head = "<tr><th>figure</th><th>now</th><th>limit</th><th></th><th>holds</th></tr>"
    return f'<table class="sits-asked {"solved" if judged.solved else "preview"}">{head}{"".join(rows)}</table>'


def _row(each: Figure, solved: bool) -> str:
    """Return the row of a figure."""
    value, unit = f"{each.value:.3g}", f" {each.unit}" if each.unit else ""
    value += f" ± {each.error:.2g}{unit}" if np.isfinite(each.error) and each.error > 0.0 else unit
    name = html.escape(kind_of(each.name).title or each.name.replace(".", " of "))
    if each.limit is None:
        return _ROW.format(kind="", name=name, value=value, limit="", bar="", holds="")
    least, size = kind_of(each.name).least, each.value / each.limit
    spare = 100.0 * ((size - 1.0) if least else (1.0 - size))
    limit = f"{'at least' if least else 'at most'} {each.limit:.3g}{unit}"
    words = each.holds if each.holds not in _COLOURS else f"{each.holds}, {spare:+.0f} %"
    bar = _bar(size, np.nan_to_num(each.error / each.limit), _COLOURS.get(each.holds if solved else "", _OPEN))
    return _ROW.format(kind=each.holds, name=name, value=value, limit=limit, bar=bar, holds=words)


def _bar(size: float, error: float, colour: str) -> str:
    """Return the bar of a figure over its limit, with its error."""
    ends = [100.0 * min(max(share, 0.0), _WIDEST) for share in (size, size - error, size + error)]
    part = f"{100.0 * size:.3g} % of the limit"
    return _BAR.format(size=ends[0], low=ends[1], high=ends[2], colour=colour, words=part)


def at_a_glance(
    asked: Requirements, sensor: Sensor, data: xr.Dataset, like: Answered | None = None
) -> tuple[Task, Answered]:
    """Return what a table over any grid of loads tells of a sensor's figures, without tolerances and overload.

    The task is that of the limits, figures are of the table's loads. Noise and rate are those of a sensor that is
    `like` it, where one is given, and errors are left out. Raises ValueError where a load has no result.
    """
    loads = Loads(several(data), tuple(data[name].to_numpy() for name in several(data)))
    L = table_inductances(sensor, data)["L"].transpose(*varied(data), "coil").to_numpy().reshape(-1, len(sensor.coils))
    if not np.isfinite(L).all():
        raise ValueError("loads: every one must have a result for figures of merit")
    solver, none = Solver(asked, float(request_of(data)["tolerance"])), np.zeros((0, *L.shape))
    judge = Judge(Operator(loads), np.zeros(0), asked.limits, asked.least_yield)
    if like is None or like.table is None:
        own, repeated, rate = solver.converter(sensor, data)
        table = Table(L, none, np.hypot(own, repeated))
        known = figure_errors(sensor, data, judge, table)
    else:
        table, rate, known = Table(L, none, like.table.noise), like.plain["rate"], {}
    task = Task(judge, asked.limits, asked.minimised)
    plain = size_of(sensor) | {"rate": rate}
    return task, Answered(Design((), ()), "", table, none, plain, {}, known)
