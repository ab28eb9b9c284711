"""Units of a lot, faulty ones among them: together they give what each gives in a process of its own.

The units are drawn here, with numpy alone. A unit alone begins with nothing remembered and nothing kept of the designs
of others, so that whatever one unit leaves behind for the next would show.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import _lru_cache_wrapper
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from inertialcal.campaign.engine.engine import Prepared, prepare, reduce_alike, reduce_test
from inertialcal.campaign.file.load import load
from inertialcal.core.errors import InertialcalError
from inertialcal.core.estimate import Array
from inertialcal.procedures import procedure_of
from inertialcal.signals.remembered import forget

HEAD = """schema = 2
[campaign]
id = "unit"
[item]
serial = "1"
[sensors.gyro]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
"""
AXES = "xyz"
FAULTS = (
    "none", "glitches", "missing", "drift", "step", "constant", "coarse", "repeated", "louder", "stuck", "wave", "cut",
    "unit",
)  # fmt: skip


def spoilt(rng: np.random.Generator, x: Array, fault: str) -> Array:
    """Return a channel with a fault."""
    n, sigma, y = len(x), float(np.std(x)), x.copy()
    at = int(rng.integers(n // 4, n // 2))
    if fault == "glitches":
        y[rng.integers(20, n - 20, 4)] += 30.0 * sigma
    elif fault == "missing":
        y[at : at + n // 10] = np.nan
    elif fault == "drift":
        y += np.linspace(0.0, 2.0 * sigma, n)
    elif fault == "step":
        y[at:] += 2.0 * sigma
    elif fault == "constant":
        y[:] = 0.125
    elif fault == "coarse":
        y = np.round(y / sigma) * sigma
    elif fault == "repeated":
        y[1::40] = y[::40][: len(y[1::40])]
    elif fault == "louder":
        y[at:] = np.mean(y) + 1.7 * (y[at:] - np.mean(y))
    elif fault == "stuck":
        y[at : at + n // 20] = y[at]
    elif fault == "wave":
        y += sigma * np.sin(40.0 * np.pi * np.arange(n) / n)
    elif fault == "cut":
        y = np.clip(y, np.mean(y) - sigma, np.mean(y) + sigma)
    elif fault == "unit":
        y[at:] *= 180.0 / np.pi
    return y


def static(rng: np.random.Generator, folder: Path) -> None:
    """Write a record at rest, of white noise, a walk, correlated or rounded noise, with a fault of one axis or two."""
    n = int(rng.choice([3_000, 3_000, 1_500, 60]))
    columns: dict[str, Any] = {"t [s]": 0.01 * np.arange(n)}
    for axis in AXES:
        x = 0.1 + 0.05 * rng.standard_normal(n)
        x += rng.choice([0.0, 1e-3]) * np.cumsum(rng.standard_normal(n))
        if rng.random() < 0.3:
            x = np.convolve(x, [0.25, 0.25, 0.25, 0.25], mode="same")
        columns[f"gyro_{axis} [deg/s]"] = spoilt(rng, x, str(rng.choice(FAULTS)) if rng.random() < 0.5 else "none")
    kept = np.arange(n) % 50 > 0 if rng.random() < 0.2 else slice(None)  # stamps that lack samples
    parquet.write_table(pa.table({name: x[kept] for name, x in columns.items()}), folder / "static.parquet")
    text = '[recordings.static]\nsensor = "gyro"\nfile = "static.parquet"\nclock = { column = "t" }\nchannels = { '
    text += ", ".join(f'{axis} = {{ column = "gyro_{axis}", unit = "deg/s" }}' for axis in AXES) + " }\n"
    text += '[[tests]]\nid = "test"\nprocedure = "static_noise"\nuse = "report_only"\nrecordings = ["static"]\n'
    (folder / "campaign.toml").write_text(HEAD + text, encoding="utf-8", newline="\n")


def thermal(rng: np.random.Generator, folder: Path) -> None:
    """Write a ramp up and one down, with a start-up or a fault of one axis."""
    n, text = int(rng.choice([500, 500, 200])), ""
    for name, way in (("up", 1), ("down", -1)):
        degrees = np.linspace(-20.0, 60.0, n)[::way] + 0.02 * rng.standard_normal(n)
        columns: dict[str, Any] = {"t [s]": 8.0 * np.arange(n), "temperature [degC]": degrees}
        for axis in AXES:
            bias = 0.1 + 1e-3 * degrees + 1e-5 * degrees**2 + rng.choice([0.0, 0.1]) * np.exp(-np.arange(n) / 20.0)
            x = bias + 0.005 * rng.standard_normal(n)
            columns[f"gyro_{axis} [deg/s]"] = spoilt(rng, x, str(rng.choice(FAULTS)) if rng.random() < 0.2 else "none")
        parquet.write_table(pa.table(columns), folder / f"{name}.parquet")
        text += f'[recordings.{name}]\nsensor = "gyro"\nfile = "{name}.parquet"\nrun = "{name}"\n'
        text += 'clock = { column = "t" }\nchannels = { temperature = { column = "temperature", unit = "degC" }, '
        text += ", ".join(f'{axis} = {{ column = "gyro_{axis}", unit = "deg/s" }}' for axis in AXES) + " }\n"
    text += '[[tests]]\nid = "test"\nprocedure = "thermal"\nuse = "report_only"\nrecordings = ["up", "down"]\n'
    text += 'plan = { at = ["0 degC"], reference_temperature = "20 degC" }\n'
    (folder / "campaign.toml").write_text(HEAD + text, encoding="utf-8", newline="\n")


def keeping() -> list[Any]:
    """Return the functions of the package that keep what they returned."""
    found = [one for one in gc.get_objects() if isinstance(one, _lru_cache_wrapper)]
    return [one for one in found if str(one.__module__).startswith("inertialcal.")]


def said(prepared: Prepared | list[str], found: Any) -> Any:
    """Return all that a unit gives: rows and remarks, or why it is refused."""
    if isinstance(prepared, list):
        return prepared
    if isinstance(found, InertialcalError):
        return [str(one) for one in found.problems]
    rows = procedure_of(prepared.test.procedure).rows(found)
    return [repr(row.to_dict()) for row in rows], [repr(one) for one in (*prepared.readings.remarks, *found.remarks)]


def ready(folder: Path) -> Prepared | list[str]:
    """Return the test of a unit, or why it is refused."""
    try:
        return prepare(load(folder), 0, {})
    except InertialcalError as error:
        return [str(one) for one in error.problems]


def alone(folder: Path, kept: list[Any]) -> Any:
    """Return what a unit gives, with nothing kept of others."""
    forget()
    for one in kept:
        one.cache_clear()
    unit = ready(folder)
    if isinstance(unit, list):
        return unit
    try:
        return said(unit, reduce_test(unit))
    except InertialcalError as error:
        return said(unit, error)


@pytest.mark.parametrize("units", [4, pytest.param(60, marks=pytest.mark.slow)])
@pytest.mark.parametrize("write", [static, thermal])
def test_units_together_give_what_each_gives_alone(
    tmp_path: Path, write: Callable[[np.random.Generator, Path], None], units: int
) -> None:
    folders = [tmp_path / f"{seed:03}" for seed in range(1, units + 1)]
    for seed, folder in enumerate(folders, 1):
        folder.mkdir()
        write(np.random.default_rng(seed), folder)
    every = [ready(folder) for folder in folders]
    taken = [one for one in every if isinstance(one, Prepared)]
    results = iter(reduce_alike(taken))
    together = [said(one, next(results) if isinstance(one, Prepared) else None) for one in every]
    kept = keeping()
    assert together == [alone(folder, kept) for folder in folders]
    assert len(taken) > units / 2
