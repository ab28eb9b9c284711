"""Verdicts on simulated runs: chance fails no good run, passes no bad one; intervals hold the truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vibration_runs import PLAN, QUICK, SHORT, lines_verdict, overall_verdict, readings_of, reduced, with_scale

import inertialcal as ic
from independent.coverage import binomial
from independent.vibration.random_run import G, Run, density, simulate
from inertialcal.procedures.vibration.reduction import reduce

TOLERANCE, OVERALL = "3 dB", 0.10
FAST, SLOW = 30, 300


def risk_holds(hits: int, n: int, risk: float) -> bool:
    """Tell whether the exact 99.9 % interval of a rate holds a risk, or lies below it."""
    return binomial(hits, n)[0] <= risk


def truth_of(run: Run, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the true density [g^2/Hz] over frequency, with the controller's error."""
    _, frequency, true = simulate(run, seed)
    return frequency, true


def count_verdicts(run: Run, n: int) -> dict[str, int]:
    found = {"PASS": 0, "FAIL": 0, "INCONCLUSIVE": 0}
    for seed in range(1, n + 1):
        result = reduced(run, seed)
        both = {lines_verdict(result, TOLERANCE).verdict, overall_verdict(result, OVERALL)}
        found["FAIL" if "FAIL" in both else "PASS" if both == {"PASS"} else "INCONCLUSIVE"] += 1
    return found


@pytest.mark.parametrize("n", [FAST, pytest.param(SLOW, marks=pytest.mark.slow)])
def test_a_good_run_passes_and_one_2_db_high_does_not(n: int) -> None:
    good = count_verdicts(replace(QUICK, error=0.4, channels=2, coherence=0.9), n)
    assert risk_holds(good["FAIL"], n, 0.05)
    assert good["PASS"] >= 0.9 * n  # so planned: see test_vibration_plan
    high = count_verdicts(replace(QUICK, error=0.4, level=2.0, channels=2, coherence=0.9), n)
    assert risk_holds(high["PASS"], n, 0.025)
    assert high["FAIL"] >= 0.9 * n


@pytest.mark.parametrize("n", [FAST, pytest.param(SLOW, marks=pytest.mark.slow)])
def test_a_run_at_its_limit_passes_or_fails_within_the_risk(n: int) -> None:
    """Every line on the limit: the hardest for FAIL (chance has all attempts), one line alone for PASS."""
    on = replace(QUICK, error=0.0, level=3.0)
    failed = sum(lines_verdict(reduced(on, seed), TOLERANCE).verdict == "FAIL" for seed in range(1, n + 1))
    assert risk_holds(failed, n, 0.05)
    nodes = ((20.0, 0.02), (499.0, 0.02), (500.0, 0.02))
    flat = Run(nodes=nodes, rate=1280.0, duration=20.0, error=0.0)
    passed = 0
    for seed in range(1, n + 1):
        control, _, _ = simulate(flat, seed)
        spectrum = np.fft.rfft(control, axis=0)
        f = np.fft.rfftfreq(len(control), 1.0 / flat.rate)
        spectrum[(f > 190.0) & (f < 210.0)] *= 10.0 ** (3.0 / 20.0)  # 3 dB over four lines, and nowhere else
        high = np.fft.irfft(spectrum, len(control), axis=0)
        passed += lines_verdict(reduce(PLAN, readings_of(flat, seed, control=high)), TOLERANCE).verdict == "PASS"
    assert risk_holds(passed, n, 0.025)


