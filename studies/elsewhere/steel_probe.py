"""What does a flat coil over a steel plate read? An LDC1612 probe of a 3D printer: the shape of its curve, its drift.

The coil is not published, so the curve is a test of shape. A flat coil of uniform turns from 0.2 R to R, at the
nozzle's height h plus z_0 over a half-space of permeable metal (Dodd and Deeds), in a tank with other inductance:

    f = f_0 / sqrt(1 + s D((h + z_0)/R; sigma/mu_r)),    D = Re Delta L / L of the coil alone,

five parameters: f_0 (inductance and capacitance, which a frequency does not tell apart), the coil's share s of the
tank's inductance (at most 1), R, z_0, and sigma/mu_r of the steel, which alone matters where mu_r is large. Residuals
are weighted to be micrometres of height. Intervals: s on a grid from 0.1 to 1, the other four fitted to each; kept is
what lies within two standard deviations of the best, each with twice its own. They are those of this model: what is
left is not noise, and R goes with the inner radius that is assumed.

Drift. The source gives f(T) = a + b T + c T^2 at nine heights, from 40 degC on; each height follows from f(31 degC) and
the curve. Computed: steel's resistivity (0.5 %/K, as of iron), the board's expansion (the scene's default, of R and so
of L and D); left open, with the interval taken: the capacitor (NP0, +-30 ppm/K), the mount (20 mm, +-20 ppm/K).
Copper's resistivity moves L by some ppm/K, less than that. Nothing is fitted.

Which part, and why that way. Near steel the frequency is higher: at 3.2 MHz its eddy currents take more flux than its
permeability adds. Warmer steel conducts less and lets the field in, the coil's inductance rises and the frequency
falls, the more the nearer it is: by 59 to 7 ppm/K over the nine heights. The board's expansion takes 7 to 8 ppm/K off
all of them alike, as the capacitor adds or takes. The difference of near and far is thus the steel's alone, but for
3 ppm/K of the mount: it comes out in sign and to two thirds in size. What is missing is known in kind: T is the coil's,
while the bed that heats it goes through more, and steel's permeability rises with temperature.

Source: saved calibration of a BTT Eddy, documentation of Simple AF (pellcorp), page "Switching Probes".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common.infinite_plate import Layer, reflection
from elsewhere.rows import Row
from scipy.constants import mu_0
from scipy.optimize import least_squares

from sits_mech.geometry.windings import Sections
from sits_mech.magnetics.coils.loops import series_inductance
from sits_mech.magnetics.coils.ring_field import source_spectrum
from sits_mech.quantities import Array
from sits_mech.report.pictures.style import new_figure, save_figure
from sits_mech.scene.parts.coils import Coil

SOURCE = 'documentation of Simple AF, page "Switching Probes"'
HEIGHT = 0.05 + np.floor(np.arange(101) * 51.2 + 0.5) / 1280  # of the nozzle, in the printer's steps [mm]
HERTZ = np.array([float(word) for word in """
    3229623.081 3228656.922 3227682.221 3226695.637 3225925.777 3225049.143 3224178.350 3223328.887 3222455.740
    3221661.219 3220817.495 3220013.384 3219257.034 3218493.613 3217775.328 3217020.398 3216301.864 3215605.615
    3214913.808 3214239.239 3213525.635 3212871.102 3212234.758 3211590.242 3211002.511 3210349.316 3209777.121
    3209175.318 3208611.538 3208032.647 3207492.880 3206917.046 3206415.591 3205880.562 3205394.722 3204864.651
    3204379.413 3203897.234 3203431.680 3202978.011 3202519.475 3202074.561 3201659.005 3201238.720 3200813.280
    3200430.722 3199992.144 3199611.268 3199221.565 3198835.752 3198467.735 3198101.270 3197730.675 3197376.618
    3197038.317 3196675.894 3196353.214 3196017.205 3195692.745 3195402.473 3195069.483 3194769.319 3194462.596
    3194164.150 3193881.610 3193597.617 3193318.625 3193042.973 3192751.070 3192490.459 3192230.825 3191958.479
    3191712.831 3191462.271 3191219.721 3190981.222 3190753.242 3190511.100 3190299.786 3190068.619 3189831.741
    3189617.482 3189389.765 3189197.550 3188974.854 3188748.495 3188581.109 3188367.906 3188168.587 3187994.694
    3187798.898 3187610.875 3187425.754 3187238.814 3187073.057 3186889.971 3186706.388 3186549.245 3186371.693
    3186206.078 3186034.704
