"""Rig of a satellite with four accelerometer heads: two are calibrated by flips, one lies between, one off their line.

The satellite keeps the local vertical but for small turns, sums of sines, that a gyro reads. Each head feels the
acceleration of the middle (drag, vibration, a manoeuvre), the turns by its place, and the gradient of gravity; it reads
that through its true orientation, with bias, white noise and noise with a memory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.campaign_text import toml_text
from ...core.estimate import Array
from ...core.key import AXES, At
from ...core.recording import SECOND, Channel, Recording
from ...physics.motion.body import parse_body
from ...physics.motion.rigid import centripetal, cross, gradient
from ...physics.orbit import orbital_rate
from ..parts.campaign import campaign_head, channel_entries
from ..protocol import Rig, on_bench
from ..twin import Extra, Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build"]

BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]
UG = 9.80665e-6  # [m/s^2]
BODY = "body.toml"
UP = np.array([1.0, 0.0, 0.0])  # vertical in the body
NORMAL = np.array([0.0, 1.0, 0.0])  # of the orbit
PLACES = {"tsh1": (0.0, -1.0, 0.0), "tsh2": (0.0, 1.0, 0.0), "tsh3": (0.0, 0.0, 0.0), "tsh4": (0.6, 0.5, 0.4)}  # [m]
HEADS = tuple(PLACES)
TURNS = {"tsh4": ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))}  # head from body; else as the body
KNOWN = ("tsh1", "tsh2")
FAULTS: dict[str, Fault] = {
    "exchanged": Fault("x and y of a head are exchanged", "wrong_orientation", {"exchanged": "tsh3"},
                       expects="refused"),
    "two_bodies": Fault("a head stands on another body", "not_one_body", {"elsewhere": "tsh3"}, expects="refused"),
    "clock": Fault("the clock of a head is 4 s ahead of what is stated", "clock_offset", {"ahead": 4.0},
                   expects="refused"),
    "copied": Fault("a recording is that of another head", "duplicate_recording", {"copied": "tsh3"},
                    expects="refused", also=("copied_recording",)),
    "unit": Fault("a head in milli-g is read as micro-g", "wrong_unit", {"times": 1e-3}, expects="refused"),
    "moved": Fault("a head is 0.4 m from where it is said to be", "wrong_position", {"moved": 0.4}),
    "drifting": Fault("a head drifts by 5 ug", "drift", {"drift": 5.0 * UG}),
    "glitches": Fault("a head has glitches", "glitch", {"glitch": 3000.0 * UG}),
    "saturated": Fault("a head reaches the end of its range", "saturated", {"range": 190.0 * UG}),
    "tilted": Fault("a head is turned by 3 deg", "orientation_differs", {"tilted": math.radians(3.0)}),
}  # fmt: skip


@dataclass(frozen=True)
class Bench:
    """The record as it is made."""

    seconds: int = 3600
    altitude: float = 400e3  # [m]
    vibration: float = 120.0 * UG  # standard deviation of an axis [m/s^2]
    turning: float = 3e-4  # of a rate about an axis [rad/s]
    noise: float = 1.5 * UG  # of a sample, white [m/s^2]
    slow: float = 0.2 * UG  # of a part with a memory of 60 s [m/s^2]
    bias: float = 60.0 * UG  # standard deviation of what is drawn [m/s^2]
    bias_u: float = 0.1 * UG  # of the flips [m/s^2]
    position_u: float = 1e-3  # [m]
    orientation_u: float = 1e-3  # [rad]
    clock_u: float = 0.2  # [s]
    exchanged: str = ""  # head whose x and y change places
    elsewhere: str = ""  # head on another body
    copied: str = ""  # head whose file is that of tsh1
    ahead: float = 0.0  # clock of tsh3 [s]
    times: float = 1.0  # readings of tsh3
    moved: float = 0.0  # tsh4, along z [m]
    drift: float = 0.0  # of tsh4 in x over the record [m/s^2]
    glitch: float = 0.0  # of tsh3 [m/s^2]
    range: float = 0.0  # of tsh3; 0 for none [m/s^2]
    tilted: float = 0.0  # tsh3 about its x [rad]
    names: Mapping[str, tuple[float, float, float]] = field(default_factory=lambda: PLACES)


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The record as it is made.
    seed : int
        Of all draws.
    """
    of_motion, of_other, of_gyro, *of_heads = np.random.default_rng(seed).spawn(3 + len(HEADS))
    time: Array = np.asarray(np.arange(bench.seconds) + 0.5, dtype=np.float64)
    orbit = float(orbital_rate(bench.altitude).values[0])
    motion, other = _motion(bench, of_motion, orbit), _motion(bench, of_other, orbit)
    read, bias, said = {}, {}, {}
    for name, rng in zip(HEADS, of_heads, strict=True):
        read[name], bias[name], said[name] = _read(bench, name, time, other if name == bench.elsewhere else motion, rng)
    if bench.copied:
        read[bench.copied] = read[HEADS[0]]
    stamps = BEGIN * SECOND + np.rint(time * SECOND).astype(np.int64)
    recordings = {
        f"recordings/{name}.csv": Recording(
            tuple(Channel(f"a{axis} [ug]", np.round(one[:, i] / UG, 4), "ug", axis=axis, quantity="accelerometer")
                  for i, axis in enumerate(AXES)),
            stamps, 1.0, None, "utc", "column", time_column="unix_s",
        )
        for name, one in read.items()
    }  # fmt: skip
    rates = motion(time)[1] + of_gyro.normal(0.0, 2e-6, (len(time), 3))
    recordings["recordings/gyro.csv"] = Recording(
        tuple(Channel(f"w{axis} [rad/s]", np.round(rates[:, i], 10), "rad/s", axis=axis, quantity="gyro")
              for i, axis in enumerate(AXES)),
        stamps, 1.0, None, "utc", "column", time_column="unix_s",
    )  # fmt: skip
    text = body_text(bench, said)
    truth, number = [], 0
    for number, name in enumerate(HEADS, 1):
        if name not in KNOWN:
            place = At("head", float(number), "")
            truth += [TrueValue("bias", axis, float(bias[name][i]), "m/s^2", at=place) for i, axis in enumerate(AXES)]
    extras = {BODY: Extra(parse_body(text.encode(), BODY), text)}
    return Twin(campaign_text(), recordings, tuple(truth), {name: one.tolist() for name, one in bias.items()}, extras)


