"""Slow parts taken out, and what that costs the line."""

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.signals.programme1969.programme import adjusted_curve
from inertialcal.signals.programme1969.reductions import (
    gain_of,
    without_bands,
    without_line,
    without_moving_mean,
    without_tilt,
)

AT = np.arange(100.0)
SINE = np.tile([0.0, 1.0, 0.0, -1.0], 25)
CLOSE = 1e-12


def test_tilt_with_a_mean_of_its_own_is_taken_out() -> None:
    """Both means go first: what the listing of 1969 leaves out."""
    tilt = 500.0 + np.cumsum(np.random.default_rng(1).standard_normal(100))
    rest, coefficient = without_tilt(1700.0 - 0.4 * tilt, tilt)
    assert coefficient == pytest.approx(-0.4)
    np.testing.assert_allclose(rest, 0.0, atol=1e-9)


def test_missing_tilt() -> None:
    tilt = np.where(AT < 50, np.nan, AT)
    rest, coefficient = without_tilt(2.0 * AT, tilt)
    assert coefficient == pytest.approx(2.0)
    assert np.isnan(rest[:50]).all()
    with pytest.raises(DataError, match="0 samples with a tilt reading"):
        without_tilt(AT, np.full(100, np.nan))
    with pytest.raises(DataError, match="does not vary"):
        without_tilt(AT, np.ones(100))
    with pytest.raises(DataError, match="100 samples, 3 of tilt"):
        without_tilt(AT, np.ones(3))


def test_a_line_with_gaps_and_times_of_its_own() -> None:
    times = np.sort(np.random.default_rng(1).uniform(0.0, 50.0, 100))
    x = np.where(AT % 7 == 3, np.nan, 5.0 - 0.2 * times)
    rest = without_line(x, times)
    np.testing.assert_array_equal(np.isnan(rest), np.isnan(x))
    np.testing.assert_allclose(rest[np.isfinite(x)], 0.0, atol=CLOSE)
    with pytest.raises(DataError, match="needs 3 samples"):
        without_line([1.0, np.nan, 2.0])


def test_bands_keep_what_lies_between_and_the_highest_line_goes() -> None:
    low, highest = np.cos(2 * np.pi * 10 * AT / 100), np.cos(np.pi * AT)
    np.testing.assert_allclose(without_bands(3.0 + low + SINE + highest, 20, 21), SINE, atol=CLOSE)
    with pytest.raises(DataError, match="30 \\+ 20 of 50 lines"):
        without_bands(SINE, 30, 20)
    with pytest.raises(DataError, match="are missing"):
        without_bands([1.0, np.nan, 1.0, 0.0, 1.0, 2.0], 0, 1)


def test_moving_mean_takes_a_straight_line_and_keeps_whole_cycles() -> None:
    rest = without_moving_mean(2.0 * AT + SINE, 4, 4)
    np.testing.assert_allclose(rest[4:96], SINE[4:96], atol=CLOSE)


def test_gain_of_a_moving_mean_is_found_and_not_known() -> None:
    """Closed form: the eight samples at the ends take 5/6 of one sample of 50. The printed ends take 2/3 of one."""
    shrinking = gain_of(lambda x: without_moving_mean(x, 4, 4), SINE)
    assert shrinking == pytest.approx(1.0 - 5.0 / 300.0, abs=CLOSE)  # 0.98333
    assert gain_of(lambda x: adjusted_curve(x, 3), SINE) == pytest.approx(1.0 - 2.0 / 150.0, abs=CLOSE)
    assert gain_of(lambda x: without_moving_mean(x, 4, 4, ends=False), SINE) == pytest.approx(1.0, abs=CLOSE)
    amplitude = without_moving_mean(23.0 * SINE + 0.3 * AT, 4, 4) @ SINE / (SINE @ SINE)
    lost = without_moving_mean(0.3 * AT, 4, 4) @ SINE / (SINE @ SINE)
    assert (amplitude - lost) / shrinking == pytest.approx(23.0)


def test_gain_with_gaps_is_that_of_the_gaps() -> None:
    gappy = np.where((AT > 20) & (AT < 25), np.nan, SINE)
    rest = without_moving_mean(gappy, 4, 4)
    np.testing.assert_array_equal(np.isnan(rest), np.isnan(gappy))
    gain = gain_of(lambda x: without_moving_mean(x, 4, 4), gappy)
    assert gain != pytest.approx(0.98333, abs=1e-4)
    there = np.isfinite(rest)
    assert rest[there] @ SINE[there] / (SINE[there] @ SINE[there]) / gain == pytest.approx(1.0)
    with pytest.raises(DataError, match="zero at every sample"):
        gain_of(lambda x: x, np.zeros(8))


def test_a_window_that_is_no_whole_number_of_cycles_is_refused() -> None:
    with pytest.raises(PlanError, match="over 6 samples, 4 samples a cycle") as refused:
        without_moving_mean(SINE, 3, 4)
    assert refused.value.problems[0].do == "Make the reach a multiple of 2"
    with pytest.raises(PlanError, match="Make the reach a multiple of 5"):
        without_moving_mean(SINE, 4, 5)
    with pytest.raises(DataError, match="4 samples for a moving mean over 8"):
        without_moving_mean(SINE[:4], 4)
