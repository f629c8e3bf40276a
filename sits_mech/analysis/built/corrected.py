"""Make scene and table of the sensor that readings have shown: what was computed, moved to where it was found.

A load f of the table is s f of the built sensor, s its modulus: the same rest, no layer is solved again. The pose there
goes to p' (`loaded`, `setup`), and is read anew by the magnetic model of the corrected scene. With the posterior's
covariance Sigma = B B^T, a root whose columns fall in what they do to the inductances,

    m_j = 2 dp'/dtheta b_j,    n_j = 2 dL/dtheta b_j,

are the parts of the errors of poses and inductances that the whole table shares, two deviations each, in place of those
of before, the magnetic model's, by whose factors the inductances are moved, and the mechanics' omissions as well. Of a
pose's other errors `OWN` is left. Errors that are shown add their sizes up, that of a force the squares (`budget`).
What a scene has no key for (where the target sits on its layer, and how it is turned; a gap below that of the scene's
film) is in the table alone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from sits_mech.analysis.bench.unknowns import PARAMETERS
from sits_mech.analysis.built.adaptation import Adaptation
from sits_mech.analysis.built.prior import OWN, root_of
from sits_mech.analysis.readings.bench import henries
from sits_mech.chain.calibrate import tabulated
from sits_mech.chain.models import loaded_model
from sits_mech.chain.plans.aimed import AimedLoads
from sits_mech.chain.propagation import Direct
from sits_mech.mechanics.loads import Settled
from sits_mech.notes import Note, NoteKind, packed, unpacked
from sits_mech.quantities import POSE, WRENCH, Array, Equilibrium, Pose, SolveReport, Wrench
from sits_mech.readout.loads import fixed, points, request_of, varied, wrench_of
from sits_mech.scene.parameters import keys_of
from sits_mech.scene.parts.cover import Cover
from sits_mech.scene.parts.elastomer import Layer
from sits_mech.scene.sensor import Sensor, Tolerances, changed
from sits_mech.scene.thermal import stiffer
from sits_mech.silicone.material import Silicone
from sits_mech.status import ANSWERED

_ENOUGH = 1e-3  # of the variance of all inductances: parts that add less are left out
_TWO = 2.0  # deviations that an error stands for
_PLACES = ("d_h", "d_y", "alpha", "alpha_x", "alpha_z")


def corrected(found: Adaptation) -> tuple[Sensor, xr.Dataset]:
    """Return scene and table of the built sensor, as `calibrate` would, errors with the posterior's."""
    prior, data = found.prior, found.prior.data
    sensor = corrected_sensor(found)
    s = _value(found, "modulus", 1.0)
    rows = list(points(data))
    good = np.array([str(row["status"].item()) in ANSWERED for row in rows])
    forces = np.array([[float(row[name]) for name in prior.forces] for row in rows])[good]
    at = prior.used(found.values)
    bench = prior.bench(s * forces)
    (places, moved, by_pose, direct), _ = bench.parts(at)
    used = np.flatnonzero(prior.in_use)
    whole = (by_pose + direct)[..., used]
    basis = _basis(whole, found.covariance[np.ix_(used, used)])
    moved = np.einsum("vmk,vj->jmk", moved[used], basis)
    scale = henries(sensor, data.attrs["unit_L"], data["L0"].to_numpy())
    parts = np.moveaxis(whole @ basis, -1, 0) / scale
    settled, turn = {}, 0
    for row, fine in zip(rows, good, strict=True):
        load = wrench_of(row)
        load = Wrench(*(s * load.components).tolist())
        if not fine:
            settled[load] = Settled(None, 0.0, str(row["status"].item()), str(row["reason"].item()))
            continue
        settled[load] = Settled(_rest(row, load, places[turn], moved[:, turn]))
        turn += 1
    request = request_of(data)
    request |= {name: (s * np.array(request[name])).tolist() for name in WRENCH if name in request}
    asked = float(data.attrs["magnetics_tolerance"])
    field, _ = loaded_model(sensor, request["magnetics"], asked, list(settled))
    axes = {name: (s * data[name].to_numpy()).tolist() for name in varied(data)}
    held = {name: s * value for name, value in fixed(data).items()}
    known = Direct(parts, bench.by_factors(at) / scale)
    table = tabulated(sensor, AimedLoads(settled, field, asked), request, (axes, held), direct=known)
    return sensor, table.assign_attrs(notes=_notes(found))


