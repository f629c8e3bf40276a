"""Plot a design search: the front, the landscape with its feasible region, figures and limits.

Filled marks hold every limit, empty ones do not; the star is the recommended design, numbers are those of the front's
scenes, grey is beyond a limit. In the landscape pale is where predictions of the recommended choice are beyond one;
dots are designs that were solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from sits_mech.quantities import Array
from sits_mech.report.pictures.style import label_bar, new_figure, numbered_labels
from sits_mech.synthesis.answer import DesignAnswer
from sits_mech.synthesis.answer import Figure as Asked
from sits_mech.synthesis.around import Landscape
from sits_mech.synthesis.required.kinds import INVERSE, STRAIN, kind_of, shown_as
from sits_mech.synthesis.required.requirements import Requirements
from sits_mech.synthesis.solved.answered import Answered, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAR = 1.3  # of a limit: what bars are cut at


def design_pictures(asked: Requirements, found: DesignAnswer) -> dict[str, Callable[[], Figure]]:
    """Return what draws each picture of an answer, by name."""
    pictures: dict[str, Callable[[], Figure]] = {}
    if found.front and _drawn(found):
        pictures["front"] = lambda: front_picture(asked, found)
    if found.landscape is not None:
        land = found.landscape
        pictures["landscape"] = lambda: landscape_picture(found, land)
    if any(each.limit is not None for each in found.figures):
        pictures["limits"] = lambda: limits_picture(found)
    return pictures


def front_picture(asked: Requirements, found: DesignAnswer) -> Figure:
    """Return what is minimised first over the figure whose limit the best design is nearest to, of all designs."""
    task, (first, *others) = found.task, _drawn(found)
    near = task.excess(task.figures(found.best), None)
    other = max(others, key=lambda name: near.get(name, -np.inf), default=first)
    with new_figure(0.8) as (figure, (spot,)):
        _marks(spot, asked, found, (other, first))
        best = choice_words(asked, found.best.design.choice)
        figure.suptitle(f"{_star(found)}: {best}\nhollow: breaks a limit; grey: beyond one\nnumbers: files in front/")
        figure.legend(*spot.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _drawn(found: DesignAnswer) -> list[str]:
    """Return the figures that are asked for and known of the best design, the minimised first."""
    task = found.task
    known = set(task.figures(found.best)) - {STRAIN, INVERSE}
    return [name for name in {**task.minimised, **task.limits} if name in known]


def _marks(spot: Axes, asked: Requirements, found: DesignAnswer, names: tuple[str, str]) -> None:
    """Draw all solved designs in the plane of two figures, a colour for each choice of the lists."""
    from matplotlib.patheffects import withStroke

    task = found.task
    _draw_choices(spot, asked, found, names)
    spot.margins(0.15)
    places, marks = (_places(task, some, names) for some in (found.front, [e for e in found.known if e.carried]))
    ends = np.array([spot.get_xlim(), spot.get_ylim()])
    for numbers, (x, y) in numbered_labels(*((each - ends[:, 0]) / np.ptp(ends, axis=1) for each in (places, marks))):
        spot.annotate(
            ", ".join(map(str, numbers)), places[numbers[0] - 1], (3 * x, 3 * y), textcoords="offset points",
            fontsize=6, ha="left" if x > 0 else "right", va="bottom" if y > 0 else "top", zorder=4,
            path_effects=[withStroke(linewidth=1.5, foreground="white")],
        )
    dx, dy = ([shown_as(name)[1] * each.error.get(name, 0.0) for each in found.front] for name in names)
    spot.set(xlim=spot.get_xlim(), ylim=spot.get_ylim())  # by the designs, not by what is not known of them
    spot.errorbar(places[:, 0], places[:, 1], dy, dx, fmt="none", ecolor="0.4", elinewidth=0.7)
    spot.plot(*_places(task, [found.best], names).T, "k*", ms=10, mfc="none", label=_star(found))
    for name, way in zip(names, "vh", strict=True):
        if name in task.limits:
            limit = shown_as(name)[1] * task.limits[name]
            far = limit + 1e3 * kind_of(name).sign * abs(limit)
            getattr(spot, f"ax{way}span")(limit, far, color="0.5", alpha=0.2, lw=0.0)
    spot.set(xlabel=_label(names[0]), ylabel=_label(names[1]))


def _draw_choices(spot: Axes, asked: Requirements, found: DesignAnswer, names: tuple[str, str]) -> None:
    """Draw the designs of each choice of the lists, hollow where they break a limit; the legend names these limits."""
    task = found.task
    for number, choice in enumerate(dict.fromkeys(each.design.choice for each in found.known)):
        own = [each for each in found.known if each.design.choice == choice and each.carried]
        spot.plot([], [], f"C{number % 10}o", label=choice_words(asked, choice))
        for holds in (True, False):
            some = [each for each in own if task.holds(each) == holds]
            spot.plot(*_places(task, some, names).T, f"C{number % 10}o", mfc=None if holds else "w")
    if broken := _broken(found):
        spot.plot([], [], "ko", mfc="w", label=fill(f"breaks {', '.join(map(_words, broken))}", 30))


def _broken(found: DesignAnswer) -> list[str]:
    """Return the limits that solved designs break."""
    task = found.task
    excess = [task.excess(task.figures(each), each.table) for each in found.known if each.carried]
    return list(dict.fromkeys(name for each in excess for name in each if each[name] > 0.0))


def _places(task: Task, designs: Sequence[Answered], names: tuple[str, str]) -> Array:
    """Return designs (n, 2) in the plane of two figures, in their shown units."""
    found = [[shown_as(name)[1] * task.figures(each)[name] for name in names] for each in designs]
    return np.array(found).reshape(-1, 2)


def choice_words(asked: Requirements, choice: tuple[int, ...]) -> str:
    """Return a choice of the lists for a reader."""
    values = [str(values[k]) for values, k in zip(asked.space.lists.values(), choice, strict=True)]
    keys = [key.rpartition(".")[2] for key in asked.space.lists]
    each = (value if key == "material" else f"{key} {value}" for key, value in zip(keys, values, strict=True))
    return ", ".join(each) or "designs"


def _words(name: str) -> str:
    """Return a figure's name for a picture."""
    kind, _, part = name.partition(".")
    return f"{kind} ${part}$" if "_" in part else name.replace("_", " ").replace(".", " ")