@pytest.mark.parametrize("n", [FAST, pytest.param(SLOW, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("channels", "u"), [(1, 0.0), (3, 0.02)])
def test_intervals_of_lines_and_level_hold_the_truth(n: int, channels: int, u: float) -> None:
    """Noise of a known density, a scale factor drawn from its uncertainty: per line, all lines, overall."""
    plan = with_scale(PLAN, u) if u else PLAN
    run = replace(QUICK, error=0.0, channels=channels, coherence=0.7, floor=0.0)
    target = np.sqrt(np.trapezoid(density(SHORT, np.linspace(20.0, 500.0, 480_001)), dx=0.001)) * G
    per_line, together, overall, lines = 0, 0, 0, 0
    for seed in range(1, n + 1):
        scale = 1.0 + u * np.random.default_rng([seed, 7]).standard_normal()
        result = reduced(run, seed, plan, scale=float(scale))
        low, high = result.deviation.interval(0.95)
        per_line += int(np.count_nonzero((low <= 0.0) & (high >= 0.0)))
        lines += len(low)
        low, high = result.deviation.interval(result.deviation.together(0.95))
        together += bool(np.all((low <= 0.0) & (high >= 0.0)))
        ends = result.control.interval(0.95)
        assert ends.lo is not None
        assert ends.hi is not None
        overall += bool(ends.lo <= target <= ends.hi)
    assert binomial(overall, n)[0] <= 0.95 <= binomial(overall, n)[1]
    assert binomial(together, n)[1] >= 0.95
    own = binomial(per_line, lines)
    spread = 0.02 if u else 0.0  # of the rate over lines that share a scale factor: they miss together
    assert own[0] - spread <= 0.95 <= own[1] + spread + 0.01


def test_where_chooses_lines() -> None:
    """A run that is wrong at low frequencies alone passes above them."""
    control, _, _ = simulate(replace(QUICK, error=0.0), 1)
    spectrum = np.fft.rfft(control, axis=0)
    f = np.fft.rfftfreq(len(control), 1.0 / QUICK.rate)
    spectrum[f < 60.0] *= 10.0 ** (6.0 / 20.0)
    result = reduce(PLAN, readings_of(QUICK, 1, control=np.fft.irfft(spectrum, len(control), axis=0)))
    assert lines_verdict(result, TOLERANCE).verdict == "FAIL"
    assert lines_verdict(result, TOLERANCE, "frequency >= 80 Hz").verdict == "PASS"
    assert lines_verdict(result, TOLERANCE, "frequency >= 900 Hz").verdict == "INCONCLUSIVE"


def test_maximum_and_bands_of_an_octave() -> None:
    """A maximum lies above the mean of its channels; bands have more degrees of freedom than lines."""
    run = replace(QUICK, error=0.0, channels=3, coherence=0.5)
    mean = reduced(run, 1)
    most = reduced(run, 1, replace(PLAN, average="maximum"))
    assert np.all(most.deviation.density >= mean.deviation.density * (1.0 - 1e-12))
    low, high = most.deviation.interval(most.deviation.together(0.95))
    assert np.mean((low <= 0.0) & (high >= 0.0)) > 0.95
    bands = reduced(run, 1, replace(PLAN, octave=6))
    assert len(bands.deviation) < 0.3 * len(mean.deviation)
    assert np.median(bands.deviation.edf) > 2.0 * np.median(mean.deviation.edf)
    assert np.max(np.abs(bands.deviation.value)) < np.max(np.abs(mean.deviation.value))


@pytest.mark.parametrize("control", [None, "Control (g)", "Control"])
def test_the_control_is_found_by_its_name(tmp_path: Path, control: str | None) -> None:
    """The column that is called so, not the response, though that has the name of an axis."""
    rows = np.column_stack([np.arange(20_000) / 1000.0, np.random.default_rng(1).standard_normal((20_000, 2))])
    rows[:, 2] *= 2.0
    run, profile = tmp_path / "run.csv", tmp_path / "profile.csv"
    np.savetxt(run, rows, fmt="%.5f", delimiter=",", header="Time (s),Control (g),Acc_X (g)", comments="")
    profile.write_text("frequency [Hz],density [g2/Hz]\n20,0.002\n300,0.002\n")
    found = ic.vibration(run, profile=str(profile), control=[] if control is None else [control])
    levels = {row.axis: row.value for row in found.rows if row.quantity == "acceleration_rms"}
    assert levels["x"] == pytest.approx(2.0 * (levels["control"] or 0.0), rel=0.05)
