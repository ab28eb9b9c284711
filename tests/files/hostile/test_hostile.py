"""Damaged files of every reader: refused in words, or read with what is gone told; no traceback, no hang, no swelling.

``make fuzz`` tries more.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

if sys.platform != "linux":
    pytest.skip("limits of processes", allow_module_level=True)

from hostile_files import NAMES, attempt, written

from inertialcal.files import read
from inertialcal.files.registry import BUILT_IN
from sized import sized

QUICK = ("text", "npz", "wav", "dataflash", "lvm")


def test_every_reader_has_a_file() -> None:
    assert set(NAMES) == set(BUILT_IN)


def check(name: str, mutations: int, cuts: int, flips: int) -> None:
    """Assert that nothing is wrong with what comes of damaged files."""
    found = attempt(name, 1, mutations, cuts, flips)
    assert len(found) == mutations + cuts + flips
    assert not [f"{one.how}: {one.wrong}" for one in found if one.wrong]


@pytest.mark.parametrize("name", QUICK)
def test_a_few_damaged_files(name: str) -> None:
    check(name, 8, 6, 4)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_damaged_files(name: str) -> None:
    check(name, *sized((15, 12, 12), (6, 5, 5)))


def test_a_segment_cut_off_before_its_values_is_told(tmp_path: Path) -> None:
    """It is passed over by npTDMS without a word: 150 of 400 rows were read as if they were all."""
    path = written("tdms", tmp_path)
    data = path.read_bytes()
    second = data.index(b"TDSm", 4)
    path.write_bytes(data[: second + 300])
    found = read(path)
    assert "torn_file" in {one.code for one in found.remarks}
