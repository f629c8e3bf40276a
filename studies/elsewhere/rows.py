"""What is a row of the table of others' numbers, and when does it agree?"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One published or measured number beside the computed one.

    Attributes
    ----------
    case, quantity, unit : str
    published, computed : float
        In that unit.
    tolerance : float
        What the source leaves open, stated or taken from its own scatter, in that unit.
    source : str
        Where the number stands.
    error : float
        Estimated error of the computed one, in that unit.
    remark : str
        Whence the tolerance; of a miss, why it is one as far as is known.
    """

    case: str
    quantity: str
    unit: str
    published: float
    computed: float
    tolerance: float
    source: str
    error: float = 0.0
    remark: str = ""

    @property
    def miss(self) -> float:
        """Computed less published."""
        return self.computed - self.published

    @property
    def within(self) -> bool:
        """Whether the miss is inside the source's tolerance plus the estimated error."""
        return abs(self.miss) <= self.tolerance + self.error

    def tabled(self) -> dict[str, object]:
        """Return the row as it stands in the table."""
        return {
            "case": self.case, "quantity": self.quantity, "unit": self.unit, "published": self.published,
            "computed": self.computed, "miss": self.miss, "tolerance": self.tolerance, "error": self.error,
            "within": "yes" if self.within else "MISS", "source": self.source, "remark": self.remark,
        }
