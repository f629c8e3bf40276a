"""Bounds of inputs: wide, with their ends in them, and named where they are left."""

from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from sits_mech.scene.bounds import Count, Length, MetalName, Name, Offset, Permeability, SiliconeOrName


@pytest.mark.parametrize(("kind", "good", "bad", "words"), [
    (Length, "2 mm", "0 mm", "must be a length from 1 nm to 1 km"),
    (Length, 1e3, 1.1e3, "must be a length from 1 nm to 1 km"),
    (Offset, 0.0, "-1 um", "must be zero or a length up to 1 km"),
    (Permeability, 1.0, 0.99, "must be a relative permeability from 1 to 1e7"),
    (Count, 1000, 1001, "must be a whole number from 1 to 1000; got 1001"),
    (Count, 1, True, "must be a whole number from 1 to 1000; got True"),
    (Name, "a coil", "two\nlines", "must be a printable text of 1 to 200 letters"),
    (MetalName, "copper", "unobtainium", "unobtainium"),
    (SiliconeOrName, "ecoflex-00-30", "chewing gum", "chewing gum"),
])
def test_one_inside_one_outside(kind: Any, good: object, bad: object, words: str) -> None:
    """What lies inside is taken, what lies outside refused with what it must be."""
    adapter: TypeAdapter[object] = TypeAdapter(kind)
    assert adapter.validate_python(good) is not None
    with pytest.raises(ValidationError, match=words):
        adapter.validate_python(bad)