def _motion(bench: Bench, rng: np.random.Generator, orbit: float):  # type: ignore[no-untyped-def]
    """Return a function of time that gives acceleration, rates and angular acceleration of a body, (n, 3) each."""

    def sines(count: int, low: float, high: float, size: float):  # type: ignore[no-untyped-def]
        pace = 2.0 * math.pi * np.exp(rng.uniform(math.log(low), math.log(high), (count, 3)))
        phase, each = rng.uniform(0.0, 2.0 * math.pi, (count, 3)), size * math.sqrt(2.0 / count)

        def at(time: Array) -> tuple[Array, Array]:
            angle = time[:, None, None] * pace + phase
            return each * np.sin(angle).sum(axis=1), each * (pace * np.cos(angle)).sum(axis=1)

        return at

    shake, turn = sines(24, 0.003, 0.1, bench.vibration), sines(10, 5e-4, 0.02, bench.turning)
    drag = sines(1, orbit / 6.3, orbit / 6.28, 0.2 * UG)

    def at(time: Array) -> tuple[Array, Array, Array]:
        turned, speeding = turn(time)
        middle = shake(time)[0] + drag(time)[0] + np.array([0.0, 0.0, -0.3 * UG])
        return middle, turned - orbit * NORMAL, speeding

    return at


