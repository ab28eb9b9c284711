"""A short rig of the tests, and the command with it: what a process runs that is killed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from inertialcal.lab.sequence.rehearsal import write_rehearsal
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig, on_bench
from inertialcal.rigs.rate_table.rig import build
from inertialcal.rigs.rate_table.setup import Bench

TABLE, LONG, SUITE = "short_table", "long_table", "short_suite"
RATES = (0.0, 1.5, -1.5, 4.5, -4.5, 0.0)


def add_rigs() -> None:
    """Register the short rigs."""
    from npsat1_small import short_twin

    bench = Bench(rates_deg_s=RATES, runs=2, fit_runs=2, dwell=60.0)
    RIGS[TABLE] = Rig(TABLE, "rate table, two power-ups", on_bench(build, bench))
    RIGS[LONG] = Rig(LONG, "rate table, longer dwells", on_bench(build, replace(bench, dwell=240.0)))
    small = {"table_runs": 3, "table_fit_runs": 2, "static_hours": 0.3, "chamber_runs": 3, "chamber_fit_runs": 2}
    RIGS[SUITE] = Rig(SUITE, "rate suite, three power-ups", lambda seed, changes: short_twin(seed, **small))


def rehearsal(folder: Path, rig: str = TABLE) -> Path:
    """Write a rehearsal; return its LAB.toml."""
    add_rigs()
    return write_rehearsal(rig, folder, 1)


if __name__ == "__main__":
    add_rigs()
    from inertialcal.cli.__main__ import main

    main()