""".split()])
DRIFT = np.array([  # a [Hz], b [Hz/K], c [Hz/K^2], T in degC
    (3248461.6, -742.266, 5.94168),
    (3232546.8, -532.646, 4.33396),
    (3221197.6, -402.246, 3.28022),
    (3212037.7, -298.347, 2.47511),
    (3205050.0, -224.531, 1.89458),
    (3199321.6, -160.480, 1.39110),
    (3194836.9, -114.272, 1.02719),
    (3191166.9, -79.114, 0.76289),
    (3188276.3, -51.153, 0.53001),
])
CALIBRATED = 31.0  # degC
OMEGA = 2 * np.pi * 3.2e6
MU_R = 300.0  # with sigma/mu_r fitted, any large one serves
INNER = 0.2  # of R
BOARD = float(Coil.model_fields["board_expansion"].default)  # 1/K
STEEL, CAPACITOR, MOUNT = -5e-3, 30e-6, 20.0 * 20e-6  # 1/K, 1/K, mm/K
NAMES = ("f_0 [MHz]", "share [-]", "R [mm]", "z_0 [mm]", "log10(sigma/mu_r [S/m])")
LOW, HIGH = (3.1, 0.05, 2.0, 0.05, 1.0), (3.3, 1.0, 15.0, 8.0, 7.5)


@dataclass(frozen=True)
class Fit:
    """Parameters in the order of `NAMES`, their standard deviations, and what is left in Hz and um."""

    p: Array
    deviation: Array
    hertz: Array
    um: Array

    @property
    def rms(self) -> float:
        """Root mean square of what is left [um]."""
        return float(np.sqrt(np.mean(self.um**2)))


def waves() -> tuple[Array, Array]:
    """Return wave numbers in units of 1/R and the weight of Gamma exp(-2 k h) in Delta L / L of the flat coil."""
    edges = np.linspace(INNER, 1.0, 17)
    r, full = (edges[1:] + edges[:-1]) / 2, np.ones(16)
    rings = Sections(r, -5e-4 * full, np.diff(edges), 1e-3 * full, full / 16)
    x, w = np.polynomial.legendre.leggauss(400)
    k = 40.0 * (x + 1.0)
    return k, 40.0 * w * np.pi * mu_0 * source_spectrum(rings, k) ** 2 / series_inductance(rings)


WAVES = waves()


def frequency(p: Array, height: Array) -> Array:
    """Return the tank's frequency [Hz] by the parameters of `NAMES` and the nozzle's height [mm]."""
    f0, share, R, z0, ratio = p
    k, weight = WAVES
    gamma = reflection(k / (R * 1e-3), OMEGA, [Layer(MU_R * 10.0**ratio, np.inf, MU_R)]).real
    D = np.exp(-2.0 * np.outer((np.atleast_1d(height) + z0) / R, k)) @ (weight * gamma)
    return np.asarray(f0 * 1e6 / np.sqrt(1.0 + share * D))


def fitted(share: float, start: Array) -> Fit:
    """Return the fit of the other four parameters for one share."""
    slope = np.abs(np.gradient(np.polynomial.Polynomial.fit(HEIGHT, HERTZ, 9)(HEIGHT), HEIGHT)) * 1e-3  # [Hz/um]

    def left(q: Array) -> Array:
        return np.asarray((frequency(np.insert(q, 1, share), HEIGHT) - HERTZ) / slope)

    keep = [0, 2, 3, 4]
    bounds = np.array(LOW)[keep], np.array(HIGH)[keep]
    found = least_squares(left, start[keep], x_scale=[1e-3, 1.0, 0.3, 0.3], bounds=bounds)
    _, s, V = np.linalg.svd(np.asarray(found.jac), full_matrices=False)
    variance = np.einsum("ki,k->i", V**2, s**-2.0) * 2 * found.cost / (HEIGHT.size - 5)
    return Fit(np.insert(found.x, 1, share), np.insert(np.sqrt(variance), 1, 0.0), found.fun * slope, found.fun)


def shape(coarse: bool) -> tuple[Fit, list[Fit]]:
    """Return the best fit, and those of other shares that the curve does not tell from it."""
    shares = (1.0, 0.5) if coarse else (1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1)
    start, fits = np.array([3.174, 1.0, 5.0, 2.5, 4.0]), list[Fit]()
    for share in shares:
        fits.append(fitted(share, start))
        start = fits[-1].p
    best = min(fits, key=lambda fit: fit.rms)
    limit = best.rms * np.sqrt(1.0 + 4.0 / (HEIGHT.size - 5))
    return best, [fit for fit in fits if fit.rms <= limit]


def shaped(best: Fit, kept: list[Fit]) -> Iterator[Row]:
    """Yield the rows of the curve's shape; the tolerance is what another fit of the same curve left."""
    low = np.min([fit.p - 2 * fit.deviation for fit in kept], axis=0)
    high = np.max([fit.p + 2 * fit.deviation for fit in kept], axis=0)
    remark = "; ".join(f"{name} {p:.5g} ({a:.5g} to {b:.5g})"
                       for name, p, a, b in zip(NAMES, best.p, low, high, strict=True))
    hertz, most = float(np.sqrt(np.mean(best.hertz**2))), float(np.abs(best.um).max())
    other = "tolerance: 10 % more than another fit of an infinite steel plate left, 41 Hz, 3.0 um, 6.8 um at most"
    yield Row("probe over steel", "rms left of the curve", "Hz", 0.0, hertz, 45.1, SOURCE, remark=remark)
    yield Row("probe over steel", "rms left of the curve", "um", 0.0, best.rms, 3.3, SOURCE, remark=other)
    yield Row("probe over steel", "largest left of the curve", "um", 0.0, most, 7.5, SOURCE, remark=other)
    yield Row("probe over steel", "rms left beside the readings' scatter", "Hz", 17.0, hertz, 3.4, SOURCE,
              remark="scatter about a smooth polynomial, 20 %: what is left is not noise, as the picture shows; the "
              "coil's turns and what lies under the steel sheet are not known")


