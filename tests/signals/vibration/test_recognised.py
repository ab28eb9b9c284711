"""Runs and sweeps are known for what they are by simulators of their own; what rests, turns or drives is neither."""

from __future__ import annotations

import numpy as np
import pytest

from independent.shaking.quadratic import G, Shaken, record
from independent.shaking.shaker import Mode, recorded
from independent.shaking.shaker import Run as Sweep
from independent.vibration.random_run import Run, simulate
from inertialcal.core.estimate import Array
from inertialcal.signals.sense.changes import changes
from inertialcal.signals.vibration.recognised import recognised

SEEDS = range(1, 6)


@pytest.mark.parametrize(
    "run",
    [
        Run(duration=8.0),
        Run(duration=8.0, steps=((-12.0, 2.0), (-6.0, 2.0))),
        Run(duration=8.0, level=-12.0),
        Run(duration=8.0, nodes=((15.0, 0.01), (190.0, 0.01)), rate=1000.0),
        Run(duration=8.0, clip=3.0),
    ],
    ids=["full", "steps", "low", "narrow", "three sigma"],
)
def test_a_random_run_is_random(run: Run) -> None:
    assert {recognised(simulate(run, seed)[0][:, 0], 1.0 / run.rate) for seed in SEEDS} == {"random"}


def test_a_run_between_rests_is_random() -> None:
    for seed in SEEDS:
        control = record(seed, Shaken(seconds=8.0)).columns["control [g]"] * G
        assert recognised(control, 1.0 / 400.0) == "random"


@pytest.mark.parametrize("sweep", [Sweep(), Sweep(linear=True, per_minute=3000.0), Sweep(start=1000.0, stop=20.0)])
def test_a_swept_sine_is_swept(sweep: Sweep) -> None:
    for seed in (1, 2):
        table, _ = recorded((Mode(300.0, 20.0),), sweep, np.random.default_rng(seed))
        assert recognised(np.asarray(table), 1.0 / sweep.sample_rate) == "swept"


def rest(rng: np.random.Generator, t: Array) -> Array:
    return 9.8 + 0.03 * rng.standard_normal(len(t))


def carried(rng: np.random.Generator, t: Array) -> Array:
    slow = np.convolve(rng.standard_normal(len(t)), np.hanning(400), mode="same")
    return 5.0 * slow / np.std(slow) + 0.1 * rng.standard_normal(len(t))


def driven(rng: np.random.Generator, t: Array) -> Array:
    """An engine: lines that keep their frequency, and gusts."""
    lines = sum(np.sin(2.0 * np.pi * f * t + p) for f, p in ((28.0, 1.0), (56.0, 2.0), (84.0, 0.4)))
    return 2.0 * lines + 2.0 * np.exp(np.convolve(rng.standard_normal(len(t)), np.hanning(300), mode="same") / 6.0) * (
        rng.standard_normal(len(t))
    )


def struck(rng: np.random.Generator, t: Array) -> Array:
    hits = np.zeros(len(t))
    hits[rng.integers(0, len(t), 12)] = 300.0
    return np.convolve(hits, np.exp(-np.arange(200) / 40.0) * np.sin(np.arange(200)), mode="same") + rest(rng, t)


def fixed_sine(rng: np.random.Generator, t: Array) -> Array:
    return 10.0 * np.sin(2.0 * np.pi * 80.0 * t) + 0.05 * rng.standard_normal(len(t))


@pytest.mark.parametrize("motion", [rest, carried, driven, struck, fixed_sine])
def test_what_is_no_shaker_is_not_taken_for_one(motion) -> None:  # type: ignore[no-untyped-def]
    t = np.arange(20_000) / 1000.0
    assert {recognised(motion(np.random.default_rng(seed), t), 1e-3) for seed in SEEDS} == {""}


def test_a_resting_sensor_in_an_unknown_unit_is_none_by_its_level_alone() -> None:
    """White noise and a run are the same but for their level: without a unit that level says nothing."""
    x = 0.01 * np.random.default_rng(1).standard_normal(20_000)
    assert (recognised(x, 1e-3), recognised(x, 1e-3, known=False)) == ("", "random")


def test_short_and_slow_records_are_none_and_a_few_lost_samples_do_not_matter() -> None:
    x = simulate(Run(duration=8.0), 1)[0][:, 0]
    assert recognised(x[:4000], 1.0 / 5120.0) == ""
    assert recognised(x, 1.0 / 100.0) == ""
    x[1000:1100] = np.nan
    assert recognised(x, 1.0 / 5120.0) == "random"
    x[1000:3000] = np.nan
    assert recognised(x, 1.0 / 5120.0) == ""


def test_levels_of_a_shaker_are_no_change_of_unit() -> None:
    """One of 4,800 simulated records, rests of a milli-g before a run: its noise rises by the factor of g and m/s^2."""
    x = simulate(Run(duration=4.0, rate=2000.0, nodes=((20.0, 0.01), (80.0, 0.04), (500.0, 0.04), (800.0, 0.01))), 3)[0]
    for seed in range(1, 11):
        rng = np.random.default_rng(seed)
        run = np.concatenate([np.zeros(12_000), x[:, 0] / x[:, 0].std(), np.zeros(8000)])
        each = [gain * run + off + 1e-3 * rng.standard_normal(len(run))
                for gain, off in ((1.0, 0.05), (0.1, 0.0), (0.03, -0.001))]  # fmt: skip
        found = changes(each, ("x", "y", "z"), "acceleration", 5e-4)
        assert not [one for one in found if one.code in ("unit_changed", "scale_changed")]
