"""How many campaigns a test of coverage draws: all of them in ``make coverage``, fewer in ``make slow``."""

from __future__ import annotations

import os

FULL = os.environ.get("INERTIALCAL_COVERAGE") == "full"


def sized(full: int, slow: int) -> int:
    """Return how many: seeds are 1 to n in both, never selected."""
    return full if FULL else slow
