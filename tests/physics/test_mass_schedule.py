"""Schedule of a moved mass: its period counts the moves, and what is no schedule is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import PlanError
from inertialcal.physics.motion.schedule import Schedule, repeated

NA = 23e-9 * 9.81  # m/s^2


def reinel(**changed: Any) -> Schedule:
    given: dict[str, Any] = {"cycles": 3, "dwell": 100.0, "move": 20.0, "drive": "sine"} | changed
    return repeated([0.2, 0.1, 0.2, 0.4], [0.0, NA, 0.0, -NA], **given)


def test_a_cycle_of_four_dwells_with_moves_has_the_period_480_s() -> None:
    schedule = reinel()
    assert schedule.step == 120.0
    assert schedule.frequency == pytest.approx(1 / 480)  # the report prints 0.0025 Hz, which leaves the moves out
    assert schedule.middle[:3].tolist() == [50.0, 170.0, 290.0]
    assert schedule.stop[-1] == 11 * 120.0 + 100.0
    assert schedule.amplitude == pytest.approx(NA)
    assert len(schedule) == 12


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"dwell": 0.0}, "a dwell of 0 s"),
        ({"dwell": np.nan}, "a dwell of nan s"),
        ({"move": -1.0}, "a move of -1 s"),
        ({"start": [0.0, 50.0, 240.0]}, "dwell 2 starts at 50 s, before dwell 1 ends at 100 s"),
        ({"start": [0.0, -120.0, 240.0]}, "dwell 2 starts"),
        ({"start": [0.0, np.inf, 240.0]}, "start of a schedule: finite"),
        ({"applied": [NA, NA, NA]}, "same acceleration is applied in every dwell"),
        ({"applied": [NA, -NA]}, r"applied \(2,\)"),
        ({"drive": "triangle"}, "drive 'triangle' is not known: sine, square, abab, custom"),
        ({"samples_per_cycle": 1}, "1 dwell"),
        ({"u_applied": -0.1}, "relative uncertainty of -0.1"),
    ],
)
def test_what_is_no_schedule_is_refused(changed: dict[str, Any], words: str) -> None:
    good: dict[str, Any] = {
        "start": [0.0, 120.0, 240.0], "dwell": 100.0, "move": 20.0, "position": [0.0, 0.1, 0.0],
        "applied": [NA, -NA, NA], "drive": "abab", "samples_per_cycle": 2,
    }  # fmt: skip
    Schedule(**good)
    with pytest.raises(PlanError, match=words):
        Schedule(**good | changed)


def test_no_cycle_is_refused() -> None:
    with pytest.raises(PlanError, match="schedule of 0 cycles"):
        reinel(cycles=0)