def _read(bench: Bench, name: str, time: Array, motion, rng: np.random.Generator):  # type: ignore[no-untyped-def]
    """Return what a head reads (n, 3), its bias, and that which flips gave [m/s^2]."""
    third = name == HEADS[2]
    place = np.array(PLACES[name]) + rng.normal(0.0, bench.position_u, 3)
    place = place + (bench.moved * np.array([0.0, 0.0, 1.0]) if name == HEADS[3] else 0.0)
    late = rng.normal(0.0, 0.5 * bench.clock_u) + (bench.ahead if third else 0.0)
    orbit = float(orbital_rate(bench.altitude).values[0])
    felt = np.zeros((len(time), 3))
    for part in (-1.0 / 3.0, 0.0, 1.0 / 3.0):
        middle, rates, speeding = motion(time - late + part)
        gamma = cross(speeding) + centripetal(rates[:, :, None] * rates[:, None, :]) - gradient(orbit, UP)
        felt += (middle + gamma @ place) / 3.0
    small = rng.normal(0.0, bench.orientation_u, 3) + (np.array([bench.tilted, 0.0, 0.0]) if third else 0.0)
    turn = np.array(TURNS.get(name, np.eye(3)), dtype=float)
    read = felt @ turn.T @ (np.eye(3) - cross(small)).T
    bias = rng.normal(0.0, bench.bias, 3)
    said = bias + rng.normal(0.0, bench.bias_u, 3)
    keep = math.exp(-1.0 / 60.0)
    slow = np.empty((len(time), 3))
    level = rng.normal(0.0, bench.slow, 3)
    steps = rng.normal(0.0, bench.slow * math.sqrt(1.0 - keep**2), (len(time), 3))
    for k in range(len(time)):
        slow[k] = level
        level = keep * level + steps[k]
    read = read + bias + slow + rng.normal(0.0, bench.noise, (len(time), 3))
    if name == HEADS[3] and bench.drift:
        read[:, 0] += bench.drift * (np.arange(len(time)) / len(time) - 0.5)
    if third:
        read = read * bench.times
        if bench.glitch:
            read[rng.integers(0, len(time), 6), 1] += bench.glitch
        if bench.range:
            read = np.clip(read, -bench.range, bench.range)
    if name == bench.exchanged:
        read = read[:, [1, 0, 2]]
    return read, bias, said


def body_text(bench: Bench, said: Mapping[str, Array]) -> str:
    """Return the file of the body."""
    heads: dict[str, object] = {}
    for name, place in PLACES.items():
        one: dict[str, object] = {
            "position": [f"{x:g} m" for x in place], "position_u": f"{bench.position_u:g} m",
            "orientation_u": f"{bench.orientation_u:g} rad", "clock": "0 s", "clock_u": f"{bench.clock_u:g} s",
        }  # fmt: skip
        if name in TURNS:
            one["orientation"] = [list(row) for row in TURNS[name]]
        if name in KNOWN:
            one |= {"bias": [f"{x / UG:.4f} ug" for x in said[name]], "bias_u": [f"{bench.bias_u / UG:g} ug"] * 3}
        heads[name] = one
    orbit = {"altitude": f"{bench.altitude / 1e3:g} km", "vertical": UP.tolist(), "vertical_u": "1 deg"}
    return toml_text({"heads": heads, "motion": orbit, "gyro": {"bias_u": "0.00001 rad/s"}})


def campaign_text() -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    channels = channel_entries({axis: f"a{axis} [ug]" for axis in AXES}, "ug")
    recordings: dict[str, object] = {
        name: {"sensor": "heads", "file": f"recordings/{name}.csv", "clock": {"column": "unix_s"},
               "head": {"file": BODY}, "channels": channels}
        for name in HEADS
    }  # fmt: skip
    rates = channel_entries({axis: f"w{axis} [rad/s]" for axis in AXES}, "rad/s")
    recordings["gyro"] = {"sensor": "gyro", "file": "recordings/gyro.csv", "clock": {"column": "unix_s"},
                          "channels": rates}  # fmt: skip
    title, about = "Bias of simulated heads by others", "two calibrated heads calibrate two others on one satellite"
    return toml_text(
        {
            **campaign_head("heads", "simulated accelerometer heads", title, about),
            "sensors": {
                "heads": {"kind": "accelerometer", "axes": list(AXES), "unit": "ug"},
                "gyro": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"},
            },
            "recordings": recordings,
            "tests": [{"id": "third_heads", "procedure": "heads", "recordings": [*HEADS, "gyro"]}],
            "requirements": [{"id": "R1", "text": "bias within 300 ug", "quantity": "bias", "limit": "300 ug"}],
        }
    )


RIG = Rig("heads", TITLE, on_bench(build, Bench()), FAULTS, tests=("heads",))