def _label(name: str) -> str:
    """Return a figure with its unit, for an axis."""
    unit = shown_as(name)[0]
    return f"{_words(name)} [{unit}]" if unit else _words(name)


def landscape_picture(found: DesignAnswer, land: Landscape) -> Figure:
    """Return what is minimised over the first one or two variables, pale beyond a limit."""
    task, ends = found.task, [key.rpartition(".")[2] for key in land.names]
    names = [f"{key} [{unit}]" if unit else key for key, unit in zip(ends, land.units, strict=True)]
    scale, what = _objective_words(task)
    shown = land.objective * scale if task.minimised else land.excess
    own = [each for each in found.known if each.design.choice == found.best.design.choice and len(each.design.x)]
    words = f"{'dots: solved; ' if len(own) > 1 else ''}star: {_star(found)}"
    at, *solved = (
        [axis[0] + x * (axis[-1] - axis[0]) for axis, x in zip(land.axes, each.design.x, strict=False)]
        for each in (found.best, *own)
    )
    with new_figure(0.75) as (figure, (spot,)):
        if len(land.axes) == 1:
            spot.plot(land.axes[0], shown, "C0")
            spot.fill_between(
                land.axes[0], 0.0, 1.0, where=(land.excess <= 0.0).tolist(), color="C2", alpha=0.15,
                transform=spot.get_xaxis_transform(), label="every limit holds",
            )
            spot.set_xlim(land.axes[0][0], land.axes[0][-1])
            for x, form in [*((each[0], "k.") for each in solved), (at[0], "k*")]:
                y = float(np.interp(x, land.axes[0], shown))
                spot.plot([x], [y], form, ms=7 if form == "k*" else 3, clip_on=False)
            spot.set(xlabel=names[0], ylabel=what, title=f"by predictions; {words}")
            spot.legend()
            return figure
        levels = np.unique([float(f"{each:.3g}") for each in np.nanquantile(shown, np.linspace(0.02, 0.9, 10))])
        several = levels if len(levels) > 1 else 1
        bands = spot.contourf(*land.axes, shown.T, several, cmap="cividis_r", extend="both")
        label_bar(figure.colorbar(bands, ax=spot, ticks=bands.levels, format="%.3g"), fill(what, 40))
        spot.contourf(*land.axes, land.excess.T, levels=[0.0, np.inf], colors="w", alpha=0.6)
        spot.contour(*land.axes, land.excess.T, levels=[0.0], colors="C3", linewidths=1.2)
        spot.plot(*np.array([each[:2] for each in solved]).T, "ko", ms=3, mec="w", mew=0.5)
        spot.plot(at[:1], at[1:2], "k*", ms=9, mec="w", mew=0.5, clip_on=False, zorder=3)
        spot.set(xlabel=names[0], ylabel=names[1])
        figure.suptitle(fill(f"pale: beyond a limit; white: not known; {words}", 56))
    return figure


