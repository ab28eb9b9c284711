"""Modes found again: frequency, Q and transmissibility of items moved in time by exact steps, in any noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from independent.shaking import masses
from independent.shaking.shaker import FINE, Mode, Run, recorded, transmissibility
from inertialcal.procedures.sine_survey.modal import Modes, find_modes, spectra
from inertialcal.procedures.sine_survey.readings import Shaken
from inertialcal.procedures.sine_survey.sweep import find_sweeps
from inertialcal.procedures.sine_survey.swept import sweeps_of
from inertialcal.statistics.intervals import coverage_factor, covers
from sized import sized

RATE = 2500.0
FAST = Run(50.0, 500.0, 20.0, sample_rate=RATE, quiet=0.5)
LEAST = 0.05


def modes_of(control: np.ndarray, response: np.ndarray, rate: float = RATE, open_end: bool = False) -> Modes:
    """Return the modes by the only sweep of a record."""
    (sweep,) = find_sweeps(control, rate)
    return find_modes([spectra(control, response, rate, sweep.lowest, sweep.highest, open_end=open_end)], least=LEAST)


def case(kind: str, seed: int) -> tuple[tuple[Mode, ...], Modes]:
    """Return the modes of an item, and those that are found."""
    rng = np.random.default_rng(seed)
    item: tuple[Mode, ...] = (
        Mode(float(rng.uniform(90.0, 130.0)), float(rng.uniform(8.0, 50.0)), 1.2),
        Mode(float(rng.uniform(250.0, 300.0)), float(rng.uniform(10.0, 60.0)), -0.4),
    )
    run, noise, colour = FAST, (0.002, 0.002), 0.0
    if kind == "close":  # one width apart
        item = (Mode(100.0, 30.0, 0.8), Mode(100.0 * (1.0 + 1.0 / 30.0), 30.0, 0.5))
    elif kind == "distorted":
        run = Run(50.0, 500.0, 20.0, sample_rate=RATE, quiet=0.5, harmonics=(0.1, 0.05), ripple=0.2)
    elif kind == "coloured":
        colour = 0.9
    elif kind == "noisy":
        noise = (0.01, 0.01)
    elif kind == "cut":
        run = Run(50.0, 500.0, 20.0, sample_rate=RATE, quiet=0.0, ramp=0.0)
    control, response = recorded(item, run, rng, noise, colour)
    if kind == "chatter":  # noise that follows the level
        level = np.sqrt(np.convolve(response**2, np.ones(100) / 100.0, "same"))
        response = response + 0.01 * level * rng.standard_normal(len(response))
    return item, modes_of(control, response, open_end=kind == "cut")


@pytest.mark.parametrize(
    "kind",
    [
        "white",
        "chatter",
        *(pytest.param(k, marks=pytest.mark.slow) for k in ("close", "distorted", "coloured", "noisy", "cut")),
    ],
)
def test_intervals_hold_the_truth(kind: str) -> None:
    seeds, hits, cases = sized(300, 16), np.zeros(3, dtype=int), 0
    for seed in range(1, seeds + 1):
        item, found = case(kind, seed)
        assert len(found) == len(item)
        own = np.array([one.frequency for one in item])
        # a straight line between fine samples drives each mode by its sinc squared
        peak = np.abs(transmissibility(item, own)) * np.sinc(own / (FINE * RATE)) ** 2
        truth = np.column_stack([own, [one.q for one in item], peak])
        values = np.column_stack([found.frequency, found.amplification, found.peak])
        factors = np.array([coverage_factor(float(dof)) for dof in found.dof])
        reach = factors * np.sqrt(np.diag(found.covariance))
        inside = np.abs(values - truth) <= reach.reshape(-1, 3)
        hits += inside.sum(axis=0)
        cases += len(item)
    for k in range(3):
        assert covers(int(hits[k]), cases, 0.93), (kind, k, hits[k] / cases)


@pytest.mark.parametrize("colour", ["white", pytest.param("pink", marks=pytest.mark.slow)])
def test_intervals_hold_the_truth_of_masses_on_springs(colour: str) -> None:
    """Three modes in state space, two of them close, Q of 10 to 100; the controller ripples by 5 %."""
    seeds, hits, cases = sized(300, 8), np.zeros(3, dtype=int), 0
    for seed in range(1, seeds + 1):
        rng = np.random.default_rng(seed)
        first = float(rng.uniform(90.0, 140.0))
        item = masses.oscillators(
            [first, first * float(rng.uniform(0.97, 1.03)), float(rng.uniform(260.0, 360.0))],
            [float(rng.uniform(15.0, 60.0)), float(rng.uniform(30.0, 100.0)), float(rng.uniform(10.0, 100.0))],
            [1.0, float(rng.uniform(0.003, 0.02)), float(rng.uniform(0.05, 0.2))],
        )
        table = masses.swept(50.0, 500.0, 20.0, RATE, rng)
        response = masses.read(item, table, RATE)
        control, answer = (masses.sampled(one, 0.002, rng, colour) for one in (table, response))
        found = modes_of(control, answer)
        truth = item.modes()
        assert len(found) == len(truth)
        truth[:, 2] *= np.sinc(truth[:, 0] / (masses.FINE * RATE))  # the input is held
        values = np.column_stack([found.frequency, found.amplification, found.peak])
        factors = np.array([coverage_factor(float(dof)) for dof in found.dof])
        reach = factors * np.sqrt(np.diag(found.covariance))
        hits += (np.abs(values - truth) <= reach.reshape(-1, 3)).sum(axis=0)
        cases += len(truth)
    for k in range(3):
        assert covers(int(hits[k]), cases, 0.93), (colour, k, hits[k] / cases)


def test_a_tracking_filter_is_biased_where_the_fit_is_not() -> None:
    item = (Mode(100.0, 50.0, 1.0),)
    control, response = recorded(item, FAST, np.random.default_rng(1), (1e-4, 1e-4))
    found = modes_of(control, response)
    assert found.amplification[0] == pytest.approx(50.0, rel=1e-3)
    assert found.frequency[0] == pytest.approx(100.0, rel=1e-4)
    (sweep,) = find_sweeps(control, RATE)
    middle, half = sweep.when(100.0), 6.0 / 100.0
    a, b = round((middle - half) * RATE), round((middle + half) * RATE)
    turned = np.hanning(b - a) * np.exp(-1j * sweep.phase(np.arange(a, b) / RATE))
    tracked = abs(np.sum(response[a:b] * turned) / np.sum(control[a:b] * turned))
    assert tracked < 0.8 * abs(transmissibility(item, np.array([100.0]))[0])


def test_the_model_is_the_closed_form_of_two_modes() -> None:
    item = (Mode(120.0, 20.0, 0.9), Mode(310.0, 35.0, 0.4))
    control, response = recorded(item, FAST, np.random.default_rng(2), (1e-5, 1e-5))
    f = np.linspace(60.0, 450.0, 200)
    found = modes_of(control, response).transmissibility(f)
    expected = transmissibility(item, f) * np.sinc(f / (FINE * RATE)) ** 2
    assert np.max(np.abs(found - expected) / np.maximum(np.abs(expected), 0.1)) < 2e-3


def test_an_item_without_a_mode_has_none() -> None:
    control, response = recorded((), FAST, np.random.default_rng(3))
    assert len(modes_of(control, response)) == 0


@pytest.mark.parametrize(
    ("start", "stop", "linear", "rate"),
    [(50.0, 500.0, False, 20.0), (500.0, 50.0, False, 20.0), (50.0, 450.0, True, 2400.0)],
)
def test_the_sweep_is_found(start: float, stop: float, linear: bool, rate: float) -> None:
    run = Run(start, stop, rate, linear=linear, sample_rate=RATE, quiet=0.5, ramp=0.0)
    control, _ = recorded((), run, np.random.default_rng(4))
    (found,) = find_sweeps(control, RATE)
    assert found.law == ("linear" if linear else "log")
    assert found.up == (stop > start)
    assert abs(found.rate) * 60.0 == pytest.approx(rate, rel=1e-4)
    assert found.start == pytest.approx(start, rel=0.01)
    assert found.stop == pytest.approx(stop, rel=0.01)
    assert found.duration == pytest.approx(run.duration, abs=0.05)
    assert np.median(found.amplitude) == pytest.approx(run.level, rel=0.01)


@pytest.mark.parametrize("seeds", [pytest.param(sized(300, 40))])
def test_the_rate_of_a_sweep_is_covered(seeds: int) -> None:
    hits = 0
    for seed in range(1, seeds + 1):
        control, _ = recorded((), Run(100.0, 400.0, 40.0, sample_rate=2000.0, quiet=0.3), np.random.default_rng(seed))
        (found,) = find_sweeps(control, 2000.0)
        hits += abs(found.rate * 60.0 - 40.0) <= coverage_factor(found.dof) * found.u_rate * 60.0
    assert covers(hits, seeds, 0.93)


def test_the_time_of_a_sweep_is_its_closed_form() -> None:
    assert math.log2(1000.0 / 20.0) / 4.0 * 60.0 == pytest.approx(84.658, abs=5e-4)
    assert Run().duration == pytest.approx(84.658, abs=5e-4)


def test_sweeps_of_one_direction_have_names_of_their_own() -> None:
    control, response = recorded((Mode(120.0, 20.0),), FAST, np.random.default_rng(3), (1e-4, 1e-4))
    both, other = np.tile(control, 2), np.tile(response, 2)
    shaken = Shaken("s", "s.csv", RATE, {"control": both}, {"x": other}, "m/s^2")
    assert [one.label for one in sweeps_of(shaken)] == ["s, up 1", "s, up 2"]
