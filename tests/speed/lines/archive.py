"""An archive of 54,000 results of 2,000 units: the history of one, the trend of a quantity over all."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from made_records import add, content, figure

from inertialcal.archive import open_archive
from inertialcal.archive.archive import Archive

from ..comparison import Work, line

UNITS, YEARS = 2_000, 3
QUANTITIES = ("bias", "scale_factor_error", "misalignment")
AXES = {"misalignment": ("xy", "yz", "zx")}


@cache
def archive() -> tuple[Archive, tempfile.TemporaryDirectory[str]]:
    """Make it, in 3 campaigns a unit of 9 results each; it goes with the process."""
    folder = tempfile.TemporaryDirectory(prefix="inertialcal-speed-")
    made, rng = open_archive(Path(folder.name) / "lab.db"), np.random.default_rng(1)
    contents = []
    for unit in range(UNITS):
        for year in range(YEARS):
            rows = [
                figure(float(rng.normal()), 0.1, quantity, axis, shared={"rate_table.rate": 0.05})
                for quantity in QUANTITIES
                for axis in AXES.get(quantity, ("x", "y", "z"))
            ]
            contents.append(
                content(f"S{unit}", year + unit / UNITS, rows, certificate=f"C-{year}", lot=f"L{unit // 50}")
            )
    for start in range(0, len(contents), 500):
        add(made, *contents[start : start + 500])
    return made, folder


def history() -> Work:
    """All nine figures of a unit, with their drifts."""
    made, _ = archive()
    assert len(made.history("S7").series) == len(QUANTITIES) * 3
    return Work(own=lambda: made.history("S7"), peer=0.05)


def trend() -> Work:
    """The last test of each of 2,000 units as a control chart."""
    made, _ = archive()
    assert len(made.trend("bias", axis="x").groups[0].labels) == UNITS
    return Work(own=lambda: made.trend("bias", axis="x"), peer=0.1)


def trend_of_lots() -> Work:
    """The same by lots."""
    made, _ = archive()
    assert len(made.trend("bias", axis="x", by="lot").groups[0].labels) == UNITS // 50
    return Work(own=lambda: made.trend("bias", axis="x", by="lot"), peer=0.1)


line("archive, 54,000 results: history of a unit", peer="allowed", goal=1.0)(history)
line("archive, 54,000 results: trend of 2,000 units", peer="allowed", goal=1.0)(trend)
line("archive, 54,000 results: trend of 40 lots", peer="allowed", goal=1.0)(trend_of_lots)
