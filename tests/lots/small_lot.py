"""A small lot: a gyro of one axis a unit, its rate table as CSV or Parquet, its noise at rest; by numpy alone."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

CAMPAIGN = """schema = 2
[campaign]
id = "gyro"
[item]
part = "G1"
[site]
latitude = "45 deg"
[standards.rate_table]
rate = { u = "0.05 %" }
mounting = { u = "0.001 rad" }
[standards.site]
latitude = { u = "0.0001 rad" }
[sensors.gyro]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
[recordings.rates]
sensor = "gyro"
file = "rates.csv"
rows = { applied = "rate", reading = "x", run = "run", unit = "deg/s" }
[[tests]]
id = "rate"
procedure = "rate_table"
recordings = ["rates"]
plan = { axis = "x", attitude = { tilt = "0 deg", u = "1 deg", azimuth = "0 deg", u_azimuth = "2 deg" } }
[model]
terms = { scale_factor = ["rate"], bias = ["rate"] }
[[requirements]]
id = "R1"
text = "scale factor within 1 %"
quantity = "scale_factor_error"
limit = "1 %"
"""


def rates(seed: int, error: float = 0.002) -> dict[str, list[object]]:
    """Return the rows of a rate table: five runs of eleven rates, an offset a run."""
    rng = np.random.default_rng(seed)
    found: dict[str, list[object]] = {"run": [], "rate": [], "x": []}
    for run in range(5):
        offset = 0.02 * rng.standard_normal()
        for rate in np.linspace(-50.0, 50.0, 11):
            found["run"].append(f"r{run}")
            found["rate"].append(float(rate))
            found["x"].append(float((1.0 + error) * rate + offset + 0.003 * rng.standard_normal()))
    return found


def csv(rows: dict[str, list[object]]) -> str:
    lines = [",".join(rows), *(",".join(str(cell) for cell in one) for one in zip(*rows.values(), strict=True))]
    return "\n".join(lines) + "\n"


def folder_lot(root: Path, count: int, first: int = 0) -> Path:
    """Write a lot as a folder of units; the scale factor of every fifth is off by 2 %."""
    root.mkdir(parents=True, exist_ok=True)
    (root / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8", newline="\n")
    for number in range(first, first + count):
        unit = root / f"u{number:03d}"
        unit.mkdir()
        error = 0.02 if number % 5 == 4 else 0.002
        (unit / "rates.csv").write_text(csv(rates(number, error)), encoding="utf-8", newline="\n")
    return root


def shared_lot(root: Path, count: int, csv_file: bool = False) -> Path:
    """Write a lot as LOT.toml, a table of units and one file with the rates of all; return LOT.toml."""
    root.mkdir(parents=True, exist_ok=True)
    (root / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8", newline="\n")
    serials = [f"u{number:03d}" for number in range(count)]
    whole: dict[str, list[object]] = {"unit": [], "run": [], "rate": [], "x": []}
    for number, serial in enumerate(serials):
        rows = rates(number, 0.02 if number % 5 == 4 else 0.002)
        whole["unit"] += [serial] * len(rows["x"])
        for name, column in rows.items():
            whole[name] += column
    name = "rates.csv" if csv_file else "rates.parquet"
    if csv_file:
        (root / name).write_text(csv(whole), encoding="utf-8", newline="\n")
    else:
        pq.write_table(pa.table(whole), root / name)
    table = ["serial,station,chamber_position,status"]
    table += [f"{serial},S{number % 3},{number % 7},new" for number, serial in enumerate(serials)]
    (root / "units.csv").write_text("\n".join(table) + "\n", encoding="utf-8", newline="\n")
    (root / "LOT.toml").write_text(
        f'schema = 1\nid = "lot-7"\nunits = "units.csv"\n[files]\nrates = {{ file = "{name}", serial = "unit" }}\n',
        encoding="utf-8",
        newline="\n",
    )
    return root / "LOT.toml"


def digests(out: Path) -> dict[str, str]:
    """Return the SHA-256 of all that a lot wrote and that is to be the same each time."""
    files = [*(out / "units").glob("*"), out / "lot.json"]
    return {one.name: hashlib.sha256(one.read_bytes()).hexdigest() for one in sorted(files)}


def rows(out: Path) -> list[dict[str, object]]:
    """Return a row a unit."""
    found: list[dict[str, object]] = []
    for part in sorted((out / "units").glob("*.parquet")):
        found += pq.read_table(part).to_pylist()
    return found
