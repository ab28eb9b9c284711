"""A rig of recordings at rest: means drawn about known ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inertialcal.core.recording import Channel, Recording
from inertialcal.rigs.protocol import Rig, on_bench
from inertialcal.rigs.twin import TrueValue, Twin

TEXT = """\
schema = 2
[campaign]
id = "toy-@SEED@"
source = "simulated: @SEAL@"
[sensors.suite]
kind = "gyro"
axes = ["x"]
unit = "rad/s"
chain = { kind = "none" }
%s[[tests]]
id = "mean"
procedure = "mean_reading"
recordings = [%s]
"""
RECORDING = """\
[recordings.r%d]
sensor = "suite"
file = "recordings/r%d.csv"
channels = { x = { column = "x", unit = "rad/s" } }
clock = { column = "unix_s" }
"""


@dataclass(frozen=True)
class Bench:
    """Recordings as they are made."""

    recordings: int = 8
    bias: float = 0.01
    scatter: float = 1e-3


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign of a seed."""
    rng = np.random.default_rng(seed)
    numbers = range(1, bench.recordings + 1)
    time = (1_700_000_000_000_000_000 + np.arange(50) * 100_000_000).astype(np.int64)
    made = {}
    for n in numbers:
        values = bench.bias + rng.normal(0.0, bench.scatter) + rng.normal(0.0, 1e-5, 50)
        channels = (Channel("x", values, "rad/s", "campaign", "x"),)
        made[f"recordings/r{n}.csv"] = Recording(
            channels, time, 0.1, epoch="utc", interval_from="column", time_column="unix_s"
        )
    text = TEXT % ("".join(RECORDING % (n, n) for n in numbers), ", ".join(f'"r{n}"' for n in numbers))
    return Twin(text, made, (TrueValue("mean_reading", "x", bench.bias, "rad/s"),), {})


RIG = Rig("toy_rest", "recordings at rest", on_bench(build, Bench()))
