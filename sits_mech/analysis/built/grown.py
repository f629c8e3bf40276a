"""Calibrate a table further where the readings of a softer sensor end at it.

A sensor of modulus s, over the scene's, rests under F where the table's rests under F/s: a table on which F/s can be
followed down to s_0 holds no softer one (`force_maps.moduli`). It is then made to reach F/s_0 `SOFTER` times, as far as
the pad bears that by its first meshes (`envelope.borne_share`). Beyond each end of a force stand as many new values as
between none and that end: the halves, quarters, ... of the old range are then those of parts of the new one
(maps/grid.py), so that what was solved is asked for again.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from sits_mech.analysis.bench.force_maps import lacking, moduli
from sits_mech.analysis.bench.load_plan import SOFTER
from sits_mech.analysis.built.fit import EndReached
from sits_mech.analysis.built.prior import Prior
from sits_mech.analysis.envelope import borne_share
from sits_mech.cases import Progress, no_progress
from sits_mech.chain.calibrate import calibrate
from sits_mech.notes import NoteKind, unpacked
from sits_mech.quantities import Array, Wrench
from sits_mech.readout.loads import load_words, request_of
from sits_mech.scene.sensor import SceneError
from sits_mech.units import SLACK


def grown(
    prior: Prior, forces: Array, end: EndReached, folder: Path | None = None, *, progress: Progress = no_progress
) -> xr.Dataset:
    """Return the table of a calibration with more loads, for forces (m, d) at which a fit came to an `end`.

    `folder` of its finished loads; `progress` as of `calibrate`. Raises `end` where it is not the table that ends, with
    the pad's own where that bears no more; SceneError for a table that was adapted itself.
    """
    data, request = prior.data, request_of(prior.data)
    if any(note.kind is NoteKind.ADAPTED for note in unpacked(str(data.attrs["notes"]))):
        raise SceneError(f"grow: must be of a calibration as computed; this one was adapted: {end}")
    least = moduli(np.nan_to_num(forces), prior.table, prior.forces)[0][0]
    if end.name != "modulus" or end.end > (1.0 + SLACK) * least:
        raise end
    factors = dict.fromkeys(prior.forces, 1.0)
    for (name, sign), most in lacking(forces, prior.table, least / SOFTER).items():
        factors[name] = max(factors[name], most / float(np.max(sign * np.array(request[name]))))
    corner = {name: factor * float(np.max(np.abs(request[name]))) for name, factor in factors.items()}
    share = borne_share(prior.sensor, Wrench(**corner), request["mechanics"])
    if share * max(factors.values()) <= 1.0:
        raise EndReached(f"{end}; the pad bears {share:g} of {load_words(corner)}", end.name, end.end)
    request |= {name: longer(request[name], share * factor) for name, factor in factors.items() if factor > 1.0}
    return calibrate(prior.sensor, **request, progress=progress, folder=folder, drift="slope_T_L" in data)


def longer(values: Sequence[float], factor: float) -> list[float]:
    """Return ascending values up to `factor` times their ends, with as many more as there are on each side of none."""
    own = np.sort(values)
    near, found = own[np.argmin(np.abs(own))], [own]
    for side in (own[own > near], own[own < near][::-1]):
        if len(side) and factor > 1.0:
            found.append(np.linspace(side[-1], factor * side[-1], len(side) + 1)[1:])
    return [float(value) for value in np.sort(np.concatenate(found))]
