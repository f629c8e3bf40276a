"""Uneven current in the coils' tracks, in the field that is there: what it adds to a model of even current.

Skin and proximity effect act on the field B across a track, and metal nearby takes away much of what the coil's own
turns make there. With b of the metal alone per ampere, which models know at `geometry.stations`, and the tracks'
response by filaments (`coils.resistance`): m, what current by the coil's own field is worth in b, and Q, what b drives,

    Delta Z = Z_alone + sum over stations of their share times (2 m . b + b . Q b),

between two coils ``(m + Q b_cc) . b_ce`` of both. First order in what the tracks' uneven current drives in the metal:
solid turns under copper agree to 0.1 % of R and 3e-5 of L (benchmarks/tracks_under_target.py).

Where a model does not know b, that is left out, and its size goes to the errors. Metal that changes Z by the share k of
the coil's own reactance is taken to make k times the field of the other turns in the tracks, whose effect is quadratic:

    about ((1 + k)^2 - 1) Z_alone,    k = Delta Z/(j omega L0),    Z_alone by `rough_alone`.

k is complex: over steel Delta Z is a loss where Delta L passes through zero, and with it what the tracks lose is a
change of L. Of 74 answers of finite elements, of copper, steel and ferrite, discs from half to six times as wide as the
coil, gaps of 0.3 to 3 mm, tracks 0.1 to 0.5 mm wide and 35 to 200 um thick at 0.3 to 3 MHz, the real and the imaginary
part were at most those of this and 0.34 of its size.

Neglected: b's change across a track beyond a linear one, a track's response where b changes along it within a few
widths; and what uneven current does to the field between two coils in free space, which is the error of their M: in a
field that is even over the coil, M over its area S, each adds M (sum m)/(j omega S), m of b up.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sits_mech.geometry.stations import Stations, stations
from sits_mech.geometry.tracks import standing_rings
from sits_mech.geometry.windings import unnamed
from sits_mech.magnetics.coils.loops import free_inductances
from sits_mech.magnetics.coils.resistance import TrackResponse, rough_alone, track_response
from sits_mech.quantities import Array, Complex, Impedance, MagneticModel, Pose
from sits_mech.scene.sensor import Coil, Sensor

_FIELD = 0.015  # error of what metal changes of uneven current: of b by one division, and of filaments
_UNKNOWN = 0.35  # of the size of what is left out that its parts may be off by, as seen
_BENT, _MOST = 0.02, 0.25  # the same of b that bends across a track, over (width/gap)^2, as seen, and at most


@dataclass(frozen=True)
class Tracks:
    """The tracks of some coils at a frequency [Hz]."""

    coils: tuple[Coil, ...]
    frequency: float
    highest: float  # that filaments are made for [Hz]

    @cached_property
    def responses(self) -> list[TrackResponse]:
        """What current does in each coil's."""
        return [track_response(coil, self.frequency, self.highest) for coil in unnamed(self.coils)]

    def places(self, gap: float) -> list[Stations]:
        """Return each coil's stations for metal from a gap on [m]."""
        return [stations(coil, gap) for coil in unnamed(self.coils)]

    def points(self, gap: float) -> Array:
        """Return where metal's field is asked in the scene, coil after coil, (k, 3) [m]."""
        return np.vstack([
            own.points.reshape(-1, 3) + (*coil.centre, 0.0)
            for own, coil in zip(self.places(gap), self.coils, strict=True)
        ])

    def change(self, gap: float, B: Complex) -> Complex:
        """Return what metal's B by each coil at the points, (p, k, 3, n) [T/A], changes of Z, (2, p, n, n) [ohm].

        With it the error, real and imaginary part apart.
        """
        places, n = self.places(gap), len(self.coils)
        ends = np.cumsum([own.points[..., 0].size for own in places])
        total = np.zeros((len(B), n, n), dtype=complex)
        for c, (own, response) in enumerate(zip(places, self.responses, strict=True)):
            b = own.by_turns(own.across(B[:, ends[c] - own.points[..., 0].size : ends[c]]))
            more, share = b[:, c] @ response.quadratic, own.share[:, None]
            shared = np.einsum("pst,pnst->pn", (response.linear + more) * share, b)
            total[:, c, :] += shared
            total[:, :, c] += shared
            total[:, c, c] -= np.einsum("pst,pst->p", more * share, b[:, c])
        return self._with_error(total, gap)

    def around(self, nodes: float, b: Complex, gap: float) -> Complex:
        """Return `change` of one coil by B up and outwards, the same around its axis, at nodes (p, m, 2) [T/A].

        `nodes` is the gap that these are for, `gap` that of the metal [m].
        """
        (own,), (response,) = self.places(nodes), self.responses
        field = own.by_turns(b[:, None, :, :, None])[:, 0, 0]
        total = (field * (2.0 * response.linear + field @ response.quadratic)).sum(axis=1)
        return self._with_error(total[:, None, None], gap)

    def unknown(self, found: Impedance) -> Complex:
        """Return about what metal changes of Z where its field is not known: none, and the error, as `change`."""
        omega, L0 = 2 * np.pi * self.frequency, np.diag(found.L0)
        alone = np.array([rough_alone(coil, self.frequency) for coil in unnamed(self.coils)])
        k = (found.R / omega + 1j * (found.L - found.L0)) / (1j * np.sqrt(np.outer(L0, L0)))
        each = np.sqrt(alone * L0 / np.diag(free_inductances(self.coils)))  # of a section per metre
        missed = k * (2.0 + k) * np.outer(each, each)
        error = _UNKNOWN * np.abs(missed) * (1.0 + 1j) + np.abs(missed.real) + 1j * np.abs(missed.imag)
        return np.stack([np.zeros_like(missed), error])

    def _with_error(self, change: Complex, gap: float) -> Complex:
        """Return a change by metal from a gap on [m] with its error."""
        width = max(coil.track_width for coil in self.coils)
        share = _FIELD + min(_BENT * (width / gap) ** 2, _MOST)
        return np.stack([change, share * (np.abs(change.real) + 1j * np.abs(change.imag))])


