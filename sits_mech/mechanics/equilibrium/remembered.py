"""Remember where bodies came to rest: other coils, converters or tolerances ask for the same rests of the same pad.

A rest is a function of the body and of what is asked of it, digit for digit, so that an answer does not depend on what
was asked before. Its deformation at the quadrature points, much larger, is made again where it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import update_wrapper
from typing import Any, Concatenate, ParamSpec, TypeVar

from sits_mech.disk_cache import fed
from sits_mech.mechanics.equilibrium.body import Bonded, State

ROOM = 2**25
"""Bytes of the states that a body keeps: 25 on the finest mesh of a pad, 800 on its second one."""
_Asked = ParamSpec("_Asked")
_Rest = TypeVar("_Rest")
Solve = Callable[Concatenate[Bonded, State, _Asked], _Rest]


def remembered(solve: Solve[_Asked, _Rest]) -> Solve[_Asked, _Rest]:
    """Return a solution from a state, a dataclass with a `state` or None, that is found once for the same numbers."""

    def found(body: Bonded, start: State, /, *asked: _Asked.args, **more: _Asked.kwargs) -> _Rest:
        words = tuple(part for pair in sorted(more.items()) for part in pair)
        name = fed((solve.__name__, replace(start, known=None), asked, words)).hexdigest()
        if name in body.rests:
            rest: _Rest = body.rests[name]
            return rest
        own = solve(body, start, *asked, **more)
        body.rests[name] = _light(own)
        while 8 * body.size * len(body.rests) > ROOM:
            del body.rests[next(iter(body.rests))]
        return own

    update_wrapper(found, solve)
    return found


def _light(found: Any) -> Any:
    """Return a solution without the deformation of its state."""
    return None if found is None else replace(found, state=replace(found.state, known=None))
