"""How far a run is, and how it ended."""

from __future__ import annotations

from collections.abc import Callable

EXIT = {"PASS": 0, "FAIL": 1, "INCONCLUSIVE": 4}  # exit status by verdict
Progress = Callable[[int, int, str], None]  # takes tests done, tests in all, what comes next
