"""A survey planned: duration by its closed form, eta as published, uncertainties as simulated fits scatter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import inertialcal as ic
from independent.shaking.masses import oscillators, read, sampled, swept
from inertialcal.procedures.sine_survey.modal import find_modes, spectra
from inertialcal.procedures.sine_survey.sweep import find_sweeps
from sized import sized
from typed_commands import call, call_json

RATE, NOISE, G = 2000.0, 0.003, 9.80665


def test_the_sweep_of_the_field_lasts_as_long_as_its_closed_form(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = call(capsys, "plan", "vibration", "survey", "--rate", "4 oct/min")
    assert (status, err) == (0, "")
    assert "84.658" in out
    (linear,) = ic.plan_vibration_survey(sweep="20 Hz to 1000 Hz", rate="10 Hz/s").forecasts
    assert linear.duration == pytest.approx(98.0)
    assert ic.plan_vibration_survey(sweep="1000 Hz to 20 Hz", rate="1 dec/min").forecasts[0].duration == pytest.approx(
        60.0 * math.log10(50.0)
    )


@pytest.mark.parametrize(("q", "eta"), [(30.0, 0.52), (50.0, 1.44), (100.0, 5.8)])
def test_eta_at_80_hz_and_4_octaves_a_minute(q: float, eta: float) -> None:
    (found,) = ic.plan_vibration_survey(frequency="80 Hz", amplification=q, rate="4 oct/min").forecasts
    assert found.eta == pytest.approx(eta, rel=0.01)
    assert found.eta == pytest.approx(4.0 * math.log(2.0) * q**2 / (60.0 * 80.0))


def test_uncertainties_are_what_fits_of_simulated_records_scatter_by() -> None:
    """The same table, modes in state space, and noise: how frequency and Q of the fit scatter."""
    seeds = sized(200, 10)
    item = oscillators([120.0], [25.0], [1.0])
    table = swept(50.0, 450.0, 30.0, RATE, np.random.default_rng(1), ripple=0.0, harmonic=0.0)
    response, found = read(item, table, RATE), []
    for seed in range(1, seeds + 1):
        rng = np.random.default_rng([seed, 7])
        control, answer = (sampled(one, NOISE, rng) for one in (table, response))
        (sweep,) = find_sweeps(control, RATE)
        modes = find_modes([spectra(control, answer, RATE, sweep.lowest, sweep.highest, open_end=False)], 1, 0.1)
        found.append([modes.frequency[0], modes.amplification[0], modes.peak[0]])
    density = f"{NOISE * math.sqrt(2.0 / RATE) * G} m/s2/sqrt(Hz)"
    (plan,) = ic.plan_vibration_survey(
        sweep="50 Hz to 450 Hz", rate="30 oct/min", level="0.25 g", frequency="120 Hz", amplification=25.0,
        noise=density, control_noise=density,
    ).forecasts  # fmt: skip
    planned = np.array([plan.u_frequency, plan.u_amplification, plan.u_peak])
    ratio = np.std(found, axis=0, ddof=1) / planned
    low, high = np.sqrt(stats.chi2.ppf([0.0005, 0.9995], seeds - 1) / (seeds - 1))
    assert np.all(ratio > low), ratio
    assert np.all(ratio < 1.1 * high), ratio  # the least that a fit can reach


def test_a_slower_sweep_knows_more() -> None:
    slow, fast = ic.plan_vibration_survey().forecasts[0], ic.plan_vibration_survey().forecasts[-1]
    assert slow.rate < fast.rate
    assert slow.u_amplification == pytest.approx(fast.u_amplification / math.sqrt(8.0), rel=0.01)


def test_rows_are_those_of_results(capsys: pytest.CaptureFixture[str]) -> None:
    found = call_json(capsys, "plan", "vibration", "survey", "--frequency", "80 Hz")
    assert (found["command"], found["exit"]) == ("plan vibration survey", 0)
    durations = [row["value"] for row in found["results"] if row["quantity"] == "sweep_duration"]
    assert durations == pytest.approx([338.631, 169.316, 84.658, 42.329], abs=1e-3)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--frequency", "8 Hz"), "--frequency 8 Hz is not inside the sweep"),
        (("--sweep", "20 to 1000"), "Write: 20 Hz to 1000 Hz"),
        (("--rate", "fast"), "Write: 4 oct/min"),
        (("--level", "0.25"), "--level"),
    ],
)
def test_what_cannot_be_meant_is_one_clear_message(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], told: str
) -> None:
    status, _, err = call(capsys, "plan", "vibration", "survey", *words)
    assert status == 2
    assert told in err


def test_an_unknown_setting_of_python_is_named() -> None:
    with pytest.raises(ic.UsageError, match="no setting 'speed'"):
        ic.plan_vibration_survey(speed="4 oct/min")
