"""Each thing that breaks a run has its remark; runs without it have none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from vibration_runs import PLAN, QUICK, SHORT, codes, lines_verdict, readings_of, reduced

from independent.vibration.random_run import Array, G, Run, noise, simulate
from inertialcal.core.errors import DataError, PlanError
from inertialcal.procedures.vibration.plan import Plan
from inertialcal.procedures.vibration.procedure import PROCEDURE
from inertialcal.procedures.vibration.reduction import Result, reduce

NOTHING = {"edges", "level_steps"}  # said of every run
BASE = replace(QUICK, error=0.3)
SEEDS = 20


def of(control: Array, run: Run = BASE, plan: Plan = PLAN, responses: Array | None = None) -> Result:
    return reduce(plan, readings_of(run, 1, control=control, responses=responses))


def control(run: Run = BASE, seed: int = 1) -> Array:
    return simulate(run, seed)[0]


def resonance(x: Array, frequency: float, q: float, rate: float = QUICK.rate) -> Array:
    """Return the response of a resonance to its base, by its transfer function at each line of the record."""
    f = np.fft.rfftfreq(len(x), 1.0 / rate)
    r = f / frequency
    gain = (1.0 + 1j * r / q) / (1.0 - r * r + 1j * r / q)
    return np.fft.irfft(np.fft.rfft(x) * gain, len(x))


def test_clean_runs_have_no_remark() -> None:
    found = {seed: codes(reduced(replace(BASE, channels=2, coherence=0.9, steps=((-6.0, 4.0),)), seed)) - NOTHING
             for seed in range(1, SEEDS + 1)}  # fmt: skip
    assert not {seed: names for seed, names in found.items() if names}


def clipped() -> Result:
    x = control(replace(BASE, clip=2.8))
    rng = np.random.default_rng(9)
    return of(x + 0.01 * x.std() * rng.standard_normal(x.shape))  # the noise of the amplifier: no two peaks are equal


def saturated() -> Result:
    x = control()
    limit = 2.0 * x.std()
    return of(np.clip(x, -limit, limit))


def tone() -> Result:
    return of(control(replace(BASE, tones=((150.0, 1.0),))))


def low() -> Result:
    return of(control(replace(BASE, level=-3.0)))


def short() -> Result:
    return of(control(), plan=replace(PLAN, duration=30.0))


def interrupted() -> Result:
    x = control()
    x[9_000:13_000] *= 0.3
    return of(x)


def above() -> Result:
    x = control()
    x[9_000:10_500] *= 1.6
    return of(x)


def drifting() -> Result:
    x = control()
    return of(x * 10.0 ** (np.linspace(-0.5, 0.5, len(x))[:, None] / 20.0))


def rattling() -> Result:
    x = control()
    rng = np.random.default_rng(5)
    for at in rng.integers(0, len(x) - 20, 12):
        x[at : at + 8, 0] += 7.0 * x.std() * rng.normal() * np.hanning(8)
    return of(x)


def swapped() -> Result:
    x = control()[:, 0]
    return of(resonance(x, 150.0, 20.0)[:, None], responses=x[:, None])


def loose() -> Result:
    x = control(replace(BASE, channels=2, coherence=0.95))
    x[:, 1] = resonance(x[:, 1], 260.0, 15.0)
    return of(x)


def folded() -> Result:
    x = control()
    rng = np.random.default_rng(3)
    return of(x + np.sqrt(0.01 * G * G * 640.0) * rng.standard_normal(x.shape))


def low_passed() -> Result:
    sos = signal.butter(4, 400.0, fs=QUICK.rate, output="sos")
    return of(signal.sosfilt(sos, control(), axis=0))


def slow() -> Result:
    nodes = ((20.0, 0.01), (80.0, 0.04), (200.0, 0.04), (620.0, 0.01))
    return reduced(replace(BASE, nodes=nodes), 1)


def narrow() -> Result:
    run = replace(BASE, duration=60.0)
    x = control(run)[:, 0]
    return of(x[:, None], run, responses=resonance(x, 120.0, 120.0)[:, None])


def gaps() -> Result:
    x = control()
    x[6_000:6_400] = np.nan
    return of(x)


FAULTS: dict[str, tuple[Callable[[], Result], set[str]]] = {
    "clipped_drive": (clipped, set()),
    "saturated": (saturated, {"level", "kurtosis"}),
    "lines": (tone, set()),
    "level": (low, set()),
    "short_run": (short, set()),
    "interrupted": (interrupted, set()),
    "above_level": (above, {"interrupted"}),
    "not_stationary": (drifting, set()),
    "kurtosis": (rattling, {"above_level", "interrupted", "not_stationary"}),
    "swapped_channels": (swapped, {"narrow_peaks", "low_pass", "not_stationary"}),
    "control_disagrees": (loose, {"level", "narrow_peaks", "low_pass", "band_off"}),
    "aliasing": (folded, {"level"}),
    "low_pass": (low_passed, set()),
    "sample_rate": (slow, set()),
    "narrow_peaks": (narrow, set()),
    "gaps": (gaps, set()),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named(name: str) -> None:
    make, also = FAULTS[name]
    found = codes(make())
    assert name in found
    assert found - NOTHING - also == {name}


def test_a_level_that_is_off_by_gravity_is_a_unit() -> None:
    for factor, word in ((G, "above"), (1.0 / G, "below")):
        (found,) = (one for one in of(factor * control()).remarks if one.code == "level")
        assert word in found.what
        assert found.do == "Check the unit of the control channels"


def test_an_error_that_a_check_finds_is_told_once() -> None:
    x = control()[:, 0]
    readings = readings_of(BASE, 1, control=resonance(x, 150.0, 20.0)[:, None], responses=x[:, None])
    checked = PROCEDURE.agreement(PLAN, readings)
    assert [one.code for one in checked] == ["swapped_channels"]
    found = [one for one in reduce(PLAN, replace(readings, remarks=tuple(checked))).remarks if one.severity == "error"]
    assert [(one.code, one.count) for one in found] == [("swapped_channels", 1)]


def test_an_error_leaves_the_verdict_open_and_a_narrow_peak_is_said_in_decibels() -> None:
    assert {one.code for one in swapped().errors} == {"swapped_channels"}
    assert {one.code for one in saturated().errors} == {"saturated"}
    remark = next(one for one in narrow().remarks if one.code == "narrow_peaks")
    assert "120 Hz" in remark.what
    assert "1.25 Hz" in remark.do


def test_a_sine_is_no_random_vibration_and_nothing_else_is_said_of_it() -> None:
    t = np.arange(25_600) / BASE.rate
    rng = np.random.default_rng(1)
    x = 60.0 * np.sin(2.0 * np.pi * 100.0 * t) + 5.0 * np.sin(2.0 * np.pi * 200.0 * t) + rng.standard_normal(len(t))
    result = of(x[:, None])
    assert [one.code for one in result.errors] == ["not_random"]
    assert "100 Hz" in result.errors[0].what
    assert codes(result) == {"not_random"}
    loud = replace(BASE, tones=((150.0, 2.0),))  # a tone that is less than the noise
    assert "not_random" not in codes(of(control(loud)))


@pytest.mark.parametrize("times", [0.5, 2.0])
def test_a_wrong_sample_rate_is_an_error_with_the_factor(times: float) -> None:
    readings = readings_of(BASE, 1)
    found = reduce(PLAN, replace(readings, interval=readings.interval * times)).errors
    assert found[0].code == "wrong_rate"
    factor = float(found[0].what.partition("profile at ")[2].partition(" times")[0])
    assert factor == pytest.approx(times, rel=0.06)
    assert "wrong_rate" not in codes(low_passed())


def test_a_dead_control_channel_is_refused_and_a_dead_response_left_out() -> None:
    x = control(replace(BASE, channels=2, coherence=0.95))
    for dead in (0.0, 0.012, 0.002 * np.random.default_rng(1).standard_normal(len(x))):
        x[:, 1] = dead
        with pytest.raises(DataError, match="control_2") as refused:
            of(x)
        assert refused.value.problems[0].code == "dead_channel"
    both = np.column_stack([np.full(len(x), 0.5), x[:, 0]])
    result = of(x[:, :1], responses=both)
    assert [one.name for one in result.channels] == ["control_1", "y"]
    assert codes(result) - NOTHING == {"dead_channel"}


def test_a_run_of_another_profile_is_one_remark() -> None:
    wild = ((20.0, 0.001), (40.0, 0.04), (60.0, 0.002), (80.0, 0.04), (110.0, 0.005), (140.0, 0.05), (170.0, 0.003),
            (200.0, 0.04), (260.0, 0.003), (320.0, 0.04), (400.0, 0.004), (500.0, 0.01))  # fmt: skip
    found = [one for one in of(control(replace(BASE, nodes=wild))).remarks if one.code.startswith(("band", "notch"))]
    assert [one.code for one in found] == ["band_off"]
    assert found[0].count > 4


def test_levels_and_duration_of_a_run_with_steps() -> None:
    run = replace(BASE, steps=((-6.0, 5.0), (-3.0, 5.0)))
    result = reduced(run, 2)
    assert [round(one.level) for one in result.levels.stretches] == [-6, -3, 0]
    assert result.levels.duration == pytest.approx(20.0, abs=3.0 * result.levels.u_duration)
    assert lines_verdict(result, "3 dB").verdict == "PASS"
    assert result.control.rms / G == pytest.approx(reduced(replace(run, steps=()), 2).control.rms / G, rel=0.05)


def test_missing_samples_do_not_break_the_time_at_full_level() -> None:
    """A few samples, and more than a window: neither leaves full level."""
    x = simulate(BASE, 1)[0].copy()
    for start, count in ((3000, 1), (9000, 5), (15_000, 400)):
        x[start : start + count] = np.nan
    levels = reduce(PLAN, readings_of(BASE, 1, control=x)).levels
    assert not levels.left
    assert levels.duration == pytest.approx(BASE.duration, abs=levels.window)


def test_low_level_run_judged_at_its_level() -> None:
    result = reduced(replace(BASE, level=-6.0), 3, replace(PLAN, level=-6.0))
    assert codes(result) <= NOTHING
    assert lines_verdict(result, "3 dB").verdict == "PASS"


def test_what_carries_no_answer_is_refused() -> None:
    with pytest.raises(DataError) as short_record:
        reduced(replace(BASE, duration=0.5), 1)
    assert short_record.value.problems[0].code == "too_short"
    with pytest.raises(DataError) as still:
        of(np.zeros((25_600, 1)))
    assert still.value.problems[0].code == "no_vibration"
    with pytest.raises(PlanError):
        reduced(BASE, 1, replace(PLAN, resolution=100.0))
    with pytest.raises(PlanError):
        reduced(BASE, 1, replace(PLAN, resolution=130.0))
    with pytest.raises(DataError) as slow_record:
        reduced(replace(BASE, rate=32.0, nodes=((20.0, 0.01), (500.0, 0.01))), 1)
    assert slow_record.value.problems[0].code == "beyond_nyquist"


def test_degrees_of_freedom_of_a_mean_follow_the_coherence() -> None:
    """Two channels of one noise count once, two of their own noise twice."""
    alike = reduced(replace(BASE, error=0.0, channels=2, coherence=1.0), 1)
    apart = reduced(replace(BASE, error=0.0, channels=2, coherence=0.0), 1)
    one = alike.spectra.edf
    assert np.median(alike.deviation.edf) == pytest.approx(one, rel=0.01)
    assert np.median(apart.deviation.edf) == pytest.approx(2.0 * one, rel=0.03)


def test_the_spectrum_is_that_of_noise_of_known_density() -> None:
    rng = np.random.default_rng(11)
    flat = np.full(12_801, 0.02)
    x = noise(flat, QUICK.rate, 25_600, rng) * G
    run = replace(QUICK, nodes=((20.0, 0.02), (500.0, 0.02)))
    result = of(x[:, None], run)
    assert np.mean(result.deviation.density) / G**2 == pytest.approx(0.02, rel=0.02)
    assert SHORT[0][0] == result.band[0]
