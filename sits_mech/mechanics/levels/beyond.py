"""Refuse a load far beyond what a layer carries, or far beyond the data of its silicone, by the first level alone.

Strains e = stretch - 1 of a solid are less on its first level than on finer ones: where three levels are at the end e_d
of the data, the first is at 0.53 to 0.83 of it (the ten rays of `biorob2018` and `biorob2018-w15`,
analysis/envelope.py); of a section at 0.94 to 1.07. So the largest load within the data lies between those under which
the first level has the strains

    0.5 e_d and 0.85 e_d,    or 0.9 e_d and 1.1 e_d,        e ~ load^p  between them, p as two loads tried show it.

A load under which the first level is beyond 2 e_d, two to three times that largest one, is refused; loads in between
are answered, and called beyond data. So is one of which it carries less than half, where the second level could not say
in a moment how much it carries. Both only where the families with contact, if faces touch, say the same.
"""

from __future__ import annotations

import math

import numpy as np

from sits_mech.mechanics.equilibrium.control import Control
from sits_mech.mechanics.equilibrium.newton import iteration_seconds
from sits_mech.mechanics.equilibrium.outcome import Outcome, PathEnd
from sits_mech.mechanics.levels.answer import law_notes, layer_stretch
from sits_mech.mechanics.levels.family import PAIR, Line
from sits_mech.mechanics.levels.pair import VERDICT, Solved, first_look, largest_load, last_rest, own_start
from sits_mech.quantities import Equilibrium
from sits_mech.scene.sensor import known_stretch

_FAR, _HALF = 2.0, 0.5  # times e_d; of a load
_MOMENT = 2.0  # s
_ENDS = (0.9, 1.1), (0.5, 0.85)  # of e_d, seen by first levels of sections and solids at the end of the data
_CLOSE, _TRIES = 0.05, 8  # of a strain, how well a load is located, and tries for it
_POWERS = 0.5, 2.0  # of the strain by the load: 0.85 to 1.3 seen


def overload_refusal(line: Line, start: Equilibrium | None, control: Control) -> Solved | None:
    """Return the refusal of a load far beyond, with the largest that is within the data or carried; None for any other.

    A first level must refuse it from rest, and from the `start` if that is its own.
    """
    looks = list[tuple[int, Outcome]]()
    for first in (0, line.last[0])[: 1 + line.auto]:
        if first and not any(line[number].coarse.touching(look.state).touch for number, look in looks):
            break
        for number in range(first, first + PAIR):
            slow, there = VERDICT * iteration_seconds(line[number].fine) > _MOMENT, own_start(line, number, start)
            for begin in (there, None)[there is None :]:
                look = first_look(line, number, begin, control)
                if not (_far(line, number, look) or (slow and look.reached < 1.0 and _share(look) < _HALF)):
                    return None
            looks.append((number, look))
            if _far(line, number, look):
                break
    number, look = max(looks, key=lambda each: (_far(line, *each), _share(each[1])))
    if _far(line, number, look):
        return _within(line, number, control, look)
    found, body, limit = last_rest(line, number, look.state), line[number].coarse, look.limit_point
    own = None if limit is None else (limit[0], math.nan)
    load = None if own is None else largest_load(line, body, control, found, own)
    laws = law_notes(line.sensor, layer_stretch(body, look.state.u, apart=0.0).each)
    return Solved(found, look.reached, look.reason, load, own, laws, look.reached)


def _share(look: Outcome) -> float:
    """Return the share of a load that a look carries, or got to."""
    return look.reached if look.limit_point is None else sum(look.limit_point)


def _far(line: Line, number: int, look: Outcome) -> bool:
    """Whether a look is far beyond the silicone's data, if these are known."""
    return _strain(line, number, look) > _FAR * (known_stretch(line.sensor) - 1.0)


def _strain(line: Line, number: int, look: Outcome) -> float:
    """Return the strain of a family's first level."""
    return layer_stretch(line[number].coarse, look.state.u).value - 1.0


def _within(line: Line, number: int, control: Control, look: Outcome) -> Solved:
    """Return the refusal of a load far beyond the data, with the largest load within them."""
    known, body = known_stretch(line.sensor) - 1.0, line[number].coarse
    ends, strain = known * np.array(_ENDS[len(body.mesh.axes) - 2]), _strain(line, number, look)
    found, asked, share, power = look, math.sqrt(math.prod(ends)), look.reached, 1.0
    for _ in range(_TRIES):
        before, last = share, strain
        share *= (asked / strain) ** (1.0 / power)
        found = first_look(line, number, None, control, share)
        share, strain = share * found.reached, _strain(line, number, found)
        power = float(np.clip(math.log(strain / last) / math.log(share / before), *_POWERS))
        if abs(strain - asked) <= _CLOSE * asked:
            break
    low, high = (share * (ends / strain) ** (1.0 / power)).tolist()
    rest, limit = last_rest(line, number, found.state), (0.5 * (low + high), 0.5 * (high - low))
    load = largest_load(line, body, control, rest, limit)
    laws = law_notes(line.sensor, layer_stretch(line[number].coarse, look.state.u).each)
    return Solved(rest, share, PathEnd.BEYOND, load, limit, laws, look.reached)
