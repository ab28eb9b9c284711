"""Rig of a unit of three accelerometers and three fine gyros on a turntable: two positions, a turn between them.

The unit stands on the turning earth, its z down but for small tilts. Attitude, biases and the errors of standards are
drawn. The turn is smooth and about the vertical; it is part of the record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.campaign_text import toml_text
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES, At
from ...core.recording import SECOND, Channel, Recording
from ...physics.attitude import from_roll_pitch_yaw
from ...physics.earth import earth_rate
from ..parts.campaign import campaign_head, channel_entries, drawn_error, drawn_errors, standard_tables
from ..protocol import Rig, on_bench
from ..twin import Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]
FILE = "recordings/imu.csv"
HOUR = math.radians(1.0) / 3600.0  # deg/h [rad/s]
MG = 9.80665e-3  # [m/s^2]
LATITUDE, GRAVITY = math.radians(36.6), 9.799
FAULTS: dict[str, Fault] = {
    "moved": Fault("the base tips by 0.2 deg in the second position", "base_moved", {"step": math.radians(0.2)},
                   expects="refused"),
    "people": Fault("people rock the base in the last third", "base_sways", {"sway": math.radians(0.002)}),
    "south": Fault("the latitude is stated with the wrong sign", "wrong_sense", {"north": -1.0}, expects="refused"),
    "reversed": Fault("all gyros read with the wrong sign", "wrong_sense", {"times": -1.0}, expects="refused"),
    "exchanged": Fault("y and z of the gyros are exchanged", "axes_disagree", {"order": (0, 2, 1)},
                       expects="refused"),
    "unit": Fault("rates in rad/s are read as deg/s", "wrong_unit", {"times": math.radians(1.0)}, expects="refused"),
    "force_unit": Fault("specific force in g is read as m/s2", "wrong_unit", {"force_times": 1.0 / 9.80665},
                        expects="refused"),
    "angle": Fault("the unit is turned by 160 deg, not 180", "turn_differs", {"turn": math.radians(160.0)},
                   expects="refused"),
    "clock": Fault("times in ms are read as s", "clock_unit", {"pace": 1000.0}, expects="refused"),
    "copied": Fault("the second position is a copy of the first", "too_short", {"copied": True}, expects="refused",
                    also=("copied_recording",)),
    "drift": Fault("the gyro x drifts by 3 deg/h", "bias_drifts", {"drift": 3.0 * HOUR}),
    "coarse": Fault("gyros of a coarse kind, 36 deg/h from position to position", "gyro_too_coarse",
                    {"redrawn": 36.0 * HOUR, "noise": 30.0 * HOUR}),
}  # fmt: skip
STANDARDS = {
    "sensor.scale_factor": Influence(1e-4, "1", certificate="data sheet of the unit", as_stated=(100.0, "ppm")),
    "sensor.misalignment": Influence(5e-5, "rad", certificate="data sheet of the unit", as_stated=(0.05, "mrad")),
    "turn.angle": Influence(math.radians(0.01), "rad", certificate="turntable", as_stated=(0.01, "deg")),
    "fixture.mounting": Influence(1e-4, "rad", certificate="drawing of the case", as_stated=(0.1, "mrad")),
    "site.latitude": Influence(math.radians(0.001), "rad", certificate="map", as_stated=(0.001, "deg")),
    "gravity.value": Influence(1e-5, "m/s^2", certificate="survey of the site", as_stated=(1.0, "mGal")),
}


@dataclass(frozen=True)
class Bench:
    """The record as it is made."""

    seconds: float = 600.0  # of each position
    moving: float = 20.0  # [s]
    rate: float = 10.0  # [Hz]
    turn: float = math.pi  # [rad]
    bias: float = 1.0 * HOUR  # standard deviation of what is drawn [rad/s]
    redrawn: float = 0.01 * HOUR  # the same from position to position [rad/s]
    noise: float = 0.3 * HOUR  # white, of the gyros [rad/s/sqrt(Hz)]
    acc_bias: float = 0.05 * MG  # standard deviation of what is drawn [m/s^2]
    acc_noise: float = 0.02 * MG  # white [m/s^2/sqrt(Hz)]
    standards: Mapping[str, Influence] = field(default_factory=lambda: STANDARDS)
    step: float = 0.0  # of the tilt of the base in the second position [rad]
    sway: float = 0.0  # amplitude of the base, at 0.4 Hz [rad]
    north: float = 1.0  # sign of the stated latitude
    times: float = 1.0  # readings of the gyros
    force_times: float = 1.0  # readings of the accelerometers
    order: tuple[int, int, int] = (0, 1, 2)  # columns of the gyros
    pace: float = 1.0  # of the clock
    drift: float = 0.0  # of the gyro x over the record [rad/s]
    copied: bool = False  # whether the second position is the first


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The record as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_errors, of_record = np.random.default_rng(seed).spawn(3)
    heading = float(of_unit.uniform(math.radians(20.0), math.radians(160.0)))
    roll, pitch = of_unit.uniform(-math.radians(1.0), math.radians(1.0), 2).tolist()
    bias, offset = of_unit.normal(0.0, bench.bias, 3), of_unit.normal(0.0, bench.acc_bias, 3)
    triads = ("accelerometer", "gyro")
    unknowns = {
        "sensor.scale_factor": [f"{one} {axis}" for one in triads for axis in AXES],
        "sensor.misalignment": [f"{one} {a}{b}" for one in triads for a in AXES for b in AXES if a != b],
        "turn.angle": ["2"],
        "fixture.mounting": list(AXES),
        "site.latitude": [""],
        "gravity.value": [""],
    }
    drawn = {f"{name}[{one}]" if one else name: drawn_error(bench.standards.get(name), of_errors)
             for name, each in unknowns.items() for one in each}  # fmt: skip
    turn = bench.turn - drawn["turn.angle[2]"]
    recording = _recording(bench, (roll, pitch, heading), turn, bias, offset, drawn, of_record)
    truth = [TrueValue("gyro_bias", axis, float(value), "rad/s") for axis, value in zip(AXES, bias, strict=True)]
    for number, own in enumerate((heading, heading + turn), 1):
        place = At("position", float(number), "")
        angles = {"roll": roll, "pitch": pitch, "heading": own}
        truth += [TrueValue(name, "", value, "rad", at=place) for name, value in angles.items()]
    latitude = LATITUDE - drawn["site.latitude"]
    truth.append(TrueValue("level_earth_rate", "", float(earth_rate(latitude)[0]), "rad/s"))
    truth.append(TrueValue("latitude_seen", "", latitude, "rad"))
    return Twin(campaign_text(bench), {FILE: recording}, tuple(truth), drawn,
                errors=drawn_errors(bench.standards, drawn))  # fmt: skip


def _recording(
    bench: Bench,
    angles: tuple[float, float, float],
    turn: float,
    bias: Array,
    offset: Array,
    drawn: Mapping[str, float],
    rng: np.random.Generator,
) -> Recording:
    count, moving = round(bench.seconds * bench.rate), round(bench.moving * bench.rate)
    n = 2 * count + moving
    time: Array = np.asarray(np.arange(n) / bench.rate, dtype=np.float64)
    phase = np.clip((np.arange(n) - count) / moving, 0.0, 1.0)
    turned = 0.5 * turn * (1.0 - np.cos(np.pi * phase))
    pace = 0.5 * turn * np.pi / bench.moving * np.sin(np.pi * phase)
    last = np.arange(n) >= n - count // 3
    tilt = np.where(last, bench.sway * np.sin(0.8 * np.pi * time), 0.0)
    tilt = tilt + np.where(np.arange(n) >= n - count // 2, bench.step, 0.0)
    rocking = np.where(last, bench.sway * 0.8 * np.pi * np.cos(0.8 * np.pi * time), 0.0)
    roll, pitch, heading = angles
    level = from_roll_pitch_yaw(roll, pitch, 0.0)  # body axes in those that turn with the heading
    earth = earth_rate(LATITUDE - drawn["site.latitude"])
    c, s = np.cos(heading + turned), np.sin(heading + turned)
    gravity = GRAVITY - drawn["gravity.value"]
    zero = np.zeros(n)
    # level axes that turn with the heading: rates of earth, turn and base (about the axis forward), specific force
    rates = np.column_stack([earth[0] * c + rocking, -earth[0] * s, earth[2] + pace]) @ level
    force = np.column_stack([zero, -gravity * np.sin(tilt), -gravity * np.cos(tilt)]) @ level
    x, y, z = (drawn[f"fixture.mounting[{axis}]"] for axis in AXES)
    case = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    read = []
    for name, values in (("accelerometer", force), ("gyro", rates)):
        matrix = np.eye(3) + np.diag([drawn[f"sensor.scale_factor[{name} {axis}]"] for axis in AXES])
        for i, a in enumerate(AXES):
            for j, b in enumerate(AXES):
                matrix[i, j] += drawn[f"sensor.misalignment[{name} {a}{b}]"] if i != j else 0.0
        read.append((values + values @ case.T) @ matrix.T)
    root = math.sqrt(0.5 * bench.rate)
    acc = (read[0] + offset + rng.normal(0.0, bench.acc_noise * root, (n, 3))) * bench.force_times
    gyro = read[1] + bias + rng.normal(0.0, bench.noise * root, (n, 3))
    for part in (slice(0, count), slice(n - count, n)):
        gyro[part] += rng.normal(0.0, bench.redrawn, 3)
    gyro[:, 0] += bench.drift * (np.arange(n) / n - 0.5)
    gyro = gyro[:, list(bench.order)] * bench.times
    if bench.copied:
        acc[n - count :], gyro[n - count :] = acc[:count], gyro[:count]
    columns = [Channel(f"acc_{axis} [m/s2]", np.round(acc[:, i], 7), "m/s^2", axis=axis, quantity="accelerometer")
               for i, axis in enumerate(AXES)]  # fmt: skip
    columns += [Channel(f"gyro_{axis} [deg/s]", np.round(np.degrees(gyro[:, i]), 8), "deg/s", axis=axis,
                        quantity="gyro") for i, axis in enumerate(AXES)]  # fmt: skip
    stamps = BEGIN * SECOND + np.rint(time * bench.pace * SECOND).astype(np.int64)
    return Recording(tuple(columns), stamps, bench.pace / bench.rate, None, "utc", "column", time_column="unix_s")


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    entries: dict[str, object] = {}
    for sensor, group, unit in (("accelerometers", "acc", "m/s2"), ("gyros", "gyro", "deg/s")):
        columns = {axis: f"{group}_{axis} [{unit}]" for axis in AXES}
        entries[group] = {"sensor": sensor, "file": FILE, "clock": {"column": "unix_s"},
                          "channels": channel_entries(columns, unit)}  # fmt: skip
    title, about = "Alignment of a simulated unit at rest", "two positions of a unit with fine gyros, turned by 180 deg"
    plan = {"turns": "180 deg", "accelerometer_bias_u": f"{bench.acc_bias / MG:g} mg"}
    return toml_text(
        {
            **campaign_head("alignment", "simulated inertial unit", title, about),
            "site": {"latitude": f"{bench.north * math.degrees(LATITUDE):g} deg", "gravity": f"{GRAVITY:g} m/s2"},
            "standards": standard_tables(bench.standards),
            "sensors": {
                "accelerometers": {"kind": "accelerometer", "axes": list(AXES), "unit": "m/s2"},
                "gyros": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"},
            },
            "recordings": entries,
            "tests": [{"id": "alignment", "procedure": "alignment", "recordings": ["acc", "gyro"], "plan": plan}],
            "requirements": [
                {"id": "R1", "text": "bias of the gyros within 6 deg/h", "quantity": "gyro_bias", "limit": "6 deg/h"}
            ],
        }
    )


RIG = Rig("alignment", TITLE, on_bench(build, Bench()), FAULTS, tests=("alignment",))
