"""Values at the ends of a range: clipped noise and sines are told, coarse codes and slow sines are not."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.signals.vibration.rails import rails_of

NOISE = np.random.default_rng(1).standard_normal(20_000)
SLOW = np.sin(2.0 * np.pi * 0.004 * np.arange(20_000) + 0.3)


@pytest.mark.parametrize("x", [NOISE, np.rint(3.0 * NOISE), SLOW, np.round(SLOW, 3), np.zeros(100), NOISE[:5]])
def test_what_is_not_clipped_has_no_rails(x: Array) -> None:
    assert rails_of(x).samples == 0


@pytest.mark.parametrize(("x", "end"), [(NOISE, 2.5), (np.round(NOISE, 2), 2.5), (SLOW, 0.9), (np.round(SLOW, 3), 0.9)])
def test_what_is_clipped_is_told_with_its_samples(x: Array, end: float) -> None:
    beyond = int(np.count_nonzero(np.abs(x) >= end))
    found = rails_of(np.clip(x, -end, end))
    assert found.samples == beyond
    assert abs(found.value) == end
    above = np.clip(x, -10.0, end)
    above[::97] = np.nan
    assert rails_of(above).value == end


def test_runs_are_counted_at_both_ends() -> None:
    x = np.array([0.0, 1.0, 1.0, 0.2, 1.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.5, -1.0, 0.1])
    assert rails_of(x).runs == 3
