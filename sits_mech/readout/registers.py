"""List the registers that set up a part: address, name and value of each, in the order to write them.

Sources: data sheets SNOSCY9A (LDC1612, LDC1614) and SNOSD01D (LDC1101).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sits_mech.readout.front_end import FrontEnd

Registers = tuple[tuple[int, str, int], ...]
_DEGLITCH = ((1e6, 0b001), (3.3e6, 0b100), (10e6, 0b101), (33e6, 0b111))  # bandwidth [Hz] and its code


def no_registers(found: FrontEnd) -> Registers:
    """Return none: those of the part are not known."""
    return ()


def registers_161x(found: FrontEnd) -> Registers:
    """Return the registers of the LDC1612 and LDC1614, each channel its own, the sequence of channels."""
    n = min(len(found.settlecount), found.part.channels)
    rows = [(0x08 + k, f"RCOUNT{k}", found.rcount) for k in range(n)]
    rows += [(0x10 + k, f"SETTLECOUNT{k}", int(found.settlecount[k])) for k in range(n)]
    dividers = (found.input_divider << 12) | found.reference_divider
    rows += [(0x14 + k, f"CLOCK_DIVIDERS{k}", dividers) for k in range(n)]
    rows += [(0x1E + k, f"DRIVE_CURRENT{k}", int(found.drive[k]) << 11) for k in range(n)]
    highest = float(found.frequency.max())
    deglitch = next((code for width, code in _DEGLITCH if highest < width), _DEGLITCH[-1][1])
    sequence = (1 << 15) | (max(n - 2, 0) << 13) if n > 1 else 0
    rows.append((0x1B, "MUX_CONFIG", sequence | 0x0208 | deglitch))
    return (*rows, (0x1A, "CONFIG", 0x1601))  # awake; own drive current; external clock


def registers_1101(found: FrontEnd) -> Registers:
    """Return the registers of the LDC1101 in its high-resolution L mode; RP_MAX is off."""
    slowest = int(np.clip(np.floor(16.0 - 8e6 / found.frequency.min()), 0, 15))
    return (
        (0x01, "RP_SET", 0x80 | int(found.drive[0])),
        (0x04, "DIG_CONFIG", (slowest << 4) | 0x07),
        (0x05, "ALT_CONFIG", 0x01),
        (0x0C, "D_CONFIG", 0x01),
        (0x30, "LHR_RCOUNT_LSB", found.rcount & 0xFF),
        (0x31, "LHR_RCOUNT_MSB", found.rcount >> 8),
        (0x34, "LHR_CONFIG", int(np.log2(found.input_divider))),
        (0x0B, "START_CONFIG", 0x00),
    )
