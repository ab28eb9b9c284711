"""One test of many units at once, against the call of each."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import inertialcal as ic
from inertialcal.procedures import procedure_of

from ..comparison import Work, line

UNITS = 40
RUNS, SIZES = 5, np.linspace(10.0, 100.0, 7)


def rate_table(folder: Path, seed: int) -> Path:
    """Return the table of one unit: three axes, 210 dwells."""
    rng, rows = np.random.default_rng(seed), ["run,axis,rate [deg/s],x [deg/s],y [deg/s],z [deg/s]"]
    for run in range(RUNS):
        offset = 0.01 * rng.standard_normal(3)
        for axis in range(3):
            for rate in (*-SIZES[::-1], *SIZES):
                y = 1.002 * rate * (np.arange(3) == axis) + offset + 0.002 * rng.standard_normal(3)
                rows.append(f"r{run},{'xyz'[axis]},{rate:g}," + ",".join(f"{value:.7f}" for value in y))
    path = folder / f"{seed}.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8", newline="\n")
    return path


def rate_tables() -> Work:
    folder, procedure = tempfile.TemporaryDirectory(), procedure_of("rate_table")
    paths = [rate_table(Path(folder.name), seed) for seed in range(UNITS)]
    tests: list[Any] = [(found.plan, found.tested[0].readings) for found in map(ic.rate_table, paths)]

    def own() -> None:
        for found in procedure.reduce_many(tests):
            procedure.rows(found)

    def peer() -> None:
        _ = folder  # stays until the last call
        for path in paths:
            ic.rate_table(path)

    return Work(own, peer)


line(f"reduce_many, {UNITS} rate tables of 210 dwells", peer="ic.rate_table of each", goal=30.0)(rate_tables)