def _notes(found: Adaptation) -> str:
    """Return the notes on a calibration, what it was adapted to, and what of it the scene does not hold."""
    notes, measured = unpacked(str(found.prior.data.attrs.get("notes", ""))), found.measured
    every_note = [*notes, Note.of(NoteKind.ADAPTED, count=len(measured.L), source=str(measured.source))]
    placed = {name: _value(found, name, 0.0) for name in _PLACES if name in found.names}
    return packed([*every_note, Note.of(NoteKind.PLACED, **placed)] if placed else every_note)


def corrected_sensor(found: Adaptation) -> Sensor:
    """Return the scene with what was found of it and what that leaves open; what has no key is left as it is."""
    sensor, keys = found.prior.sensor, []
    layer = sensor.elastomer
    if layer is not None:
        thickness, gap = layer.thickness + _value(found, "thickness", 0.0), _value(found, "gap", 0.0)
        film = max(layer.standoff + gap, 0.0)
        modulus, stiffening = _value(found, "modulus", 1.0), _value(found, "stiffening", 0.0)

        def made(each: Layer | Cover) -> dict[str, Silicone]:
            """Return the silicone of a layer, or of the cover, as it was found."""
            return {"material": _silicone(each.silicone, modulus, stiffening)}

        layer = layer.of_thickness(thickness).remade(made, standoff=film)
        cover = None if sensor.cover is None else sensor.cover.model_copy(update=made(sensor.cover))
        sensor = sensor.model_copy(update={"elastomer": layer, "cover": cover})
    readout = sensor.readout
    keys += [f"readout.lead_inductance={readout.lead_inductance + _value(found, 'lead', 0.0)!r}"]
    C = readout.parallel_capacitance
    keys += [f"readout.parallel_capacitance={C + _value(found, 'capacitance', 0.0)!r}"]
    for each in found.prior.setup.parameters:
        if each.name not in PARAMETERS:
            value = _value(found, each.name, 0.0)
            keys += [f"{key}={value!r}" for key in keys_of(sensor, each.name)]
    open_ = np.minimum(found.deviations, found.prior.deviations)  # less is known of none, however badly it fits
    left = {name: float(open_[found.names.index(name)]) for name in Tolerances.model_fields if name in found.names}
    if "modulus" in left:
        left["modulus"] /= _value(found, "modulus", 1.0)
    return changed(sensor.model_copy(update={"tolerances": Tolerances(**left)}), keys)


def _silicone(silicone: Silicone, modulus: float, stiffening: float) -> Silicone:
    """Return the silicone as it was found."""
    if stiffening:
        silicone = silicone.stiffened(stiffening)
    found = stiffer(silicone, modulus)
    bulk_modulus = modulus * silicone.bulk_modulus
    return replace(found, name="", bulk_modulus=bulk_modulus, source="adapted to readings", spread=None)


def _value(found: Adaptation, name: str, usual: float) -> float:
    """Return the value of an unknown that was found, or else the usual one."""
    return float(found.values[found.names.index(name)]) if name in found.names else usual


def _basis(slopes: Array, covariance: Array) -> Array:
    """Return the columns 2 b_j of the module docstring that matter, shape (p, j), of slopes (m, n, p)."""
    units = np.sqrt(np.diagonal(covariance))  # of unknowns in metres, farads, ...
    root = units[:, None] * root_of(covariance / np.outer(units, units))
    _, s, W = np.linalg.svd(slopes.reshape(-1, slopes.shape[-1]) @ root, full_matrices=False)
    kept = np.cumsum(s[::-1] ** 2)[::-1] > _ENOUGH * np.sum(s**2)
    return np.asarray(_TWO * (root @ W.T)[:, kept])


def _rest(row: xr.Dataset, load: Any, place: Array, parts: Array) -> Equilibrium:
    """Return a rest of the table under its new load, at its new place, with new shared parts (j, 6) of its error."""
    names = [name for name in POSE if f"error_{name}" in row]
    error, shared = np.zeros((2, len(POSE)))
    for name in names:
        error[POSE.index(name)] = float(row[f"error_{name}"])
        shared[POSE.index(name)] = float(np.abs(row[f"shared_{name}"]).sum()) if f"shared_{name}" in row else 0.0
    error = OWN * np.maximum(error - shared, 0.0) + np.abs(parts).sum(axis=0)
    report = SolveReport(
        "adapted", 0, int(row["iterations"]), 0.0, float(row["error_mechanics"]), 0.0,
        notes=unpacked(str(row["notes"].item())),
        min_J=float(row["min_J"]), stretch=float(row["stretch"]),
    )
    return Equilibrium(load, Pose.of(place), Pose.of(error), np.zeros(0), report, parts)
