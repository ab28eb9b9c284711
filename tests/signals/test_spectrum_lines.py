"""Lines: false alarms at the stated rate, lines found with their frequency and amplitude; Allan against spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal, stats

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import allan
from inertialcal.signals.spectrum import allan_of_spectrum, compare_allan, find_lines, psd

INTERVAL = 0.01  # s
N = 2**14

Noise = Callable[[np.random.Generator], Array]
NOISES: dict[str, Noise] = {
    "white": lambda rng: rng.normal(size=N),
    "random walk": lambda rng: np.asarray(np.cumsum(rng.normal(size=N))),
    "white and random walk": lambda rng: np.asarray(rng.normal(size=N) + 0.03 * np.cumsum(rng.normal(size=N))),
    "Gauss-Markov": lambda rng: np.asarray(signal.lfilter([1.0], [1.0, -0.9], rng.normal(size=N))),
}


@pytest.mark.parametrize("name", NOISES)
def test_noise_alone_shows_lines_as_rarely_as_stated(name: str) -> None:
    rng, records, false_alarm = np.random.default_rng(1), 120, 0.05
    found = sum(len(find_lines(psd(NOISES[name](rng), INTERVAL), false_alarm)) > 0 for _ in range(records))
    assert found <= stats.binom.isf(1e-3, records, false_alarm)


def test_lines_are_found_named_and_measured() -> None:
    rng, t = np.random.default_rng(2), np.arange(4 * N) * INTERVAL
    truth = {"0.56 Hz": (0.56, 0.5), "9.97 Hz": (9.97, 0.3), "3 x 9.97 Hz": (29.91, 0.2)}
    x = rng.normal(size=len(t)) + 0.01 * np.cumsum(rng.normal(size=len(t)))
    x += sum(a * np.sin(2.0 * np.pi * f * t + f) for f, a in truth.values())
    for method in ("welch", "multitaper"):
        lines = find_lines(psd(x, INTERVAL, method))
        found = [(line.name, line.kind) for line in lines.found]
        assert len(found) == 3
        for line, (name, (frequency, amplitude)) in zip(lines.found, truth.items(), strict=True):
            assert line.kind == "line"
            assert line.name.startswith("3 x") == name.startswith("3 x")
            assert line.frequency == pytest.approx(frequency, abs=5.0 * line.u_frequency)
            assert line.amplitude == pytest.approx(amplitude, abs=4.0 * line.u_amplitude)
            assert line.chance < 1e-6
        assert len(lines.remarks) == 3
        assert "9.97 Hz" in str(lines)


def test_the_uncertainty_of_an_amplitude_is_its_scatter() -> None:
    rng, t = np.random.default_rng(3), np.arange(N) * INTERVAL
    found = []
    for _ in range(150):
        frequency = 9.97 + rng.uniform(-0.1, 0.1)
        x = rng.normal(size=N) + 0.2 * np.sin(2.0 * np.pi * frequency * t + rng.uniform(0.0, 6.0))
        (line,) = find_lines(psd(x, INTERVAL), 1e-4).found
        found.append((line.amplitude - 0.2, line.u_amplitude, line.frequency - frequency, line.u_frequency))
    offset, u, off_frequency, u_frequency = np.array(found).T
    assert abs(offset.mean()) < 0.3 * u.mean()
    assert offset.std() == pytest.approx(u.mean(), rel=0.3)
    assert off_frequency.std() < 1.5 * u_frequency.mean()


def test_a_resonance_is_broad_and_a_constant_axis_has_no_lines() -> None:
    rng = np.random.default_rng(4)
    peak = signal.lfilter([1.0], [1.0, -2.0 * 0.995 * np.cos(0.8), 0.995**2], rng.normal(size=4 * N))
    x = np.stack((rng.normal(size=4 * N) + 0.3 * peak, np.ones(4 * N)), axis=1)
    lines = find_lines(psd(x, INTERVAL, segment=4_000))
    assert lines.found
    assert {line.axis for line in lines.found} == {0}
    widest = max(lines.found, key=lambda line: line.width)
    assert widest.kind == "broad"
    assert widest.frequency == pytest.approx(0.8 / (2.0 * np.pi * INTERVAL), rel=0.05)


def test_lines_taken_out_leave_the_noise() -> None:
    rng, t = np.random.default_rng(5), np.arange(4 * N) * INTERVAL
    spectrum = psd(rng.normal(size=4 * N) + np.sin(2.0 * np.pi * 20.0 * t), INTERVAL)
    lines = find_lines(spectrum)
    left = spectrum.without(lines.marked)
    assert spectrum.density.max() > 1_000.0 * left.density.mean()
    assert left.density.mean() == pytest.approx(2.0 * INTERVAL, rel=0.02)
    assert not find_lines(left).found
    with pytest.raises(DataError, match="or all marked"):
        spectrum.without(np.ones_like(lines.marked))
    with pytest.raises(PlanError, match="false_alarm 0"):
        find_lines(spectrum, 0.0)


# Allan variance from the spectrum


@dataclass(frozen=True)
class Curve:
    tau: Array
    deviation: Array
    edf: Array


def measured(x: Array, m: NDArray[np.int64]) -> Curve:
    """Overlapping Allan deviation by its definition, white noise's degrees of freedom at least."""
    phase = np.concatenate(([0.0], np.cumsum(x - x.mean())))
    second = [phase[2 * k :] - 2.0 * phase[k:-k] + phase[: -2 * k] for k in m]
    deviation = np.array([np.sqrt(np.mean(d**2) / 2.0) / k for d, k in zip(second, m, strict=True)])
    edf = np.maximum(1.0, 1.4 * (len(x) / m - 2.0))
    return Curve(np.asarray(m * INTERVAL, dtype=np.float64), deviation[:, None], edf[:, None])


