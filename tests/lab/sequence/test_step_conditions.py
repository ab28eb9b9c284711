"""When a record is enough: intervals of records that ended by themselves hold the truth; what is steady."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.fft import dct
from scipy.signal import lfilter
from scipy.stats import binom

from inertialcal.core.recording import SECOND
from inertialcal.lab.sequence.conditions import at_rest, held, known_well, stays_at_rest, uncertainty
from inertialcal.lab.sequence.sequence import LOOKS
from sized import sized

LONG = sized(300, 100)  # records
SHORT = 20  # samples of a record at least
SLOW = {"white": 0.0, "0.6": 0.6, "0.9": 0.9, "0.97": 0.97, "mixed": 0.97}  # correlation of neighbours
LENGTH = {"white": 1500, "0.6": 2000, "0.9": 6000, "0.97": 20_000, "mixed": 20_000}  # samples, of which more never come


def noise(kind: str, seed: int) -> np.ndarray:
    """Return noise of variance 1 about zero, (n, 1); mixed: of a fifth of its variance neighbours are correlated."""
    rng = np.random.default_rng(seed)
    white = rng.normal(size=LENGTH[kind])
    step = rng.normal(size=LENGTH[kind]) * np.sqrt(1.0 - SLOW[kind] ** 2)
    step[0] = rng.normal()
    slow = lfilter([1.0], [1.0, -SLOW[kind]], step)
    found: np.ndarray = (np.sqrt(0.8) * white + np.sqrt(0.2) * slow if kind == "mixed" else slow)[:, np.newaxis]
    return found


def stopped(x: np.ndarray, time_ns: np.ndarray, u: float, least: int = SHORT) -> int:
    """Return after how many samples a record ends, as the sequence looks at it; 0 if it never does."""
    stop = least
    while stop <= len(x):
        if known_well(x[:stop], time_ns[:stop], u):
            return stop
        stop += max(stop // LOOKS, 1)
    return 0


def ended(kind: str, u: float, n: int, least: int = SHORT) -> tuple[int, int, float]:
    """Return of n records how many ended, whose interval held zero, and the median of their lengths."""
    lengths, inside = [], 0
    for seed in range(1, n + 1):
        x = noise(kind, seed)
        time_ns = np.arange(len(x)) * SECOND
        if stop := stopped(x, time_ns, u, least):
            _, half = uncertainty(x[:stop], time_ns[:stop])
            inside += abs(x[1 : stop - 1, 0].mean()) <= half[0]  # without its edges, as of a dwell
            lengths.append(stop)
    print(f"{kind} u = {u} from {least} on: {inside} of {len(lengths)}, {n} begun, {np.median(lengths):g} samples")
    return len(lengths), inside, float(np.median(lengths))


@pytest.mark.parametrize(
    ("kind", "u", "least", "n"),
    [
        ("0.9", 0.25, SHORT, 30),
        *(pytest.param(kind, 0.13, SHORT, LONG, marks=pytest.mark.slow) for kind in ("white", "0.6", "0.9", "0.97")),
        pytest.param("mixed", 0.06, SHORT, LONG, marks=pytest.mark.slow),
    ],
)
def test_intervals_of_records_that_ended_by_themselves_hold_the_truth(kind: str, u: float, least: int, n: int) -> None:
    """The exact 99.9 % binomial interval of the hits reaches 95 %."""
    count, inside, _ = ended(kind, u, n, least)
    assert count >= 0.9 * n
    assert binom.cdf(inside, count, 0.95) > 0.0005


def test_white_noise_takes_little_longer() -> None:
    """Scatter 1 and u = 0.13 are 1/u^2 = 59 samples when the scatter is known, 69 when it is judged from them too."""
    count, inside, length = ended("white", 0.13, 60)
    assert length < 1.3 * 69
    assert count == 60
    assert binom.cdf(inside, count, 0.95) > 0.0005


def test_a_correlation_that_few_samples_hide_ends_no_record() -> None:
    """Of noise of a correlation time of 65 samples none ends before ten of them."""
    for seed in range(1, 21):
        x = noise("0.97", seed)[:650]
        assert not stopped(x, np.arange(len(x)) * SECOND, 0.25)


def test_a_drift_ends_no_record_unless_it_is_small() -> None:
    """A drift over the record of as much as 8 u is not known; of 0.3 u it is."""
    time_ns, ends = np.arange(400) * SECOND, {8.0: 0, 0.3: 0}
    for drift in ends:
        for seed in range(1, 21):
            x = noise("white", seed)[:400] + drift * 0.1 * np.linspace(-0.5, 0.5, 400)[:, np.newaxis]
            ends[drift] += known_well(x, time_ns, 0.1)
    assert ends[8.0] <= 2
    assert ends[0.3] >= 17


def test_few_samples_end_no_record_and_gaps_do_not_stop_it() -> None:
    rng = np.random.default_rng(5)
    x, time_ns = rng.normal(size=(400, 2)), np.arange(400) * SECOND
    assert not known_well(x[:40], time_ns[:40], 10.0)
    x[100:120] = np.nan
    time_ns[300:] += 50 * SECOND
    assert known_well(x, time_ns, 0.2)
    assert not known_well(x[:1], time_ns[:1], 10.0)


def test_a_value_is_held_at_its_own_within_its_limits_and_up_to_the_end() -> None:
    time_ns = np.arange(20) * SECOND
    x = np.concatenate([np.linspace(0.0, 9.0, 10), np.full(10, 10.0)])
    assert held(x, time_ns, 10.0, 0.01, 9.0)
    assert not held(x, time_ns, 10.0, 0.01, 9.5)  # not for so long
    assert not held(x, time_ns, 10.1, 0.01, 5.0)  # elsewhere
    assert held(x, time_ns, None, 0.01, 5.0)
    assert not held(np.append(x[:-1], 10.5), time_ns, 10.0, 0.01, 5.0)  # no longer
    assert not held(x[:3], time_ns[:3], 2.0, 0.01, 0.0)


def test_rest_is_what_the_procedures_take_for_it() -> None:
    rng = np.random.default_rng(3)
    time_ns = np.arange(600) * SECOND // 100
    x = rng.normal(scale=0.01, size=(600, 3)) + np.array([0.0, 0.0, 9.8])
    assert at_rest(x, time_ns, 4.0)
    assert stays_at_rest(x, time_ns)
    x[:300, 0] += np.sin(np.arange(300) / 10.0)
    assert at_rest(x, time_ns, 2.5)
    assert not at_rest(x, time_ns, 4.0)
    assert not stays_at_rest(x, time_ns)
    assert not at_rest(x[:250], time_ns[:250], 0.5)


def test_few_independent_samples_make_a_wide_interval() -> None:
    """Student's t of as many degrees of freedom as there are cosines, 2.1788 (table), or of fewer."""
    time_ns = np.arange(120) * SECOND
    for seed in range(1, 21):
        x = noise("white", seed)[:120]
        u, half = uncertainty(x, time_ns)
        assert half[0] >= 1.98 * u[0]  # of 118
        assert half[0] >= 2.1788 * np.sqrt(2.0 * np.mean(cosines(x[1:-1, 0]) ** 2)) * (1.0 - 1e-9)


def cosines(x: np.ndarray) -> np.ndarray:
    """Return the weighted means with the slowest twelve cosines: the discrete cosine transform."""
    found: np.ndarray = dct(x, type=2)[1:13] / (2.0 * len(x))
    return found


def test_as_many_samples_as_correlated_ones_need_make_twenty_independent_ones() -> None:
    """Neighbours correlated by 0.6: n (1 - r) / (1 + r) is 30 of 120, and 19 with r at its limit, 0.73."""
    time_ns = np.arange(120) * SECOND
    without = sum(bool(np.isinf(uncertainty(noise("0.6", seed)[:120], time_ns)[1][0])) for seed in range(1, 41))
    assert without >= 20  # about half of all or more; by 1 - r alone one in seven
