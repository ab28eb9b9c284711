"""Rig of an accelerometer head in a space station: one record with a gap, longer than an orbit.

The slow part is what a place off the centre of mass feels: gravity gradient, which stays, and drag, which follows the
orbit. On top of it there is noise, white in the band of the record, which axes share in part (structure, crew), and
lines (pumps, fans) of drawn phase. The head reads with a bias, which a flip found with an error, and a scale factor
that is off by an unknown error.

Sizes are those of a quiet time of a station in round figures; none is that of a certain head.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.campaign_text import toml_text
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ..parts.campaign import campaign_head, channel_entries, drawn_error, drawn_errors, standard_tables
from ..protocol import Rig, on_bench
from ..twin import Extra, Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]
RECORD, COPY, CURVE = "recordings/record.csv", "recordings/copy.csv", "curve.csv"
UG = factor("ug", "m/s^2")
EDGES = 10.0**-1.15, 10.0**0.65  # of the bands that 100 s and a cut-off of 5 Hz leave [Hz]
CURVE_TEXT = "frequency [Hz],rms [ug]\n0.01,6\n0.1,6\n100,6000\n300,6000\n"
FAULTS: dict[str, Fault] = {
    "glitches": Fault("bits of some samples were lost", "glitches", {"glitches": 5}),
    "saturated": Fault("y is at the end of its range at times", "saturated", {"largest": 60e-6}),
    "wrong_unit": Fault("readings in ug are headed g", "wrong_unit", {"headed": "g"}),
    "drift": Fault("the bias of x drifts with temperature", "drifts", {"drift": 12e-6}),
    "rate_changes": Fault("the sample rate changes on the way", "rate_changes", {"second_rate": 1.1}),
    "duplicated": Fault("a part of the record is there twice", "duplicate_recording", {"duplicated": True}),
    "crew": Fault("the crew exercises for ten minutes", "not_steady", {"crew": 150e-6}),
    "short": Fault("the record is 80 s long", "short_blocks", {"seconds": 80.0, "gap": (0.0, 0.0)}),
}
STANDARDS = {"sensor.scale_factor": Influence(0.005, "1", certificate="ground test of the head")}


@dataclass(frozen=True)
class Bench:
    """The record as it is made."""

    rate: float = 12.5  # [Hz]
    seconds: float = 6000.0
    gap: tuple[float, float] = (3050.0, 3140.0)  # begin and end [s]
    noise: tuple[float, float, float] = (9e-6, 14e-6, 8e-6)  # of a sample of each axis [g]
    shared: float = 0.4  # part of its power that axes share (1)
    lines: tuple[tuple[int, float, float], ...] = ((0, 3.1, 8e-6), (2, 1.13, 12e-6))  # axis, frequency [Hz], size [g]
    slow: tuple[float, float, float] = (0.5e-6, -0.3e-6, 0.6e-6)  # standard deviations of what is drawn, about 0 [g]
    drag: float = 0.2e-6  # amplitude along the orbit [g]
    period: float = 5556.0  # [s]
    bias: tuple[float, float, float] = (20e-6, -35e-6, 8e-6)  # as a flip found it [g]
    bias_u: float = 0.15e-6  # [g]
    standards: Mapping[str, Influence] = field(default_factory=lambda: STANDARDS)
    glitches: int = 0  # samples
    largest: float = 0.0  # end of the range of y about its bias [g]; 0: none
    headed: str = "ug"  # unit in the header
    drift: float = 0.0  # of the bias of x over the record [g]
    second_rate: float = 1.0  # of the second half over that of the first (1)
    duplicated: bool = False  # whether a part of the record is there twice
    crew: float = 0.0  # of what ten minutes of exercise add to each axis [g]


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The record as it is made.
    seed : int
        Of all draws.
    """
    of_place, of_errors, of_record = np.random.default_rng(seed).spawn(3)
    slow = of_place.normal(0.0, 1.0, 3) * np.array(bench.slow)
    drawn = {f"sensor.scale_factor[{axis}]": drawn_error(bench.standards.get("sensor.scale_factor"), of_errors)
             for axis in AXES}  # fmt: skip
    bias = np.array(bench.bias) + of_errors.normal(0.0, bench.bias_u, 3)
    scale = 1.0 + np.array([drawn[f"sensor.scale_factor[{axis}]"] for axis in AXES])
    recording, mean = _recording(bench, slow, bias, scale, of_record)
    recordings = {RECORD: recording}
    if bench.duplicated:
        n = len(recording)
        recordings[COPY] = _part(recording, slice(n // 3, n // 2))
    g = UG * 1e6
    truth = [TrueValue("quasi_steady_acceleration", axis, float(value) * g, "m/s^2")
             for axis, value in zip(AXES, mean, strict=True)]  # fmt: skip
    powers = np.array([_power(bench, i) for i in range(3)])
    truth += [TrueValue("vibratory_rms", axis, math.sqrt(float(power)) * g, "m/s^2")
              for axis, power in zip((*AXES, "rss"), (*powers, powers.sum()), strict=True)]  # fmt: skip
    extras = {CURVE: Extra(None, CURVE_TEXT)}
    errors = {name: -value for name, value in drawn.items()}
    return Twin(campaign_text(bench), recordings, tuple(truth), drawn, extras, drawn_errors(bench.standards, errors))


def _power(bench: Bench, axis: int) -> float:
    """Return the power of an axis in the bands [g^2]."""
    white = bench.noise[axis] ** 2 * (EDGES[1] - EDGES[0]) / (0.5 * bench.rate)
    return float(white) + sum(0.5 * size**2 for on, f, size in bench.lines if on == axis and EDGES[0] < f < EDGES[1])


def _recording(
    bench: Bench, slow: Array, bias: Array, scale: Array, rng: np.random.Generator
) -> tuple[Recording, Array]:
    """Return the record, and the mean of its slow part [g]."""
    n = round(bench.rate * bench.seconds)
    time = np.arange(n) / bench.rate
    phases = rng.uniform(0.0, 2.0 * math.pi, 3)
    quiet = slow + bench.drag * np.sin(2.0 * math.pi * time[:, None] / bench.period + phases)
    drive = math.sqrt(1.0 - bench.shared) * rng.normal(size=(n, 3)) + math.sqrt(bench.shared) * rng.normal(size=(n, 1))
    x = quiet + drive * np.array(bench.noise)
    for axis, frequency, size in bench.lines:
        x[:, axis] += size * np.sin(2.0 * math.pi * frequency * time + rng.uniform(0.0, 2.0 * math.pi))
    if bench.crew:
        busy = (time > 0.2 * bench.seconds) & (time < 0.2 * bench.seconds + 600.0)
        x[busy] += bench.crew * np.sin(2.0 * math.pi * 1.4 * time[busy] + 3.0 * np.sin(0.7 * time[busy]))[:, None]
    x[:, 0] += bench.drift * (time / bench.seconds - 0.5)
    read = x * scale + bias
    if bench.largest:
        read[:, 1] = np.clip(read[:, 1], bias[1] - bench.largest, bias[1] + 1.7 * bench.noise[1])
    read = np.round(read * 1e6, 3)
    if bench.glitches:
        at = rng.choice(np.arange(100, n - 100), bench.glitches, replace=False)
        read[at, rng.integers(0, 3, bench.glitches)] += 4096.0
    kept = (time < bench.gap[0]) | (time >= bench.gap[1])
    clock = np.where(np.arange(n) < n // 2, time, time[n // 2] + (time - time[n // 2]) / bench.second_rate)
    stamps = BEGIN * SECOND + np.rint(clock * SECOND).astype(np.int64)
    names = [f"acc_{axis} [{bench.headed}]" for axis in AXES]
    channels = tuple(Channel(name, read[kept, i], bench.headed, axis=axis, quantity="acc")
                     for i, (name, axis) in enumerate(zip(names, AXES, strict=True)))  # fmt: skip
    made = Recording(channels, stamps[kept], 1.0 / bench.rate, None, "utc", "column", time_column="unix_s")
    return made, np.asarray(quiet[kept].mean(axis=0))


def _part(one: Recording, rows: slice) -> Recording:
    channels = tuple(Channel(c.name, c.data[rows], c.unit, axis=c.axis, quantity=c.quantity) for c in one.channels)
    times = None if one.time_ns is None else one.time_ns[rows]
    return Recording(channels, times, one.sample_interval, None, "utc", "column", time_column="unix_s")


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    unit = bench.headed
    channels = channel_entries({axis: f"acc_{axis} [{unit}]" for axis in AXES}, unit)
    files = {"record": RECORD} | ({"copy": COPY} if bench.duplicated else {})
    recordings = {name: {"sensor": "head", "file": file, "clock": {"column": "unix_s"}, "curve": CURVE,
                         "channels": channels} for name, file in files.items()}  # fmt: skip
    plan = {f"bias_{axis}": f"{1e6 * value:g} ug" for axis, value in zip(AXES, bench.bias, strict=True)}
    plan |= {"bias_u": f"{1e6 * bench.bias_u:g} ug", "cut_off": "5 Hz", "orbit": f"{bench.period / 60.0:g} min"}
    title, about = "Environment of a simulated station", "an accelerometer head in a station over one orbit"
    test = {"id": "environment", "procedure": "microgravity", "recordings": list(files), "plan": plan}
    return toml_text(
        {
            **campaign_head("station", "simulated accelerometer head", title, about),
            "standards": standard_tables(bench.standards),
            "sensors": {"head": {"kind": "accelerometer", "axes": list(AXES), "unit": "ug"}},
            "recordings": recordings,
            "tests": [test],
            "requirements": [
                {"id": "R1", "text": "levels below the curve", "quantity": "octave_band_rms_ratio", "limit": "1"},
                {"id": "R2", "text": "slow acceleration within 3 ug", "quantity": "quasi_steady_magnitude",
                 "limit": "3 ug"},
            ],
        }
    )  # fmt: skip


RIG = Rig("station", TITLE, on_bench(build, Bench()), FAULTS, tests=("microgravity",))