@dataclass(frozen=True)
class Tracked:
    """A magnetic model of even current, with what uneven current in the tracks adds.

    One that knows what metal does there has `with_tracks`: impedance, and `Tracks.change` at each pose or None.
    """

    model: MagneticModel
    sensor: Sensor

    def impedance(self, pose: Pose, frequency: float) -> Impedance:
        """Return L, R and L0 with uneven current, in henry and ohm; as the model's own, per metre."""
        tracks = Tracks(self.sensor.coils, frequency, self.sensor.frequency)
        known = getattr(self.model, "with_tracks", None)
        found, change = known(pose, frequency, tracks) if known else (self.model.impedance(pose, frequency), None)
        return with_tracks(tracks, found, tracks.unknown(found) if change is None else change)


def with_tracks(tracks: Tracks, found: Impedance, change: Complex | None = None) -> Impedance:
    """Return an impedance of even current with that of the tracks, and what metal changes of it [ohm].

    As it is where it has that; one per metre has what metal changes in its errors alone.
    """
    if found.uneven:
        return found
    omega, most = 2 * np.pi * found.frequency, float(np.abs(found.L - found.L0).max(initial=0.0))
    more, error = np.zeros((2, 1), dtype=complex) if change is None else change.reshape(2, *found.L.shape)
    relative = float(np.max(error.imag, initial=0.0)) / omega / most if most > 0.0 else 0.0
    error_L, error_R = found.error_L + error.imag / omega, found.error_R + error.real
    if found.unit_L != "H":
        report = replace(found.report, estimated_error=found.report.estimated_error + relative)
        return replace(found, error_L=error_L, error_R=error_R, report=report)
    alone, off = (np.diag([getattr(own, name) for own in tracks.responses]) for name in ("alone", "error"))
    L0, both = found.L0 + alone.imag / omega, alone + more
    error_L0 = off.imag / omega + _mutual_error(tracks, found.L0)
    shared = found.shared_L
    if more.any():  # poses and coils have one factor in common
        own = (np.sign(more.imag) * error.imag / omega)[None]
        shared = own if shared is None else np.concatenate([shared, own])
    if most == 0.0:
        relative = float((off.imag / omega).max() / L0.max())
    return replace(
        found, L=found.L + both.imag / omega, R=found.R + both.real, L0=L0, error_L=error_L,
        error_R=error_R + off.real, uneven=True, error_L0=error_L0, shared_L=shared,
        report=replace(found.report, estimated_error=found.report.estimated_error + relative),
    )


def _mutual_error(tracks: Tracks, L0: Array) -> Array:
    """Return about what uneven current adds to the mutual inductances in free space (n, n) [H]; zero of coils alone."""
    omega, shares = 2 * np.pi * tracks.frequency, []
    for coil, response in zip(tracks.coils, tracks.responses, strict=True):
        rings = standing_rings(coil)
        area = abs(float(rings.signs @ (np.pi * rings.radius**2)))
        up = response.linear[: len(rings.radius)].sum().imag / omega
        shares.append(abs(float(up)) / area)
    return np.abs(L0 - np.diag(np.diag(L0))) * np.add.outer(shares, shares)
