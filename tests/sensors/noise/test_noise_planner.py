"""Record length: the standard's rule, exact degrees of freedom, and what a fit of all terms is forecast to give."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.planner import forecast, plan_record
from inertialcal.sensors.noise.simulate import simulate
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
from inertialcal.signals.allan.deviations import KINDS
from inertialcal.signals.allan.edf import degrees_of_freedom

INTERVAL = 0.01  # s
TERMS = (RandomWalk(1e-4), BiasInstability(1e-5), RateRandomWalk(1e-7))


def test_one_white_term_is_known_as_well_as_its_samples_allow() -> None:
    """sd of the standard deviation of n samples is 1 / sqrt(2 n); a fit to Allan variances comes within 30 %."""
    n = 10_000
    (found,) = forecast((RandomWalk(1.0),), n * INTERVAL, INTERVAL).known
    assert 1.0 / np.sqrt(2.0 * n) < found.relative_error < 1.3 / np.sqrt(2.0 * n)
    assert found.shown


def scatter(terms: tuple[Term, ...], record: float, records: int) -> Array:
    """Relative scatter of every parameter, as `fit` finds it in simulated records."""
    rng, n, names = np.random.default_rng(2), round(record / INTERVAL), [term.name for term in terms]
    found = []
    for _ in range(records):
        curve = allan(simulate(terms, n, INTERVAL, rng), INTERVAL, quantity="rate")
        found.append([one.value for term in fit(curve, "gyro", terms=names).found for one in term.parameters])
    return np.asarray(np.std(np.log(found), axis=0))


WALK = (RandomWalk(1e-3), RateRandomWalk(5e-4))
FITTED: list[tuple[tuple[Term, ...], float]] = [
    ((RandomWalk(1e-3), BiasInstability(1e-3)), 300.0),
    ((RandomWalk(1e-3), GaussMarkov(2e-3, 1.0)), 300.0),
    ((RandomWalk(1e-3), RateRamp(1e-4)), 300.0),  # the walk's own scatter is what a ramp is told from
]


def test_the_forecast_is_the_scatter_of_fits() -> None:
    known = [one.relative_error for one in forecast(WALK, 100.0, INTERVAL).known]
    assert scatter(WALK, 100.0, 80) == pytest.approx(known, rel=0.3)  # scatter of 80 records is known to 8 %


@pytest.mark.slow
@pytest.mark.parametrize(("terms", "record"), FITTED)
def test_the_forecast_is_the_scatter_of_many_fits(terms: tuple[Term, ...], record: float) -> None:
    known = [one.relative_error for one in forecast(terms, record, INTERVAL).known]
    assert scatter(terms, record, 100) == pytest.approx(known, rel=0.25)


@pytest.mark.slow
def test_records_as_long_as_planned_give_the_error_that_was_wanted() -> None:
    plan = plan_record(WALK, "rate_random_walk", 0.1, INTERVAL)
    assert scatter(WALK, plan.fit, 100)[1] == pytest.approx(0.1, rel=0.25)


@pytest.mark.parametrize("term", [term.name for term in TERMS])
def test_a_record_as_long_as_planned_gives_the_error_that_was_wanted(term: str) -> None:
    wanted = 0.05 if term == "random_walk" else 0.2
    plan = plan_record(TERMS, term, wanted, INTERVAL)
    assert forecast(TERMS, plan.fit, INTERVAL).of(term).relative_error == pytest.approx(wanted, rel=0.02)
    assert 0.3 * plan.standard < plan.exact < 2.0 * plan.standard


def test_a_record_is_long_enough_for_the_term_to_be_named() -> None:
    """A fit that is told its terms needs less than one that has to choose them."""
    terms = (RandomWalk(1e-3), RateRandomWalk(1e-4))
    plan = plan_record(terms, "rate_random_walk", 0.25, 0.1)
    assert plan.record > 1.5 * plan.fit
    rng, named = np.random.default_rng(3), []
    for _ in range(20):
        curve = allan(simulate(terms, int(plan.record / 0.1), 0.1, rng), 0.1, quantity="rate")
        named.append("rate_random_walk" in {term.name for term in fit(curve, "gyro").terms})
    assert sum(named) >= 18  # 19 expected at least
    given = plan_record((*terms, Sinusoid(1e-3, 0.2)), "sinusoid", 0.1, 0.1)  # a line is given, not chosen
    assert given.record == given.fit
    twice = plan_record((RandomWalk(1.0), GaussMarkov(0.3, 1.0), GaussMarkov(0.3, 50.0)), "random_walk", 0.1, 0.1)
    assert twice.record == twice.fit


def test_a_term_alone_is_read_as_the_rule_says() -> None:
    plan = plan_record((RandomWalk(1.0),), "random_walk", 0.01, INTERVAL)
    assert plan.standard == pytest.approx(INTERVAL * (1.0 + 0.5 / 0.01**2))
    assert plan.standard_tau == INTERVAL
    edf = degrees_of_freedom(KINDS["overlapping"], 1, int(plan.exact / INTERVAL) - 1, 0)
    assert 1.0 / np.sqrt(2.0 * edf) == pytest.approx(0.01, rel=0.01)


def test_an_hour_does_not_show_a_slow_random_walk_and_says_how_long_it_takes() -> None:
    hour = forecast(TERMS, 3_600.0, INTERVAL)
    assert hour.of("random_walk").shown
    assert not hour.of("rate_random_walk").shown
    assert plan_record(TERMS, "rate_random_walk", 0.25, INTERVAL).fit > 50.0 * 3_600.0
    assert "no" in str(hour)


def test_longer_records_tell_more_of_every_parameter() -> None:
    terms = (RandomWalk(1.0), GaussMarkov(0.3, 1.0), Sinusoid(0.2, 9.97))
    errors = [[one.relative_error for one in forecast(terms, t, INTERVAL).known] for t in (30.0, 300.0, 3_000.0)]
    assert np.all(np.diff(np.array(errors), axis=0) < 0.0)
    names = [(one.term, one.parameter) for one in forecast(terms, 30.0, INTERVAL).known]
    assert ("gauss_markov", "correlation_time") in names
    assert ("sinusoid", "frequency") not in names


def test_what_cannot_be_planned_is_refused_or_infinite() -> None:
    tiny = (RandomWalk(1.0), RateRandomWalk(1e-15))
    assert plan_record(tiny, "rate_random_walk", 0.1, INTERVAL).fit == np.inf
    with pytest.raises(PlanError, match="no term 'rate_ramp'"):
        plan_record(TERMS, "rate_ramp", 0.1, INTERVAL)
    with pytest.raises(PlanError, match="a relative error of -1"):
        plan_record(TERMS, "random_walk", -1.0, INTERVAL)
    with pytest.raises(PlanError, match="random_walk given twice"):
        forecast((RandomWalk(1.0), RandomWalk(2.0)), 10.0, INTERVAL)
    with pytest.raises(PlanError, match="no terms"):
        forecast((), 10.0, INTERVAL)
    with pytest.raises(DataError, match="2 averaging times for 3 unknowns"):
        forecast(TERMS, 8.0 * INTERVAL, INTERVAL)
    with pytest.raises(PlanError, match="no parameter rate_ramp"):
        forecast(TERMS, 10.0, INTERVAL).of("rate_ramp")
    assert "IEEE 952" in str(plan_record(TERMS, "random_walk", 0.1, INTERVAL))
