"""Time of a record in the unit that its length asks for."""

from __future__ import annotations

import numpy as np

from ....core.estimate import Array

UNITS = ((3.0 * 3600.0, 3600.0, "h"), (300.0, 60.0, "min"))


def scaled(seconds: Array) -> tuple[Array, str]:
    """Return times and their unit."""
    longest = float(np.nanmax(seconds)) if len(seconds) else 0.0
    for least, one, word in UNITS:
        if longest >= least:
            return seconds / one, word
    return seconds, "s"
