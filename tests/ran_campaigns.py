"""Campaigns that were run, for the tests of what results.json holds; a short simulated one with every kind of loss."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from inertialcal.campaign.engine.engine import Prepared, prepare
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.rigs.twin import SEED

SHORT = Bench(rates_deg_s=(0.0, 2.0, -2.0, 6.0, 4.0, -4.0, 0.0), dwell=24.0, runs=5, fit_runs=3)  # 6 is at the rail
TEST_LOW = 7  # samples, of one recording


@dataclass(frozen=True)
class Ran:
    """Folder, prepared tests and results of a campaign."""

    folder: Path
    prepared: list[Prepared]
    results: dict[str, Any]


def ran(folder: Path) -> Ran:
    campaign = load(folder)
    prepared = [prepare(campaign, number) for number in range(len(campaign.file.tests))]
    return Ran(folder, prepared, run(folder, write=False).results)


def lossy_twin(folder: Path) -> Path:
    """Write three axes in five power-ups; one step is at the rail, and a built-in test is low for a while."""
    twin = rate_table.build(SHORT, 3)
    (folder / "campaign.toml").write_text(twin.campaign.replace(SEED, "3"), encoding="utf-8")
    for file, recording in twin.recordings.items():
        path = folder / file
        path.parent.mkdir(exist_ok=True)
        path.write_text(csv_text(recording), encoding="utf-8")
    lower_the_test(folder / "recordings/x_run1.csv")
    return folder


def lower_the_test(path: Path) -> None:
    """Let the built-in test of the x sensor be low at the start of a recording."""
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    at = head.split(",").index("x_bit")
    cells = [row.split(",") for row in rows]
    for row in cells[:TEST_LOW]:
        row[at] = "0"
    path.write_text("\n".join([head, *map(",".join, cells), ""]), encoding="utf-8")
