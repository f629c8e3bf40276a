"""What inductance do others' coils have, alone? Wound bundles, published closed forms, a square spiral over metal.

A wound coil is a stack of turns: round wires of uniform current on a rectangular lattice, turn by turn,

    L = sum_ij M(a_i, a_j, z_i - z_j),    M_ii = mu0 a_i (ln(16 a_i/d) - 7/4),

of wires of diameter d. No source gives it; it lies between half the pitch and all of it, and 0.8 is taken. Uniform
current in the whole section has ``mu0 N a (ln(pitch/d) + 0.138)`` less, a the mean radius: 0.2 % of 387 turns and
2e-4 of 3790 between d = pitch/2 and d = pitch, and always upwards.

Mohan et al., IEEE J. Solid-State Circuits 34 (1999) 1419, n turns between d_in and d_out, d their mean, rho their
difference over their sum, w and s of track and gap:

    modified Wheeler  L = k1 mu0 n^2 d / (1 + k2 rho)
    current sheet     L = c1 mu0 n^2 d/2 (ln(c2/rho) + c3 rho + c4 rho^2)
    monomial          L = beta d_out^a1 w^a2 d^a3 n^a4 s^a5    (micrometres, nH)

stated to be 1 to 3 % from measurement and field solvers, the current sheet to 8 % where s is up to 3 w.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from elsewhere.rows import Row
from scipy.constants import mu_0

from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.loops import free_inductances, mutual_loops
from sits_mech.magnetics.sheets import sheets
from sits_mech.quantities import Pose
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.parts.coils import Coil
from sits_mech.scene.sensor import Sensor, Target

WHEELER = {"square": (2.34, 2.75)}
SHEET = {"square": (1.27, 2.07, 0.18, 0.13), "circle": (1.00, 2.46, 0.00, 0.20)}
MONOMIAL = (1.62e-3, -1.21, -0.147, 2.40, 1.78, -0.030)
FILLED = 0.8  # of the pitch: diameter of a wire
SMALLEST = 2e-6  # track and gap of the coils that the monomial was fitted to [m]
MOHAN = "Mohan et al. 1999, tables I to III; coefficients as in repositories that implement them"
TEAM = "TEAM workshop problem 15, as in repository xfmrexpert/MFEM-ElectroMag, examples/team15"
CNEA = "repositories carabedo/iamend_ci and iamend_test: bo.py; sweeps of a Solartron 1260A"
ECAS = "repository nistiuk/ldc1614-eddy-current-array, README"


@dataclass(frozen=True)
class Winding:
    """A wound coil between two radii: inner and outer radius and length [mm], turns, inductance [uH], its tolerance."""

    name: str
    inner: float
    outer: float
    length: float
    turns: int
    L: float
    tolerance: float
    source: str
    remark: str


_ROUNDED = "tolerance: sizes given to 0.01 mm, 1 %"
_TEAM = (
    "tolerance: sizes to 0.01 mm, 0.2 %. Finite elements of that repository have 225.9 mH of coil A as stated: two "
    "codes agree, and filling moves L by 2e-4 (A) and 2e-3 (B), upwards. What is stated is not what was wound: "
    "{turns:.1f} turns or {size:.2f} mm of inner radius less would read it"
)
WINDINGS = (
    Winding("coil m1", 1.15, 2.95, 2.48, 387, 375.75, 3.8, CNEA, _ROUNDED),
    Winding("coil pp1", 3.00, 4.56, 5.02, 253, 345.85, 3.5, CNEA, _ROUNDED),
    Winding("coil of 900 turns", 3.015, 5.46, 2.94, 900, 6030.0, 60.0, "repository carabedo/ci_mutual",
            "stated as L0 beside its sizes, measured or not is not said; 1 %"),
    Winding("pancake P40", 0.60, 10.05, 0.12, 40, 14.237, 0.3, CNEA + "; at 10 kHz",
            "leads are in the reading; the layout of the 40 turns is not stated"),
    Winding("TEAM 15, coil A", 6.15, 12.40, 6.15, 3790, 221.8e3, 0.5e3, TEAM, _TEAM),
    Winding("TEAM 15, coil B", 9.34, 18.40, 9.00, 408, 3960.0, 8.0, TEAM, _TEAM),
)


def bundle(winding: Winding, across: int = 1, along: int = 1) -> Sections:
    """Return a winding as so many rings of equal section, its top at z = 0, each of the turns that it stands for."""
    width, height = (winding.outer - winding.inner) / across * 1e-3, winding.length / along * 1e-3
    r = winding.inner * 1e-3 + width * (np.arange(across) + 0.5)
    R, Z = np.meshgrid(r, -height * (np.arange(along) + 0.5))
    full = np.ones(R.size)
    return Sections(R.ravel(), Z.ravel(), width * full, height * full, winding.turns / R.size * full)


def wired(winding: Winding, share: float) -> float:
    """Return the inductance of a winding turn by turn, its wires' diameter a share of the pitch [H]."""
    width, height, N = winding.outer - winding.inner, winding.length, winding.turns
    pitch = np.sqrt(width * height / N)
    along = max(1, round(height / pitch))
    across = N if along == 1 else round(width / pitch)
    a = (winding.inner + width / across * (np.arange(across) + 0.5)) * 1e-3
    d = share * min(width / across, height / along) * 1e-3
    alone = np.diag(mu_0 * a * (np.log(16.0 * a / d) - 1.75))
    total = along * float(np.sum(alone))
    for k in range(along):
        M = mutual_loops(a[:, None], a, k * height / along * 1e-3)
        total += (2.0 * (along - k) if k else along) * float(np.sum(M, where=np.isfinite(M)))
    return total * (N / (across * along)) ** 2


