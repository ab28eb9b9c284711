"""A profile in a sheet of the workbook that holds the recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError
from inertialcal.procedures.vibration.profile_file import read_profile

openpyxl = pytest.importorskip("openpyxl")
Rows = Sequence[tuple[object, ...]]
RUN: Rows = [("Time (s)", "Acc X (g)"), *((n / 100, 0.1 * (n % 7)) for n in range(50))]
SPEC: Rows = [("Random vibration, acceptance",), (), ("Frequency (Hz)", "PSD (g²/Hz)"), (20, 0.01), (500, 0.01)]


def book(path: Path, sheets: Sequence[tuple[str, Rows]]) -> Path:
    """Write a workbook."""
    made = openpyxl.Workbook()
    made.remove(made.active)
    for name, rows in sheets:
        sheet = made.create_sheet(name)
        for row in rows:
            sheet.append(row)
    made.save(path)
    return path


def test_the_sheet_with_a_profile_is_found(tmp_path: Path) -> None:
    path = book(tmp_path / "vib.xlsx", [("Run 1", RUN), ("Spec", SPEC)])
    found = read_profile(path)
    assert found.profile.rms() / 9.80665 == pytest.approx((0.01 * 480.0) ** 0.5)


def test_of_two_profiles_none_is_taken(tmp_path: Path) -> None:
    path = book(tmp_path / "vib.xlsx", [("Run 1", RUN), ("Spec", SPEC), ("Qualification", SPEC)])
    with pytest.raises(DataError, match="holds 2 profiles: Spec, Qualification"):
        ic.vibration_profile(path)


def test_a_workbook_without_one_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no column of frequency and density"):
        ic.vibration_profile(book(tmp_path / "vib.xlsx", [("Run 1", RUN)]))
