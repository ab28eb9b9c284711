"""A real record of the archive from `info` to `flip` on the command line: its traps are told, nothing made certain."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from typed_commands import call

RECORD = "2014_10_22_09_36_36.324-2014_10_22_09_37_35.317.121f03006"
WINDOWS = (
    "--window", "2014/295/09:36:37..2014/295/09:37:02=0 deg",
    "--window", "2014-10-22T09:37:05Z..2014-10-22T09:37:34Z=180 deg",
)  # fmt: skip
TRAPS = {"stop_differs", "stamps_made", "as_archived", "bias_not_applied"}


def test_info_tells_the_traps_and_what_to_type_next(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    path = str(shared / "data" / "pims_pad" / RECORD)
    status, out, _ = call(capsys, "info", path)
    assert status == 0
    told = " ".join(out.split())
    assert "8378 rows" in told
    for words in (
        "placeholder digits",
        "end of the record",
        "computed as TimeZero + n/(142 Hz)",
        "not those of the sensor",
    ):
        assert words in told
    assert f"next: inertialcal microgravity {path}" in told


def test_a_record_without_a_turn_is_refused_with_a_way_out(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    status, out, err = call(capsys, "flip", str(shared / "data" / "pims_pad" / RECORD))
    assert (status, out) == (2, "")
    assert "no turn of the head found in 59 s" in err
    assert "--window" in err


def test_windows_given_carry_the_traps_into_the_result(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    status, out, _ = call(capsys, "flip", str(shared / "data" / "pims_pad"), *WINDOWS, "--json")
    assert status == 0
    content: dict[str, Any] = json.loads(out)
    codes = {remark["code"] for remark in content["remarks"]}
    assert codes >= {*TRAPS, "turned_to_sensor_axes", "short_record"}
    assert len(content["inputs"][0]["sha256"]) == 64
