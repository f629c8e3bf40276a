"""Combine what varies to the cases of a study: samples of ranges, derived keys, conditions.

Samples are points of the unit cube, a coordinate for each key: Sobol' points scrambled by the seed, of which the first
N are the same for any larger N; a Latin hypercube, which is another for each N; or Saltelli's design for indices of
sensitivity: N rows each of A and B (Sobol' points of twice the dimension), then of A with a column of B, for each key.
A. Saltelli et al., Computer Physics Communications 181 (2010) 259.

Derived keys and conditions are texts: names of keys, numbers with units, + - * / and comparisons, all in SI.

    "target.width <= elastomer.width"     "1 mm < dv - 0.5 * target.thickness < 4 mm"     'target.material != "brass"'

A unit of several factors stands in quotes with its number: 'moment <= "2 N*mm"'. Texts are parsed by `ast`; what is not
listed here is refused, and nothing of a text is executed. Units of what is compared are not: 2 mm < 5 Hz is false.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from sits_mech.inputs import meant
from sits_mech.quantities import Array
from sits_mech.units import SceneError, shown, si_label

_SIGNED: Mapping[type, Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_JOINED: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
}
_COMPARED: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_WITH_UNIT = re.compile(r"""("[^"]*"|'[^']*')|(?<![\w.])((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?+)\s*([A-Za-zµμΩ°%]+)""")
LONGEST = 400  # letters of a text, so that its tree is no deeper than may be walked
_NODES = (ast.BinOp, ast.UnaryOp, ast.Name, ast.Load, *_SIGNED, *_JOINED, *_COMPARED)
_WORDS = "names of keys, numbers with units, + - * /"


@dataclass(frozen=True)
class Expression:
    """A text of a study that can be evaluated; made by `expression`."""

    where: str  # what an error names: the text's place
    text: str
    tree: ast.expr

    @property
    def names(self) -> set[str]:
        """The keys that the text names."""
        return _names(self.tree)

    def __call__(self, values: Mapping[str, Any]) -> Any:
        """Return the value at a point, whose keys have `values` in SI; raise SceneError where there is none."""
        try:
            found = _value(self.tree, values)
        except KeyError as error:
            was = meant(error.args[0], list(values))
            what = "must name what the study varies, derives or fixes, or what its scene has"
            raise SceneError(f"{self.where}: {what}; got {was}") from None
        except (TypeError, ArithmeticError) as error:
            raise SceneError(f"{self.where}: must be of numbers; {shown(self.text)}: {error}") from None
        return found


def expression(where: str, text: object, *, condition: bool = False) -> Expression:
    """Return a condition, or what gives a number, from its text; raise SceneError naming `where` for anything else."""
    tree = _parsed(text)
    if tree is None or isinstance(tree, ast.Compare) != condition:
        form = f"a comparison of {_WORDS}" if condition else f"made of {_WORDS}"
        raise SceneError(f"{where}: must be {form}; got {shown(text)}")
    for each in ast.walk(tree):
        if isinstance(each, ast.Constant) and re.match(r"\s*[-+.]?\d", str(each.value)) and not _number(each):
            raise SceneError(f"{where}: must have numbers with units that exist; got {shown(each.value)}")
    return Expression(where, str(text), tree)


