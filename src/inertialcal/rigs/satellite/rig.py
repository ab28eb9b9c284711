"""Rig of a satellite in a circular orbit that turns slowly: gyro, magnetometer, position, a sample a second.

The body turns as three smooth angles say, and its rates follow from them in closed form. The field is that of the model
of the earth's field along the orbit, and an error that is the same all along. The gyro reads through a matrix that is
off by scale factors and misalignment, the magnetometer through a small rotation; both have a bias and white noise.

The sizes are those of a small satellite: 0.004 deg/s and 50 nT of noise a sample [1]_.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, section IV.F (noise of the gyro).
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
from ...physics.geomagnetic import field_along
from ...physics.orbit import circular_track
from ..parts.campaign import campaign_head, channel_entries, drawn_error, drawn_errors, standard_tables
from ..protocol import Rig, on_bench
from ..twin import Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]
FILE = "recordings/orbit.csv"
FAULTS: dict[str, Fault] = {
    "axes_exchanged": Fault("x and y of the magnetometer are exchanged", "axes_disagree", {"exchanged": True}),
    "drift": Fault("the bias drifts over the orbit", "bias_drifts", {"drift": 1e-4}),
    "late": Fault("the clock of the position is 20 s late", "clock_offset", {"late": 20.0}),
    "torquers": Fault("magnetorquers act", "disturbed", {"torquers": 5e-6}),
    "magnetometer_scale": Fault("the magnetometer reads 2 % too much in x", "scale_factor_seen", {"scale": 0.02}),
    "wrong_orbit": Fault("the position is that of half an orbit later", "no_fit", {"late": -2870.0}),
    "short": Fault("twenty minutes are too short", "too_short", {"seconds": 1200}),
}
STANDARDS = {
    "sensor.scale_factor": Influence(0.002, "1", certificate="data sheet of the unit"),
    "sensor.misalignment": Influence(1e-3, "rad", certificate="data sheet of the unit", as_stated=(1.0, "mrad")),
    "magnetometer.mounting": Influence(2e-3, "rad", certificate="survey of the satellite", as_stated=(2.0, "mrad")),
    "earth_field.uniform": Influence(20e-9, "T", certificate="quiet day", as_stated=(20.0, "nT")),
}


@dataclass(frozen=True)
class Bench:
    """The record as it is made."""

    seconds: int = 5740  # one orbit at 560 km
    altitude: float = 560e3  # [m]
    rate_noise: float = 7e-5  # of a sample [rad/s]
    field_noise: float = 50e-9  # of a sample [T]
    bias: float = 1e-3  # standard deviation of what is drawn [rad/s]
    magnetometer_bias: float = 3e-7  # the same [T]
    standards: Mapping[str, Influence] = field(default_factory=lambda: STANDARDS)
    exchanged: bool = False  # whether x and y of the magnetometer change places
    drift: float = 0.0  # of the bias of x over the record [rad/s]
    late: float = 0.0  # the position is that of so much earlier [s]
    torquers: float = 0.0  # field of magnetorquers, 8 s of each minute [T]
    scale: float = 0.0  # what the magnetometer reads too much in x (1)


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The record as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_errors, of_orbit, of_record = np.random.default_rng(seed).spawn(4)
    bias = of_unit.normal(0.0, bench.bias, 3)
    offset = of_unit.normal(0.0, bench.magnetometer_bias, 3)
    pairs = [f"{a}{b}" for a in AXES for b in AXES if a != b]
    unknowns = {"sensor.scale_factor": AXES, "sensor.misalignment": pairs, "magnetometer.mounting": AXES,
                "earth_field.uniform": AXES}  # fmt: skip
    drawn = {f"{name}[{one}]": drawn_error(bench.standards.get(name), of_errors)
             for name, each in unknowns.items() for one in each}  # fmt: skip
    recording = _recording(bench, bias, offset, drawn, of_orbit, of_record)
    truth = [TrueValue("bias", axis, float(value), "rad/s") for axis, value in zip(AXES, bias, strict=True)]
    truth += [TrueValue("magnetometer_bias", axis, float(value), "T") for axis, value in zip(AXES, offset, strict=True)]
    return Twin(
        campaign_text(bench), {FILE: recording}, tuple(truth), drawn, errors=drawn_errors(bench.standards, drawn)
    )


def _recording(
    bench: Bench,
    bias: Array,
    offset: Array,
    drawn: Mapping[str, float],
    of_orbit: np.random.Generator,
    rng: np.random.Generator,
) -> Recording:
    time = np.arange(bench.seconds, dtype=float)
    inclination = float(np.arccos(of_orbit.uniform(-0.3, 0.7)))
    node, start = of_orbit.uniform(0.0, 2.0 * math.pi, 2).tolist()
    position = circular_track(bench.altitude, inclination, time, node, start)
    uniform = np.array([drawn[f"earth_field.uniform[{axis}]"] for axis in AXES])
    reference = field_along(time, position, BEGIN * SECOND) + uniform
    attitude, rates = _motion(time, of_orbit)
    gyro = np.eye(3) + np.diag([drawn[f"sensor.scale_factor[{axis}]"] for axis in AXES])
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES):
            gyro[i, j] += drawn[f"sensor.misalignment[{a}{b}]"] if i != j else 0.0
    x, y, z = (drawn[f"magnetometer.mounting[{axis}]"] for axis in AXES)
    triad = np.eye(3) + np.array([[bench.scale, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    n = len(time)
    read = rates @ gyro.T + bias + np.outer((np.arange(n) / max(n - 1, 1) - 0.5) * bench.drift, [1.0, 0.0, 0.0])
    read = read + rng.normal(0.0, bench.rate_noise, (n, 3))
    field_read = np.einsum("kij,kj->ki", attitude, reference) @ triad.T + offset
    field_read = field_read + rng.normal(0.0, bench.field_noise, (n, 3))
    if bench.torquers:
        acting = np.arange(n) % 60 < 8
        field_read[acting] += rng.normal(0.0, bench.torquers, (int(acting.sum()), 3))
    if bench.exchanged:
        field_read = field_read[:, [1, 0, 2]]
    told = circular_track(bench.altitude, inclination, time - bench.late, node, start)
    channels = [Channel(f"gyro_{axis} [deg/s]", np.round(read[:, i] * factor("rad/s", "deg/s"), 6), "deg/s", axis=axis,
                        quantity="gyro") for i, axis in enumerate(AXES)]  # fmt: skip
    channels += [Channel(f"mag_{axis} [nT]", np.round(field_read[:, i] * 1e9, 2), "nT", axis=axis,
                         quantity="magnetometer") for i, axis in enumerate(AXES)]  # fmt: skip
    channels += [Channel(f"ecef_{axis} [km]", np.round(told[:, i] * 1e-3, 4), "km") for i, axis in enumerate(AXES)]
    stamps = BEGIN * SECOND + np.rint(time * SECOND).astype(np.int64)
    return Recording(tuple(channels), stamps, 1.0, None, "utc", "column", time_column="unix_s")


def _motion(time: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return body from axes that do not turn, (n, 3, 3), and rates in body axes, (n, 3) [rad/s], of 3-1-3 angles."""
    spin, slow = float(rng.uniform(3e-3, 6e-3)), float(rng.uniform(5e-4, 2e-3))
    sway, period = float(rng.uniform(0.2, 0.8)), float(rng.uniform(300.0, 900.0))
    phase = rng.uniform(0.0, 2.0 * math.pi, 3)
    pace = 2.0 * math.pi / period
    node, tilt, own = phase[0] + slow * time, 1.2 + sway * np.sin(pace * time + phase[1]), phase[2] + spin * time
    tilting = sway * pace * np.cos(pace * time + phase[1])
    rates = np.column_stack([
        slow * np.sin(tilt) * np.sin(own) + tilting * np.cos(own),
        slow * np.sin(tilt) * np.cos(own) - tilting * np.sin(own),
        slow * np.cos(tilt) + spin,
    ])  # fmt: skip
    one, zero = np.ones_like(time), np.zeros_like(time)

    def turn(angle: Array, about: int) -> Array:
        c, s = np.cos(angle), np.sin(angle)
        rows = {
            0: [[one, zero, zero], [zero, c, s], [zero, -s, c]],
            2: [[c, s, zero], [-s, c, zero], [zero, zero, one]],
        }
        return np.moveaxis(np.array(rows[about]), -1, 0)

    return turn(own, 2) @ turn(tilt, 0) @ turn(node, 2), rates


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    channels = channel_entries({axis: f"gyro_{axis} [deg/s]" for axis in AXES}, "deg/s")
    channels |= channel_entries({f"magnetometer_{axis}": f"mag_{axis} [nT]" for axis in AXES}, "nT")
    channels |= channel_entries({f"position_{axis}": f"ecef_{axis} [km]" for axis in AXES}, "km")
    recording = {"sensor": "suite", "file": FILE, "clock": {"column": "unix_s"}, "channels": channels}
    title, about = "Bias of a simulated gyro in orbit", "a gyro and a magnetometer over one orbit"
    return toml_text(
        {
            **campaign_head("satellite", "simulated rate gyro", title, about),
            "standards": standard_tables(bench.standards),
            "sensors": {"suite": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}},
            "recordings": {"orbit": recording},
            "tests": [{"id": "in_orbit", "procedure": "magnetometer_bias", "recordings": ["orbit"]}],
            "requirements": [{"id": "R1", "text": "bias within 0.3 deg/s", "quantity": "bias", "limit": "0.3 deg/s"}],
        }
    )


RIG = Rig("satellite", TITLE, on_bench(build, Bench()), FAULTS, tests=("magnetometer_bias",))