def as_measured(one: Winding, found: float) -> str:
    """Return the remark of a winding of some inductance [uH], with how much less of it would read what was measured."""
    slope = (wired(replace(one, inner=one.inner - 0.05), FILLED) * 1e6 - found) / 0.05
    return one.remark.format(turns=one.turns * (1.0 - np.sqrt(one.L / found)), size=(one.L - found) / slope)


def bundles() -> Iterator[Row]:
    """Yield the rows of wound coils."""
    for one in WINDINGS:
        loose, found, tight = (wired(one, share) * 1e6 for share in (0.5, FILLED, 1.0))
        yield Row("wound coils", f"L of {one.name}", "uH", one.L, found, one.tolerance, one.source,
                  error=max(loose - found, found - tight), remark=as_measured(one, found))


def spiral(shape: str, turns: int, outer: float, width: float, gap: float, thickness: float) -> Coil:
    """Return a one-layer coil by its outer size between outermost edges; lengths in one unit, taken as metres."""
    inner = outer - 2 * turns * (width + gap) + 2 * gap
    sizes = {"inner_diameter": inner} if shape == "circle" else {"shape": "rectangle", "inner_width": inner,
                                                                 "inner_length": inner}
    return Coil(name="C", centre=(0.0, 0.0), layers=1, turns=turns, track_width=width, track_gap=gap,
                track_thickness=thickness, **sizes)


def closed_forms(shape: str, turns: int, outer: float, width: float, gap: float) -> dict[str, float]:
    """Return the published closed forms of a one-layer coil [H]; lengths in metres."""
    inner = outer - 2 * turns * (width + gap) + 2 * gap
    d, rho = (outer + inner) / 2, (outer - inner) / (outer + inner)
    c1, c2, c3, c4 = SHEET[shape]
    found = {"current sheet": c1 * mu_0 * turns**2 * d / 2 * (np.log(c2 / rho) + c3 * rho + c4 * rho**2)}
    if shape in WHEELER:
        k1, k2 = WHEELER[shape]
        found["modified Wheeler"] = k1 * mu_0 * turns**2 * d / (1 + k2 * rho)
        beta, a1, a2, a3, a4, a5 = MONOMIAL
        um = 1e6
        nano = beta * (outer * um) ** a1 * (width * um) ** a2 * (d * um) ** a3 * turns**a4 * (gap * um) ** a5
        found["monomial"] = 1e-9 * nano
    return found


def spirals(coarse: bool) -> dict[str, list[tuple[float, float]]]:
    """Return fill and formula over computed, of each formula and shape; tracks and gaps from 2 um."""
    found = dict[str, list[tuple[float, float]]]()
    counts, fills = ((3, 6), (0.3, 0.6)) if coarse else ((2, 3, 5, 8, 12, 20), (0.15, 0.3, 0.45, 0.6, 0.75))
    for shape, turns, rho, ratio in product(SHEET, counts, fills, (0.25, 1.0)):  # ratio: gap over width
        outer = 300e-6
        pitch = outer * rho / (1 + rho) / (turns - ratio / (1 + ratio))
        width, gap = pitch / (1 + ratio), pitch * ratio / (1 + ratio)
        if min(width, gap) < SMALLEST:
            continue
        coil = spiral(shape, turns, outer, width, gap, 1e-6)
        L = float(free_inductances((coil,))[0, 0])
        for name, value in closed_forms(shape, turns, outer, width, gap).items():
            found.setdefault(f"{name}, {shape}", []).append((rho, value / L))
    return found


