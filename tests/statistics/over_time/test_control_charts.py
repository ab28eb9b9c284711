"""Control charts: published examples and constants, shares of standards, false alarms."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.statistics.difference import Figure
from inertialcal.statistics.intervals import covers
from inertialcal.statistics.over_time.control_charts import RUN, c4, individuals, lots

# NIST/SEMATECH e-Handbook 6.3.2.2: flow rate of ten batches, and what stands below the table
FLOW = (49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1)
# Constants of X-bar and S charts for n = 2, 5, 10: c4, A3, B3, B4 (the tables of textbooks)
CONSTANTS = {2: (0.7979, 2.659, 0.0, 3.267), 5: (0.9400, 1.427, 0.0, 2.089), 10: (0.9727, 0.975, 0.284, 1.716)}
LAST_DIGIT = 6e-4


def plain(values: np.ndarray | tuple[float, ...], u: float = 0.0) -> list[Figure]:
    return [Figure(float(y), u) for y in values]


def test_individuals_of_the_handbook() -> None:
    chart = individuals(plain(FLOW))
    assert chart.centre == pytest.approx(50.81, abs=5e-3)
    assert chart.spread_centre == pytest.approx(1.8778, abs=5e-5)
    assert chart.upper[0] == pytest.approx(55.8041, abs=2e-3)  # with d2 = 1.128
    assert chart.lower[-1] == pytest.approx(45.8159, abs=2e-3)
    assert chart.spread_upper[1] == pytest.approx(3.267 * 1.8778, abs=2e-3)
    assert chart.in_control


@pytest.mark.parametrize("n", CONSTANTS)
def test_constants_of_lots(n: int) -> None:
    factor, a3, b3, b4 = CONSTANTS[n]
    assert float(c4(np.array(float(n)))) == pytest.approx(factor, abs=LAST_DIGIT / 6)
    rng = np.random.default_rng(n)
    chart = lots(plain(rng.normal(size=8 * n)), [i // n for i in range(8 * n)])
    s = chart.spread.mean()
    assert chart.spread_centre == pytest.approx(s)
    assert (chart.upper[0] - chart.centre) / s == pytest.approx(a3, abs=LAST_DIGIT)
    assert chart.spread_lower[0] / s == pytest.approx(b3, abs=LAST_DIGIT)
    assert chart.spread_upper[0] / s == pytest.approx(b4, abs=LAST_DIGIT)


def test_an_error_that_all_tests_share_is_in_no_limit() -> None:
    rng = np.random.default_rng(1)
    y = rng.normal(0.0, 0.1, 50)
    one = individuals([Figure(v, 0.5, changes={"table": 0.5}) for v in y])
    assert one.upper - one.lower == pytest.approx(individuals(plain(y)).upper - individuals(plain(y)).lower, rel=0.02)


def test_another_certificate_widens_the_limits_instead_of_a_signal() -> None:
    rng = np.random.default_rng(2)
    y = rng.normal(0.0, 0.1, 60) + np.repeat([0.0, 1.0], 30)  # the standards differ by what they may
    alone = individuals(plain(y))
    known = individuals([Figure(v, 0.8, changes={"C-1" if i < 30 else "C-2": 0.8}) for i, v in enumerate(y)])
    assert alone.out.any()
    assert not known.out.any()
    assert known.process == pytest.approx(0.1, rel=0.35)


def test_the_scatter_of_tests_is_told_from_that_of_units() -> None:
    rng = np.random.default_rng(3)
    chart = individuals(plain(rng.normal(0.0, np.hypot(0.3, 0.4), 2000), 0.4))
    assert chart.process == pytest.approx(0.3, rel=0.15)


def test_signals() -> None:
    rng = np.random.default_rng(4)
    y = rng.normal(0.0, 1.0, 40)
    y[20] = 9.0
    assert individuals(plain(y)).out.tolist().index(True) == 20
    shifted = np.concatenate([rng.normal(0.0, 1.0, 30), np.full(RUN, 0.9)])
    assert individuals(plain(shifted)).in_run[-1]
    wide = np.concatenate([rng.normal(0.0, 1.0, 60), rng.normal(0.0, 8.0, 6)])
    assert lots(plain(wide), [i // 6 for i in range(66)]).spread_out[-1]


def test_false_alarms_are_as_rare_as_stated() -> None:
    n = 300
    rng = np.random.default_rng(5)
    outside = sum(int(individuals(plain(rng.normal(size=100))).out.sum()) for _ in range(n))
    assert covers(100 * n - outside, 100 * n, low=0.99, high=0.999)  # 0.27 %, and a little more for estimated limits


def test_too_few_are_refused() -> None:
    with pytest.raises(DataError, match="2 figures, need 3"):
        individuals(plain((1.0, 2.0)))
    with pytest.raises(DataError, match="fewer than two lots"):
        lots(plain((1.0, 2.0, 3.0)), ["a", "a", "b"])
