"""Spectrum: units, degrees of freedom, intervals, gaps, refusals."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.expected import sampled_spectrum
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRandomWalk,
    Term,
)
from inertialcal.signals.names import Method
from inertialcal.signals.spectrum.psd import psd
from inertialcal.signals.spectrum.tapers import Tapers, hann, slepian
from inertialcal.statistics.intervals import covers

METHODS = get_args(Method)
INTERVAL = 0.02  # s
AGREE = 1e-12  # relative, of the same sum in another order


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


def test_it_is_the_density_of_scipy() -> None:
    x = white(1, 5_000, 2)
    found, (frequency, density) = psd(x, INTERVAL, segment=500), signal.welch(x, 1.0 / INTERVAL, "hann", 500, axis=0)
    at = np.round(found.frequency * 500 * INTERVAL).astype(int)
    assert found.frequency == pytest.approx(frequency[at], rel=AGREE)
    assert found.density == pytest.approx(density[at], rel=AGREE)


@pytest.mark.parametrize("method", METHODS)
def test_degrees_of_freedom_and_correlation_of_neighbours_are_those_seen(method: Method) -> None:
    found = psd(white(0, 1_000, 600), 1.0, method, segment=250 if method == "welch" else 1_000)
    many = found.density.T
    seen = 2.0 / np.mean(many.var(axis=0) / many.mean(axis=0) ** 2)
    assert found.edf == pytest.approx(seen, rel=0.05)
    apart = [np.mean([np.corrcoef(many[:, i], many[:, i + k])[0, 1] for i in range(0, 100, 3)]) for k in range(4)]
    assert found.neighbours[:4] == pytest.approx(apart, abs=0.03)


@pytest.mark.parametrize("n", [8, 64, 501])
def test_noise_bandwidth_counts_spacings(n: int) -> None:
    """One without a taper, and 1.5 of a Hann taper, of whatever length."""
    assert Tapers(np.full((1, n), n**-0.5), n, 1).enbw == pytest.approx(1.0, rel=AGREE)
    assert hann(n).enbw == pytest.approx(1.5, rel=AGREE)


@pytest.mark.parametrize("n", [32, 501, 4_096])
def test_tapers_are_those_of_scipy(n: int) -> None:
    window = signal.windows.hann(n, sym=False)
    assert hann(n).weights[0] == pytest.approx(window / np.linalg.norm(window), abs=1e-15)
    own, other = slepian(n, 4.0).weights, signal.windows.dpss(n, 4.0, 6)
    signs = np.sign(np.sum(own * other, axis=1))[:, None]
    assert own == pytest.approx(signs * other, abs=1e-15)


def test_degrees_of_freedom_are_those_published() -> None:
    """Half overlapping Hann windows: correlation (1/6)^2 of neighbours; K tapers: 2 K (Percival and Walden, 1993)."""
    segments = 15
    found = psd(white(1, 8 * 512), 1.0, "welch", segment=512)
    assert found.segments == segments
    assert found.edf == pytest.approx(2.0 * segments / (1.0 + 2.0 * (1.0 - 1.0 / segments) / 36.0), rel=1e-6)
    assert psd(white(1, 4_000), 1.0, "multitaper", segment=4_000).edf == pytest.approx(12.0, rel=1e-9)


# Noises (samples of many records side by side) and their closed one-sided densities, by the cycles a sample


def walk(rng: np.random.Generator, n: int, records: int) -> Array:
    return np.asarray(np.cumsum(rng.normal(size=(n, records)), axis=0))


def markov(rng: np.random.Generator, n: int, records: int) -> Array:
    start = rng.normal(0.0, 1.0 / np.sqrt(1.0 - 0.9**2), (1, records))
    return np.asarray(signal.lfilter([1.0], [1.0, -0.9], rng.normal(size=(n, records)), axis=0, zi=0.9 * start)[0])


NOISES: dict[str, tuple[Callable[..., Array], Callable[[Array], Array]]] = {
    "white": (lambda rng, n, records: rng.normal(size=(n, records)), lambda f: 2.0 * np.ones_like(f)),
    "quantised": (
        lambda rng, n, records: np.diff(rng.normal(size=(n + 1, records)), axis=0),
        lambda f: 8.0 * np.sin(np.pi * f) ** 2,
    ),
    "Gauss-Markov": (markov, lambda f: 2.0 / (1.0 - 1.8 * np.cos(2.0 * np.pi * f) + 0.81)),
    "random walk": (walk, lambda f: 0.5 / np.sin(np.pi * f) ** 2),
}


def covered(name: str, method: Method, records: int, p: float) -> list[int]:
    """How many intervals hold the density at the lowest frequencies, in the middle, and at the highest one."""
    noise, density = NOISES[name]
    found = psd(noise(np.random.default_rng(1), 2_048, records), 1.0, method)
    lo, hi = found.interval_of(p)
    true = density(found.frequency)[:, None]
    middle = len(found.frequency) // 2
    return [int(np.sum((lo[i] < true[i]) & (true[i] < hi[i]))) for i in (1, 2, 5, middle, -1)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NOISES)
def test_intervals_cover_at_every_frequency_that_is_given(name: str, method: Method) -> None:
    for hits in covered(name, method, 300, 0.95):
        assert covers(hits, 300)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NOISES)
def test_intervals_cover_a_thousand_times(name: str, method: Method) -> None:
    for p in (0.6827, 0.95):
        for hits in covered(name, method, 1_000, p):
            assert covers(hits, 1_000, p - 0.02, p + 0.02)


@pytest.mark.parametrize("method", METHODS)
def test_what_a_removed_mean_or_smoothing_falsifies_is_left_out(method: Method) -> None:
    """A Hann window loses 1/6 of the power at one cycle a segment; smoothing adds 1/f^2 to a walk, f in cycles."""
    for name in ("white", "random walk"):
        noise, density = NOISES[name]
        found = psd(noise(np.random.default_rng(2), 2_048, 500), 1.0, method, segment=2_048)
        assert found.density.mean(axis=1)[:3] == pytest.approx(density(found.frequency[:3]), rel=0.18)
        # 10 % allowed at most, and three standard deviations
    assert psd(white(1, 4_000), 1.0, segment=500).frequency[0] == pytest.approx(4.0 / 500.0)


TERMS: list[tuple[Term, ...]] = [
    (Quantization(0.02), RandomWalk(0.3)),
    (RandomWalk(0.3), BiasInstability(1.0)),
    (RandomWalk(0.3), GaussMarkov(1.0, 0.5), RateRandomWalk(0.2)),
]


@pytest.mark.parametrize("averaging", [INTERVAL, 0.5 * INTERVAL])
@pytest.mark.parametrize("terms", TERMS)
def test_samples_of_noise_terms_have_the_density_of_the_terms(terms: tuple[Term, ...], averaging: float) -> None:
    """What a figure draws through a spectrum: aliased, with dead time too."""
    rng = np.random.default_rng(5)
    x = np.stack([simulate(terms, 4_000, INTERVAL, rng, averaging) for _ in range(60)], axis=1)
    found = psd(x, INTERVAL)
    ratio = found.density.mean(axis=1) / sampled_spectrum(terms, found.frequency, INTERVAL, averaging)
    scatter = np.sqrt(2.0 / (60.0 * found.edf))
    assert ratio[5:].mean() == pytest.approx(1.0, abs=0.01)  # what smoothing adds to a steep part lies below
    assert ratio[5:].std() == pytest.approx(scatter, rel=0.3)


def test_bands_keep_the_level_and_know_their_scatter() -> None:
    _, density, edf = psd(white(1, 4_000, 300), INTERVAL).smoothed(5)
    means = density.T
    assert means.mean() == pytest.approx(2.0 * 9.0 * INTERVAL, rel=0.02)
    assert 2.0 / (means.var(axis=0) / means.mean(axis=0) ** 2) == pytest.approx(edf, rel=0.3)
    with pytest.raises(PlanError, match="0 bands a decade"):
        psd(white(1, 4_000), INTERVAL).smoothed(0)


def test_a_weighted_sum_knows_its_scatter() -> None:
    found = psd(white(2, 2_000, 400), INTERVAL)
    weights = np.exp(-found.frequency)
    total, edf = found.summed(weights)
    assert total.mean() == pytest.approx(2.0 * 9.0 * INTERVAL * weights.sum(), rel=0.02)
    assert 2.0 * total.mean() ** 2 / total.var() == pytest.approx(edf.mean(), rel=0.2)


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


def test_segments_are_short_enough_that_most_samples_count() -> None:
    x = white(1, 20_000)
    x[np.arange(3_000, 20_000, 500)] = np.nan  # a stretch of 3,000 samples holds the longest segment, alone
    found = psd(x, INTERVAL)
    assert 250 <= found.segment < 500
    assert found.used > 0.7 * 20_000
    assert [one.code for one in found.remarks] == ["gaps"]


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


def test_an_axis_that_changes_at_its_end_is_not_constant() -> None:
    x = np.full(70_000, 9.8)  # more than one batch
    assert [one.code for one in psd(x, INTERVAL).remarks] == ["constant"]
    x[-1] += 1e-6
    assert not psd(x, INTERVAL).remarks


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
        ({"method": "multitaper", "segment": 60}, "segments of 60 samples, need 64", PlanError),
        ({"p": 1.0}, "probability 1.0", PlanError),
        ({"x": np.zeros((2, 2, 2))}, r"a signal of shape \(2, 2, 2\)", DataError),
        ({"x": np.zeros(10)}, "10 samples, at most 10 in a row", DataError),
    ],
)
def test_bad_input_is_refused_with_its_value(change: dict[str, object], words: str, error: type[Exception]) -> None:
    given_ = {"x": white(1, 4_000), "interval": INTERVAL, **change}
    with pytest.raises(error, match=words):
        psd(**given_)  # type: ignore[arg-type]


@settings(max_examples=25)
@given(st.floats(1e-6, 1e6), st.floats(-1e6, 1e6), st.sampled_from(METHODS))
def test_shift_leaves_and_scale_squares_the_density(scale: float, shift: float, method: Method) -> None:
    x = white(3, 600, sigma=1.0)
    plain, changed = psd(x, 1.0, method, segment=200), psd(scale * (x + shift), 1.0, method, segment=200)
    assert changed.density == pytest.approx(scale**2 * plain.density, rel=1e-4)


def test_intervals_hold_the_density() -> None:
    found = psd(white(1, 4_000, 2), INTERVAL)
    assert np.all((found.lo < found.density) & (found.density < found.hi))
    with pytest.raises(PlanError, match="probability 0"):
        found.interval_of(0.0)
