"""Fit of noise terms: truth recovered, what is not identified, misfit, several runs, units, refusals."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from noise_records import GMWM, WALK, curve, exact_run, fitted, names, record, values

from inertialcal.core.errors import DataError, PlanError
from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.fitting.goodness import chi_square, residual_test
from inertialcal.sensors.noise.fitting.likelihood import covariance_of_runs, estimate, mean_of, slopes_of, time_at
from inertialcal.sensors.noise.fitting.problem import Run, expected, problem_of
from inertialcal.sensors.noise.planner import plan_record
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
)
from inertialcal.signals.allan import allan

EXACT = 1e-3  # of a coefficient fitted to exact variances


@pytest.mark.parametrize("averaging", [None, 1.0])
@pytest.mark.parametrize(
    "terms",
    [
        (RandomWalk(1.0), BiasInstability(0.2), RateRandomWalk(0.01)),
        (RandomWalk(1.0), GaussMarkov(0.3, 40.0), RateRandomWalk(0.003)),
        (RandomWalk(1.0), RateRamp(1e-3)),
    ],
    ids=lambda terms: "+".join(term.name for term in terms),
)
def test_exact_variances_give_the_terms_back(terms: tuple[Term, ...], averaging: float | None) -> None:
    found = fit(exact_run(terms, 100_000, 2.0, averaging), "gyro", terms=names(terms))
    for term in terms:
        for name in term.parameters:
            assert values(found)[f"{term.name}.{name}"] == pytest.approx(getattr(term, name), rel=EXACT)
    assert found.residual is not None
    assert found.residual.p > 0.99


def test_a_line_that_is_known_is_fitted_with_the_rest() -> None:
    terms = (RandomWalk(0.01), Sinusoid(0.5, 0.37))
    found = fitted(terms, 20_000, 0.1, 1, auto=True)
    assert values(found)["sinusoid.amplitude"] == pytest.approx(0.5, rel=0.02)
    assert values(found)["random_walk.coefficient"] == pytest.approx(0.01, rel=0.05)
    assert found.estimate.names == ("angle_random_walk", "sinusoid_amplitude")


def test_one_second_averages_every_two_seconds_recover_all_terms() -> None:
    terms = (RandomWalk(1.0), BiasInstability(0.3), RateRandomWalk(0.02))
    found = np.array([list(values(fitted(terms, 20_000, 2.0, seed, 1.0)).values()) for seed in range(1, 21)])
    assert np.mean(found, axis=0) == pytest.approx([1.0, 0.3, 0.02], rel=0.06)
    not_said = allan(record(terms, 20_000, 2.0, 1, 1.0), 2.0, quantity="rate")
    wrong = values(fit(not_said, "gyro", terms=names(terms)))
    assert wrong["random_walk.coefficient"] == pytest.approx(np.sqrt(2.0), rel=0.03)


def test_quantisation_is_not_separable_from_white_noise_where_there_is_dead_time() -> None:
    found = fitted((RandomWalk(1.0),), 4000, 2.0, 1, 1.0, auto=True)
    one = found.term("quantization")
    assert one is not None
    assert "same as white noise" in one.reason


def test_a_term_not_identified_has_its_reason_limit_and_record_length() -> None:
    truth = 0.01
    found = fitted((RandomWalk(1.0), RateRandomWalk(truth)), 4000, 0.01, 3, auto=True)
    one = found.term("rate_random_walk")
    assert one is not None
    assert one.status == "not_identified"
    assert one.upper_limit is not None
    assert one.record_needed is not None
    assert one.upper_limit > truth
    assert one.record_needed > one.record == pytest.approx(40.0)
    assert "record too short" in one.reason
    at_limit = (RandomWalk(1.0), RateRandomWalk(one.upper_limit))
    longer = fitted(at_limit, int(one.record_needed * 100), 0.01, 4, auto=True)
    assert "rate_random_walk" in {term.name for term in longer.terms}
    planned = plan_record(at_limit, "rate_random_walk", 0.125, 0.01).fit  # of the coefficient: 25 % of its square
    assert 0.5 < one.record_needed / planned < 4.0
    row = next(row for row in found.rows("x") if row.quantity == "rate_random_walk")
    assert row.status == "upper_limit"
    assert "would show it" in row.reason.text


def test_gauss_markov_noise_not_identified_is_limited_where_it_could_hide() -> None:
    one = fitted((RandomWalk(1.0),), 4000, 0.01, 3, auto=True).term("gauss_markov")
    assert one is not None
    assert (one.status, one.unit) == ("not_identified", "rad/s")
    assert one.upper_limit is not None
    assert one.limit_at is not None
    assert 0.01 <= one.limit_at < 20.0
    truth = (RandomWalk(1.0), GaussMarkov(2.0 * one.upper_limit, one.limit_at))
    assert "gauss_markov" in {term.name for term in fitted(truth, 40_000, 0.01, 5, auto=True).terms}


def test_a_term_that_looks_like_another_says_which() -> None:
    found = fitted((RandomWalk(1.0), RateRandomWalk(0.5)), 4000, 0.01, 2, auto=True)
    other = {"rate_random_walk": "bias_instability", "bias_instability": "rate_random_walk"}
    named = next(name for name in other if name in {term.name for term in found.terms})
    one = found.term(other[named])
    assert one is not None
    assert f"cannot be separated from {named}" in one.reason
    assert (one.code, one.others) == ("like_another", (named,))
    rival = found.term(named)
    assert rival is not None
    assert rival.code == "like_another"
    assert rival.reason == f"{other[named]} would fit nearly as well"
    row = next(row for row in found.rows() if row.quantity == rival.parameters[0].name)
    assert (row.status, row.reason.text) == ("estimated", rival.reason)


def test_why_a_term_is_not_there_says_a_length_only_where_length_is_what_lacks() -> None:
    """Quantisation beside white noise is told by fast samples; a record of a few seconds by its own length."""
    for n in (300, 4000):
        missing = [one for one in fitted((RandomWalk(1.0),), n, 0.01, 3, auto=True).found if one.code]
        assert {one.name: one.code for one in missing}["quantization"] == "hidden_by_white"
        for one in missing:
            longer = one.record_needed is not None and one.record_needed > one.record
            assert longer == (one.code == "too_short"), one


def test_terms_that_do_not_explain_are_told_by_the_residual_test() -> None:
    wrong = fit(curve(WALK, 40_000, 0.01, 1), "gyro", terms=["random_walk"])
    assert wrong.residual is not None
    assert wrong.residual.p < 1e-3
    assert [remark.code for remark in wrong.remarks] == ["terms_do_not_explain"]
    assert f"{100.0 * wrong.misfit:.2g} %" in wrong.remarks[0].what
    right = fitted(WALK, 40_000, 0.01, 1)
    assert (right.misfit, right.remarks) == (0.0, ())


@pytest.mark.parametrize("left", [1e-17, 0.0, -1e-17], ids=["above", "none", "below"])
def test_a_value_that_the_fit_took_whole_says_nothing(left: float) -> None:
    """What rounding leaves of its variance may have either sign."""
    values, covariance = np.array([1.0, -1.0, 1.0, 1e-18]), np.diag([1.0, 2.0, 4.0, left])
    test = chi_square(np.column_stack([values, covariance]), 3)
    assert test is not None
    assert test.dof == 3
    assert test.statistic == pytest.approx(1.75)


def test_variances_at_the_centre_of_their_distribution_leave_nothing_to_the_residual_test() -> None:
    """Wilson and Hilferty: the cube root of chi-square over its nu degrees of freedom is 1 - 2 / (9 nu) in the mean."""
    problem = problem_of([exact_run((RandomWalk(1.0),), 300, 1.0)])
    found = estimate(problem, ["random_walk"])
    mu, sigma = mean_of(problem, found), covariance_of_runs(problem, found)
    centre = mu * (1.0 - np.diag(sigma) / (9.0 * mu**2)) ** 3  # nu = 2 mu^2 / variance of the variance
    test = residual_test(replace(problem, variance=centre), found, sigma)
    assert test is not None
    assert test.statistic == pytest.approx(0.0, abs=1e-12)


def test_a_misfit_at_short_times_does_not_outweigh_long_ones() -> None:
    """Ripples of 6 % of the variance, as filters and lines make them, where a million samples know it to 0.2 %."""
    truth = (RandomWalk(1.0), BiasInstability(0.2))
    run = exact_run(truth, 2**20, 0.01)
    ripple = 1.0 + 0.06 * np.cos(2.4 * np.arange(len(run.m))) * (run.m < 2**10)
    found = fit(replace(run, variance=run.variance * ripple), "gyro")
    assert [term.name for term in found.terms] == names(truth)
    assert 0.01 < found.misfit < 0.04
    assert values(found)["bias_instability.coefficient"] == pytest.approx(0.2, rel=0.1)
    assert values(found)["random_walk.coefficient"] == pytest.approx(1.0, abs=0.02)
    assert found.estimate.u[0] > 5.0 * fit(run, "gyro").estimate.u[0]


def test_a_misfit_is_that_of_the_sensor_and_does_not_shrink_with_more_runs() -> None:
    white = (RandomWalk(1.0),)
    curves = [curve(white, 2**17, 0.01, seed) for seed in range(1, 5)]
    ripple = 1.0 + 0.05 * np.cos(2.4 * np.arange(len(curves[0])))[:, None]
    rippled = [replace(one, deviation=one.deviation * ripple) for one in curves]
    (alone, four), exact = ([fit(some[:n], "gyro", terms=names(white)) for n in (1, 4)] for some in (rippled, curves))
    assert 0.01 < alone.misfit < 0.08
    assert four.misfit == pytest.approx(alone.misfit, rel=0.6)
    assert four.estimate.u[0] > 0.8 * alone.estimate.u[0]
    assert exact[1].estimate.u[0] == pytest.approx(0.5 * exact[0].estimate.u[0], rel=0.02)


def test_noise_that_a_filter_makes_is_told_with_the_random_walk_that_it_adds() -> None:
    found = fitted((RandomWalk(0.5e-3), GaussMarkov(1e-2, 0.02)), 100_000, 0.01, 1, auto=True)
    (remark,) = found.remarks
    assert remark.code == "white_with_filter"
    both = np.degrees(np.hypot(0.5e-3, 1e-2 * np.sqrt(2.0 * 0.02))) * 60.0
    told = float(remark.what.split(" is ")[-1].split()[0])
    assert told == pytest.approx(both, rel=0.05)
    assert remark.what.endswith("deg/sqrt(h)")


def test_runs_are_fitted_together_and_tested_for_agreement() -> None:
    curves = [curve(WALK, 4000, 0.01, seed) for seed in range(1, 7)]
    one, six = fit(curves[0], "gyro", terms=names(WALK)), fit(curves, "gyro", terms=names(WALK))
    assert six.estimate.u[0] == pytest.approx(one.estimate.u[0] / np.sqrt(6.0), rel=0.1)
    assert six.agreement is not None
    assert six.agreement.p > 0.01
    assert six.agreement.dof == 10
    loud = allan(1.3 * record(WALK, 4000, 0.01, 9), 0.01, quantity="rate")
    apart = fit([*curves, loud], "gyro", terms=names(WALK))
    assert apart.agreement is not None
    assert apart.agreement.p < 1e-4
    assert "runs_disagree" in {remark.code for remark in apart.remarks}


def test_a_run_that_differs_is_no_misfit_of_the_terms() -> None:
    """One of three runs with 5 % more white noise: told, in figures that stay as sharp as scatter allows."""
    white, told = (RandomWalk(1.0),), 0
    for seed in range(1, 7):
        runs = [curve((RandomWalk(size),), 10_000, 0.1, 10 * seed + i) for i, size in enumerate((1.0, 1.0, 1.05))]
        found = fit(runs, "gyro", terms=names(white))
        told += "runs_disagree" in found.fit_warnings
        assert found.misfit < 0.02
    assert told >= 5
    (row,) = (row for row in found.rows() if row.quantity == "angle_random_walk")
    assert "the records do not agree" in row.reason.text


def test_a_misfit_at_its_bound_is_told() -> None:
    run = exact_run((RandomWalk(1.0),), 2**16, 0.01)
    wild = replace(run, variance=run.variance * np.exp(2.0 * np.cos(2.4 * np.arange(len(run.m)))))
    found = fit(wild, "gyro", terms=["random_walk"])
    assert found.misfit == 0.25
    assert found.fit_warnings == ("terms_do_not_explain",)
    assert "no figure of this fit holds" in found.remarks[0].what
    assert "do not explain" in found.rows()[0].reason.text


def test_result_does_not_depend_on_the_unit() -> None:
    y = record(WALK, 10_000, 0.01, 2)
    a, b = (fit(allan(scale * y, 0.01, quantity="rate"), "gyro") for scale in (1.0, 1e-6))
    assert [term.name for term in a.terms] == [term.name for term in b.terms]
    assert 1e-6 * a.estimate.values == pytest.approx(b.estimate.values, rel=1e-4)


def test_a_curve_that_says_its_unit_is_converted() -> None:
    y = record(WALK, 10_000, 0.01, 2)
    plain = fit(allan(y, 0.01, quantity="rate"), "gyro")
    said = fit(allan(np.degrees(y), 0.01, quantity="rate", unit="deg/s"), "gyro")
    assert said.estimate.values == pytest.approx(plain.estimate.values, rel=1e-4)
    assert said.unit == "rad/s"
    counted = fit(allan(y, 0.01, quantity="rate", unit="count"), None)
    assert counted.estimate.units[0] == "count*sqrt(s)"
    with pytest.raises(DataError, match="'m/s' cannot be expressed in 'rad/s'"):
        fit(allan(y, 0.01, quantity="rate", unit="m/s"), "gyro")


def test_is_shown_in_units_of_data_sheets_and_as_rows() -> None:
    found = fitted((RandomWalk(np.radians(0.3) / 60.0),), 4000, 0.01, 1, auto=True)
    assert "angle_random_walk" in str(found)
    assert "deg/sqrt(h)" in str(found)
    assert "<table" in found._repr_html_()
    assert list(found.to_frame()["status"][:2]) == ["estimated", "upper_limit"]
    plain = fit(exact_run((RandomWalk(1.0),), 4000, 0.01), None, unit="count")
    assert plain.estimate.units == ("count*sqrt(s)",)
    assert "random_walk" in str(plain)
    acc = fit(exact_run((RandomWalk(1e-3),), 4000, 0.01), "accelerometer")
    assert acc.estimate.names == ("velocity_random_walk",)
    assert "ug/sqrt(Hz)" in str(acc)


def test_what_cannot_be_fitted_is_refused() -> None:
    y = record(WALK, 4000, 0.01, 1)
    with pytest.raises(DataError, match="a curve of the modified deviation"):
        fit(allan(y, 0.01, quantity="rate", deviation="modified"), "gyro")
    with pytest.raises(DataError, match="zero throughout"):
        fit(exact_and_zero(), "gyro")
    run = exact_run(WALK, 4000, 0.01)
    with pytest.raises(DataError, match=r"2 averaging time\(s\)"):
        fit(replace(run, variance=np.where(run.m < 4, run.variance, np.nan)), "gyro")
    with pytest.raises(DataError, match="no term of noise 'pink'"):
        fit(run, "gyro", terms=["pink"])
    with pytest.raises(DataError, match="a ramp or a line alone"):
        fit(run, "gyro", terms=["rate_ramp"])
    with pytest.raises(DataError, match="a ramp or a line alone"):
        fit(replace(run, variance=run.tau**2), "gyro")
    with pytest.raises(DataError, match="a curve of 2 axes"):
        fit(allan(np.column_stack([y, y]), 0.01, quantity="rate"), "gyro")
    with pytest.raises(DataError, match="axis 2 of a curve of 2"):
        fit(allan(np.column_stack([y, y]), 0.01, quantity="rate"), "gyro", axis=2)
    with pytest.raises(PlanError, match="intervals of probability 95"):
        fit(run, "gyro", p=95.0)
    with pytest.raises(DataError, match=r"0 averaging time\(s\)"):
        fit(replace(run, variance=np.full(len(run.m), np.nan)), "gyro")
    with pytest.raises(DataError, match="no Allan deviation to fit"):
        fit([], "gyro")


def exact_and_zero() -> Run:
    run = exact_run(WALK, 4000, 0.01)
    return replace(run, variance=np.zeros_like(run.variance))


@pytest.mark.bench
@pytest.mark.parametrize("chosen", [True, False], ids=["chosen", "given"])
def test_a_fit_takes_at_most_a_tenth_of_a_second(chosen: bool) -> None:
    """Compiled code is kept between runs of the program; the very first fit takes some seconds to compile it."""
    one = curve(GMWM, 100_000, 0.01, 1)
    terms = "auto" if chosen else names(GMWM)
    times = []
    for _ in range(12):
        start = time.perf_counter()
        fit(one, "gyro", terms=terms)
        times.append(1e3 * (time.perf_counter() - start))
    print(f"\nfit of {len(one)} averaging times: first {times[0]:.0f} ms, then {min(times):.1f} ms at best")
    assert min(times) <= 100.0


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_quantization_of_rates_with_gaps_is_no_random_walk(share: float) -> None:
    """Each gap leaves two ends of the integrated signal, whose errors no longer cancel: white noise, but explained."""
    rng = np.random.default_rng(1)
    rates = np.diff(rng.normal(size=10_001)) + 0.2 * rng.normal(size=10_000)
    rates[rng.random(len(rates)) < share] = np.nan
    found = fit(allan(rates, 1.0, quantity="rate"), "gyro")
    assert found.residual is not None
    assert found.residual.p > 0.001
    assert found.estimate.value("quantization") == pytest.approx(1.0, rel=0.04)
    if "angle_random_walk" in found.estimate.names:
        assert found.estimate.value("angle_random_walk") == pytest.approx(0.2, rel=0.35)


def test_the_slope_in_the_correlation_time_is_that_of_the_logarithm() -> None:
    run = exact_run((RandomWalk(1.0), GaussMarkov(0.3, 40.0)), 100_000, 2.0)
    problem = problem_of([run])
    found = estimate(problem, ["random_walk", "gauss_markov"])
    sigma, time, h = float(np.sqrt(found.powers[-1])), time_at(problem, found.position), 1e-3
    ends = [expected(GaussMarkov(sigma, time * float(np.exp(by))), run) for by in (h, -h)]
    slope = (ends[0] - ends[1]) / (2.0 * h)
    assert slopes_of(problem, found)[:, -1] == pytest.approx(slope, abs=0.03 * np.abs(slope).max())
