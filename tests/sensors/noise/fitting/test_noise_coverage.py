"""Fits of noise terms over many records: intervals cover, scatter is small, nothing is named that is not there."""

from __future__ import annotations

import numpy as np
import pytest
from noise_records import GMWM, WALK, curve, fitted, names, record, values

from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.fitting.noise_fit import NoiseFit
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
)
from inertialcal.signals.allan import allan
from inertialcal.statistics.intervals import contains, covers
from sized import sized

Case = tuple[tuple[Term, ...], int, float, float | None, bool]  # terms, n, interval, averaging, terms chosen


def hits(found: NoiseFit, terms: tuple[Term, ...]) -> dict[str, bool]:
    """Whether the interval of each parameter holds the truth; frequencies are given."""
    hit = {}
    for term in terms:
        one = found.term(term.name)
        assert one is not None
        for name, parameter in zip(term.parameters, one.parameters, strict=False):
            if parameter.u > 0.0:
                hit[f"{term.name}.{name}"] = contains(parameter.interval, getattr(term, name))
    return hit


def check_coverage(case: Case, records: int) -> None:
    terms, n, interval, averaging, auto = case
    counts: dict[str, list[bool]] = {}
    for seed in range(1, records + 1):
        for name, hit in hits(fitted(terms, n, interval, seed, averaging, auto), terms).items():
            counts.setdefault(name, []).append(hit)
    assert sum(len(hit) for hit in counts.values()) > 0.95 * records * len(counts)  # identified in nearly all
    rates = {name: float(np.mean(hit)) for name, hit in counts.items()}
    assert all(covers(sum(hit), len(hit)) for hit in counts.values()), rates


@pytest.mark.parametrize(
    ("terms", "records"),
    [(WALK, 300), ((RandomWalk(1.0), GaussMarkov(2.0, 0.3)), 60)],
    ids=["walk", "gauss_markov"],
)
def test_intervals_cover_the_truth(terms: tuple[Term, ...], records: int) -> None:
    check_coverage((terms, 4000, 0.01, None, False), records)


MANY: dict[str, Case] = {
    "walk, terms chosen": ((RandomWalk(1.0), RateRandomWalk(3.0)), 6000, 0.01, None, True),
    "quantization and ramp": ((Quantization(0.05), RandomWalk(1.0), RateRamp(0.05)), 10_000, 0.01, None, False),
    "dead time": ((RandomWalk(1.0), BiasInstability(0.3), RateRandomWalk(0.03)), 8000, 2.0, 1.0, False),
    "gauss_markov": ((RandomWalk(1.0), GaussMarkov(2.0, 0.5)), 8000, 0.01, None, False),
    "line": ((RandomWalk(0.01), Sinusoid(0.5, 0.37)), 10_000, 0.1, None, False),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MANY)
def test_intervals_cover_the_truth_in_many_records(name: str) -> None:
    check_coverage(MANY[name], sized(1000, 250))


@pytest.mark.slow
def test_intervals_of_runs_fitted_together_cover_the_truth() -> None:
    terms, counts = (RandomWalk(1.0), RateRandomWalk(2.0)), [0, 0]
    n = sized(1000, 300)
    for seed in range(1, n + 1):
        runs = [curve(terms, n, 0.01, 10 * seed + i) for i, n in enumerate((1000, 2000))]
        found = fit(runs, "gyro", terms=names(terms))
        for i, hit in enumerate(hits(found, terms).values()):
            counts[i] += hit
    assert all(covers(count, n) for count in counts), counts


def gmwm_scatter(records: int) -> dict[str, float]:
    """Root mean square of ln(parameter / truth), of variances and of 1 / time; of the walk the median size."""
    truth = {f"{term.name}.{name}": getattr(term, name) for term in GMWM for name in term.parameters}
    logs: dict[str, list[float]] = {name: [] for name in truth}
    for seed in range(1, records + 1):
        found = values(fitted(GMWM, 100_000, 0.01, seed))
        for name, true in truth.items():
            times = 1.0 if name.endswith("time") else 2.0
            logs[name].append(times * float(np.log(found[name] / true)) if name in found else -np.inf)
    scatter = {name: float(np.sqrt(np.mean(np.square(logs[name])))) for name in truth if name in list(truth)[:3]}
    return scatter | {"median": float(np.median(np.abs(logs["rate_random_walk.coefficient"])))}


def check_gmwm(records: int, margin: float) -> None:
    """GMWM of simts 0.2.4 on 40 records of the same terms: 0.0041, 0.0533, 0.0904 and 0.84.

    Its figure for white noise lies below sqrt(2 / N) = 0.00447, which no estimator can beat, by the chance of 40
    records; the bound takes its place.
    """
    found = gmwm_scatter(records)
    assert found["random_walk.coefficient"] <= margin * max(0.0041, np.sqrt(2.0 / 1e5))
    assert found["gauss_markov.sigma"] <= margin * 0.0533
    assert found["gauss_markov.correlation_time"] <= margin * 0.0904
    assert found["median"] <= margin * 0.84


def test_scatter_is_like_that_of_gmwm() -> None:
    check_gmwm(25, 1.5)


