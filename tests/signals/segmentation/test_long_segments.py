"""A long record, whose arrays lie in temporary files, is cut as one that is held, wherever its batches end."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core import batches
from inertialcal.core.batches import summaries
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Times
from inertialcal.signals import threads
from inertialcal.signals.segmentation import noise_scale
from inertialcal.signals.segmentation.dwells import dwell_of
from inertialcal.signals.segmentation.placements import disturbed_inside, placements, shortest_placement
from inertialcal.signals.segmentation.segments import detect

N, INTERVAL = 3000, 0.01
RATES = 0.1  # size of the signal of the gyros beside that of the accelerometers


def record(seed: int, missing: bool, stamped: bool) -> tuple[Array, Times | None]:
    """Levels with noise between jumps, a shaken stretch and a single outlier; some samples or some time missing."""
    rng = np.random.default_rng(seed)
    x = rng.normal(scale=0.01, size=(N, 3))
    for edge in rng.integers(200, N - 200, 5):
        x[edge:] += rng.normal(size=3)
    x[500:530] += rng.normal(size=(30, 3))
    x[N // 2] += 5.0
    if missing:
        x[rng.integers(0, N, 20), rng.integers(0, 3, 20)] = np.nan
        x[1000:1040] = np.nan
    steps = np.where(rng.random(N) < 0.001, 30, 1) if stamped else None
    return x, None if steps is None else np.cumsum(steps) * 10_000_000


def found_in(x: Array, time_ns: Times | None) -> list[Any]:
    cut = detect(x, time_ns, None if time_ns is not None else INTERVAL)
    lies = placements(cut, shortest_placement(cut), RATES * batches.stacked(list(x.T)))
    parts = [dwell_of(cut.samples, one.start, one.stop, drop) for one in lies for drop in (0, 1, 3)]
    of_dwells = [getattr(one, part.name) for one in parts if one is not None for part in fields(one)]
    noise = [cut.noise.scale, cut.noise.dof, cut.noise.step, cut.noise.live]
    seen = [cut.start, cut.stop, cut.still, cut.stuck, cut.level, cut.scatter, cut.widening, *noise]
    flags = [cut.samples.finite, cut.samples.outlier, cut.samples.gap, disturbed_inside(x, lies)]
    said = [(one.code, one.what, one.where, one.count) for one in cut.remarks]
    return [*seen, *flags, said, lies, *of_dwells]


@given(
    seed=st.integers(0, 2**16), missing=st.booleans(), stamped=st.booleans(), size=st.integers(20, N),
    share=st.integers(3, N // 8),
)  # fmt: skip
@settings(max_examples=12, deadline=None)
def test_rests_do_not_depend_on_where_batches_end(
    seed: int, missing: bool, stamped: bool, size: int, share: int
) -> None:
    x, time_ns = record(seed, missing, stamped)
    expected = found_in(np.asfortranarray(x), time_ns)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "HELD", 0)
        patch.setattr(batches, "SIZE", size)
        patch.setattr(summaries, "AT_ONCE", share)
        patch.setattr(threads, "SHARE", noise_scale.BLOCK * share)
        stored = batches.stacked(list(x.T))
        assert batches.is_stored(stored)
        found = found_in(stored, time_ns)
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        if isinstance(other, np.ndarray):
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-14)
        elif isinstance(other, float):
            assert one == pytest.approx(other, rel=1e-12)
        else:
            assert one == other


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=60), st.floats(0.0, 1.0))
@settings(max_examples=50, deadline=None)
def test_a_quantile_of_a_stored_array(numbers: list[float], share: float) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "HELD", 0)
        patch.setattr(batches, "SIZE", 7)
        patch.setattr(summaries, "AT_ONCE", 3)
        x = batches.stacked([np.array(numbers)])[:, 0]
        assert summaries.quantile(x, share) == pytest.approx(float(np.quantile(numbers, share)), rel=1e-12, abs=1e-6)


@given(st.lists(st.booleans(), min_size=1, max_size=60), st.integers(1, 70), st.data())
@settings(max_examples=50, deadline=None)
def test_flags_are_counted_in_batches(flags: list[bool], size: int, data: st.DataObject) -> None:
    own = np.array(flags)
    at = np.array(sorted(data.draw(st.lists(st.integers(0, len(own))))), dtype=np.int64)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "SIZE", size)
        np.testing.assert_array_equal(batches.counts_before(own, at), [own[:one].sum() for one in at])
