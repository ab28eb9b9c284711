"""One test of a unit of a lot, from its files to its rows, against the command for the same files in a loop."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from itertools import cycle
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from independent.positions import by_hand, tumbled
from inertialcal.campaign.engine.engine import prepare, reduce_alike
from inertialcal.campaign.file.load import load
from inertialcal.campaign.inputs.sources import ReadOnce
from inertialcal.procedures import procedure_of
from inertialcal.signals.remembered import forget

from ..comparison import Work, line

UNITS = 40
AXES = "xyz"
HEAD = """schema = 2
[campaign]
id = "unit"
[item]
serial = "{serial}"
[standards.thermometer]
temperature = {{ u = "0.1 degC" }}
[sensors.gyro]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
"""
RECORDING = """[recordings.{name}]
sensor = "gyro"
file = "{name}.parquet"
run = "{name}"
clock = {{ column = "t" }}
channels = {{ {channels} }}
"""
TESTS = {
    "static_noise": '[[tests]]\nid = "test"\nprocedure = "static_noise"\nuse = "report_only"\n'
    'recordings = ["static"]\n',
    "thermal": '[[tests]]\nid = "test"\nprocedure = "thermal"\nuse = "report_only"\nrecordings = ["up", "down"]\n'
    'plan = { at = ["0 degC", "20 degC"], reference_temperature = "20 degC" }\n',
}
COMMANDS = {
    "static_noise": ["allan"],
    "thermal": ["thermal"],
    "positions": ["positions", "--gravity", "9.81 m/s2", "--latitude", "48 deg"],
    "triad": ["positions", "--unit", "acc=m/s2", "--gravity", "9.81 m/s2"],
}
POSITIONS = """schema = 2
[campaign]
id = "unit"
[item]
serial = "{serial}"
[site]
gravity = "9.81 m/s2"
latitude = "48 deg"
[sensors.acc]
kind = "accelerometer"
axes = ["x", "y", "z"]
unit = "m/s2"
[sensors.gyro]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "rad/s"
[[tests]]
id = "test"
procedure = "positions"
recordings = [{recordings}]
use = "report_only"
"""
BY_HAND = """[recordings.{name}]
sensor = "{name}"
file = "hand.parquet"
clock = {{ column = "unix_s" }}
channels = {{ {channels} }}
"""
RESTS = """[recordings.acc]
sensor = "acc"
file = "rests.parquet"
[recordings.acc.rests]
unit = "m/s2"
reading = { x = "acc_x", y = "acc_y", z = "acc_z" }
scatter = { x = "acc_x_std", y = "acc_y_std", z = "acc_z_std" }
samples = "samples"
"""


def columns_of(rng: np.random.Generator, test: str, down: bool) -> dict[str, object]:
    """Return the columns of a file: 20,000 samples at rest, or a ramp of 2,000."""
    if test == "static_noise":
        noise = 0.05 * rng.standard_normal((3, 20_000)) + 1e-5 * rng.standard_normal((3, 20_000)).cumsum(axis=1)
        return {"t [s]": np.arange(20_000) * 0.01, **{f"gyro_{a} [deg/s]": x for a, x in zip(AXES, noise, strict=True)}}
    degrees = np.linspace(-20.0, 60.0, 2_000)[:: -1 if down else 1] + 0.02 * rng.standard_normal(2_000)
    found: dict[str, object] = {"t [s]": np.arange(2_000) * 2.0, "temperature [degC]": degrees}
    for axis in AXES:
        bias = 0.1 + 0.01 * rng.standard_normal() + 1e-3 * (degrees - 20.0)
        found[f"gyro_{axis} [deg/s]"] = bias + 0.005 * rng.standard_normal(2_000)
    return found


def unit(folder: Path, seed: int, test: str) -> list[Path]:
    """Write the campaign of a unit; return its recordings."""
    rng, text, files = np.random.default_rng(seed), HEAD.format(serial=seed), []
    folder.mkdir(parents=True)
    for name in ("up", "down") if test == "thermal" else ("static",):
        files.append(folder / f"{name}.parquet")
        parquet.write_table(pa.table(columns_of(rng, test, name == "down")), files[-1])
        channels = [f'{axis} = {{ column = "gyro_{axis}", unit = "deg/s" }}' for axis in AXES]
        channels += ['temperature = { column = "temperature", unit = "degC" }'] * (test == "thermal")
        text += RECORDING.format(name=name, channels=", ".join(channels))
    (folder / "campaign.toml").write_text(text + TESTS[test], encoding="utf-8", newline="\n")
    return files


def of_positions(folder: Path, seed: int, test: str) -> list[Path]:
    """Write the campaign of a unit: 24 positions, as a recording by hand or as a row each; return its file."""
    if test == "triad":
        case, name, text = tumbled(seed, positions=24, condition=(0.0, 40.0), cone=180.0), "rests", RESTS
    else:
        case, name, text = by_hand(seed), "hand", ""
        for sensor, unit in (("acc", "m/s2"), ("gyro", "rad/s")):
            channels = [f'{axis} = {{ column = "{sensor}_{axis}", unit = "{unit}" }}' for axis in AXES]
            text += BY_HAND.format(name=sensor, channels=", ".join(channels))
    folder.mkdir(parents=True)
    parquet.write_table(pa.table(dict(case.tables[f"{name}.csv"].columns)), folder / f"{name}.parquet")
    names = '"acc"' if test == "triad" else '"acc", "gyro"'
    text = POSITIONS.format(serial=seed, recordings=names) + text
    (folder / "campaign.toml").write_text(text, encoding="utf-8", newline="\n")
    return [folder / f"{name}.parquet"]


def of_unit(test: str) -> Work:
    """Return a unit of many, each read, prepared, reduced and written as rows; the command stands beside it."""
    root = Path(mkdtemp(prefix="units"))
    is_positions = test in ("positions", "triad")
    files = [(of_positions if is_positions else unit)(root / str(seed), seed, test) for seed in range(UNITS)]
    campaigns = cycle([load(root / str(seed)) for seed in range(UNITS)])
    procedure = procedure_of("positions" if is_positions else test)

    def own() -> int:
        forget()
        campaign = next(campaigns)
        prepared = prepare(campaign, 0, {}, ReadOnce(campaign.folder))
        (result,) = reduce_alike([prepared])
        return len(procedure.rows(result))

    for _ in range(UNITS):  # loops are compiled or loaded after some calls
        own()
    command = [sys.executable, "-m", "inertialcal", *COMMANDS[test], *map(str, files[0]), "--json"]
    return Work(own, lambda: subprocess.run(command, check=False, capture_output=True))


line("static_noise of a unit, 3 axes x 20,000 samples", peer="inertialcal allan", goal=30.0)(
    partial(of_unit, "static_noise")
)
line("thermal of a unit, 3 axes x 2 x 2,000 samples", peer="inertialcal thermal", goal=30.0)(
    partial(of_unit, "thermal")
)
line("positions of a unit, by hand, 24 positions x 6 s", peer="inertialcal positions", goal=30.0)(
    partial(of_unit, "positions")
)
line("positions of a unit, a table of 24", peer="inertialcal positions", goal=30.0)(partial(of_unit, "triad"))
