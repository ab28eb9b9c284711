"""Correlation and what is made of it: against sums written out, closed forms, and what no gap may change."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.signals.correlation import autocorrelation, cross_correlation
from inertialcal.signals.spectrum.blackman_tukey import correlation_spectrum, hanning_smoothed
from inertialcal.signals.spectrum.fourier import fourier_coefficients

CLOSE = 1e-12


def by_sums(x: list[float], y: list[float], lag: int, biased: bool) -> tuple[float, int]:
    pairs = [a * b for a, b in zip(x[: len(x) - lag], y[lag:], strict=True) if not math.isnan(a + b)]
    both = sum(not math.isnan(a + b) for a, b in zip(x, y, strict=True))
    return sum(pairs) / (both if biased else len(pairs)), len(pairs)


@pytest.mark.parametrize("kind", ["unbiased", "biased"])
@pytest.mark.parametrize("n", [40, 6000])
def test_against_sums_written_out(kind: str, n: int) -> None:
    """Short and long records, with gaps: NaN at a tenth of the samples, more pairs at no lag than there are."""
    rng = np.random.default_rng(1)
    x, y = rng.standard_normal(n), rng.standard_normal(n)
    x[rng.random(n) < 0.1] = np.nan
    y[n // 3] = np.nan
    found = cross_correlation(x, y, 20, kind, centred=False)  # type: ignore[arg-type]
    for lag in (0, 1, 7, 20):
        value, pairs = by_sums(x.tolist(), y.tolist(), lag, kind == "biased")
        assert found.values[lag] == pytest.approx(value, abs=CLOSE)
        assert found.pairs[lag] == pairs


def test_a_positive_lag_says_that_the_second_comes_later() -> None:
    x = np.random.default_rng(1).standard_normal(500)
    later = np.concatenate([np.zeros(3), x[:-3]])
    assert int(np.argmax(cross_correlation(x, later, 10).values)) == 3
    assert int(np.argmax(cross_correlation(later, x, 10).values)) != 3


def test_a_sine_has_a_cosine_for_its_correlation() -> None:
    x = np.sin(2 * np.pi * np.arange(400) / 8)
    found = autocorrelation(x, 16)
    np.testing.assert_allclose(found.values[::8], 0.5, atol=CLOSE)
    np.testing.assert_allclose(found.normalised[[0, 4, 8]], [1.0, -1.0, 1.0], atol=CLOSE)


@given(st.floats(-1e3, 1e3), st.floats(0.1, 10.0))
def test_offset_does_nothing_and_scale_squares(offset: float, scale: float) -> None:
    x = np.random.default_rng(1).standard_normal(50)
    moved = autocorrelation(scale * x + offset, 5).values
    np.testing.assert_allclose(moved, scale**2 * autocorrelation(x, 5).values, atol=1e-9 * (1.0 + scale**2 + offset**2))


def test_a_lag_without_pairs_is_not_a_number() -> None:
    found = autocorrelation([1.0, np.nan, np.nan, 2.0], 3, centred=False)
    assert np.isnan(found.values[[1, 2]]).all()
    assert found.values[3] == 2.0


def test_refused() -> None:
    with pytest.raises(DataError, match="lags up to 5 of 5 samples"):
        autocorrelation(np.ones(5), 5)
    with pytest.raises(DataError, match="signals of 3 and 4 samples"):
        cross_correlation(np.ones(3), np.ones(4), 1)
    with pytest.raises(DataError, match="0 sample"):
        autocorrelation([np.nan, np.nan], 1)
    with pytest.raises(DataError, match="does not vary"):
        _ = autocorrelation(np.ones(5), 1).normalised


def test_spectrum_of_a_sine_gives_its_amplitude_raw_and_smoothed() -> None:
    """23 sin(pi/2 i), 100 samples, 50 lags: exactly 23 on line 25, nothing beside; smoothed a root of two is needed."""
    x = 23.0 * np.sin(np.pi / 2 * np.arange(100))
    raw = correlation_spectrum(autocorrelation(x, 50).values, 120.0)
    assert raw.amplitude[25] == pytest.approx(23.0)
    assert raw.frequency[25] == pytest.approx(1.0 / 480.0)
    assert raw.bandwidth == pytest.approx(1.0 / 6000.0)
    smooth = hanning_smoothed(raw)
    assert smooth.amplitude[25] == pytest.approx(23.0)
    assert smooth.density[24] == pytest.approx(0.25 * raw.density[25])
    with pytest.raises(DataError, match="smoothed already"):
        hanning_smoothed(smooth)


def test_spectrum_of_white_noise_has_its_density_and_a_sixth_of_it_below_zero() -> None:
    """One-sided density 2 sigma^2 H; the published share of negative raw values is 16.6 %, smoothed 0.2 %."""
    rng = np.random.default_rng(1)
    raw = [correlation_spectrum(autocorrelation(x, 50).values, 1.0) for x in rng.standard_normal((500, 100))]
    values, smooth = (np.array([one.density[1:50] for one in many]) for many in (raw, map(hanning_smoothed, raw)))
    assert values.mean() == pytest.approx(2.0, rel=0.02)
    assert np.mean(values < 0.0) == pytest.approx(0.166, abs=0.01)
    assert np.mean(smooth < 0.0) == pytest.approx(0.002, abs=0.002)


def test_spectrum_refused() -> None:
    with pytest.raises(DataError, match="Need three finite ones"):
        correlation_spectrum(np.array([1.0, np.nan, 0.0]), 1.0)
    with pytest.raises(DataError, match="interval of 0"):
        correlation_spectrum(np.ones(3), 0.0)


@pytest.mark.parametrize("n", [8, 9])
def test_fourier_coefficients_give_the_record_back(n: int) -> None:
    x, i = np.random.default_rng(1).standard_normal(n), np.arange(n)
    found = fourier_coefficients(x)
    angle = 2 * np.pi / n * np.outer(i, np.arange(n // 2 + 1))
    np.testing.assert_allclose(np.cos(angle) @ found.cosine + np.sin(angle) @ found.sine, x, atol=CLOSE)


def test_fourier_signs_and_the_weight_of_the_highest_line() -> None:
    i = np.arange(100)
    highest = np.cos(np.pi * i)
    found = fourier_coefficients(3.0 * np.sin(2 * np.pi * 5 * i / 100) + highest + 2.0)
    assert (found.sine[5], found.cosine[50], found.cosine[0]) == pytest.approx((3.0, 1.0, 2.0))
    assert found.amplitude[5] == pytest.approx(3.0)
    assert found.frequency(120.0)[25] == pytest.approx(1.0 / 480.0)
    with pytest.raises(DataError, match="1 of 2 samples are missing"):
        fourier_coefficients([1.0, np.nan])
    with pytest.raises(DataError, match="Need two samples"):
        fourier_coefficients([1.0])
