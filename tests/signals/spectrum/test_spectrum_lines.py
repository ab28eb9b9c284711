"""Lines: false alarms at the stated rate, lines found with their frequency and amplitude; Allan against spectrum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal, stats

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import allan
from inertialcal.signals.allan.channel import Allan
from inertialcal.signals.names import Method
from inertialcal.signals.spectrum.allan_check import allan_of_spectrum, compare_allan
from inertialcal.signals.spectrum.lines import background_of, find_lines
from inertialcal.signals.spectrum.psd import psd

INTERVAL = 0.01  # s
N = 2**13

Noise = Callable[[np.random.Generator, int], Array]
NOISES: dict[str, Noise] = {  # of many records side by side
    "white": lambda rng, records: rng.normal(size=(N, records)),
    "quantised": lambda rng, records: np.asarray(np.diff(rng.normal(size=(N + 1, records)), axis=0)),
    "random walk": lambda rng, records: np.asarray(np.cumsum(rng.normal(size=(N, records)), axis=0)),
    "white and random walk": lambda rng, records: np.asarray(
        rng.normal(size=(N, records)) + 0.03 * np.cumsum(rng.normal(size=(N, records)), axis=0)
    ),
    "Gauss-Markov": lambda rng, records: np.asarray(
        signal.lfilter([1.0], [1.0, -0.9], rng.normal(size=(N + 200, records)), axis=0)[200:]
    ),
    "sharp filter before rounding": lambda rng, records: np.asarray(
        signal.sosfilt(signal.butter(4, 0.5, output="sos"), rng.normal(size=(N + 200, records)), axis=0)[200:].round(2)
    ),
}
FALSE_ALARM = 0.05


def alarms(name: str, records: int, method: Method, segment: int | None = None) -> int:
    """Records of noise alone in which any line is found."""
    spectrum = psd(NOISES[name](np.random.default_rng(1), records), INTERVAL, method, segment=segment)
    return len({line.axis for line in find_lines(spectrum, FALSE_ALARM).found})


@pytest.mark.parametrize("name", NOISES)
def test_noise_alone_shows_lines_as_rarely_as_stated(name: str) -> None:
    records = 60
    assert alarms(name, records, "welch") <= stats.binom.isf(1e-3, records, FALSE_ALARM)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "segment"), [("welch", None), ("welch", N // 64), ("multitaper", None)])
@pytest.mark.parametrize("name", NOISES)
def test_false_alarms_of_many_records(name: str, method: Method, segment: int | None) -> None:
    records = 200
    assert alarms(name, records, method, segment) <= stats.binom.isf(1e-3, records, FALSE_ALARM)


def test_lines_are_found_named_and_measured() -> None:
    rng, t = np.random.default_rng(2), np.arange(8 * N) * INTERVAL
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


def test_the_uncertainty_of_an_amplitude_is_its_scatter() -> None:
    rng, t = np.random.default_rng(3), np.arange(N)[:, None] * INTERVAL
    frequency, start = 9.97 + rng.uniform(-0.1, 0.1, 60), rng.uniform(0.0, 6.0, 60)
    x = rng.normal(size=(N, 60)) + 0.3 * np.sin(2.0 * np.pi * frequency * t + start)
    lines = find_lines(psd(x, INTERVAL), 1e-4).found
    assert [line.axis for line in lines] == list(range(60))
    offset = np.array([line.amplitude for line in lines]) - 0.3
    u = np.array([line.u_amplitude for line in lines])
    assert abs(offset.mean()) < 0.3 * u.mean()
    assert offset.std() == pytest.approx(u.mean(), rel=0.3)
    ratio = (np.array([line.frequency for line in lines]) - frequency) / [line.u_frequency for line in lines]
    assert 0.4 < ratio.std() < 1.2  # stated on the safe side, most for strong lines


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


def test_a_short_spectrum_says_that_it_cannot_tell_lines() -> None:
    x = np.random.default_rng(4).normal(size=1_000) + 3.0 * np.sin(0.7 * np.arange(1_000))
    short = find_lines(psd(x, INTERVAL))
    assert not short.found
    assert [one.code for one in short.remarks] == ["lines_not_tested"]
    (line,) = find_lines(psd(x, INTERVAL, "multitaper")).found
    assert line.frequency == pytest.approx(0.7 / (2.0 * np.pi * INTERVAL), rel=0.01)


def test_a_line_at_the_edge_of_what_is_tested_is_measured_without_the_rise_below_it() -> None:
    """A random walk rises below the lowest frequency tested: none of that is the line's."""
    rng, t, records = np.random.default_rng(9), np.arange(8 * N)[:, None] * INTERVAL, 12
    x = 0.05 * np.cumsum(rng.normal(size=(8 * N, records)), axis=0)
    spectrum = psd(x, INTERVAL)
    lowest = find_lines(spectrum).tested[0]
    frequency = lowest + spectrum.spacing
    level = spectrum.density[np.argmin(np.abs(spectrum.frequency - frequency))].mean()
    amplitude = np.sqrt(2.0 * 15.0 * level * spectrum.enbw)  # 15 times the noise
    lines = find_lines(psd(x + amplitude * np.sin(2.0 * np.pi * frequency * t), INTERVAL)).found
    near = [line for line in lines if abs(line.frequency - frequency) < spectrum.spacing]
    assert len(near) == records
    assert np.mean([line.amplitude for line in near]) == pytest.approx(amplitude, rel=0.05)
    assert np.mean([line.frequency for line in near]) == pytest.approx(frequency, abs=0.15 * spectrum.spacing)


