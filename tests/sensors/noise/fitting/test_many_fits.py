"""Series fitted together give what each gives alone: terms, intervals, limits, remarks and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from noise_records import curve, record

from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.sensors.noise.fitting.estimator import Fit, fit, fit_many
from inertialcal.sensors.noise.fitting.filtered import Band, mild_band, search
from inertialcal.sensors.noise.fitting.noise_fit import NoiseFit
from inertialcal.sensors.noise.terms import BiasInstability, GaussMarkov, RandomWalk, RateRandomWalk, Sinusoid, Term
from inertialcal.signals.allan import Allan, allan
from inertialcal.signals.spectrum.psd import psd

ROUNDING = 1e-9
WHITE: tuple[Term, ...] = (RandomWalk(1.0),)
KINDS: tuple[tuple[Term, ...], ...] = (
    WHITE,
    (*WHITE, BiasInstability(0.3)),
    (*WHITE, RateRandomWalk(0.3)),
    (*WHITE, GaussMarkov(2.0, 1.0)),
    (*WHITE, Sinusoid(1.0, 0.7)),
)


def filtered() -> tuple[Allan, Band | None]:
    """White noise behind a low pass, and what that leaves of it."""
    rates = np.convolve(record(WHITE, 8000, 0.05, 9), np.exp(-0.3 * np.arange(60)) * (1.0 - np.exp(-0.3)))[60:7000]
    found = search(psd(rates, 0.05))
    return allan(rates, 0.05, quantity="rate"), None if found is None else found.band()


@pytest.fixture(scope="module")
def given() -> list[Fit]:
    curves = [curve(terms, 8000, 0.05, seed) for seed in (1, 2) for terms in KINDS]
    fits = [Fit(one, "gyro") for one in curves]
    fits += [Fit(one, "gyro", bands=[mild_band(0.01 * (i + 1))]) for i, one in enumerate(curves)]
    fits += [Fit(one, None, ("random_walk", "rate_random_walk"), p=0.9) for one in curves[:3]]
    fits += [Fit(curves[4], "gyro", lines=[0.7]), Fit(curves[9], "gyro", lines=[0.7]), Fit(curves[:2], "gyro")]
    still = replace(curves[0], deviation=0.0 * curves[0].deviation)
    below, band = filtered()
    assert band is not None
    fits += [Fit(below, "gyro", bands=[band]), Fit(curve(WHITE, 2000, 0.05, 3), "accelerometer")]
    fits += [Fit(still, "gyro"), Fit(curves[0], "gyro", "wander"), Fit([], "gyro"), Fit(curves[0], "gyro", p=2.0)]
    fits += [Fit(curves[0], "gyro", ("rate_ramp",)), Fit(curve(WHITE, 12, 0.05, 1), "gyro")]
    return [fits[i] for i in np.random.default_rng(1).permutation(len(fits))]


def alone(one: Fit) -> NoiseFit | InertialcalError:
    try:
        return fit(one.curves, one.kind, terms=one.terms, lines=one.lines, bands=one.bands, axis=one.axis,
                   unit=one.unit, p=one.p)  # fmt: skip
    except InertialcalError as error:
        return error


def figures(found: NoiseFit) -> list[float]:
    values = [value for term in found.found for one in term.parameters for value in (one.value, one.u)]
    ends = [end or 0.0 for term in found.found for one in term.parameters for end in (one.interval.lo, one.interval.hi)]
    limits = [v or 0.0 for term in found.found for v in (term.upper_limit, term.record_needed, term.limit_at)]
    return [*values, *ends, *limits, *(worse for _, worse in found.choices), *found.expected[0], found.misfit]


def test_series_fitted_together_give_what_each_gives_alone(given: list[Fit]) -> None:
    refused = 0
    for one, found in zip(given, fit_many(given), strict=True):
        own = alone(one)
        if isinstance(own, InertialcalError):
            assert isinstance(found, InertialcalError)
            assert (type(found), str(found)) == (type(own), str(own))
            refused += 1
            continue
        assert isinstance(found, NoiseFit)
        assert str(found) == str(own)
        assert found.remarks == own.remarks
        assert [term.reason for term in found.found] == [term.reason for term in own.found]
        assert [terms for terms, _ in found.choices] == [terms for terms, _ in own.choices]
        assert found.at(0.5).found[0].parameters == own.at(0.5).found[0].parameters
        assert np.allclose(figures(found), figures(own), rtol=ROUNDING, atol=0.0)
        assert np.allclose(found.estimate.covariance, own.estimate.covariance, rtol=ROUNDING, atol=0.0)
    assert refused == 6


def test_the_order_of_series_does_not_matter(given: list[Fit]) -> None:
    back = [str(one) for one in fit_many(given[::-1])][::-1]
    assert back == [str(one) for one in fit_many(given)]


def test_a_series_that_cannot_be_fitted_is_refused_alone(given: list[Fit]) -> None:
    good = next(one for one in given if isinstance(alone(one), NoiseFit))
    found = fit_many([good, Fit([], "gyro"), good])
    assert [type(one) for one in found] == [NoiseFit, DataError, NoiseFit]
