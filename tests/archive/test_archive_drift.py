"""Units with and without a drift, through an archive: what its history calls one, and what it states of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_records import add, content, figure
from numpy.typing import NDArray

from inertialcal.archive import open_archive
from inertialcal.statistics.intervals import covers
from sized import sized

AXES = "xyz"
SCATTER, STANDARD = 0.01, 0.03  # of a test, and of the standard behind all of them [%]


def unit(serial: str, days: NDArray[np.float64], drift: float, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Tests of a unit on these days of a year [year]: three axes, one standard, what power-ups differ by drawn anew."""
    true, error = rng.normal(0.0, 0.2, 3), rng.normal(0.0, STANDARD)
    made = []
    for day in days.tolist():
        ups = rng.normal(0.0, SCATTER * 2.0, (3, 4))
        own = ups.std(axis=1, ddof=1) / 2.0
        values = true + drift * day + error + ups.mean(axis=1)
        rows = [
            figure(float(values[i]), float(np.hypot(own[i], STANDARD)), axis=axis,
                   dof=float(3.0 * (np.hypot(own[i], STANDARD) / own[i]) ** 4), shared={"rate_table.rate": STANDARD})
            for i, axis in enumerate(AXES)
        ]  # fmt: skip
        made.append(content(serial, day, rows))
    return made


@pytest.mark.parametrize("n", [12, pytest.param(sized(1000, 300), marks=pytest.mark.slow)])
def test_a_year_without_drift_is_called_one_in_at_most_5_of_100(tmp_path: Path, n: int) -> None:
    """Of a unit tested each quarter, in any of its axes; and ten years with one are told, to what it is."""
    archive = open_archive(tmp_path / "lab.db")
    rng = np.random.default_rng(31)
    quiet = [f"quiet {k}" for k in range(n)]
    for serial in quiet:
        add(archive, *unit(serial, np.arange(5) / 4.0, 0.0, rng))
    called = sum(any(one.word == "drift" for one in archive.history(serial).series) for serial in quiet)
    print(f"{called} of {n} called a drift")
    assert covers(n - called, n)

    drift, told, held = 0.02, 0, 0
    for k in range(n):
        serial = f"aged {k}"
        add(archive, *unit(serial, np.arange(11.0), drift, rng))
        one = archive.history(serial).series[0]
        assert one.drift is not None
        assert one.drift.interval is not None
        held += (one.drift.interval.lo or 0.0) <= drift <= (one.drift.interval.hi or 0.0)
        told += one.word == "drift"
    print(f"{told} told, {held} of {n} hold it")
    assert covers(held, n)
    assert told > 0.9 * n
