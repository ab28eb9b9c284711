"""Rig of a gyro that stands still: what its logger saves of its noise, with dead time between the averages.

Each axis has white noise of the rate and one slow term: x none, y a random walk of the rate, z flicker. The sizes
follow the flight unit of [1]_: averages of 1 s saved every 2 s with about 0.004 deg/s of scatter, some not saved. What
is saved is off by the scale factor, one unknown error within its stated uncertainty for all axes.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, section IV.F.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...core.campaign_text import Noted, toml_text
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ...sensors.noise.simulate import simulate
from ...sensors.noise.terms import BiasInstability, RandomWalk, RateRandomWalk, Sinusoid, quantity_name
from ..parts.campaign import campaign_head, channel_entries, drawn_error, drawn_errors, standard_tables
from ..protocol import Rig, on_bench
from ..twin import Drawn, Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

Drift: TypeAlias = RandomWalk | RateRandomWalk | BiasInstability
BEGIN = 1_272_467_400  # 2010-04-28 15:10:00 UTC [s]
APART = 86_400  # from record to record [s]
SPREAD = 0.2  # of the sizes, from unit to unit (1)
STEP = 1e-5  # of what is saved [deg/s]
KNOCK = 0.05  # amplitude of a disturbance [rad/s]
WARMING = 2_000.0  # time constant of a warm-up [s]
FAULTS: dict[str, Fault] = {
    "knocked": Fault("the bench is knocked", "disturbed", {"knocked": True}),
    "warming": Fault("the unit is still warming up", "warm_up", {"warming": 3e-4}),
    "humming": Fault("a fan runs next to the bench", "lines", {"humming": 5e-5}),
    "stuck": Fault("the y channel is stuck", "constant", {"stuck": "y"}),
    "too_short": Fault("40 s is too short for a noise test", "too_short", {"samples": 20, "skipped": 0.0}),
}
SCALE = Influence(0.002, "1", certificate="data sheet of the unit")


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The record as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, of_records = np.random.default_rng(seed).spawn(3)
    terms = _draw_unit(bench, of_unit)
    error = drawn_error(bench.scale_factor, of_bench)
    bias = of_unit.normal(0.0, 1e-3, len(AXES))
    recordings = {
        recording_file(number): _recording(bench, terms, bias, error, number, of_records)
        for number in range(1, bench.records + 1)
    }
    drawn: Drawn = {"scale_factor_error": error, "bias": bias.tolist()}
    errors = drawn_errors({"sensor.scale_factor": bench.scale_factor}, {"sensor.scale_factor": -error})
    return Twin(campaign_text(bench), recordings, _true_values(terms), drawn, errors=errors)


def _draw_unit(bench: Bench, rng: np.random.Generator) -> dict[str, tuple[Drift, ...]]:
    """Return the terms of each axis, drawn about those of the bench."""
    size = 1.0 + SPREAD * (2.0 * rng.random(5) - 1.0)
    return {
        "x": (RandomWalk(bench.walk * size[0]),),
        "y": (RandomWalk(bench.walk * size[1]), RateRandomWalk(bench.rate_walk * size[2])),
        "z": (RandomWalk(bench.walk * size[3]), BiasInstability(bench.flicker * size[4])),
    }


def _true_values(terms: Mapping[str, tuple[Drift, ...]]) -> tuple[TrueValue, ...]:
    """Return the sizes as the results name them, SI."""
    units = {"random_walk": "rad/sqrt(s)", "rate_random_walk": "rad/s/sqrt(s)", "bias_instability": "rad/s"}
    return tuple(
        TrueValue(quantity_name(term.name, "coefficient", "gyro"), axis, float(term.coefficient), units[term.name])
        for axis, own in terms.items()
        for term in own
    )


def _recording(
    bench: Bench,
    terms: Mapping[str, tuple[Drift, ...]],
    bias: Array,
    error: float,
    number: int,
    rng: np.random.Generator,
) -> Recording:
    """Return one record, as the logger saves it [deg/s]."""
    n = bench.samples
    time = np.arange(n) * bench.interval
    common = bench.warming * np.exp(-time / WARMING) + (_knock(n) if bench.knocked else 0.0)
    kept = np.flatnonzero(rng.random(n) >= bench.skipped)
    kept = np.union1d(kept, [0, n - 1])
    channels = []
    for axis, level in zip(AXES, bias.tolist(), strict=True):
        own = (*terms[axis], Sinusoid(bench.humming, 0.11)) if bench.humming and axis == "x" else terms[axis]
        rate = simulate(own, n, bench.interval, rng, bench.averaging) + level + common
        saved = np.round((1.0 + error) * rate * factor("rad/s", "deg/s") / STEP) * STEP
        saved = np.full(n, saved[0]) if axis == bench.stuck else saved
        channels.append(Channel(axis, np.round(saved[kept], 6), "deg/s", "campaign", axis, "gyro"))
    stamps = (BEGIN + number * APART) * SECOND + np.rint((time + bench.averaging) * SECOND).astype(np.int64)
    return Recording(
        tuple(channels), stamps[kept], bench.interval, bench.averaging, "utc", "column", time_column="unix_s"
    )  # fmt: skip


def _knock(n: int) -> Array:
    """Return a swing of 60 averages in the middle of the record [rad/s]."""
    swing = np.zeros(n)
    middle = n // 2
    swing[middle : middle + 60] = KNOCK * np.sin(np.arange(60) / 3.0) * np.exp(-np.arange(60) / 20.0)
    return swing


@dataclass(frozen=True)
class Bench:
    """The record as it is made."""

    # records, and averages in each
    records: int = 2
    samples: int = 12_000
    # interval and length of the averages [s]
    interval: float = 2.0
    averaging: float = 1.0
    # nominal sizes of the drawn terms: N [rad/sqrt(s)], K [rad/s/sqrt(s)], B [rad/s]
    walk: float = 7e-5
    rate_walk: float = 8e-7
    flicker: float = 3e-5
    skipped: float = 0.001  # fraction of averages that are not saved (1)
    scale_factor: Influence = SCALE  # uncertainty of the scale factor
    knocked: bool = False  # whether the bench is knocked
    warming: float = 0.0  # bias change during warm-up [rad/s]
    humming: float = 0.0  # amplitude of a spectral line in x [rad/s]
    stuck: str = ""  # axis with a stuck channel; empty for none


def recording_name(number: int) -> str:
    """Return the name of a record in the campaign."""
    return f"still{number}"


def recording_file(number: int) -> str:
    """Return the file of a record, in the campaign folder."""
    return f"recordings/{recording_name(number)}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title, about = "Noise of a simulated three-axis gyro", "a three-axis rate gyro that stands still"
    times = {"interval": f"{bench.interval:g} s", "averaging": f"{bench.averaging:g} s"}
    recordings = {
        recording_name(number): {
            "sensor": "suite",
            "file": recording_file(number),
            "clock": {"column": "unix_s", "stamp": "end", **times},
            "channels": channel_entries({axis: axis for axis in AXES}, "deg/s"),
        }
        for number in range(1, bench.records + 1)
    }
    saved = f"Each average lasts {bench.averaging:g} s; one is saved every {bench.interval:g} s."
    limits = {"angle_random_walk": "0.36 deg/sqrt(h)", "bias_instability": "20 deg/h"}
    requirements = [
        {"id": f"R{i}", "text": f"{quantity.replace('_', ' ')} at most {limit}", "quantity": quantity, "upper": limit}
        for i, (quantity, limit) in enumerate(limits.items(), 1)
    ]
    return toml_text(
        {
            **campaign_head("still_gyro", "simulated rate gyro", title, about),
            "standards": standard_tables({"sensor.scale_factor": bench.scale_factor}),
            "sensors": {"suite": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}},
            "recordings": Noted(recordings, above=saved),
            "tests": [{"id": "noise", "procedure": "static_noise", "recordings": list(recordings)}],
            "requirements": requirements,
        }
    )


RIG = Rig("still_gyro", TITLE, on_bench(build, Bench()), FAULTS, tests=("static_noise",))
