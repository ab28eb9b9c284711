"""Records of the archive are the same in memory and stored a batch at a time, wherever batches and files end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import inertialcal as ic
from inertialcal.core import batches
from inertialcal.core.recording import Recording
from inertialcal.files.pad import data, pairs
from inertialcal.files.pad import header as headers
from pad_pairs_made import START, header, pair, records, stamp, systems

MORE = systems((0.0, 30.0, -90.0))


def written(folder: Path, seed: int) -> None:
    """Write one to four files with gaps in and between them."""
    rng, seconds = np.random.default_rng(seed), 0.0
    for _ in range(int(rng.integers(1, 5))):
        table = records(int(rng.integers(2, 400)))
        table[len(table) // 2 :, 0] += rng.choice([0.0, 0.05])
        table[rng.random(len(table)) < rng.choice([0.0, 0.05]), 2] = np.nan
        start = stamp(START, seconds)
        pair(folder, table, start=start, text=header(start, more=MORE))
        seconds += float(table[-1, 0]) + rng.choice([0.01, 0.5])


def assert_same(found: Recording, expected: Recording) -> None:
    assert found.time_ns is not None
    assert expected.time_ns is not None
    np.testing.assert_array_equal(found.time_ns, expected.time_ns)
    for one, other in zip(found.channels, expected.channels, strict=True):
        assert (one.name, one.unit, one.data.dtype) == (other.name, other.unit, other.data.dtype)
        np.testing.assert_array_equal(one.data, other.data)
    assert (found.source, found.sample_interval) == (expected.source, expected.sample_interval)
    assert [str(one) for one in found.remarks] == [str(one) for one in expected.remarks]


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6), size=st.integers(2, 500), frame=st.sampled_from(["data", "sensor"]), cut=st.booleans()
)
def test_a_stored_record_of_the_archive(
    tmp_path_factory: pytest.TempPathFactory, seed: int, size: int, frame: str, cut: bool
) -> None:
    folder = tmp_path_factory.mktemp("archive")
    written(folder, seed)
    options: dict[str, Any] = {"frame": frame} | ({"start": "2014/295/09:36:36.015"} if cut else {})
    expected = ic.read(folder, **options)
    with pytest.MonkeyPatch.context() as patch:
        for module in (data, headers, pairs):
            patch.setattr(module, "BLOCK", size)
        patch.setattr(batches, "SIZE", size)
        patch.setattr(batches, "HELD", 0)
        found = ic.read(folder, **options)
    assert_same(found, expected)
    assert all(batches.is_stored(one.data) for one in found.channels)
