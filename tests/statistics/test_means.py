"""Means at every level: the GUM's two-level example, closed forms, unbiasedness, invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics.intervals import contains, covers, t_interval
from inertialcal.statistics.means import (
    birge_ratio,
    block_means,
    combine_means,
    mean,
    nested_mean,
    pooled_std,
    weighted_mean,
)

HALVES = np.array([[0.5, -0.5], [0.5, 0.5]])
CLOSED = 1e-12  # relative

# JCGM 100:2008, Table H.9: daily means less 10 V and standard deviations of 5 readings a day [uV]
ZENER_MEANS = np.array([172.0, 116.0, 13.0, 144.0, 106.0, 31.0, 60.0, 125.0, 163.0, 41.0])
ZENER_STDS = np.array([60.0, 77.0, 111.0, 101.0, 67.0, 93.0, 80.0, 73.0, 88.0, 86.0])
ROUNDING = 0.51  # uV, H.5.2.2 to H.5.2.6


def five_readings(average: float, std: float) -> Array:
    pattern = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]) / math.sqrt(2.5)
    return average + std * pattern


def test_zener_standard_of_the_gum() -> None:
    readings = np.concatenate([five_readings(m, s) for m, s in zip(ZENER_MEANS, ZENER_STDS, strict=True)])
    found = nested_mean(readings, {"day": np.repeat(np.arange(10), 5)})
    day, sample = found.levels
    assert found.mean.value == pytest.approx(97.0, abs=ROUNDING)
    assert found.mean.u == pytest.approx(18.0, abs=ROUNDING)
    assert (found.level, found.mean.dof, found.not_repeated) == ("day", 9.0, ())
    assert day.mean_square is not None
    assert sample.mean_square is not None
    assert math.sqrt(day.mean_square) == pytest.approx(57.0, abs=ROUNDING)
    assert math.sqrt(5.0 * day.mean_square) == pytest.approx(128.0, abs=ROUNDING)  # s_a of (H.25a)
    assert math.sqrt(sample.mean_square) == pytest.approx(85.0, abs=ROUNDING)
    assert (day.dof, sample.dof) == (9, 40)


def test_mean_of_three() -> None:
    found = mean([1.0, 2.0, 4.0])
    assert found.value == pytest.approx(7.0 / 3.0, rel=CLOSED)
    assert found.u == pytest.approx(math.sqrt(7.0 / 9.0), rel=CLOSED)  # s² = 7/3
    assert found.dof == 2.0


def test_weighted_mean_of_two() -> None:
    found = weighted_mean([1.0, 2.0], [1.0, 0.5], dof=[4.0, 6.0])
    assert found.value == pytest.approx(1.8, rel=CLOSED)  # weights 1 and 4
    assert found.u == pytest.approx(1.0 / math.sqrt(5.0), rel=CLOSED)
    assert found.dof == pytest.approx(1.0 / (0.2**2 / 4.0 + 0.8**2 / 6.0), rel=CLOSED)
    assert weighted_mean([1.0, 2.0], [1.0, 0.5]).dof == math.inf


def test_weighted_mean_of_equal_uncertainties_is_the_mean() -> None:
    x = np.array([3.0, 5.0, 10.0, 2.0])
    assert weighted_mean(x, np.full(4, 0.2)).value == pytest.approx(x.mean(), rel=CLOSED)
    assert birge_ratio(x, np.full(4, x.std(ddof=1))) == pytest.approx(1.0, rel=CLOSED)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=30), st.floats(-1e3, 1e3), st.floats(0.1, 10.0))
def test_mean_follows_shift_and_scale(readings: list[float], shift: float, scale: float) -> None:
    one, other = mean(readings), mean(scale * np.array(readings) + shift)
    assert other.value == pytest.approx(scale * one.value + shift, abs=1e-8)
    assert other.u == pytest.approx(scale * one.u, rel=1e-6, abs=1e-9)


def test_block_means_leave_the_unfilled_block_out() -> None:
    assert block_means(np.arange(8.0), 3).tolist() == [1.0, 4.0]
    two = block_means(np.column_stack([np.arange(8.0), 2.0 * np.arange(8.0)]), 4)
    assert two.tolist() == [[1.5, 3.0], [5.5, 11.0]]
    assert block_means(np.arange(2.0), 3).size == 0


def test_pooled_standard_deviation() -> None:
    std, dof = pooled_std([3.0, 4.0], [1.0, 3.0])
    assert std == pytest.approx(math.sqrt((9.0 + 48.0) / 4.0), rel=CLOSED)
    assert dof == 4.0
    assert pooled_std([2.0, 99.0], [5.0, 0.0]) == (2.0, 5.0)


def test_half_sum_and_half_difference() -> None:
    blocks = {"position 0": np.array([3.0, 5.0]), "position pi": np.array([1.0, 2.0, 3.0])}
    found = combine_means(blocks, HALVES, ("G", "B"), "ug")
    variances = np.array([1.0, 1.0 / 3.0])  # s²/n of the two dwells
    assert found.values.tolist() == [1.0, 3.0]
    assert found.u == pytest.approx(np.full(2, 0.5 * math.sqrt(variances.sum())), rel=CLOSED)
    assert found.covariance[0, 1] == pytest.approx(0.25 * (variances[0] - variances[1]), rel=CLOSED)
    welch = variances.sum() ** 2 / (variances**2 / np.array([1.0, 2.0])).sum()
    assert found.dof == pytest.approx([welch, welch], rel=CLOSED)
    assert [c.source for c in found.components] == [
        "scatter of block means, position 0",
        "scatter of block means, position pi",
    ]
    assert found.units == ("ug", "ug")


def balanced(
    rng: np.random.Generator, runs: int, dwells: int, samples: int
) -> tuple[Array, dict[str, NDArray[np.intp]]]:
    run_error = rng.normal(0.0, 3.0, (runs, 1, 1))
    dwell_error = rng.normal(0.0, 1.0, (runs, dwells, 1))
    x = 10.0 + run_error + dwell_error + rng.normal(0.0, 0.5, (runs, dwells, samples))
    labels = np.indices(x.shape)
    return x.ravel(), {"run": labels[0].ravel(), "dwell": labels[1].ravel()}


def test_mean_squares_of_three_levels_are_those_of_the_textbook() -> None:
    """Sums of squares of the balanced nested analysis of variance, written out."""
    x, labels = balanced(np.random.default_rng(5), runs=4, dwells=3, samples=6)
    cube = x.reshape(4, 3, 6)
    dwell, run = cube.mean(axis=2), cube.mean(axis=(1, 2))
    textbook = [
        3 * 6 * np.sum((run - cube.mean()) ** 2) / 3,
        6 * np.sum((dwell - run[:, None]) ** 2) / 8,
        np.sum((cube - dwell[:, :, None]) ** 2) / 60,
    ]
    found = nested_mean(x, labels)
    assert [level.name for level in found.levels] == ["run", "dwell", "sample"]
    assert [level.dof for level in found.levels] == [3, 8, 60]
    assert [level.groups for level in found.levels] == [4, 12, 72]
    squares = np.array([level.mean_square for level in found.levels], dtype=float)
    assert squares * [18, 6, 1] == pytest.approx(np.array(textbook), rel=1e-10)
    assert found.mean.value == pytest.approx(cube.mean(), rel=CLOSED)
    assert found.mean.u == pytest.approx(math.sqrt(textbook[0] / 72), rel=1e-10)


def test_a_level_that_was_not_repeated_is_named() -> None:
    x = [1.0, 1.1, 2.0, 2.1]
    found = nested_mean(x, {"day": [1] * 4, "run": [1] * 4, "dwell": [1, 1, 2, 2]})
    assert found.level == "dwell"
    assert found.not_repeated == ("day", "run")
    assert found.mean.dof == 1.0
    assert found.levels[0].mean_square is None
    assert found.mean.u == pytest.approx(0.5, rel=CLOSED)  # dwell means 1.05 and 2.05


def test_one_dwell_a_run_gives_no_scatter_of_dwells() -> None:
    found = nested_mean([1.0, 2.0, 4.0], {"run": ["a", "b", "c"], "dwell": [1, 1, 1]})
    assert [level.mean_square is None for level in found.levels] == [False, True, True]
    assert found.mean.u == pytest.approx(mean([1.0, 2.0, 4.0]).u, rel=CLOSED)
    assert found.mean.dof == 2.0


def test_samples_of_one_dwell_alone() -> None:
    found = nested_mean([1.0, 2.0, 4.0], {})
    assert (found.level, found.not_repeated) == ("sample", ())
    assert found.mean.u == pytest.approx(mean([1.0, 2.0, 4.0]).u, rel=CLOSED)
    assert found.mean.dof == 2.0


def test_labels_may_be_used_again_in_another_run() -> None:
    x = np.array([1.0, 3.0, 10.0, 14.0])
    again = nested_mean(x, {"run": [1, 1, 2, 2], "dwell": [1, 2, 1, 2]})
    never = nested_mean(x, {"run": [1, 1, 2, 2], "dwell": [1, 2, 3, 4]})
    assert again == never


@given(st.permutations(range(12)))
def test_order_of_readings_does_not_matter(order: list[int]) -> None:
    x, labels = balanced(np.random.default_rng(2), runs=2, dwells=3, samples=2)
    at = np.array(order)
    one, other = nested_mean(x, labels), nested_mean(x[at], {k: v[at] for k, v in labels.items()})
    assert other.mean.value == pytest.approx(one.mean.value, rel=CLOSED)
    assert other.mean.u == pytest.approx(one.mean.u, rel=1e-9)


def unequal_runs(rng: np.random.Generator) -> tuple[Array, dict[str, NDArray[np.intp]]]:
    """Six runs of 1 to 12 dwells; run errors twice those of dwells; true mean 5."""
    run = np.repeat(np.arange(6), [1, 2, 2, 4, 8, 12])
    return 5.0 + rng.normal(0.0, 2.0, 6)[run] + rng.normal(0.0, 1.0, run.size), {"run": run}


@pytest.mark.parametrize("n", [300, pytest.param(3000, marks=pytest.mark.slow)])
def test_interval_from_unequal_runs_keeps_its_promise(n: int) -> None:
    hits = 0
    for seed in range(1, n + 1):
        found = nested_mean(*unequal_runs(np.random.default_rng(seed)), innermost="dwell").mean
        hits += contains(t_interval(found.value, found.u, found.dof), 5.0)
    assert covers(hits, n)


def test_variance_of_the_mean_is_unbiased_for_unequal_runs() -> None:
    """Expected u² is (run variance + dwell variance times the mean of 1/dwells) over the runs."""
    squares = [
        nested_mean(*unequal_runs(np.random.default_rng(seed)), innermost="dwell").mean.u ** 2
        for seed in range(1, 2001)
    ]
    expected = (4.0 + np.mean(1.0 / np.array([1, 2, 2, 4, 8, 12]))) / 6.0
    assert np.mean(squares) == pytest.approx(expected, abs=float(4.0 * np.std(squares)) / math.sqrt(2000.0))


def test_refusals_by_their_words() -> None:
    with pytest.raises(DataError, match=r"position pi: 1 value\(s\), need 2 or more for an uncertainty"):
        combine_means({"position 0": np.arange(3.0), "position pi": np.arange(1.0)}, HALVES, ("G", "B"))
    with pytest.raises(DataError, match="position 0: all 3 values are 2"):
        combine_means({"position 0": np.full(3, 2.0), "position pi": np.arange(3.0)}, HALVES, ("G", "B"))
    with pytest.raises(DataError, match=r"matrix of shape \(2, 2\) for 1 values of 1 dwells"):
        combine_means({"position 0": np.arange(3.0)}, HALVES, ("G",))
    with pytest.raises(DataError, match="readings: 2 not finite, the first is number 2"):
        mean([1.0, math.nan, math.inf])
    with pytest.raises(DataError, match=r"0 value\(s\), need 2"):
        mean([])
    with pytest.raises(DataError, match="blocks of 0 readings"):
        block_means(np.arange(4.0), 0)
    with pytest.raises(DataError, match="1 not finite, the first is number 3"):
        block_means(np.array([[1.0, 2.0], [3.0, 4.0], [math.nan, 1.0]]), 1)
    with pytest.raises(DataError, match="smallest standard uncertainty 0"):
        weighted_mean([1.0, 2.0], [0.0, 1.0])
    with pytest.raises(DataError, match="0 values"):
        weighted_mean([], [])
    with pytest.raises(DataError, match=r"1 value\(s\), need 2"):
        birge_ratio([1.0], [1.0])
    with pytest.raises(DataError, match="with 0 degrees of freedom"):
        pooled_std([1.0, 2.0], [0.0, 0.0])
    with pytest.raises(DataError, match="from -1 up"):
        pooled_std([-1.0, 2.0], [3.0, 3.0])
    with pytest.raises(DataError, match=r"level 'run': labels of shape \(2,\) for 3 readings"):
        nested_mean([1.0, 2.0, 3.0], {"run": [1, 2]})
