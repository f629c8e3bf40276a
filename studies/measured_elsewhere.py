"""Do the models meet what others measured and published? One table and a figure a case; every miss is named.

Coils alone (elsewhere/coils_alone.py): wound coils, Mohan's closed forms, the square spiral of an open eddy-current
array. Coils over plates (elsewhere/plates.py): sweeps of impedance over blocks of known conductivity and over steel,
and what another code has for the coil of TEAM problem 15 over its plate. A probe over steel (elsewhere/steel_probe.py):
an LDC1612's curve over 101 heights, its drift with temperature. Rubber (elsewhere/rubber.py): Gent and Lindley's closed
forms and their disc. Forces: cylinders of Ecoflex between plates (elsewhere/pressed.py), bonded discs of natural rubber
(elsewhere/discs.py), by what is given and after adaptation to few of their points. A row agrees where its miss is
inside the source's tolerance (stated, or from its own scatter) plus the estimated error; the remark says which it is
and, of a miss, why it is one as far as is known.

Run ``python studies/measured_elsewhere.py [--coarse] --output DIR``: a table as CSV and Markdown, and pictures.
"""

from __future__ import annotations

from pathlib import Path

from common.outputs import study_arguments, write_rows
from elsewhere import coils_alone, discs, plates, pressed, rubber, steel_probe
from elsewhere.rows import Row
from threadpoolctl import threadpool_limits


def coils(coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of coils alone."""
    forms = coils_alone.spirals(coarse)
    rows = [*coils_alone.bundles(), *coils_alone.probe(coarse), *coils_alone.mohan(forms)]
    coils_alone.draw(forms, rows, folder)
    return rows


def over_plates(coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of coils over plates."""
    found = plates.sweep(coarse)
    rows, table = plates.flat()
    plates.draw(found, table, folder)
    return [*plates.swept(found), *rows, *plates.team()]


def over_steel(coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of the probe over steel."""
    best, kept = steel_probe.shape(coarse)
    slopes = steel_probe.drift(best)
    steel_probe.draw(best, slopes, folder)
    return [*steel_probe.shaped(best, kept), *steel_probe.drifting(slopes)]


def bonded(coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of rubber."""
    rows, curves = rubber.blocks(coarse)
    more, curve = rubber.pulled(coarse)
    rubber.draw(curves, curve, folder)
    return [*rows, *more]


def forces(coarse: bool, folder: Path) -> list[Row]:
    """Return the rows of measured forces, by what is given and after adaptation to few of their points."""
    cylinders = pressed.tests(coarse)
    pressed.draw(cylinders, folder)
    rows = [*pressed.rows(cylinders), *([] if coarse else pressed.followed())]
    hardnesses = list(discs.MATERIALS)[:1] if coarse else discs.MATERIALS
    tables = {hardness: discs.compressed(hardness, 0.05 if coarse else 0.02) for hardness in hardnesses}
    pull, compliance = discs.pulled()
    discs.draw(tables, pull, folder)
    rows += [row for hardness, one in tables.items() for row in discs.stiffness(hardness, one)]
    return [*rows, *discs.forces(45, discs.loaded(45)), *discs.tension(pull, compliance)]


def main() -> None:
    """Compare all cases; write the table and print it, with what is known of the misses."""
    coarse, folder = study_arguments(__doc__ or "")
    with threadpool_limits(limits=1):
        rows = [row for part in (coils, over_plates, over_steel, bonded, forces) for row in part(coarse, folder)]
    write_rows([row.tabled() for row in rows], folder / "measured_elsewhere.csv")
    for row in rows:
        numbers = f"{row.published:.4g}, computed {row.computed:.4g} {row.unit}, open {row.tolerance + row.error:.2g}"
        verdict = "" if row.within else f"\n    MISS: {row.remark}"
        print(f"{row.case}: {row.quantity}: {numbers}{verdict}")
    print(f"{len(rows)} rows, {sum(not row.within for row in rows)} misses")


if __name__ == "__main__":
    main()
