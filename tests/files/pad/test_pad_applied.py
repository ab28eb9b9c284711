"""What headers of the archive say was done, as steps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from inertialcal.files import read
from inertialcal.files.pad.header import PadHeader, applied

HEADER = PadHeader("sams2_accel", "121f03", 0, 500.0, "<f4", "", None, None, None, None, None, None, "", "")


@pytest.mark.parametrize(
    ("said", "steps"),
    [
        ("temperature+gain+axial-mis-alignment, Valid, resampled from 500.00 Hz",
         ("bias", "scale_factor", "misalignment")),
        ("gain+axial-mis-alignment, No temperature compensation", ("scale_factor", "misalignment")),
        ("Gain, Axial misalignment", ("scale_factor", "misalignment")),
        ("not temperature compensated, gain", ("scale_factor",)),
        ("uncompensated for temperature, gain", ("scale_factor",)),
        ("temperature uncorrected; gain", ("scale_factor",)),
        ("Valid", ()),
        ("", ()),
    ],
)  # fmt: skip
def test_words_of_the_archive(said: str, steps: tuple[str, ...]) -> None:
    assert applied(replace(HEADER, quality=said)) == steps


def test_the_record_of_the_archive_says_what_was_applied(shared: Path) -> None:
    folder = shared / "data" / "pims_pad"
    (file,) = [one for one in folder.iterdir() if one.name.endswith("121f03006")]
    assert read(file).applied == ("bias", "scale_factor", "misalignment")
