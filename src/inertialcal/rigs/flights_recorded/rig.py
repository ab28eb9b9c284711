"""Rig of the same head with its recordings: each flight is a record in which it was turned by half a turn and back.

The flips are tests of the campaign, the shifted ground model is made of them. Readings are those of the sensors, before
the ground model, at one temperature in each flight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.campaign_text import Noted, toml_text
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.times import instant_text, read_instant
from ...files.models.model_json import dump_model
from ..flights.rig import GROUND, SERIAL, UG, Flown, fly
from ..flights.rig import Bench as Flights
from ..parts.campaign import campaign_head, channel_entries, drawn_errors, standard_tables
from ..parts.head_turn import course, felt
from ..parts.noise import flicker, white
from ..protocol import Rig, on_bench
from ..twin import Extra, Fault, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

TURNS, TURN, LENGTH = (1800.0, 3600.0), 10.0, 5400.0  # [s]
WINDOWS = ((100.0, 1780.0, 0), (1830.0, 3580.0, 180), (3630.0, 5300.0, 0))  # [s], [deg]
FAULTS: dict[str, Fault] = {
    "no_thermometer": Fault("one flight was recorded without its temperature", "missing_temperature",
                            {"no_thermometer": True}, "refused"),
    "same_record": Fault("one flight has the readings of another", "duplicate_recording", {"copied": True}, "refused"),
    "older": Fault("the ground model is younger than the first flight", "older_than_ground",
                   {"ground_date": "2020-01-01"}, "refused"),
    "knock": Fault("the head is knocked before the last flight", "prediction_missed", {"knock": 120.0}),
}  # fmt: skip


@dataclass(frozen=True)
class Bench(Flights):
    """The flights, and how they are recorded; accelerations in ug."""

    flips: int = 1  # in each flight
    rate: float = 1.0  # [Hz]
    white: float = 2.0  # [ug/sqrt(Hz)]
    flicker: float = 0.02  # of the square root of S f [ug]
    ambient: float = 4.0  # size of the ambient acceleration
    no_thermometer: bool = False


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The flights as they are flown.
    seed : int
        Of all draws.
    """
    made = fly(replace(bench, flips=1), seed)
    rng = np.random.default_rng([seed, 1])
    flights = list(dict.fromkeys(row.flight for row in made.rows))
    files = {f"recordings/flight{name}.csv": _record(bench, made, name, rng) for name in flights}
    if bench.copied:
        first, second = (files[f"recordings/flight{number}.csv"] for number in (1, 2))
        files["recordings/flight2.csv"] = replace(first, time_ns=second.time_ns)
    extras = {GROUND: Extra(made.ground, dump_model(made.ground))}
    drawn = drawn_errors(bench.standards, made.errors)
    return Twin(campaign_text(bench, made, files), files, made.truth, made.errors, extras, drawn)


def _record(bench: Bench, made: Flown, flight: str, rng: np.random.Generator) -> Recording:
    """Return the recording of a flight: readings of the sensors [ug] and one temperature [degC]."""
    own = {row.axis: row for row in made.rows if row.flight == flight}
    seconds = np.arange(0.0, LENGTH, 1.0 / bench.rate)
    angle = course(seconds, np.array(TURNS), np.array([np.pi, 0.0]), TURN).angle
    ambient = rng.choice([-1.0, 1.0], (1, 3)) * rng.uniform(0.5, 1.5, (1, 3)) * bench.ambient
    head = felt(ambient, angle, np.array([1.0, 0.0, 0.0]))
    bias = np.array([own[axis].true if axis in own else 0.0 for axis in AXES])
    bias[0] = float(np.linalg.solve(made.ground.matrix[0], made.ground.bias)[0] / UG)
    gain = np.array([1.0 + made.errors.get(f"sensor.scale_factor[{axis}]", 0.0) for axis in AXES])
    zero = np.array([made.errors.get(f"converter.zero[{axis}]", 0.0) / UG for axis in AXES])
    read = ((head + bias) * gain + zero) @ made.ground.matrix[0].T
    read += white(bench.white * np.sqrt(0.5 * bench.rate), len(seconds), 3, rng)
    read += flicker(bench.flicker**2, len(seconds), 3, rng)
    warm = own["y"].temperature + rng.normal(0.0, 0.01, len(seconds))
    channels = [Channel(axis, read[:, i], "ug") for i, axis in enumerate(AXES)]
    if not (bench.no_thermometer and flight == "2"):
        channels.append(Channel("temperature", warm, "degC"))
    begin = read_instant(f"{own['y'].date}T12:00:00Z")
    stamps = begin + np.rint(seconds * SECOND).astype(np.int64)
    return Recording(tuple(channels), stamps, 1.0 / bench.rate, epoch="utc")


def campaign_text(bench: Bench, made: Flown, files: dict[str, Recording]) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    entries: dict[str, object] = {}
    for number, (file, one) in enumerate(files.items(), 1):
        begin = read_instant(f"{made.rows[2 * (number - 1)].date}T12:00:00Z")
        positions = [{"start": instant_text(begin + round(a * SECOND)), "stop": instant_text(begin + round(b * SECOND)),
                      "angle": f"{angle} deg"} for a, b, angle in WINDOWS]  # fmt: skip
        warm = channel_entries({"temperature": "temperature"} if "temperature" in one.names else {}, "degC")
        entries[f"flight{number}"] = {
            "sensor": "head", "file": file, "clock": {"column": "unix_s"}, "positions": positions,
            "channels": channel_entries({axis: axis for axis in AXES}, "ug") | warm,
        }  # fmt: skip
    names = list(entries)
    flips = [{"id": f"flip{i}", "procedure": "flip", "recordings": [name], "plan": {"axis": "x"}}
             for i, name in enumerate(names, 1)]  # fmt: skip
    plan = {"ground_date": bench.ground_date} | (
        {"shift_slope": f"{bench.said_slope:g} ug/degC"} if bench.said_slope else {}
    )
    shifted = {"procedure": "shifted_model", "plan": plan}
    before = [str(one["id"]) for one in flips]
    tests = [
        *flips,
        Noted(
            {"id": "shifted", **shifted, "recordings": names[:-1], "after": before[:-1]},
            above="Made of what the flips find",
        ),
        Noted(
            {"id": "later", **shifted, "recordings": names[-1:], "after": before[-1:], "use": "hold_out"},
            above="The last flight judges",
        ),
    ]
    title = "Ground model of a simulated head, shifted by flips that were recorded in several flights"
    head = campaign_head("flights_recorded", "simulated triaxial sensor head", title, "one head flies several times")
    return toml_text(
        {
            **head | {"item": {"maker": "inertialcal", "part": "head", "serial": SERIAL}},
            "standards": standard_tables(bench.standards, {"m/s^2": "ug"}),
            "sensors": {"head": {"kind": "accelerometer", "axes": list(AXES), "unit": "ug",
                                 "chain": {"kind": "none", "model": Noted(GROUND, "the ground model")}}},
            "recordings": entries,
            "tests": tests,
            "requirements": [{"id": "R1", "text": "drift below 20 ug a year", "quantity": "bias_drift",
                              "limit": "20 ug/year", "tests": ["shifted"]}],
        }
    )  # fmt: skip


RIG = Rig("flights_recorded", TITLE, on_bench(build, Bench()), FAULTS, tests=("shifted_model",))
