"""Speed of compensation against its peer: reading the same rows from Parquet with pyarrow, in the same process.

Run by ``make bench``. The peer is taken at its fastest, the read alone, without turning its table into an array.
Beside it stands what no compensation can go below: one pass over memory, the readings copied into a new array.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from inertialcal.core.estimate import Array
from inertialcal.core.units import factor
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.equation import Conditions
from inertialcal.sensors.model.sensor_model import SensorModel

ROWS = 10_000_000
ROUNDS = 7
LIMIT = 3.0  # issue 3: time of compensation over time of reading

MODEL = flight_unit().models["corrected"]
PLAIN = SensorModel("gyro", MODEL.axes, MODEL.scale_factor, "V", MODEL.matrix, MODEL.bias)
FULL_SCALE = 5.0 * factor("deg/s", "rad/s")
ASYMMETRY = np.array([0.01, -0.02, 0.005])
CURVED = {
    "scale_factor_asymmetry": ASYMMETRY,
    "second_order": np.array([0.03, -0.02, 0.01]) / FULL_SCALE,
    "third_order": np.array([0.01, 0.02, -0.01]) / FULL_SCALE**2,
    "input_range": np.array([[-FULL_SCALE, FULL_SCALE]] * 3),
}
IN_TEMPERATURE = np.concatenate([MODEL.matrix, 1e-5 * np.ones((1, 3, 3)), 1e-7 * np.eye(3)[np.newaxis]])
WITHIN: dict[str, tuple[SensorModel, str]] = {
    "constant bias": (PLAIN, ""),
    "cubic in one temperature": (MODEL, "column"),
    "asymmetry": (replace(PLAIN, scale_factor_asymmetry=ASYMMETRY), ""),
    "asymmetry, cubic in one temperature": (replace(MODEL, scale_factor_asymmetry=ASYMMETRY), "column"),
    "K2 and K3": (replace(PLAIN, **CURVED), ""),  # type: ignore[arg-type]
    "M(T)": (replace(MODEL, matrix=IN_TEMPERATURE, scale_factor_asymmetry=ASYMMETRY), "column"),
}


def seconds(action: Callable[[], object]) -> float:
    started = time.perf_counter()
    action()
    return time.perf_counter() - started


@pytest.fixture(scope="module")
def readings() -> Array:
    rng = np.random.default_rng(1)
    return rng.uniform(-1.0, 1.0, (ROWS, 3)) * 5.0 * factor("deg/s", "rad/s")


@pytest.fixture(scope="module")
def file(readings: Array, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bench") / "readings.parquet"
    parquet.write_table(pa.table({axis: readings[:, i] for i, axis in enumerate("xyz")}), path)
    return path


@pytest.mark.bench
@pytest.mark.parametrize("case", WITHIN)
def test_compensating_takes_at_most_three_times_reading(benchmark: Any, case: str, readings: Array, file: Path) -> None:
    assert ratio(benchmark, case, WITHIN[case], readings, file) <= LIMIT


def ratio(benchmark: Any, case: str, what: tuple[SensorModel, str], readings: Array, file: Path) -> float:
    """Median time of compensation over median time of reading."""
    model, kind = what
    conditions: Conditions = {"temperature": np.linspace(-20.0, 60.0, ROWS)} if kind == "column" else {}
    compensate(model, readings, **conditions)  # compiled once, kept on disk
    peer, one_pass = [], []

    def setup() -> None:
        """Between any two rounds the peer and the pass have their turn, so that all meet the same load."""
        peer.append(seconds(lambda: parquet.read_table(file)))
        one_pass.append(seconds(readings.copy))

    done = benchmark.pedantic(compensate, (model, readings), conditions, setup=setup, rounds=ROUNDS)
    assert done.shape == (ROWS, 3)
    own, read, copied = benchmark.stats.stats.median, median(peer), median(one_pass)
    benchmark.extra_info |= {"rows": ROWS, "parquet_read_median_s": read, "ratio": own / read, "one_pass_s": copied}
    print(f"\n{case}: {own:.3f} s, Parquet {read:.3f} s, ratio {own / read:.2f}; one pass over memory {copied:.3f} s")
    return float(own / read)
