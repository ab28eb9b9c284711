"""How much a slow test takes: all in ``make coverage``, a part of it in ``make slow``."""

from __future__ import annotations

import os
from typing import TypeVar

FULL = os.environ.get("INERTIALCAL_COVERAGE") == "full"
T = TypeVar("T")


def sized(full: T, slow: T) -> T:
    """Return the number of seeds, 1 to n in both and never selected, or the cases to try."""
    return full if FULL else slow