def test_the_allan_variance_of_a_level_spectrum_is_that_of_white_noise() -> None:
    """N^2 / tau with one-sided density 2 N^2, for any tau; a unit density, no noise in it."""
    spectrum = psd(np.random.default_rng(1).normal(size=N), INTERVAL)
    level = replace(spectrum, density=np.full_like(spectrum.density, 2.0))
    tau = np.array([1.0, 2.0, 5.0, 16.0, 50.0]) * INTERVAL
    found = allan_of_spectrum(level, tau)
    assert found.deviation[:, 0] ** 2 == pytest.approx(1.0 / tau, rel=2e-3)
    with pytest.raises(DataError, match=r"not all whole multiples of 0\.01"):
        allan_of_spectrum(level, np.array([0.015]))


@pytest.mark.parametrize("name", NOISES)
def test_figures_of_one_record_agree(name: str) -> None:
    rng, m = np.random.default_rng(6), 2 ** np.arange(12, dtype=np.int64)
    for _ in range(20):
        x = NOISES[name](rng)
        found = compare_allan(psd(x, INTERVAL), measured(x, m))
        assert found.agree.all()
        assert found.compared >= 5
        assert np.nanmax(np.abs(found.ratio - 1.0)) < 0.1
        assert not found.remarks


def test_a_wrong_interval_disagrees() -> None:
    rng, m = np.random.default_rng(7), 2 ** np.arange(10, dtype=np.int64)
    x = rng.normal(size=N)
    curve = measured(x, m)
    wrong = replace(curve, deviation=1.1 * curve.deviation)
    found = compare_allan(psd(x, INTERVAL), wrong)
    assert not found.agree.any()
    assert found.remarks[0].code == "allan_spectrum_disagree"
    assert "DISAGREE" in str(found)
    with pytest.raises(PlanError, match="false_alarm 1"):
        compare_allan(psd(x, INTERVAL), curve, 1.0)
    with pytest.raises(DataError, match="different axes"):
        compare_allan(psd(np.stack((x, x), axis=1), INTERVAL), curve)
    long = measured(x, np.array([4_096]))
    assert compare_allan(psd(x, INTERVAL), long).remarks[0].code == "allan_not_compared"


def test_the_allan_deviation_built_here_agrees_with_the_spectrum_of_the_same_samples() -> None:
    rng = np.random.default_rng(8)
    x = np.stack((rng.normal(size=N), np.cumsum(rng.normal(size=N))), axis=1)
    found = compare_allan(psd(x, INTERVAL), allan(x, INTERVAL, quantity="rate"))
    assert found.agree.all()
    assert found.compared >= 12
