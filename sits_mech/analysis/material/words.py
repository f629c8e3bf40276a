"""Name what a column of a test machine holds, by its words in English, German, French, Spanish and Japanese.

A word may stand for two quantities (an extension in mm or in %); the unit decides. Words that only say which of a kind
it is (engineering, tensile) are passed over, "true" makes another quantity, and any other word makes a column unknown:
"strain rate" is no strain.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from sits_mech.analysis.readings.columns import Column, plain
from sits_mech.units import SceneError, si_value

UNITS = {
    "time": "s", "strain": "", "stretch": "", "true_strain": "", "displacement": "m", "stress": "Pa",
    "true_stress": "Pa", "force": "N",
}
"""SI units of what a column may hold."""
_WORDS = {
    ("time",): "time zeit prüfzeit temps tiempo 時間",
    ("strain",): "strain ε dehnung nenndehnung bruchdehnung stauchung ひずみ 歪 歪み",
    ("strain", "displacement"): (
        "elongation extension compression deformation verformung verlängerung allongement déformation alargamiento "
        "elongación deformación extensión 伸び 伸び率"
    ),
    ("stretch",): "stretch λ lambda streckung verstreckung streckverhältnis stretchratio extensionratio 伸長比",
    ("displacement",): (
        "displacement crosshead position stroke travel weg standardweg traversenweg déplacement traverse course "
        "desplazamiento carrera posición 変位 ストローク"
    ),
    ("stress",): "stress σ spannung nennspannung zugspannung druckspannung contrainte esfuerzo 応力",
    ("stress", "force"): "tension tensión effort druckkraft",
    ("force",): "force f load kraft standardkraft prüfkraft zugkraft last charge fuerza carga 試験力 荷重 力",
}
"""What a word may stand for, most likely first."""
_KINDS = {plain(word): kinds for kinds, words in _WORDS.items() for word in words.split()}
_PASSED = {plain(word) for word in (
    "engineering nominal tensile compressive technical uniaxial axial average corrected standard absolute displacement "
    "crosshead extensometer machine technische nominelle nominale en traction compresión de tracción ingenieril "
    "unitaria longitudinal ingénierie conventionnelle uniaxiale composite"
).split()}
_TRUE = {plain(word) for word in (
    "true logarithmic log hencky cauchy wahre logarithmische vraie rationnelle real verdadera verdadero logarítmica"
).split()}
_READ = _KINDS.keys() | _PASSED | _TRUE
_MODES = {
    "planar": "planar", "pure shear": "planar", "equibiaxial": "biaxial", "equi biaxial": "biaxial",
    "biaxial": "biaxial", "uniaxial": "uniaxial", "simple shear": "shear", "shear": "shear",
}
_JAPANESE = re.compile(r"公称|工学|引張り?|圧縮|一軸|標準|最大(?=点)")
_PRESSED = re.compile(r"compres|stauchung|druck|圧縮")
_MARK = re.compile(r"(?:\b(?:specimen|sample|probe|test|eprouvette|probeta)\b|試験片)?\s*#?\d+\b|[()\[\]]|\bratio\b")
_SIZES = {
    "length": "length gaugelength gagelength gripseparation messlänge anfangsmesslänge einspannlänge longueur "
    "longueurinitiale longueurdereference longitud longitudinicial 標線間距離 つかみ間隔 長さ l0",
    "width": "width breite probenbreite largeur ancho 幅 b0",
    "thickness": "thickness dicke probendicke épaisseur espesor 厚さ 厚み a0",
    "diameter": "diameter durchmesser diamètre diámetro 直径 d0",
    "area": "area crosssection crosssectionalarea querschnitt querschnittsfläche section aire área 断面積 s0",
}
_SIZED = {plain(word): size for size, words in _SIZES.items() for word in words.split()}
_SIZE = re.compile(r"\W*([^\d:=(\[]+0?)\s*(?:[(\[]([^)\]]*)[)\]])?\s*[:=]?\s*(\d+(?:[.,]\d+)?)\s*(\S*).*")


class Quantity(NamedTuple):
    """What a column holds: the mode of the test, a kind of `UNITS`, and the factor of its unit to SI."""

    mode: str
    kind: str
    factor: float
    column: Column

    @property
    def pressed(self) -> bool:
        """Whether its words say compression."""
        return bool(_PRESSED.search(self.column.name))


def quantities(columns: Sequence[Column]) -> list[Quantity]:
    """Return what is known of columns, in their order; factor nan where a unit does not fit."""
    return [known for column in columns if (known := _quantity(column)) is not None]


def _quantity(column: Column) -> Quantity | None:
    """Return what a column holds; None where its words are not all known."""
    text = plain(_JAPANESE.sub("", column.name).replace("真", "true "))
    mode = next((name for name in _MODES if text.startswith(f"{name} ")), "")
    words = _MARK.sub(" ", text.removeprefix(mode)).split()
    kinds = [kind for word in words for kind in _KINDS.get(word, ())]
    if not kinds or not {*words} <= _READ:
        return None
    if _TRUE & {*words}:
        kinds = [f"true_{kind}" for kind in kinds if kind in ("strain", "stress")]
    known = [Quantity(_MODES.get(mode, "uniaxial"), kind, _factor(column.unit, UNITS[kind]), column) for kind in kinds]
    return next(iter(sorted(known, key=lambda one: math.isnan(one.factor))), None)


def _factor(unit: str, si: str) -> float:
    """Return the factor of a unit to SI; nan where it does not fit. Times and strains may be without one."""
    try:
        return si_value(f"1 {unit}", si) if unit or si in ("", "s") else math.nan
    except SceneError:
        return math.nan


def specimen_sizes(above: Sequence[list[str]]) -> dict[str, float]:
    """Return the sizes of a specimen [m, m^2] that lines above a table name, first of each: "Width; 6; mm"."""
    found: dict[str, float] = {}
    for cells in above:
        match = _SIZE.fullmatch(" ".join(cell for cell in cells if cell))
        size = match and _SIZED.get(re.sub(r"specimen|sample|probe\b| ", "", plain(match[1])))
        if match and size and size not in found:
            factor = _factor(match[2] or match[4], "m^2" if size == "area" else "m")
            if math.isfinite(factor):
                found[size] = factor * float(match[3].replace(",", "."))
    return found
