"""Samples that are lost during a sweep: named with how many and when; a shaker's own phase is not."""

from __future__ import annotations

import numpy as np
import pytest

from independent.shaking.masses import FINE, sampled, swept
from inertialcal.procedures.sine_survey.doubts import doubts
from inertialcal.procedures.sine_survey.lost import lost_samples
from inertialcal.procedures.sine_survey.plan import Plan
from inertialcal.procedures.sine_survey.readings import Shaken
from inertialcal.procedures.sine_survey.sweep import Sweep, find_sweeps
from inertialcal.procedures.sine_survey.swept import sweeps_of

RATE = 2500.0
BAND = (20.0, 1000.0, 16.0)


def found_in(control: np.ndarray) -> Sweep:
    """Return the only sweep."""
    (sweep,) = find_sweeps(control, RATE)
    return sweep


def clean(seed: int = 1, band: tuple[float, float, float] = BAND) -> np.ndarray:
    """A control channel."""
    rng = np.random.default_rng(seed)
    return sampled(swept(*band, RATE, rng), 0.002, rng)


@pytest.mark.parametrize("cycles", [0.98, 1.0, 2.0])
def test_a_loss_of_whole_cycles_is_named_with_its_count_and_time(cycles: float) -> None:
    control = clean()
    at = len(control) // 2
    frequency = float(found_in(control).frequency(np.array([at / RATE]))[0])
    lost = round(cycles * RATE / frequency)
    damaged = np.delete(control, np.arange(at, at + lost))
    sweep = found_in(damaged)
    assert np.abs(np.diff(sweep.left)).max() < 0.1  # no step of the phase shows it
    loss = lost_samples(sweep, RATE)
    assert loss is not None
    assert loss.samples == pytest.approx(lost, rel=0.05)
    assert loss.time == pytest.approx(at / RATE, abs=0.1)
    (one,) = sweeps_of(Shaken("s", "s.csv", RATE, {"control": damaged}, {}, "m/s^2"))
    assert [remark.code for remark in doubts(Plan(), one)] == ["lost_samples"]


@pytest.mark.parametrize("count", [2, 3, 40, -2])
@pytest.mark.parametrize("band", [BAND, (1000.0, 20.0, 16.0)])
def test_any_loss_is_named(count: int, band: tuple[float, float, float]) -> None:
    control, at = clean(2, band), 9000
    damaged = (
        np.delete(control, np.arange(at, at + count)) if count > 0 else np.insert(control, at, control[at + count : at])
    )
    (one,) = sweeps_of(Shaken("s", "s.csv", RATE, {"control": damaged}, {}, "m/s^2"))
    assert "lost_samples" in {remark.code for remark in doubts(Plan(), one)}


@pytest.mark.parametrize("q", [2.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("own", [80.0, 300.0])
def test_a_resonance_of_the_shaker_that_turns_the_phase_is_no_loss(own: float, q: float) -> None:
    rng = np.random.default_rng(1)
    table = swept(*BAND, RATE, rng)
    f = np.fft.rfftfreq(len(table), 1.0 / (FINE * RATE))
    turn = np.exp(-1j * np.angle(own**2 - f**2 + 1j * f * own / q))
    turned = np.fft.irfft(np.fft.rfft(table) * turn, len(table))
    assert lost_samples(found_in(sampled(turned, 0.002, rng)), RATE) is None


def test_a_sweep_without_a_loss_has_none() -> None:
    assert lost_samples(found_in(clean(3)), RATE) is None
