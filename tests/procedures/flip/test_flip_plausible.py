"""What no accelerometer reads and no clock tells is refused."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.recording import SECOND, Channel, Recording, Source
from inertialcal.procedures.flip.dwells.disturbances import is_reading, stamped
from inertialcal.procedures.flip.inputs import MeanOf, readings_of_means


def recording(y: list[float], seconds: list[float] | None = None) -> Recording:
    time = np.asarray(np.arange(len(y)) if seconds is None else seconds) * SECOND
    channels = (Channel("y", np.array(y), "m/s^2"), Channel("other", np.full(len(y), 1e30)))
    return Recording(channels, time.astype(np.int64), 1.0, source=Source("head.csv", "", "text"), first_row=2)


def test_a_right_recording_stays_as_it_is() -> None:
    one = recording([1e-3, np.nan, -1e30])
    assert stamped(one) is one


def test_a_clock_that_goes_back_is_refused() -> None:
    assert stamped(recording([0.0, 0.0], [1.0, 1.0]))  # twice the same is no step back
    with pytest.raises(DataError, match="time goes back by 3 s, from 5 s to 2 s") as caught:
        stamped(recording([0.0] * 4, [0.0, 5.0, 2.0, 3.0]))
    assert (caught.value.problems[0].where, caught.value.problems[0].code) == ("head.csv:4", "time_backwards")


@pytest.mark.parametrize(("value", "is_one"), [(0.0, True), (np.nan, True), (1e7, False), (-np.inf, False)])
def test_what_a_reading_can_be(value: float, is_one: bool) -> None:
    assert is_reading(value) == is_one


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (MeanOf("y", 0.0, 1e300, where="t.csv:2"), "mean of y is 1e.300 m/s.2, too large for an accelerometer"),
        (MeanOf("y", 0.0, 0.0, half_widths=((0.95, 1e300),), where="t.csv:2"), "half width 0.95 of y is"),
        (MeanOf("y", 0.0, 0.0, others={"median": -1e300}, where="t.csv:2"), "median of y is"),
    ],
)
def test_a_mean_that_is_no_reading_is_refused(bad: MeanOf, words: str) -> None:
    with pytest.raises(DataError, match=words) as caught:
        readings_of_means([bad])
    assert caught.value.problems[0].where == "t.csv:2"