def mohan(found: dict[str, list[tuple[float, float]]]) -> Iterator[Row]:
    """Yield the rows of the closed forms: root mean square and largest distance from the computed inductance."""
    for name, points in found.items():
        away = 100 * (np.array(points)[:, 1] - 1)
        yield Row("closed forms", f"{name}: rms from ours", "%", 0.0, float(np.sqrt(np.mean(away**2))), 3.0, MOHAN,
                  remark="stated 1 to 3 %")
        yield Row("closed forms", f"{name}: largest from ours", "%", 0.0, float(np.abs(away).max()), 8.0, MOHAN,
                  remark="stated 8 % at most for s up to 3 w, of the current sheet; taken for all")


def probe(coarse: bool) -> Iterator[Row]:
    """Yield the rows of the square spiral of 18 turns over aluminium."""
    one = spiral("square", 18, 10e-3, 0.127e-3, 0.127e-3, 35e-6)
    alone = float(free_inductances((one,))[0, 0]) * 1e6
    wheeler = closed_forms("square", 18, 10e-3, 0.127e-3, 0.127e-3)["modified Wheeler"] * 1e6
    yield Row("ECAS-8 spiral", "L by its designer's formula", "uH", 1.654, wheeler, 0.001, ECAS)
    yield Row("ECAS-8 spiral", "L alone, one layer of 18 turns", "uH", 1.654, alone, 0.05, ECAS,
              remark="3 % of the formula")
    yield Row("ECAS-8 spiral", "L measured over intact aluminium", "uH", 3.57, alone, 0.1, ECAS,
              remark="metal can only lower L, so one layer of 18 turns in a tank of 1 nF does not read this. Layers "
              "and lift-off are not stated: two layers of 18 turns, 1.4 mm apart as the outer ones of its board, would "
              f"read it {lift_off(3.57e-6, 0.1 if coarse else 0.05) * 1e3:.1f} mm above the metal")
    yield Row("ECAS-8 spiral", "rise over the slot of 1.5 mm, of L", "%", 6.3, np.nan, 0.9, ECAS,
              remark="not computed: neither lift-off nor winding is stated, and the base above is not met")


def lift_off(L: float, tolerance: float) -> float:
    """Return how far above aluminium the spiral would read L, if it had two layers 1.4 mm apart [m]."""
    pitch, hertz = 0.254e-3, 2.66e6
    inner = 10e-3 - 35 * pitch
    coil = Coil(name="C", centre=(0.0, 0.0), layers=2, turns=18, layer_pitch=1.4e-3, shape="rectangle",
                inner_width=inner, inner_length=inner, track_width=pitch / 2, track_gap=pitch / 2,
                track_thickness=35e-6)
    plate = Target(material="aluminium", shape="rectangle", width=24e-3, length=24e-3, thickness=1e-3, load_height=0.0)
    model = sheets(Sensor(name="ECAS-8", frequency=hertz, coils=(coil,), target=plate), tolerance)
    gaps = np.array([0.5e-3, 0.8e-3, 1.1e-3, 1.5e-3, 2e-3])
    read = [model.impedance(Pose(0.0, float(gap), 0.0), hertz).L[0, 0] for gap in gaps]
    return float(np.interp(L, read, gaps))


def draw(found: dict[str, list[tuple[float, float]]], rows: list[Row], folder: Path) -> None:
    """Draw the closed forms over fill, and the wound coils' misses."""
    with new_figure(height=0.9) as (figure, (axes,)):
        for number, (name, points) in enumerate(found.items()):
            rho, share = np.array(points).T
            axes.plot(rho + 0.006 * (number - 1.5), 100 * (share - 1), f"C{number}o", label=name, alpha=0.6)
        for limit in (-3.0, 3.0):
            axes.axhline(limit, color="k", linewidth=0.6, linestyle="--", label="3 %" if limit > 0.0 else None)
        axes.set(xlabel="fill (d_out - d_in)/(d_out + d_in) [-]", ylabel="closed form minus computed [%]")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        save_figure(figure, folder / "closed_forms.png")
    wound = [row for row in rows if row.case in ("wound coils", "ECAS-8 spiral") and np.isfinite(row.computed)]
    with new_figure(height=0.7) as (figure, (axes,)):
        for place, row in enumerate(wound):
            mark = "C0o" if row.within else "C3X"
            axes.errorbar(100 * row.miss / row.published, place, xerr=100 * row.tolerance / row.published, fmt=mark)
        labels = [row.quantity if row.case == "wound coils" else f"ECAS-8: {row.quantity}" for row in wound]
        axes.set_yticks(range(len(wound)), labels, fontsize=5.5)
        axes.set_xscale("symlog", linthresh=5.0)
        axes.set_xticks([-50, -10, -5, -2, 0, 2, 5], ["-50", "-10", "-5", "-2", "0", "2", "5"])
        axes.set(xlabel="computed minus published [%]", xlim=(-70.0, 7.0))
        axes.invert_yaxis()
        save_figure(figure, folder / "coils_alone.png")
