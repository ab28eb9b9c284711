"""Alignments of simulated units: readings without files, truth, hits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from independent.orbit.aligned import EARTH, Bench, Made, made
from inertialcal.core.influence import Influence
from inertialcal.procedures.alignment.plan import Plan
from inertialcal.procedures.alignment.readings import BLOCKS, Position, Readings, _block_means
from inertialcal.procedures.alignment.reduction import Result, reduce

Array = NDArray[np.float64]
SITE = {"latitude": math.radians(36.6), "gravity": 9.799}
SHORT = {"seconds": 300.0, "step": 0.5}


def readings(one: Made) -> Readings:
    """Return positions as the procedure has them, without files."""
    found = []
    for first, stop in one.spans:
        acc, gyro = one.acc[first:stop], one.gyro[first:stop]
        means = [_block_means(own, max(len(own) // BLOCKS, 1)) for own in (acc, gyro)]
        found.append(Position(means[0], means[1], one.bench.seconds, float(one.times[first]), "imu", raw=(acc, gyro)))
    return Readings(tuple(found), {"accelerometer": {}, "gyro": {}})


def plan(bench: Bench, **more: object) -> Plan:
    """Return the plan of a bench, with its turns as stated."""
    stated = ", ".join(f"{one:.9g} deg" for one in bench.turns) or None
    own = {"latitude": math.radians(bench.latitude), "gravity": bench.gravity, "turns": stated}
    return Plan(**{**own, **more})  # type: ignore[arg-type]


def reduced(bench: Bench, seed: int, **more: object) -> tuple[Made, Result]:
    """Return a record, and what it gives."""
    one = made(bench, np.random.default_rng(seed))
    return one, reduce(plan(bench, **more), readings(one))


def standards(**sizes: tuple[float, str]) -> Mapping[str, Influence]:
    """Return standards by name, ``sensor_misalignment=(1e-4, "rad")``."""
    found = {}
    for name, (u, unit) in sizes.items():
        standard, _, quantity = name.partition("__")
        found[f"{standard}.{quantity}"] = Influence(u, unit, standard=standard, quantity=quantity)
    return found


def truths(one: Made, bias: Array | None = None) -> dict[str, float]:
    """Return true values by the names of the estimate, SI; headings in [0, 2 pi)."""
    bench, found, many = one.bench, {}, len(one.spans) > 1
    for at, (heading, matrix) in enumerate(zip(one.headings, one.attitudes, strict=True), 1):
        place = f" at {at}" if many else ""
        down, right = matrix[2], -1.0 if bench.z_up else 1.0
        found[f"heading{place}"] = math.radians(heading)
        found[f"pitch{place}"] = -math.asin(down[0])
        found[f"roll{place}"] = math.atan2(right * down[1], right * down[2])
    if bias is not None:
        found |= {f"gyro_bias_{axis}": float(bias[at]) for at, axis in enumerate("xyz")}
    found["level_earth_rate"] = EARTH * math.cos(math.radians(bench.latitude))
    found["latitude_seen"] = math.radians(bench.latitude)
    return found


def hits(one: Made, result: Result, bias: Array | None = None) -> dict[str, bool]:
    """Return whether the interval of each figure holds the truth."""
    found, true = {}, truths(one, bias)
    for row in result.rows():
        name = str(row.key)
        if row.status == "estimated" and name in true and row.interval is not None:
            assert row.value is not None
            assert row.interval.lo is not None
            assert row.interval.hi is not None
            value = row.value + math.remainder(true[name] - row.value, 2.0 * math.pi)
            found[name] = row.interval.lo <= value <= row.interval.hi
    return found


def drawn(bench: Bench, rng: np.random.Generator, gyro: float = 0.0, acc: float = 0.0) -> Bench:
    """Return a bench with attitude and biases drawn: standard deviations in deg/h and mg."""
    bias, off = rng.normal(0.0, 1.0, (2, 3))
    return replace(bench, heading=float(rng.uniform(0.0, 360.0)), pitch=float(rng.uniform(-2.0, 2.0)),
                   roll=float(rng.uniform(-2.0, 2.0)), gyro_bias=tuple(gyro * bias),
                   acc_bias=tuple(acc * off))  # fmt: skip
