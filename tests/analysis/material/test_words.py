"""Words of test machines: what a column holds, by word and unit; sizes of a specimen above the names."""

import numpy as np
import pytest

from sits_mech.analysis.material.words import quantities, specimen_sizes
from sits_mech.analysis.readings.columns import Column, titled


def kind(title: str) -> tuple[str, str] | None:
    """Mode and kind of a column, "?" behind a kind whose unit does not fit; None for one not known."""
    known = quantities([Column(0, title, *titled(title))])
    return (known[0].mode, known[0].kind + "?" * bool(np.isnan(known[0].factor))) if known else None


@pytest.mark.parametrize(
    ("titles", "expected"),
    [
        (("Tensile strain (%)", "Dehnung [%]", "Déformation", "Alargamiento (%)", "伸び(%)"), "strain"),
        (("Extension (mm)", "Standardweg [mm]", "Déplacement (mm)", "ストローク(mm)"), "displacement"),
        (("Tensile stress (MPa)", "Zugspannung/MPa", "Contrainte (bar)", "Tensión (kPa)", "引張応力 [MPa]"), "stress"),
        (("Load (kgf)", "Prüfkraft in N", "Effort (N)", "Tensión (N)", "試験力 (N)"), "force"),
        (("Hencky strain", "wahre Dehnung [-]", "Déformation vraie", "deformación real", "真ひずみ"), "true_strain"),
        (("True Stress (Pa)", "真応力 (MPa)"), "true_stress"), (("Stretch ratio (-)", "λ", "伸長比"), "stretch"),
        (("Time", "Prüfzeit [s]", "Temps (min)", "時間(秒)"), "time"),
        (("Stress", "Engineering stress (mm)"), "stress?"),
    ],
)
def test_words_of_five_languages(titles: tuple[str, ...], expected: str) -> None:
    """The unit decides where a word has two meanings."""
    assert {title: kind(title) for title in titles} == dict.fromkeys(titles, ("uniaxial", expected))


def test_other_words_are_not_known() -> None:
    """A rate is no strain, whatever else it says; modes are known, numbers of specimens passed over."""
    assert not any(map(kind, ("strain rate (1/s)", "Tensile strain at Break (%)", "Maximum Load (N)", "Note", "1")))
    assert kind("Equibiaxial nominal stress 2 [kPa]") == ("biaxial", "stress")
    assert kind("Pure shear strain") == ("planar", "strain") and kind("Specimen 3 strain (%)") == ("uniaxial", "strain")


def test_sizes_above_the_names() -> None:
    """In cells or in one, with the unit before or behind; the first counts; what has no unit is none."""
    lines = [["Specimen Thickness (mm)", "4"], ["Messlänge", "25,00", "mm"], ["Width = 6.0 mm"], ["Width", "7", "mm"],
             ["Querschnitt [mm²]", "24", ""], ["Diameter", "3"], ["Speed", "450", "mm/min"]]
    assert specimen_sizes(lines) == pytest.approx({"thickness": 4e-3, "length": 25e-3, "width": 6e-3, "area": 24e-6})
