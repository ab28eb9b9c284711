"""What all tests share: other people's recordings, which may be absent, and a small campaign to break."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with ``data/`` and ``reference/``; the test is skipped, and says so, where it is absent."""
    folder = Path(os.environ.get("INERTIALCAL_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no recordings of others: {folder} is absent (set INERTIALCAL_SHARED)")
    return folder


CAMPAIGN = """\
schema = 1
[campaign]
id = "small"
[item]
serial = "7"
[standards.rate_table]
rate = { u = "0.05 %", certificate = "C-1" }
[sensors.suite]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
range = ["-10 deg/s", "10 deg/s"]
chain = { kind = "adc", lsb = "5 V / 4095", counts = [0, 4095], reference = "2.5 V", scale_factor = "0.5 V/(deg/s)" }
[recordings.one]
sensor = "suite"
file = "one.csv"
rows = { applied = "rate", reading = "x", scatter = "std", group = "set", run = "run", unit = "deg/s" }
[[tests]]
id = "first"
procedure = "rate_table"
recordings = ["one"]
plan = { axis = "x", zero_reference = true }
[[requirements]]
id = "R1"
quantity = "rate_error"
limit = "5 %"
where = "abs(rate) >= 0.5 deg/s"
"""


def table() -> str:
    rng = np.random.default_rng(1)
    lines = ["rate,x,std,set,run"]
    for run in range(1, 7):
        offset = rng.normal(0.0, 0.002)
        for group in ("1", "2"):
            for rate in (-4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0):
                reading = 1.01 * rate + 0.01 + offset + rng.normal(0.0, 0.001)
                lines.append(f"{rate},{reading:.6f},0.004,{group},{run}")
    return "\n".join(lines) + "\n"


@pytest.fixture
def campaign(tmp_path: Path) -> Callable[..., Path]:
    """Write the campaign, with some text replaced, and return its folder."""

    def write(*replacements: tuple[str, str], data: str | None = None) -> Path:
        text = CAMPAIGN
        for old, new in replacements:
            assert old in text, f"the campaign has no {old!r}"
            text = text.replace(old, new, 1)
        (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
        (tmp_path / "one.csv").write_text(table() if data is None else data, encoding="utf-8")
        return tmp_path

    return write