def _star(found: DesignAnswer) -> str:
    """Return what the starred design is."""
    return "recommended" if found.feasible else "nearest"


def _objective_words(task: Task) -> tuple[float, str]:
    """Return scale and label of the minimised figure; a sum of several is relative."""
    weights = task.minimised
    if len(weights) != 1:
        each = (_words(name) if weight == 1.0 else f"{weight:g} {_words(name)}" for name, weight in weights.items())
        what = " + ".join(each)
        return 1.0, f"{what}, relative" if what else "largest excess over a limit [-]"
    name, weight = next(iter(weights.items()))
    return kind_of(name).sign * task.scale(name) / weight * shown_as(name)[1], _label(name)


def _draw_limit(spot: Axes, number: int, each: Asked) -> None:
    """Draw a figure over its limit as a bar with its error, and both in words."""
    limit = each.limit or 1.0
    share, sign = (limit / each.value, "\u2265") if kind_of(each.name).least else (each.value / limit, "\u2264")
    error = 0.0 if np.isnan(each.error) else share * each.error / max(abs(each.value), 1e-300)
    spot.barh(number, min(share, _BAR), xerr=error, color="C2" if share <= 1.0 else "C3", error_kw={"lw": 0.8})
    words = f"{each.value:.3g} {sign} {each.limit:.3g} {each.unit}"
    spot.text(_BAR + 0.05, number, words, va="center", fontsize=6)


def limits_picture(found: DesignAnswer) -> Figure:
    """Return each figure over its limit with its error, and the share of the sensors made that hold each limit."""
    rows, shares = [each for each in found.figures if each.limit], dict(found.held)
    if not np.isnan(found.share.value):
        shares["all limits"] = found.share.value
    heights = [len(rows) + 1.0] + ([len(shares) + 1.0] if shares else [])
    with new_figure(0.09 * (sum(heights) + 2.5), 1, len(heights), shares=heights) as (figure, (spot, *others)):
        for number, each in enumerate(rows):
            _draw_limit(spot, number, each)
        spot.axvline(1.0, color="k", lw=0.8)
        spot.set(yticks=range(len(rows)), yticklabels=[_short(each.name) for each in rows], xlim=(0.0, 2.3))
        spot.set(xlabel="figure over its limit [-]", title="lines on bars: estimated error")
        spot.invert_yaxis()
        for other in others:
            other.barh(range(len(shares)), [100.0 * each for each in shares.values()], color="C0")
            other.set(yticks=range(len(shares)), yticklabels=[_short(name) for name in shares], xlim=(0.0, 100.0))
            other.axvline(100.0 * found.task.judge.share, color="k", lw=0.8, ls="--")
            other.set(xlabel="sensors made that hold it [%]", title="dashed: asked")
            other.invert_yaxis()
    return figure


def _short(name: str) -> str:
    """Return a figure's name beside a bar."""
    return {INVERSE: "loads with an inverse", "crosstalk_before_inverse": "crosstalk"}.get(name, _words(name))
