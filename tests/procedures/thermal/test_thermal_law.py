"""Cells, law and order: what weighs how much, what is left out, what the polynomial is, at which level it is judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import polynomial
from thermal_sweeps import path, plan, readings, sweep, way

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.procedures.thermal.fit import order as order_module
from inertialcal.procedures.thermal.fit.cells import cells_of, series_of
from inertialcal.procedures.thermal.fit.law import law_of
from inertialcal.procedures.thermal.fit.order import choose_order
from inertialcal.procedures.thermal.reduction import Readings, reduce
from inertialcal.statistics.intervals import contains
from inertialcal.statistics.polynomial import powers_from_series

CUBIC = (0.03, -3e-3, 1.6e-5, -2e-7)
SMALL = 1e-9


def cubic(T: Array) -> Array:
    return np.asarray(polynomial.polyval(T - 20.0, CUBIC))


def test_a_noiseless_cubic_comes_back_to_its_coefficients() -> None:
    cells = cells_of(plan(), series_of(plan(), readings(cubic, gap=0.004), "x"))
    law = law_of(cells, 3)
    found = powers_from_series(3, law.domain, 20.0) @ law.coefficients
    assert found == pytest.approx(CUBIC, rel=2e-3, abs=1e-9)  # a cell sees its mean to second order
    D, _, _ = law.path_contrasts(law.path_basis([-10.0, 20.0, 50.0]))
    assert list(D) == pytest.approx([0.004] * 3, rel=1e-3)
    assert law.midway
    assert law.level == "run"


def test_bins_so_wide_that_the_curve_bends_inside_them_do_no_harm() -> None:
    wide = plan(bins=8)
    law = law_of(cells_of(wide, series_of(wide, readings(cubic), "x")), 3)
    found = powers_from_series(3, law.domain, 20.0) @ law.coefficients
    assert found == pytest.approx(CUBIC, rel=0.02, abs=1e-9)


def test_the_mean_of_a_parabola_over_a_wide_bin_is_taken_exactly() -> None:
    """Mean of a parabola over a cell: its value at the mean temperature and half its curvature times the spread."""
    wide, parabola = plan(bins=8), (0.03, -3e-3, 1.6e-5)
    sweeps = readings(lambda T: np.asarray(polynomial.polyval(T - 20.0, parabola)))
    law = law_of(cells_of(wide, series_of(wide, sweeps, "x")), 2)
    assert powers_from_series(2, law.domain, 20.0) @ law.coefficients == pytest.approx(parabola, rel=1e-9)


def test_a_slow_end_does_not_outweigh_the_rest() -> None:
    """Ten hours at the cold end change nothing: the bin there has the weight of every other."""
    t, T = path(20.0, -20.0, 60.0, 20.0)
    wait = np.full(1800, -20.0)
    at = int(np.argmin(T))
    long_T = np.concatenate([T[: at + 1], wait, T[at + 1 :]])
    long_t = 20.0 * np.arange(float(long_T.size))
    wrong = np.where(long_T == -20.0, 0.05, 0.0)  # something that only the cold end has
    runs = [sweep(f"r{i}", long_t, long_T, cubic(long_T) + wrong) for i in range(3)]
    short = [sweep(f"r{i}", t, T, cubic(T) + np.where(T < -19.6, 0.05, 0.0)) for i in range(3)]
    laws = [
        law_of(cells_of(plan(), series_of(plan(), Readings(tuple(one)), "x")), 1).coefficients for one in (runs, short)
    ]
    assert laws[0] == pytest.approx(laws[1], rel=0.25)
    whole = np.polynomial.polynomial.polyfit(long_T, cubic(long_T) + wrong, 1)
    assert abs(whole[1] - np.polynomial.polynomial.polyfit(T, cubic(T), 1)[1]) > 2e-4  # all samples alike: bent


def test_two_ramps_through_one_bin_share_its_weight() -> None:
    t, T = path(0.0, 60.0, 0.0, 60.0, 0.0)
    cells = cells_of(plan(), series_of(plan(), Readings((sweep("a", t, T, T * 0.0),)), "x"))
    sums: dict[tuple[int, int], float] = {}
    keys = zip(cells.path.tolist(), cells.bin.tolist(), strict=True)
    for weight, key in zip(cells.weight.tolist(), keys, strict=True):
        sums[key] = sums.get(key, 0.0) + weight
    assert list(sums.values()) == pytest.approx([1.0] * len(sums))


def test_every_sample_is_counted_once() -> None:
    found = readings(cubic, noise=1e-3)
    spoiled = found.sweeps[0].outputs["x"].copy()
    spoiled[100:110] = np.nan
    first = replace(found.sweeps[0], outputs={"x": spoiled})
    found = replace(found, sweeps=(first, *found.sweeps[1:]))
    series = series_of(plan(), found, "x")
    cells = cells_of(plan(), series, 300.0)
    assert int(cells.samples.sum()) + sum(cells.left_out.values()) == len(found)
    assert cells.left_out["invalid"] == 10
    assert cells.left_out["warm_up"] == 5 * 15  # 300 s of 20 s samples in each run


@pytest.mark.parametrize(("coefficients", "order"), [((0.1,), 0), ((0.1, 2e-3), 1), ((0.0, 1e-3, 2e-5), 2), (CUBIC, 3)])
def test_the_order_is_that_of_the_truth(coefficients: tuple[float, ...], order: int) -> None:
    def truth(T: Array) -> Array:
        return np.asarray(polynomial.polyval(T - 20.0, coefficients)) + 0.0 * T

    chosen = []
    for seed in range(1, 16):
        cells = cells_of(plan(), series_of(plan(), readings(truth, noise=2e-3, offset=0.01, seed=seed), "x"))
        chosen.append(choose_order(cells, 5).order)
    assert min(chosen) >= order
    assert np.mean(np.array(chosen) == order) > 0.7


def test_an_order_that_is_given_is_taken_and_the_scores_are_told() -> None:
    cells = cells_of(plan(), series_of(plan(), readings(cubic, noise=1e-3), "x"))
    choice = choose_order(cells, 5, given=2)
    assert (choice.order, choice.held_out) == (2, "given")
    assert choice.scores[3] < 0.5 * choice.scores[2]


@pytest.mark.parametrize("runs", [1, 2, 5])
def test_orders_solved_at_once_predict_as_each_alone(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    found = readings(lambda T: 1e-3 * T + 1e-6 * T**3, runs=runs, gap=1e-3, noise=1e-3, offset=1e-2)
    at_once = choose_order(cells_of(plan(), series_of(plan(), found, "x")), 5)
    monkeypatch.setattr(order_module, "SAFE", 0.0)
    alone = choose_order(cells_of(plan(), series_of(plan(), found, "x")), 5)
    assert at_once.scores == pytest.approx(alone.scores, rel=1e-9)
    assert (at_once.order, at_once.held_out) == (alone.order, alone.held_out)


def test_what_is_held_out_follows_from_what_there_is() -> None:
    def held_out(found: Readings) -> str:
        return choose_order(cells_of(plan(), series_of(plan(), found, "x")), 4).held_out

    assert held_out(readings(cubic, runs=3, noise=1e-3)) == "runs"
    assert held_out(readings(cubic, runs=2, noise=1e-3)) == "ramps"
    assert held_out(readings(cubic, runs=1, noise=1e-3)) == "blocks"


def test_a_run_is_predicted_but_for_its_offset() -> None:
    """Offsets of a tenth of a volt do not hide a cubic of a hundredth."""
    cells = cells_of(plan(), series_of(plan(), readings(cubic, noise=1e-3, offset=1.0), "x"))
    assert choose_order(cells, 5).order == 3


def test_the_order_is_found_where_one_run_of_three_alone_shows_both_paths() -> None:
    """The other two tell nothing of what the paths differ by: no score of the third may rest on it."""
    rng, swept = np.random.default_rng(2), []
    for number, points in enumerate([(-30.0, 67.0), (-30.0, 67.0, -30.0), (67.0, -30.0)], 1):
        t, T = path(*points)
        swept.append(sweep(f"run{number}", t, T, cubic(T) + 1e-3 * way(T) + rng.normal(0.0, 1e-3, T.size)))
    cells = cells_of(plan(), series_of(plan(), Readings(tuple(swept)), "x"))
    choice = choose_order(cells, 5)
    assert (choice.held_out, choice.order) == ("runs", 3)
    assert np.nanmax(choice.scores) < 1.0


def test_the_score_of_an_order_is_the_mean_square_error_on_the_run_held_out() -> None:
    """Runs of different slopes, no noise: the run held out is off by its slope less the mean slope of the others."""
    t, T = path(23.0, -30.0, 67.0, 23.0)
    slopes = np.array([1e-3, 2e-3, 4e-3])
    runs = Readings(tuple(sweep(f"r{i}", t, T, slope * T) for i, slope in enumerate(slopes)))
    cells = cells_of(plan(), series_of(plan(), runs, "x"))
    one = cells.run == 0
    mean = np.average(cells.temperature[one], weights=cells.weight[one])
    variance = np.average((cells.temperature[one] - mean) ** 2, weights=cells.weight[one])
    errors = slopes - (slopes.sum() - slopes) / 2.0
    assert choose_order(cells, 2).scores[1] == pytest.approx(np.sqrt(np.mean(errors**2) * variance), rel=1e-6)


def test_the_scatter_in_a_cell_is_that_of_the_noise_whatever_its_slope() -> None:
    """Two degrees of freedom of each cell go to its own line over temperature."""
    noise = 2e-3
    cells = cells_of(plan(), series_of(plan(), readings(lambda T: 0.05 * T, runs=10, noise=noise), "x"))
    free = cells.samples - 2.0
    assert np.median(free) < 5.0  # few enough for the degrees of freedom to count
    found = np.sum(free * cells.scatter**2) / free.sum()
    assert found == pytest.approx(noise**2, rel=4.0 * np.sqrt(2.0 / free.sum()))
    assert free.sum() > 1000.0


@pytest.mark.parametrize(("runs", "points", "level"), [
    (4, (23.0, -30.0, 67.0, 23.0), "run"),
    (1, (0.0, 60.0, 0.0, 60.0, 0.0), "ramp"),
    (1, (23.0, -30.0, 67.0), "block"),
])  # fmt: skip
def test_the_uncertainty_is_that_of_the_highest_level_that_was_repeated(
    runs: int, points: tuple[float, ...], level: str
) -> None:
    cells = cells_of(plan(), series_of(plan(), readings(cubic, runs, points, noise=1e-3), "x"))
    assert law_of(cells, 2).level == level


def test_the_uncertainty_of_equal_runs_is_the_scatter_of_their_own_fits() -> None:
    found = readings(cubic, noise=1e-3, offset=0.01)
    series = series_of(plan(), found, "x")
    law = law_of(cells_of(plan(), series), 3)
    own = []
    for number in range(5):
        alone = replace(series, reading=np.where(series.run == number, series.reading, np.nan))
        own.append(law_of(cells_of(plan(), alone), 3))
    at = law.basis([-20.0, 0.0, 20.0, 60.0])
    values = np.array([one.basis([-20.0, 0.0, 20.0, 60.0]) @ one.coefficients for one in own])
    covariance, dof = law.contrasts(at)
    assert np.sqrt(np.diag(covariance)) == pytest.approx(values.std(axis=0, ddof=1) / np.sqrt(5.0), rel=0.03)
    assert dof == pytest.approx([4.0] * 4, rel=1e-3)


def test_half_a_range_on_one_path_only_is_left_out() -> None:
    """It cools from 65 to -25 and warms to 30: nothing says what it would read at 60 while warming."""
    found = readings(cubic, 4, (65.0, -25.0, 30.0), noise=1e-3)
    cells = cells_of(plan(), series_of(plan(), found, "x"))
    assert cells.left_out["one_path"] > 0
    assert cells.range[1] < 45.0
    assert cells.both is not None
    assert cells.both[1] < 31.0


def test_shift_and_scale_of_readings() -> None:
    base = readings(cubic, noise=1e-3, gap=0.002, offset=0.01)
    moved = replace(
        base, sweeps=tuple(replace(one, outputs={"x": 3.0 * one.outputs["x"] + 0.5}) for one in base.sweeps)
    )
    a, b = (law_of(cells_of(plan(), series_of(plan(), one, "x")), 3) for one in (base, moved))
    assert b.coefficients == pytest.approx(3.0 * a.coefficients + 0.5 * np.eye(4)[0], abs=1e-9)
    at = a.basis([0.0, 40.0])
    assert b.contrasts(at)[0] == pytest.approx(9.0 * a.contrasts(at)[0], rel=1e-6)


def test_the_other_way_round_in_temperature_mirrors_the_law() -> None:
    base = readings(cubic, noise=1e-3)
    mirrored = replace(
        base, sweeps=tuple(replace(one, temperature={"x": -one.temperature["x"]}) for one in base.sweeps)
    )
    a, b = (law_of(cells_of(plan(), series_of(plan(), one, "x")), 3) for one in (base, mirrored))
    at = np.array([-20.0, 5.0, 40.0])
    assert b.basis(-at) @ b.coefficients == pytest.approx(a.basis(at) @ a.coefficients, abs=2e-4)
    sign = np.sum(way(base.sweeps[0].temperature["x"]))
    assert np.sum(way(mirrored.sweeps[0].temperature["x"])) == -sign


def test_refusals() -> None:
    t, T = path(20.0, 24.0, 20.0)
    with pytest.raises(DataError, match=r"temperature from 20.2 to 23.8 degC, a range of 3.6") as found:
        reduce(plan(), Readings((sweep("a", t, T, T),)))
    assert found.value.problems[0].code == "no_temperature_change"
    t, T = path(0.0, 60.0)
    with pytest.raises(DataError, match="no sample is valid"):
        reduce(plan(), Readings((sweep("a", t, T, np.full(T.size, np.nan)),)))
    with pytest.raises(DataError, match="no temperature"):
        reduce(plan(), Readings((replace(sweep("a", t, T, T), temperature={}),)))
    with pytest.raises(DataError, match="no sample lies on a ramp"):
        reduce(plan(turn_over=80.0), Readings((sweep("a", t, T, T),)))
    with pytest.raises(DataError, match="no sensor was read"):
        reduce(plan(), Readings(()))


def test_the_interval_allows_for_the_choice_of_the_order() -> None:
    """A cubic term too small to be chosen: of a parabola alone the slope would be off by up to three half widths."""
    held = 0
    small = (0.02, 2e-4, 3e-6, 1.5e-8)
    for seed in range(1, 13):
        given = readings(lambda T: np.asarray(polynomial.polyval(T - 20.0, small)), noise=2e-3, seed=seed)
        found = reduce(plan(), given)
        row = next(one for one in found.rows() if str(one.key) == "bias_temperature_1_x")
        held += row.interval is not None and contains(row.interval, small[1])
        alone = found.sensors["x"].law
        assert found.estimate is not None
        sources = [str(one.origin) for one in found.estimate.components]
        assert ("order of the polynomial" in sources) == (alone.higher is not None)
    assert held >= 10
    told = reduce(plan(order=3), given)
    assert told.estimate is not None
    assert "order of the polynomial" not in [str(one.origin) for one in told.estimate.components]
