"""Spectrum: units, degrees of freedom, intervals, gaps, refusals."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.spectrum import psd
from inertialcal.signals.spectrum.density import Method

METHODS = get_args(Method)
INTERVAL = 0.02  # s


def white(seed: int, n: int, axes: int = 1, sigma: float = 3.0) -> Array:
    return np.random.default_rng(seed).normal(5.0, sigma, (n, axes))


@pytest.mark.parametrize("method", METHODS)
def test_white_noise_has_the_one_sided_density_of_twice_its_variance_times_the_interval(method: Method) -> None:
    found = psd(white(1, 20_000, 2), INTERVAL, method, segment=500)
    assert found.density.mean(axis=0) == pytest.approx(2.0 * 9.0 * INTERVAL, rel=0.03)
    assert found.density.shape == (len(found.frequency), 2)
    assert np.all((found.frequency > 0.0) & (found.frequency < 0.5 / INTERVAL))


@pytest.mark.parametrize("method", METHODS)
def test_the_power_of_a_sine_is_half_its_squared_amplitude(method: Method) -> None:
    t = np.arange(20_000) * INTERVAL
    found = psd(0.7 * np.sin(2.0 * np.pi * 7.3 * t), INTERVAL, method, segment=2_000)
    assert found.density.sum() * found.spacing == pytest.approx(0.5 * 0.7**2, rel=1e-3)
    # removing the mean and the lowest frequencies take a little, nothing else does


@pytest.mark.parametrize("method", METHODS)
def test_degrees_of_freedom_and_correlation_of_neighbours_are_those_seen(method: Method) -> None:
    segment = 250 if method == "welch" else 1_000
    found = psd(white(0, 1_000), 1.0, method, segment=segment)
    many = np.stack([psd(white(k, 1_000), 1.0, method, segment=segment).density[:, 0] for k in range(1, 600)])
    seen = 2.0 / np.mean(many.var(axis=0) / many.mean(axis=0) ** 2)
    assert found.edf == pytest.approx(seen, rel=0.05)
    apart = [np.mean([np.corrcoef(many[:, i], many[:, i + k])[0, 1] for i in range(0, 100, 3)]) for k in range(4)]
    assert found.neighbours[:4] == pytest.approx(apart, abs=0.03)


def test_degrees_of_freedom_are_those_published() -> None:
    """Half overlapping Hann windows: correlation (1/6)^2 of neighbours; K tapers: 2 K (Percival and Walden, 1993)."""
    segments = 15
    found = psd(white(1, 8 * 512), 1.0, "welch", segment=512)
    assert found.segments == segments
    assert found.edf == pytest.approx(2.0 * segments / (1.0 + 2.0 * (1.0 - 1.0 / segments) / 36.0), rel=1e-6)
    assert psd(white(1, 4_000), 1.0, "multitaper", segment=4_000).edf == pytest.approx(14.0, rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_intervals_cover(method: Method) -> None:
    hits = []
    for seed in range(300):
        lo, hi = psd(white(seed, 1_000), INTERVAL, method, segment=500).interval_of(0.95)
        hits.append((lo[5:200:20, 0] < 2.0 * 9.0 * INTERVAL) & (hi[5:200:20, 0] > 2.0 * 9.0 * INTERVAL))
    assert np.mean(hits) == pytest.approx(0.95, abs=0.015)


def test_the_lowest_frequencies_are_left_out_where_the_removed_mean_falsifies_them() -> None:
    """A Hann window loses 1/6 of the power at one cycle a segment, nothing at two; see tapers.falsified."""
    assert psd(white(1, 4_000), 1.0, segment=500).frequency[0] == pytest.approx(2.0 / 500.0)
    many = np.mean([psd(white(k, 4_000), 1.0, segment=500).density[:3, 0] for k in range(200)], axis=0)
    assert many == pytest.approx(18.0, rel=0.06)


def test_bands_keep_the_level_and_know_their_scatter() -> None:
    bands = [psd(white(k, 4_000), INTERVAL).smoothed(5) for k in range(300)]
    means, edf = np.stack([density[:, 0] for _, density, _ in bands]), bands[0][2]
    assert means.mean() == pytest.approx(2.0 * 9.0 * INTERVAL, rel=0.02)
    assert 2.0 / (means.var(axis=0) / means.mean(axis=0) ** 2) == pytest.approx(edf, rel=0.3)
    with pytest.raises(PlanError, match="0 bands a decade"):
        psd(white(1, 4_000), INTERVAL).smoothed(0)


def test_segments_lie_between_gaps_and_what_is_lost_is_counted() -> None:
    x = white(1, 20_000)
    x[3_000:3_050] = np.nan
    x[9_000] = np.nan
    found = psd(x, INTERVAL, segment=400)
    assert found.missing == 51
    assert [one.code for one in found.remarks] == ["gaps"]
    assert found.remarks[0].count == 2
    assert found.density.mean() == pytest.approx(2.0 * 9.0 * INTERVAL, rel=0.03)
    assert found.used <= 20_000 - 51
    whole = psd(x[9_001:], INTERVAL, segment=400).segments
    assert found.segments == whole + (3_000 - 200) // 200 + (5_950 - 200) // 200


def test_a_sample_missing_in_one_axis_is_missing() -> None:
    x = white(1, 4_000, 2)
    x[100, 1] = np.nan
    assert psd(x, INTERVAL).missing == 1


def test_many_short_gaps_are_remarked_and_too_many_refused() -> None:
    x = white(1, 20_000)
    x[::300] = np.nan
    x[10_000:10_300] = white(2, 300)
    found = psd(x, INTERVAL, segment=301)
    assert "few_segments" in {one.code for one in found.remarks}
    with pytest.raises(DataError, match="segments of 700 samples, but at most") as refused:
        psd(x, INTERVAL, segment=700)
    assert refused.value.problems[0].code == "gaps"
    x[::20] = np.nan
    with pytest.raises(DataError, match="a spectrum needs 32") as refused:
        psd(x, INTERVAL)
    assert refused.value.problems[0].code == "gaps"


def test_a_constant_axis_is_remarked() -> None:
    x = np.concatenate((white(1, 4_000), np.full((4_000, 1), 9.80665)), axis=1)
    assert [(one.code, one.what[:6]) for one in psd(x, INTERVAL).remarks] == [("constant", "axis 1")]


@pytest.mark.parametrize(
    ("change", "words", "error"),
    [
        ({"interval": 0.0}, "a sample interval of 0.0 s", DataError),
        ({"interval": np.nan}, "a sample interval of nan s", DataError),
        ({"method": "fft"}, "method 'fft'", PlanError),
        ({"segment": 8}, "segments of 8 samples", PlanError),
        ({"segment": 5_000}, "segments of 5000 samples, but at most 4000", DataError),
        ({"time_bandwidth": 0.1}, "time_bandwidth 0.1", PlanError),
        ({"p": 1.0}, "probability 1.0", PlanError),
        ({"x": np.zeros((2, 2, 2))}, r"a signal of shape \(2, 2, 2\)", DataError),
        ({"x": np.zeros(10)}, "10 samples, at most 10 in a row", DataError),
    ],
)
def test_bad_input_is_refused_with_its_value(change: dict[str, object], words: str, error: type[Exception]) -> None:
    given_ = {"x": white(1, 4_000), "interval": INTERVAL, **change}
    with pytest.raises(error, match=words):
        psd(**given_)  # type: ignore[arg-type]


@given(st.floats(1e-6, 1e6), st.floats(-1e6, 1e6), st.sampled_from(METHODS))
def test_shift_leaves_and_scale_squares_the_density(scale: float, shift: float, method: Method) -> None:
    x = white(3, 600, sigma=1.0)
    plain, changed = psd(x, 1.0, method, segment=200), psd(scale * (x + shift), 1.0, method, segment=200)
    assert changed.density == pytest.approx(scale**2 * plain.density, rel=1e-4)


def test_it_prints_and_its_intervals_hold_it() -> None:
    found = psd(white(1, 4_000, 2), INTERVAL)
    assert "spectrum (welch): 15 segment(s)" in str(found)
    assert "<table" in found._repr_html_()
    assert np.all((found.lo < found.density) & (found.density < found.hi))
    with pytest.raises(PlanError, match="probability 0"):
        found.interval_of(0.0)
