"""campaign.toml of the simulated flip, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

import numpy as np

from ...core.campaign_text import Noted, toml_text
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND
from ..parts.campaign import Content, by_axis, campaign_head, channel_entries, standard_tables
from .setup import (
    CODES,
    GAINS,
    REFERENCE_TEMPERATURE,
    SCALE_FACTOR_V_PER_G,
    THERMOMETER_V_PER_DEGC,
    UG,
    Bench,
    Drawing,
    Head,
    chain,
)

RECORDING = "flip"
FILE = f"recordings/{RECORDING}.csv"
BEGIN = 824_817_600  # 1996-02-20 12:00:00 UTC [s]
EACH_ERROR = "Each standard has one unknown error for the whole campaign, or one for each axis."

Stated = tuple[float, float, float]  # start and stop [s], angle [deg]


def windows(bench: Bench) -> tuple[Stated, ...]:
    """Return the windows before and after each turn with their positions, without those that are not recorded.

    The window before a turn ends where the turn begins; that after it begins where it ends, with the settling to be
    left out. Between two turns that are too near for both there is one.
    """
    ends = (*bench.turn_starts, bench.duration)
    begins = (0.0, *(start + bench.turn_time for start in bench.turn_starts))
    angles = (0.0, *bench.positions_deg)
    found: list[Stated] = []
    last = len(angles) - 1
    for i, (begin, end, angle) in enumerate(zip(begins, ends, angles, strict=True)):
        whole = bench.settle + bench.window
        early, late = (begin, min(begin + whole, end)), (max(end - whole, begin), end)
        if 0 < i < last and early[1] > late[0]:
            found.append((begin, end, angle))
            continue
        found += [(*early, angle)] if i > 0 else []
        found += [(*late, angle)] if i < last else []
    lost = bench.lost or (np.inf, np.inf)
    return tuple(one for one in found if one[1] <= lost[0] or one[0] >= lost[1])


def campaign_text(bench: Bench, head: Head, model: Drawing | None = None) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth.

    Parameters
    ----------
    bench, head : Bench, Head
        As they are drawn.
    model : Drawing, optional
        What the engineer knows of the head, from the ground.
    """
    about = "a triaxial head turned by half a turn and back, in orbit"
    title = "In-orbit flip of a simulated triaxial sensor head"
    plan: Content = {"axis": "x", "settle": f"{bench.settle:g} s"}
    test: Content = {"procedure": "flip", "recordings": [RECORDING]}
    tests: list[object] = [{"id": "flip", **test, "plan": Noted(plan, "x: axis of the turn")}]
    if model is not None:
        corrected = {"id": "corrected", **test, "plan": plan | {"corrected": True}}
        why = "The same, with the bias of the ground model subtracted: what remains is the error of that model"
        tests.append(Noted(corrected, above=why))
    units = {"m/s^2": "ug", "rad": "deg"}
    requirement = {
        "id": "R1",
        "text": "ambient acceleration below 50 ug",
        "quantity": "ambient_acceleration",
        "limit": "50 ug",
    }
    return toml_text(
        {
            **campaign_head("sams_tsh", "simulated triaxial sensor head", title, about),
            "standards": Noted(standard_tables(bench.standards, units), above=EACH_ERROR),
            "sensors": {
                "head": {
                    "kind": "accelerometer",
                    "axes": list(AXES),
                    "unit": "ug",
                    "chain": _chain(bench, head, model),
                }
            },
            "recordings": {RECORDING: _entry(bench)},
            "tests": tests,
            "requirements": [requirement],
        }
    )


def _chain(bench: Bench, head: Head, model: Drawing | None) -> Noted:
    """Return the signal chain, with the ground model where there is one."""
    gain = dict(zip(AXES, map(int, bench.gains), strict=True))
    scale_factor = by_axis([f"{value:g} V/g" for value in SCALE_FACTOR_V_PER_G])
    ground: Content = {}
    if model is not None:
        ground = {"order": bench.ground, "ground": _ground_model(head, model)}
    if bench.saved != "count":
        said: Content = {} if model is None else {"gain": gain, "scale_factor": scale_factor}
        return Noted({"kind": "none", **said, **ground})
    content: Content = {
        "kind": "adc",
        "lsb": "10 V / 65536",
        "counts": list(CODES),
        "gain": gain,
        "zero": by_axis([_microvolts(value) for value in np.asarray(chain(bench, head).zero)]),
        "scale_factor": scale_factor,
        "thermometer": {"slope": f"{THERMOMETER_V_PER_DEGC:g} V/degC", "voltage": "0 V", "temperature": "0 degC"},
    }
    hold = f"scale factors hold at {REFERENCE_TEMPERATURE:g} degC"
    return Noted(content | ground, above=f"The zero of the electronics is that of a shorted input; {hold}.")


def _ground_model(head: Head, model: Drawing) -> Content:
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    return {
        "reference_temperature": f"{REFERENCE_TEMPERATURE:g} degC",
        "source": "simulated: made on the ground",
        "misalignment": {f"{AXES[i]}{AXES[j]}": _polynomial(model.cross[:, i, j], "rad") for i, j in pairs},
        "gains": {
            f"{gain:g}": {
                "bias": {axis: _polynomial(model.bias[:, i] / UG, "ug") for i, axis in enumerate(AXES)},
                "scale_factor": {axis: _polynomial(model.scale[at, :, i], "V/g") for i, axis in enumerate(AXES)},
                "zero": by_axis([_microvolts(value) for value in head.zero[at]]),
            }
            for at, gain in enumerate(GAINS)
        },
    }


def _microvolts(volts: float) -> str:
    return f"{1e6 * volts:.6g} uV"


def _polynomial(coefficients: Array, unit: str) -> list[str]:
    """Return coefficients in powers of the temperature, from the constant on."""
    units = [unit, *(f"{unit}/degC" + (f"^{power}" if power > 1 else "") for power in range(1, len(coefficients)))]
    return [f"{value:.12g} {one}" for value, one in zip(coefficients, units, strict=True)]


def _entry(bench: Bench) -> Content:
    """Return the entry of the recording, with the windows before and after each turn."""
    warm = "count" if bench.saved == "count" else "degC"
    channels = channel_entries({axis: axis for axis in AXES}, bench.said)
    channels |= channel_entries({f"temperature_{axis}": f"temperature_{axis}" for axis in AXES}, warm)
    if bench.gain_recorded:
        channels |= channel_entries({f"gain_{axis}": f"gain_{axis}" for axis in AXES}, "1")
    positions = [
        {"start": instant(start), "stop": instant(stop), "angle": f"{angle:g} deg", "flip": "1"}
        for start, stop, angle in windows(bench)
    ]
    return {
        "sensor": "head",
        "file": FILE,
        "clock": {"column": "unix_s", "stamp": "middle", "interval": f"{1.0 / bench.rate:g} s"},
        "positions": Noted(positions, "the windows before and after each turn"),
        "channels": channels,
    }


def instant(seconds: float) -> str:
    """Return a time of the record as UTC."""
    stamp = np.datetime64(round((BEGIN + seconds) * SECOND), "ns")
    return f"{stamp.astype('datetime64[ms]')}Z"