LEVELS: dict[str, Noise] = {name: NOISES[name] for name in ("white", "quantised", "random walk")}


@pytest.mark.parametrize("name", LEVELS)
def test_the_level_is_that_of_the_noise_and_knows_its_scatter(name: str) -> None:
    """Unbiased to the edges of what is tested, where values lie on one side or the spectrum is steep."""
    records = 150
    spectrum = psd(LEVELS[name](np.random.default_rng(3), records), INTERVAL, segment=N // 8)
    sine = 2.0 * np.sin(np.pi * spectrum.frequency * INTERVAL)
    true = 2.0 * INTERVAL * sine ** {"white": 0.0, "quantised": 2.0, "random walk": -2.0}[name]
    unmarked = np.zeros(len(true), dtype=bool)
    found = [background_of(spectrum, axis, unmarked) for axis in range(records)]
    known = np.flatnonzero(np.isfinite(found[0].level))
    ratio = np.stack([one.level[known] for one in found]) / true[known]
    for at in (0, 1, len(known) // 2, -3, -1):
        dof = found[0].dof[known[at]]
        sigma = np.sqrt(2.0 / dof)
        assert ratio[:, at].mean() == pytest.approx(1.0, abs=4.0 * sigma / np.sqrt(records) + 0.01)
        assert ratio[:, at].std() == pytest.approx(sigma, rel=0.25)


def test_a_line_does_not_raise_the_level_at_its_own_frequency() -> None:
    rng, t = np.random.default_rng(5), np.arange(N) * INTERVAL
    x = rng.normal(size=N)
    plain, lined = psd(x, INTERVAL), psd(x + np.sin(2.0 * np.pi * 12.5 * t), INTERVAL)
    unmarked = np.zeros(len(plain.frequency), dtype=bool)
    at = int(np.argmax(lined.density[:, 0]))
    level = [background_of(one, 0, unmarked).level[at] for one in (plain, lined)]
    assert lined.density[at, 0] > 100.0 * level[0]
    assert level[1] == pytest.approx(level[0], rel=0.01)


def test_lines_taken_out_leave_the_noise() -> None:
    rng, t = np.random.default_rng(5), np.arange(4 * N) * INTERVAL
    spectrum = psd(rng.normal(size=4 * N) + np.sin(2.0 * np.pi * 20.0 * t), INTERVAL)
    lines = find_lines(spectrum)
    left = spectrum.without(lines.marked)
    assert spectrum.density.max() > 500.0 * left.density.mean()
    assert left.density.mean() == pytest.approx(2.0 * INTERVAL, rel=0.02)
    assert not find_lines(left).found
    with pytest.raises(DataError, match="or all marked"):
        spectrum.without(np.ones_like(lines.marked))
    with pytest.raises(PlanError, match="false_alarm 0"):
        find_lines(spectrum, 0.0)


# Allan variance from the spectrum


def curve_of(tau: Array, deviation: Array, edf: Array) -> Allan:
    """Return what the comparison looks at of a measured curve."""
    return cast("Allan", SimpleNamespace(tau=tau, deviation=deviation, edf=edf, interval=np.nan))


def measured(x: Array, m: NDArray[np.int64]) -> Allan:
    """Overlapping Allan deviation by its definition, white noise's degrees of freedom at least."""
    phase = np.concatenate(([0.0], np.cumsum(x - x.mean())))
    second = [phase[2 * k :] - 2.0 * phase[k:-k] + phase[: -2 * k] for k in m]
    deviation = np.array([np.sqrt(np.mean(d**2) / 2.0) / k for d, k in zip(second, m, strict=True)])
    edf = np.maximum(1.0, 1.4 * (len(x) / m - 2.0))
    return curve_of(np.asarray(m * INTERVAL, dtype=np.float64), deviation[:, None], edf[:, None])


def test_the_allan_variance_of_a_level_spectrum_is_that_of_white_noise() -> None:
    """N^2 / tau with one-sided density 2 N^2, for any tau; a unit density, no noise in it."""
    spectrum = psd(np.random.default_rng(1).normal(size=4 * N), INTERVAL)
    level = replace(spectrum, density=np.full_like(spectrum.density, 2.0))
    tau = np.array([1.0, 2.0, 5.0, 16.0, 50.0]) * INTERVAL
    found = allan_of_spectrum(level, tau)
    assert found.deviation[:, 0] ** 2 == pytest.approx(1.0 / tau, rel=2e-3)
    with pytest.raises(DataError, match=r"not all whole multiples of 0\.01"):
        allan_of_spectrum(level, np.array([0.015]))


@pytest.mark.parametrize("name", NOISES)
def test_figures_of_one_record_agree(name: str) -> None:
    x = NOISES[name](np.random.default_rng(6), 20)
    found = compare_allan(psd(x, INTERVAL), allan(x, INTERVAL, quantity="rate"))
    assert found.agree.all()
    assert found.compared >= 20 * 3
    assert np.nanmax(np.abs(found.ratio - 1.0)) < 0.1
    assert not found.remarks


def test_the_chance_of_a_ratio_is_that_of_fishers_distribution() -> None:
    """Ratio 2 of variances, with 5 degrees of freedom above and those of the spectrum below."""
    spectrum = psd(np.random.default_rng(1).normal(size=N), INTERVAL)
    meant = allan_of_spectrum(spectrum, np.array([4.0 * INTERVAL]))
    curve = curve_of(meant.tau, np.sqrt(2.0) * meant.deviation, np.array([[5.0]]))
    chance = 2.0 * stats.f.sf(2.0 / 1.05, 5.0, meant.edf[0, 0])  # 5 % is no disagreement
    assert compare_allan(spectrum, curve).chance[0, 0] == pytest.approx(chance, rel=1e-6)
    lower = curve_of(meant.tau, np.sqrt(0.5) * meant.deviation, np.array([[5.0]]))
    chance = 2.0 * stats.f.cdf(0.5 / 0.95, 5.0, meant.edf[0, 0])
    assert compare_allan(spectrum, lower).chance[0, 0] == pytest.approx(chance, rel=1e-6)


def test_a_wrong_interval_disagrees() -> None:
    rng, m = np.random.default_rng(7), 2 ** np.arange(10, dtype=np.int64)
    x = rng.normal(size=N)
    curve = measured(x, m)
    wrong = curve_of(curve.tau, 1.1 * curve.deviation, curve.edf)
    found = compare_allan(psd(x, INTERVAL), wrong)
    assert not found.agree.any()
    assert found.remarks[0].code == "allan_spectrum_disagree"
    with pytest.raises(PlanError, match="false_alarm 1"):
        compare_allan(psd(x, INTERVAL), curve, 1.0)
    with pytest.raises(DataError, match="different axes"):
        compare_allan(psd(np.stack((x, x), axis=1), INTERVAL), curve)
    long = measured(x, np.array([4_096]))
    assert compare_allan(psd(x, INTERVAL), long).remarks[0].code == "allan_not_compared"