@pytest.mark.slow
def test_scatter_is_that_of_gmwm_over_many_records() -> None:
    check_gmwm(400, 1.15)


def named_on_white(n: int, records: int) -> int:
    """In how many records of white noise nothing else is named."""
    white = (RandomWalk(1.0),)
    found = (fitted(white, n, 0.01, seed, auto=True) for seed in range(1, records + 1))
    return sum([term.name for term in one.terms] == ["random_walk"] for one in found)


def test_pure_white_noise_names_no_other_term() -> None:
    assert named_on_white(4000, 40) >= 0.95 * 40


@pytest.mark.slow
@pytest.mark.parametrize(("n", "records"), [(4000, 300), (100_000, sized(200, 60))])
def test_pure_white_noise_names_no_other_term_in_many_records(n: int, records: int) -> None:
    assert named_on_white(n, records) >= 0.95 * records


def test_white_noise_and_random_walk_long_enough_are_both_named() -> None:
    terms = (RandomWalk(1.0), RateRandomWalk(0.3))
    for seed in range(1, 11):
        assert set(names(terms)) <= {term.name for term in fitted(terms, 100_000, 0.01, seed, auto=True).terms}


def check_limits(terms: tuple[Term, ...], records: int, most: int) -> None:
    """Limits of the last term, whether it is named or not."""
    truth, over = getattr(terms[-1], terms[-1].parameters[0]), 0
    for seed in range(1, records + 1):
        one = fit(curve(terms, 4000, 0.01, seed), "gyro", terms="auto").term(terms[-1].name)
        assert one is not None
        over += one.upper_limit is not None and one.upper_limit < truth
    assert over <= most


def test_upper_limits_hold() -> None:
    """Of a term that half of the records show: limits are those of the other half, in which it came out small."""
    check_limits((RandomWalk(1.0), RateRandomWalk(0.45)), 40, 4)  # 1 expected of 18; plain limits miss in 7


@pytest.mark.slow
@pytest.mark.parametrize("term", [RateRandomWalk(0.3), BiasInstability(0.5)])
def test_upper_limits_hold_in_many_records(term: Term) -> None:
    check_limits((RandomWalk(1.0), term), 200, 21)  # 10 expected; 0.1 % of such counts are more


def missing_scatter(records: int) -> tuple[Array, Array]:
    """Coefficients of whole records, and of the same with a tenth missing: half one by one, half in bursts."""
    whole: list[list[float]] = []
    holed: list[list[float]] = []
    for seed in range(1, records + 1):
        y = record(WALK, 10_000, 0.01, seed)
        gaps, rng = y.copy(), np.random.default_rng(seed)
        gaps[rng.random(len(y)) < 0.053] = np.nan
        for start in rng.integers(0, len(y) - 100, 5):
            gaps[start : start + 100] = np.nan
        for x, found in ((y, whole), (gaps, holed)):
            terms = values(fit(allan(x, 0.01, quantity="rate"), "gyro", terms=names(WALK)))
            found.append([terms.get(f"{name}.coefficient", 0.0) for name in names(WALK)])
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


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3])
@pytest.mark.parametrize("terms", [(RandomWalk(1.0),), (RandomWalk(1.0), RateRandomWalk(5.0))], ids=["white", "walk"])
def test_intervals_cover_the_truth_with_samples_missing(terms: tuple[Term, ...], share: float) -> None:
    counts: dict[str, list[bool]] = {}
    for seed in range(1, sized(400, 150) + 1):
        y = record(terms, 4000, 0.01, seed)
        y[np.random.default_rng(seed).random(len(y)) < share] = np.nan
        found = fit(allan(y, 0.01, quantity="rate"), "gyro", terms=names(terms))
        assert found.residual is not None
        for name, hit in [*hits(found, terms).items(), ("residual", found.residual.p > 0.05)]:
            counts.setdefault(name, []).append(hit)
    assert all(covers(sum(hit), len(hit)) for hit in counts.values()), {
        name: np.mean(hit) for name, hit in counts.items()
    }


@pytest.mark.parametrize(
    ("terms", "n", "interval"),
    [(WALK, 4000, 0.01), ((RandomWalk(0.01), Sinusoid(0.5, 0.37)), 10_000, 0.1)],
    ids=["walk", "line"],
)
def test_residual_test_seldom_rejects_what_explains(terms: tuple[Term, ...], n: int, interval: float) -> None:
    tests = [fitted(terms, n, interval, seed).residual for seed in range(1, 101)]
    assert sum(test is not None and test.p < 0.05 for test in tests) <= 14  # 0.1 % of such counts are more


def test_agreement_of_runs_is_seldom_denied() -> None:
    tests = []
    for seed in range(1, 41):
        runs = [curve(WALK, 4000, 0.01, 1000 + 3 * seed + i) for i in range(3)]
        found = fit(runs, "gyro", terms=names(WALK)).agreement
        assert found is not None
        tests.append(found)
    assert {test.dof for test in tests} == {4}
    assert sum(test.p < 0.01 for test in tests) <= 4
    assert np.mean([test.statistic for test in tests]) == pytest.approx(4.0, abs=4.0 * np.sqrt(8.0 / 40.0))
