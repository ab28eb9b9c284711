"""What remarks of a run say is true: a band of a run that is off as a whole, hum, channels that differ, the time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from vibration_runs import PLAN, QUICK, SHORT, readings_of

from independent.vibration.random_run import Array, simulate
from inertialcal.procedures.vibration.reduction import Result, reduce

BASE = replace(QUICK, error=0.0)


def of(control: Array) -> Result:
    return reduce(PLAN, readings_of(BASE, 1, control=control))


def told(result: Result, code: str) -> list[str]:
    return [one.what for one in result.remarks if one.code == code]


def test_a_band_of_a_run_that_is_off_as_a_whole_is_told_with_the_level_that_is_taken_off() -> None:
    hump = ((20.0, 0.01), (80.0, 0.04), (120.0, 0.04), (121.0, 0.16), (150.0, 0.16), (151.0, 0.04), *SHORT[2:])
    x = simulate(replace(BASE, nodes=hump), 1)[0]
    (plain,) = told(of(x), "band_off")
    (moved,) = told(of(x * 10.0 ** (3.0 / 20.0)), "band_off")
    assert "above the profile (" in plain
    assert "above the profile moved by 3.1 dB to the run's own level (" in moved
    assert plain.split(" above")[0] == moved.split(" above")[0]


@pytest.mark.parametrize("frequency", [50.0, 60.0])
def test_hum_is_told_where_it_is_and_as_large_as_it_is(frequency: float) -> None:
    (what,) = told(of(simulate(replace(BASE, tones=((frequency, 0.8),)), 2)[0]), "lines")
    said, _, rest = what.removeprefix("sine in the random spectrum: ").partition(" Hz, amplitude ")
    assert float(said) == pytest.approx(frequency, abs=0.6)
    assert float(rest.removesuffix(" g")) == pytest.approx(0.8, rel=0.15)


def test_of_two_control_channels_that_differ_none_is_blamed_and_of_three_the_one_that_does() -> None:
    x = simulate(replace(BASE, channels=2, coherence=0.99), 1)[0]
    (two,) = told(of(x * [1.0, 0.5]), "control_disagrees")
    assert two.startswith("channel 'control_1' and channel 'control_2' differ by 6 dB")
    assert not told(of(x * [1.0, 0.8]), "control_disagrees")
    (three,) = told(of(np.column_stack([x, 0.5 * x[:, 0]])), "control_disagrees")
    assert three.startswith("channel 'control_3' differs from the other control channels by 6 dB")


def test_what_lies_behind_the_last_window_counts() -> None:
    x = simulate(BASE, 1)[0]
    window = of(x).levels.size
    for beyond in (1, window // 2, window - 1):
        n = 40 * window + beyond
        assert of(x[:n]).levels.duration == pytest.approx(n / BASE.rate, abs=1e-9)
