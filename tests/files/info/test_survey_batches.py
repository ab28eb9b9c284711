"""What a file holds is the same whatever the size of a batch, in memory and on the disk."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core import batches as b
from inertialcal.core.recording import Channel, Recording
from inertialcal.files.info.survey import survey_recording
from inertialcal.signals import codes
from inertialcal.signals.codes import levels_of, resolution, resolution_of_values
from inertialcal.signals.screening.slow import stuck_slow

ROUNDING = 1e-12


def made(seed: int, n: int, *, stored: bool) -> Recording:
    """Return a recording of a triad and a thermometer with some of the faults that there are."""
    rng = np.random.default_rng(seed)
    step = rng.choice([0.0, 1 / 16384, 0.25])
    acc = rng.normal([0.0, 0.1, 1.0], rng.choice([1e-3, 1.0, 2000.0]), (n, 3))
    acc = np.round(acc / step) * step if step else acc
    warm = np.round(20.0 + 20.0 * np.sin(np.arange(n) / n * 9.0) + rng.normal(0.0, 0.02, n), 2)
    if rng.random() < 0.5:
        first = int(rng.integers(0, n // 2))
        warm[first : first + n // 4] = warm[first]
    acc[rng.random(n) < rng.choice([0.0, 0.01]), 0] = np.nan
    acc[n // 2 :, 1] *= rng.choice([1.0, -1.0])
    warm[rng.random(n) < rng.choice([0.0, 0.001])] = -400.0
    time = np.cumsum(rng.choice([10_000_000, 10_000_000 + int(rng.integers(0, 3)), 40_000_000], n, p=[0.9, 0.09, 0.01]))
    unit = rng.choice(["g", ""]) or None
    names = [("acc_x", "x", "acc"), ("acc_y", "y", "acc"), ("acc_z", "z", "acc")]
    channels = [Channel(name, kept(acc[:, i], stored), unit, "", axis, what)
                for i, (name, axis, what) in enumerate(names)]  # fmt: skip
    channels.append(Channel("temperature", kept(warm, stored), "degC", "", "", "temperature"))
    return Recording(tuple(channels), kept(time.astype(np.int64), stored), 0.01, interval_from="flag")


def kept(x: NDArray[Any], stored: bool) -> NDArray[Any]:
    out = b.empty(len(x), x.dtype, stored)
    out[:] = x
    return out


def alike(one: object, other: object) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=ROUNDING, abs_tol=ROUNDING)
    return one == other


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(300, 4000), size=st.integers(1, 5000), stored=st.booleans())
def test_the_survey_does_not_hang_on_the_size_of_a_batch(seed: int, n: int, size: int, stored: bool) -> None:
    whole = json.loads(json.dumps(survey_recording(made(seed, n, stored=False)).to_dict()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(b, "SIZE", size)
        patch.setattr(b, "HELD", 0 if stored else b.HELD)
        found = json.loads(json.dumps(survey_recording(made(seed, n, stored=stored)).to_dict()))
    assert alike(found, whole)


@given(seed=st.integers(0, 10**6), n=st.integers(2, 2000), steps=st.sampled_from([0.0, 1e-3, 0.25, 1 / 131]),
       chunk=st.integers(4, 300))  # fmt: skip
def test_the_step_is_that_of_the_levels(seed: int, n: int, steps: float, chunk: int) -> None:
    x = np.random.default_rng(seed).normal(0.0, 2.0, n)
    x = np.round(x / steps) * steps if steps else x
    true = resolution(levels_of(x))
    x = np.concatenate((x, [np.nan, np.inf]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(codes, "SORTED", 0)
        patch.setattr(codes, "CHUNK", chunk)
        assert resolution_of_values(x) == true


@given(seed=st.integers(0, 10**6), size=st.integers(1, 300))
def test_a_hold_is_found_across_batches(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.round(20.0 + rng.normal(0.0, 0.05, 800), 2)
    x[:400] += np.linspace(0.0, 8.0, 400)
    first = int(rng.integers(0, 700))
    x[first : first + 100] = x[first]
    x[rng.random(800) < 0.01] = np.nan
    whole = stuck_slow(x)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(b, "SIZE", size)
        assert stuck_slow(x) == whole