def names_of(values: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Return tables as one, keys joined by dots, entries of lists of tables by their names."""
    found = dict[str, Any]()
    for key, item in values.items():
        if isinstance(item, list) and item and all(isinstance(each, dict) and "name" in each for each in item):
            item = {each["name"]: each for each in item}
        found |= names_of(item, f"{before}{key}.") if isinstance(item, dict) else {f"{before}{key}": item}
    return found


def _parsed(text: object) -> ast.expr | None:
    """Return the tree of a text; None where it is none, or has what no text may have."""
    if not isinstance(text, str) or len(text) > LONGEST:
        return None
    quoted = _WITH_UNIT.sub(lambda match: match[1] or f'"{match[2]} {match[3]}"', text)
    try:
        tree = ast.parse(quoted.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return tree if all(_allowed(node, tree) for node in ast.walk(tree)) else None


def _number(node: ast.Constant) -> bool:
    """Tell whether a constant is a finite number, or a quantity with a unit that exists."""
    value = si_label(node.value)
    return isinstance(value, float) and math.isfinite(value)


def _allowed(node: ast.AST, tree: ast.expr) -> bool:
    """Tell whether a tree may have a node: a comparison at its top, attributes of names, numbers and texts."""
    match node:
        case ast.Compare():
            return node is tree
        case ast.Attribute(value):
            return isinstance(value, ast.Attribute | ast.Name)
        case ast.Constant(value):
            return type(value) in (int, float, str)
        case _:
            return type(node) in _NODES


def _name(node: ast.expr) -> str | None:
    """Return the key that a node names, with its dots."""
    if isinstance(node, ast.Attribute):
        before = _name(node.value)
        return None if before is None else f"{before}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else None


def _names(node: ast.expr) -> set[str]:
    """Return the keys that an allowed tree names."""
    name = _name(node)
    if name is not None:
        return {name}
    return {found for each in ast.iter_child_nodes(node) if isinstance(each, ast.expr) for found in _names(each)}


def _value(node: ast.expr, values: Mapping[str, Any]) -> Any:
    """Return the value of an allowed tree; raise KeyError of a key that has none."""
    match node:
        case ast.Compare(left, signs, others):
            each = [_value(item, values) for item in (left, *others)]
            return reduce(operator.and_, (_COMPARED[type(sign)](*each[k : k + 2]) for k, sign in enumerate(signs)))
        case ast.BinOp(left, sign, right):
            return _JOINED[type(sign)](_value(left, values), _value(right, values))
        case ast.UnaryOp(sign, inner):
            return _SIGNED[type(sign)](_value(inner, values))
        case ast.Constant(value):
            return si_label(value)
        case _:
            return values[str(_name(node))]


SAMPLED = ("sobol", "latin", "saltelli")
"""Ways to combine ranges to samples."""
MOST = 1_000_000  # cases of a study


def cube(combine: str, count: int, seed: int, keys: int) -> Array:
    """Return the points of the unit cube for so many samples, shape (cases, keys)."""
    from scipy.stats import qmc  # 0.4 s, for samples alone

    if combine == "latin":
        return qmc.LatinHypercube(keys, rng=seed).random(count)
    wide = keys * (1 + (combine == "saltelli"))
    found = qmc.Sobol(wide, rng=seed).random_base2(math.ceil(math.log2(count)))[:count]
    if combine == "sobol":
        return found
    a, b = found[:, :keys], found[:, keys:]
    return np.concatenate([a, b, *(np.where(np.arange(keys) == key, b, a) for key in range(keys))])


def sampled(varied: Mapping[str, Any], points: Array) -> dict[str, list[Any]]:
    """Return the values of each key at points of the unit cube: within the ends of a range, or evenly of a list."""
    found = {}
    for (name, item), shares in zip(varied.items(), points.T, strict=True):
        if isinstance(item, list):
            found[name] = [item[int(share * len(item))] for share in shares]
        else:
            first, last, unit = item
            found[name] = number_texts(first + (last - first) * shares, unit)
    return found


def number_texts(numbers: Array, unit: str) -> list[Any]:
    """Return numbers of fifteen digits as a study file has them, with their unit."""
    rounded = [float(f"{number:.15g}") for number in numbers]
    return [f"{number!r} {unit}" for number in rounded] if unit else rounded


def derived(
    points: Sequence[dict[str, Any]], derive: Mapping[str, Expression], where: Sequence[Expression],
    known: Callable[[Mapping[str, Any]], Mapping[str, Any]],
) -> list[dict[str, Any]]:
    """Return points with their derived keys, without those that break a condition.

    `known` gives all that texts may name at a point but what the point has itself, in SI.
    """
    found = []
    for point in points:
        values, more = {**known(point), **{name: si_label(item) for name, item in point.items()}}, {}
        for name, text in derive.items():
            value = text(values)
            values[name] = more[name] = float(f"{value:.15g}") if isinstance(value, float) else value
        if all([text(values) for text in where]):
            found.append(point | more)
    if not found:
        raise SceneError(f"where: must leave a case at least; all {len(points)} break a condition")
    return found