@dataclass(frozen=True)
class Drift:
    """Height of each curve [mm]; measured slope at 40, 60 and 80 degC; computed by steel and board; open [Hz/K].

    Of what is open the first is the capacitor's, alike at all heights, the second the mount's.
    """

    height: Array
    hertz: Array
    measured: Array
    steel: Array
    board: Array
    parts: tuple[Array, Array]

    @property
    def computed(self) -> Array:
        """By all that is computed."""
        return self.steel + self.board

    @property
    def open(self) -> Array:
        """By what is open, at most."""
        return self.parts[0] + self.parts[1]


def drift(fit: Fit) -> Drift:
    """Return measured and computed slopes of the nine curves over temperature."""
    a, b, c = DRIFT.T
    calibrated = a + b * CALIBRATED + c * CALIBRATED**2
    fine = np.linspace(-0.5, 8.0, 2000)
    height = np.interp(-calibrated, -frequency(fit.p, fine), fine)
    measured = np.stack([b + 2 * c * T for T in (40.0, 60.0, 80.0)], axis=1)
    step = 1e-3

    def slope(number: int, by: float) -> Array:
        away = np.zeros(5)
        away[number] = by
        return (frequency(fit.p + away, height) - frequency(fit.p - away, height)) / (2 * by)

    f = frequency(fit.p, height)
    steel = slope(4, step) * STEEL / np.log(10.0)
    board = slope(2, step) * fit.p[2] * BOARD - f * BOARD / 2
    mount = np.abs(slope(3, step)) * MOUNT
    return Drift(height, f, measured, steel, board, (f * CAPACITOR / 2, mount))


def drifting(found: Drift) -> Iterator[Row]:
    """Yield the rows of drift: slopes at the beginning of its range, and how they turn."""
    open_words = "open: capacitor +-30 ppm/K, mount +-0.4 um/K; at 40 degC, the beginning of the range"
    for h, slopes, computed, open_ in zip(found.height, found.measured, found.computed, found.open, strict=True):
        yield Row("probe's drift", f"df/dT at 40 degC, height {h:.2f} mm", "Hz/K", float(slopes[0]), float(computed),
                  float(open_), SOURCE, remark=open_words)
    slopes = (1e6 * own / found.hertz for own in (found.measured[:, 0], found.computed, found.parts[1]))
    measured, computed, open_ = (float(own[0] - own[-1]) for own in slopes)
    yield Row("probe's drift", "df/dT/f at 40 degC, nearest less farthest", "ppm/K", measured, computed, open_, SOURCE,
              remark="steel's part: capacitor and board are alike at all heights; T is the coil's, the bed that heats "
              "it goes through more; permeability over temperature is not known, 0.3 %/K would close it")
    for column, T in ((1, 60), (2, 80)):
        away = found.computed - found.measured[:, column]
        yield Row("probe's drift", f"df/dT at {T} degC, rms of nine heights", "Hz/K", 0.0,
                  float(np.sqrt(np.mean(away**2))), float(np.sqrt(np.mean(found.open**2))), SOURCE,
                  remark="coefficients of materials are constant over 40 K to some percent, so a drift by them does "
                  "not turn; each of the nine curves turns between 48 and 63 degC: something else moves as the printer "
                  "warms up")


def draw(best: Fit, found: Drift, folder: Path) -> None:
    """Draw what the fits leave, and slopes over height."""
    with new_figure(height=1.1, rows=2) as (figure, (upper, lower)):
        upper.plot(HEIGHT, HERTZ / 1e6, "C0o", label="measured")
        upper.plot(HEIGHT, frequency(best.p, HEIGHT) / 1e6, "C1-", label="flat coil over steel")
        upper.set(ylabel="frequency [MHz]")
        upper.legend()
        lower.plot(HEIGHT, best.um, "C1-")
        lower.set(xlabel="height of the nozzle [mm]", ylabel="residual as height [um]")
        save_figure(figure, folder / "probe_over_steel.png")
    with new_figure() as (figure, (axes,)):
        for number, T in enumerate((40, 60, 80)):
            axes.plot(found.height, found.measured[:, number], f"C{number}o", label=f"measured at {T} degC")
        axes.plot(found.height, found.computed, "k-", label="computed: steel and board")
        axes.fill_between(found.height, found.computed - found.open, found.computed + found.open, alpha=0.2,
                          label="unknown: capacitor, mount")
        axes.set(xlabel="height of the nozzle [mm]", ylabel="df/dT [Hz/K]")
        axes.legend()
        save_figure(figure, folder / "probe_drift.png")
