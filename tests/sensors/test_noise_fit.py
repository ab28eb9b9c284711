"""Fit of noise terms: truth recovered, intervals cover, nothing named that is not there."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.allan_of_terms import expected_variance
from inertialcal.sensors.noise.covariance_of_allan import covariance_of_allan, model_edf
from inertialcal.sensors.noise.fit import fit
from inertialcal.sensors.noise.noise_fit import NoiseFit
from inertialcal.sensors.noise.runs import Run
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    total_phase,
)
from inertialcal.signals.allan import allan
from inertialcal.statistics.intervals import binomial_interval, contains

WALK = (RandomWalk(1.0), RateRandomWalk(0.3))
GMWM = (RandomWalk(0.1), GaussMarkov(np.sqrt(0.05), 1.0), RateRandomWalk(np.sqrt(7.5e-5)))  # 100 Hz, N = 1e5
EXACT = 1e-3  # of a coefficient fitted to exact variances


def exact_run(terms: tuple[Term, ...], n: int, interval: float, averaging: float | None = None) -> Run:
    """The Allan variances that terms are expected to have."""
    m = 2.0 ** np.arange(int(np.log2(n / 4)) + 1)
    phase, pairs = total_phase(terms, interval, averaging), n - 2.0 * m + 1.0
    variance = expected_variance(terms, m, interval, averaging)
    edf = model_edf(variance, covariance_of_allan(phase, m, pairs))
    return Run(m, variance, pairs, edf, interval, averaging or interval, np.ones(len(m)))


def record(
    terms: tuple[Term, ...], n: int, interval: float, seed: int, averaging: float | None = None
) -> Array:  # fmt: skip
    return simulate(terms, n, interval, np.random.default_rng([2026, seed]), averaging)


def fitted(
    terms: tuple[Term, ...], n: int, interval: float, seed: int, averaging: float | None = None, auto: bool = False
) -> NoiseFit:
    curve = allan(record(terms, n, interval, seed, averaging), interval, quantity="rate", averaging=averaging)
    return fit(curve, "gyro", terms="auto" if auto else [term.name for term in terms])


def values(found: NoiseFit) -> dict[str, float]:
    return {f"{term.name}.{name}": getattr(term, name) for term in found.terms for name in term.parameters}


def hits(found: NoiseFit, terms: tuple[Term, ...]) -> dict[str, bool]:
    """Whether the interval of each parameter holds the truth; a term that is missing has it from zero to its limit."""
    hit = {}
    for term in terms:
        one = found.term(term.name)
        assert one is not None
        for name, parameter in zip(term.parameters, one.parameters, strict=False):
            hit[f"{term.name}.{name}"] = contains(parameter.interval, getattr(term, name))
    return hit


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
    found = fit(exact_run(terms, 100_000, 2.0, averaging), "gyro", terms=[term.name for term in terms])
    for term in terms:
        for name in term.parameters:
            assert values(found)[f"{term.name}.{name}"] == pytest.approx(getattr(term, name), rel=EXACT)
    assert found.residual is not None
    assert found.residual.p > 0.99


def test_a_line_that_is_known_is_fitted_with_the_rest() -> None:
    terms = (RandomWalk(0.01), Sinusoid(0.5, 0.37))
    found = fit(allan(record(terms, 20_000, 0.1, 1), 0.1, quantity="rate"), "gyro", lines=[0.37])
    assert values(found)["sinusoid.amplitude"] == pytest.approx(0.5, rel=0.02)
    assert values(found)["random_walk.coefficient"] == pytest.approx(0.01, rel=0.05)
    assert found.estimate.names == ("angle_random_walk", "sinusoid_amplitude")


def test_one_second_averages_every_two_seconds_recover_all_terms() -> None:
    terms = (RandomWalk(1.0), BiasInstability(0.3), RateRandomWalk(0.02))
    found = np.array([list(values(fitted(terms, 20_000, 2.0, seed, 1.0)).values()) for seed in range(20)])
    assert np.mean(found, axis=0) == pytest.approx([1.0, 0.3, 0.02], rel=0.06)
    curve = allan(record(terms, 20_000, 2.0, 0, 1.0), 2.0, quantity="rate")  # dead time not said
    wrong = values(fit(curve, "gyro", terms=[term.name for term in terms]))
    assert wrong["random_walk.coefficient"] == pytest.approx(np.sqrt(2.0), rel=0.03)


def test_quantisation_is_not_separable_from_white_noise_where_there_is_dead_time() -> None:
    found = fitted((RandomWalk(1.0),), 4000, 2.0, 1, 1.0, auto=True)
    one = found.term("quantization")
    assert one is not None
    assert "looks like white noise" in one.reason


def named_on_white(records: int) -> int:
    alone = 0
    for seed in range(records):
        alone += {term.name for term in fitted((RandomWalk(1.0),), 4000, 0.01, seed, auto=True).terms} == {
            "random_walk"
        }
    return alone


def test_pure_white_noise_names_no_other_term() -> None:
    assert named_on_white(60) >= 0.95 * 60


@pytest.mark.slow
def test_pure_white_noise_names_no_other_term_in_many_records() -> None:
    assert named_on_white(600) >= 0.95 * 600


def test_white_noise_and_random_walk_long_enough_are_both_named() -> None:
    for seed in range(10):
        names = {
            term.name for term in fitted((RandomWalk(1.0), RateRandomWalk(0.3)), 100_000, 0.01, seed, auto=True).terms
        }
        assert {"random_walk", "rate_random_walk"} <= names


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
    longer = fitted(
        (RandomWalk(1.0), RateRandomWalk(one.upper_limit)), int(one.record_needed * 100), 0.01, 4, auto=True
    )
    assert "rate_random_walk" in {term.name for term in longer.terms}
    row = next(row for row in found.rows("x") if row.quantity == "rate_random_walk")
    assert row.status == "upper_limit"
    assert "would show it" in row.reason


def test_upper_limits_hold() -> None:
    truth, over = 0.05, 0
    for seed in range(100):
        curve = allan(record((RandomWalk(1.0), RateRandomWalk(truth)), 4000, 0.01, seed), 0.01, quantity="rate")
        one = fit(curve, "gyro", terms="auto").term("rate_random_walk")
        assert one is not None
        over += one.upper_limit is not None and one.upper_limit < truth
    assert over <= 12  # 5 expected; 0.3 % of such counts are more


def coverage(terms: tuple[Term, ...], n: int, interval: float, records: int, averaging: float | None = None) -> None:
    """DESIGN: the exact 99.9 % interval of the hit rate overlaps 93 to 97 %."""
    counts: dict[str, list[bool]] = {}
    for seed in range(1, records + 1):
        for name, hit in hits(fitted(terms, n, interval, seed, averaging), terms).items():
            counts.setdefault(name, []).append(hit)
    for name, hit in counts.items():
        lo, hi = binomial_interval(sum(hit), len(hit))
        assert lo <= 0.97, (name, np.mean(hit))
        assert hi >= 0.93, (name, np.mean(hit))


def test_intervals_cover_the_truth() -> None:
    coverage(WALK, 4000, 0.01, 300)


COVERED: list[tuple[tuple[Term, ...], int, float, float | None]] = [
    (WALK, 10_000, 0.01, None),
    ((RandomWalk(1.0), BiasInstability(1.0)), 10_000, 0.01, None),
    ((Quantization(0.05), RandomWalk(1.0)), 10_000, 0.01, None),
    ((RandomWalk(1.0), BiasInstability(0.3), RateRandomWalk(0.02)), 20_000, 2.0, 1.0),
    ((RandomWalk(1.0), RateRamp(0.02)), 10_000, 0.01, None),
]


@pytest.mark.slow
@pytest.mark.parametrize(("terms", "n", "interval", "averaging"), COVERED)
def test_intervals_cover_the_truth_in_many_records(
    terms: tuple[Term, ...], n: int, interval: float, averaging: float | None
) -> None:
    coverage(terms, n, interval, 1000, averaging)


def gmwm_scatter(records: int) -> dict[str, float]:
    """Root mean square of ln(parameter / truth), of variances and 1 / time; of the walk the median size."""
    truth = {f"{term.name}.{name}": getattr(term, name) for term in GMWM for name in term.parameters}
    logs: dict[str, list[float]] = {name: [] for name in truth}
    for seed in range(records):
        found = values(fitted(GMWM, 100_000, 0.01, seed))
        for name, true in truth.items():
            times = 1.0 if name.endswith("time") else 2.0
            logs[name].append(times * float(np.log(found[name] / true)) if name in found else -np.inf)
    scatter = {name: float(np.sqrt(np.mean(np.square(each)))) for name, each in logs.items() if "walk.c" not in name}
    scatter["random_walk"] = float(np.sqrt(np.mean(np.square(logs["random_walk.coefficient"]))))
    scatter["rate_random_walk"] = float(np.median(np.abs(logs["rate_random_walk.coefficient"])))
    return scatter


def check_gmwm(records: int, margin: float) -> None:
    """GMWM of simts 0.2.4 on 40 records of the same terms: 0.0041, 0.0904, 0.0533 and 0.84.

    Its figure for white noise lies below sqrt(2 / N) = 0.00447, which no estimator can beat, by the chance of 40
    records; the bound takes its place.
    """
    found = gmwm_scatter(records)
    assert found["random_walk"] <= margin * max(0.0041, np.sqrt(2.0 / 1e5))
    assert found["gauss_markov.correlation_time"] <= margin * 0.0904
    assert found["gauss_markov.sigma"] <= margin * 0.0533
    assert found["rate_random_walk"] <= margin * 0.84


def test_scatter_is_like_that_of_gmwm() -> None:
    check_gmwm(40, 1.4)


@pytest.mark.slow
def test_scatter_is_that_of_gmwm_over_many_records() -> None:
    check_gmwm(400, 1.15)


def missing_scatter(records: int) -> tuple[Array, Array]:
    whole, holed = [], []
    for seed in range(records):
        y = record(WALK, 10_000, 0.01, seed)
        gaps = y.copy()
        gaps[np.random.default_rng(seed).random(len(y)) < 0.05] = np.nan
        for start in np.random.default_rng(seed).integers(0, len(y) - 100, 5):
            gaps[start : start + 100] = np.nan
        for x, found in ((y, whole), (gaps, holed)):
            terms = fit(allan(x, 0.01, quantity="rate"), "gyro", terms=[term.name for term in WALK])
            found.append([values(terms).get(f"{term.name}.coefficient", 0.0) for term in WALK])
    return np.array(whole), np.array(holed)


def check_missing(records: int, margin: float) -> None:
    whole, holed = missing_scatter(records)
    assert np.all(np.std(holed, axis=0) <= margin * np.std(whole, axis=0))
    assert np.mean(holed, axis=0) == pytest.approx(np.mean(whole, axis=0), rel=0.05)


def test_a_tenth_of_samples_missing_changes_little() -> None:
    check_missing(40, 1.25)


@pytest.mark.slow
def test_a_tenth_of_samples_missing_changes_little_in_many_records() -> None:
    check_missing(400, 1.15)


def test_residual_test_rejects_what_does_not_explain_and_seldom_what_does() -> None:
    right = [fitted(WALK, 4000, 0.01, seed).residual for seed in range(100)]
    assert sum(one is not None and one.p < 0.05 for one in right) <= 14
    wrong = fit(allan(record(WALK, 40_000, 0.01, 1), 0.01, quantity="rate"), "gyro", terms=["random_walk"])
    assert wrong.residual is not None
    assert wrong.residual.p < 1e-3
    assert [remark.code for remark in wrong.remarks] == ["terms_do_not_explain"]


def test_runs_are_fitted_together_and_tested_for_agreement() -> None:
    curves = [allan(record(WALK, 4000, 0.01, seed), 0.01, quantity="rate") for seed in range(6)]
    names = [term.name for term in WALK]
    one, six = fit(curves[0], "gyro", terms=names), fit(curves, "gyro", terms=names)
    assert six.estimate.u[0] == pytest.approx(one.estimate.u[0] / np.sqrt(6.0), rel=0.1)
    assert six.agreement is not None
    assert six.agreement.p > 0.01
    assert six.agreement.dof == 10
    loud = allan(1.3 * record(WALK, 4000, 0.01, 9), 0.01, quantity="rate")
    apart = fit([*curves, loud], "gyro", terms=names)
    assert apart.agreement is not None
    assert apart.agreement.p < 1e-4
    assert "runs_disagree" in {remark.code for remark in apart.remarks}


def test_agreement_is_seldom_denied() -> None:
    denied = 0
    for seed in range(60):
        curves = [allan(record(WALK, 4000, 0.01, 1000 + 3 * seed + i), 0.01, quantity="rate") for i in range(3)]
        test = fit(curves, "gyro", terms=[term.name for term in WALK]).agreement
        denied += test is not None and test.p < 0.01
    assert denied <= 5


def test_result_does_not_depend_on_the_unit() -> None:
    y = record(WALK, 10_000, 0.01, 2)
    a, b = (fit(allan(scale * y, 0.01, quantity="rate"), "gyro") for scale in (1.0, 1e-6))
    assert [term.name for term in a.terms] == [term.name for term in b.terms]
    assert 1e-6 * a.estimate.values == pytest.approx(b.estimate.values, rel=1e-4)


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
    curve = allan(y, 0.01, quantity="rate")
    with pytest.raises(DataError, match="a curve of the modified deviation"):
        fit(allan(y, 0.01, quantity="rate", deviation="modified"), "gyro")
    with pytest.raises(DataError, match="zero throughout"):
        fit(exact_and_zero(), "gyro")
    run = exact_run(WALK, 4000, 0.01)
    with pytest.raises(DataError, match=r"2 averaging time\(s\)"):
        fit(replace(run, variance=np.where(run.m < 4, run.variance, np.nan)), "gyro")
    with pytest.raises(DataError, match="no term of noise 'pink'"):
        fit(curve, "gyro", terms=["pink"])
    with pytest.raises(DataError, match="a curve of 2 axes"):
        fit(allan(np.column_stack([y, y]), 0.01, quantity="rate"), "gyro")
    with pytest.raises(DataError, match="no Allan deviation to fit"):
        fit([], "gyro")


def exact_and_zero() -> Run:
    run = exact_run(WALK, 4000, 0.01)
    return replace(run, variance=np.zeros_like(run.variance))


@pytest.mark.bench
def test_a_fit_takes_at_most_fifty_milliseconds() -> None:
    curve = allan(record(GMWM, 100_000, 0.01, 1), 0.01, quantity="rate")
    fit(curve, "gyro")
    times = []
    for _ in range(7):
        start = time.perf_counter()
        fit(curve, "gyro")
        times.append(time.perf_counter() - start)
    assert min(times) <= 0.05
