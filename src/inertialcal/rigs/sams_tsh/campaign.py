"""campaign.toml of the simulated flip, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

import json

import numpy as np

from ...core.axes import AXES
from ...core.influence import Influence
from ...core.recording import SECOND
from ..parts.standards import standard_tables
from ..protocol import SEAL, SEED
from ..sams_tsh_model.campaign import model_text
from .setup import (
    CODES,
    REFERENCE_TEMPERATURE,
    SCALE_FACTOR_V_PER_G,
    THERMOMETER_V_PER_DEGC,
    UG,
    Bench,
    Drawing,
    Head,
    chain,
)

TIME = "unix_s"
RECORDING = "flip"
FILE = f"recordings/{RECORDING}.csv"
BEGIN = 824_817_600  # 1996-02-20 12:00:00 UTC [s]

Stated = tuple[float, float, float]  # start and stop [s], angle [deg]


def windows(bench: Bench) -> tuple[Stated, ...]:
    """Return the windows beside each turn with their positions, but for what is not recorded.

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
    sensor = _sensor(bench, head) if model is None else _sensor_with_model(bench, head, model)
    tests = [_test(bench)] if model is None else [_test(bench), TEST_OF_MODEL.format(settle=bench.settle)]
    return "\n".join([HEAD, _standards(bench), sensor, _recording(bench), *tests, REQUIREMENT])


HEAD = f"""\
# A simulated campaign: a triaxial head turned by half a turn and back, in orbit.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "sams_tsh-{SEED}"
title = "In-orbit flip of a simulated triaxial sensor head"
source = "simulated: rig sams_tsh, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated triaxial sensor head"
serial = "{SEED}"
"""


def _standards(bench: Bench) -> str:
    """Return the tables of the standards; an error of each was drawn with this uncertainty."""
    return "# Each error is one unknown value for the whole campaign, or one for each axis.\n" + standard_tables(
        bench.standards, _entry
    )


def _entry(influence: Influence) -> str:
    sizes = {"1": (100.0, "%"), "m/s^2": (1.0 / UG, "ug"), "rad": (float(np.degrees(1.0)), "deg")}
    by, unit = sizes.get(influence.unit, (1.0, influence.unit))
    return (
        f"{{ u = {json.dumps(f'{influence.u * by:.12g} {unit}')}, certificate = {json.dumps(influence.certificate)} }}"
    )


def _sensor(bench: Bench, head: Head) -> str:
    return f"{_kind(bench)}chain = {{ {', '.join(_chain(bench, head))} }}\n"


def _sensor_with_model(bench: Bench, head: Head, model: Drawing) -> str:
    """Return the sensor with its chain as tables: a table in one line cannot be gone on with."""
    settings = _chain(bench, head)
    if bench.saved != "count":
        factors = [f"{value:g} V/g" for value in SCALE_FACTOR_V_PER_G]
        settings += [f"gain = {{ {_gain_text(bench)} }}", f"scale_factor = {_each(factors)}"]
    lines = "\n".join([*settings, f'order = "{bench.ground}"'])
    return f"{_kind(bench)}\n[sensors.head.chain]\n{lines}\n\n{model_text(head, model)}"


def _kind(bench: Bench) -> str:
    axes = ", ".join(f'"{axis}"' for axis in AXES)
    kind = f'[sensors.head]\nkind = "accelerometer"\naxes = [{axes}]\nunit = "ug"\n'
    if bench.saved != "count":
        return kind
    hold = f"scale factors hold at {REFERENCE_TEMPERATURE:g} degC"
    return f"{kind}# The zero of the electronics is that of a shorted input; {hold}.\n"


def _gain_text(bench: Bench) -> str:
    return ", ".join(f"{axis} = {gain:g}" for axis, gain in zip(AXES, bench.gains, strict=True))


def _chain(bench: Bench, head: Head) -> list[str]:
    """Return the settings of the chain."""
    if bench.saved != "count":
        return ['kind = "none"']
    known = chain(bench, head)
    return [
        'kind = "adc"',
        'lsb = "10 V / 65536"',
        f"counts = {list(CODES)}",
        f"gain = {{ {_gain_text(bench)} }}",
        f"zero = {_each([f'{1e6 * value:.6g} uV' for value in np.asarray(known.zero)])}",
        f"scale_factor = {_each([f'{value:g} V/g' for value in SCALE_FACTOR_V_PER_G])}",
        f'thermometer = {{ slope = "{THERMOMETER_V_PER_DEGC:g} V/degC", voltage = "0 V", temperature = "0 degC" }}',
    ]


def _each(texts: list[str]) -> str:
    return "{ " + ", ".join(f'{axis} = "{text}"' for axis, text in zip(AXES, texts, strict=True)) + " }"


def _recording(bench: Bench) -> str:
    warm = "count" if bench.saved == "count" else "degC"
    units = dict.fromkeys(AXES, bench.said) | dict.fromkeys([f"temperature_{axis}" for axis in AXES], warm)
    units |= dict.fromkeys([f"gain_{axis}" for axis in AXES], "1") if bench.gain_recorded else {}
    channels = ", ".join(f'{name} = {{ column = "{name}", unit = "{unit}" }}' for name, unit in units.items())
    rows = ",\n".join(
        f'  {{ start = "{instant(start)}", stop = "{instant(stop)}", angle = "{angle:g} deg", flip = "1" }}'
        for start, stop, angle in windows(bench)
    )
    return f"""\
[recordings.{RECORDING}]
sensor = "head"
file = "{FILE}"
clock = {{ column = "{TIME}", stamp = "middle", interval = "{1.0 / bench.rate:g} s" }}
channels = {{ {channels} }}
positions = [  # the windows beside each turn
{rows},
]
"""


def _test(bench: Bench) -> str:
    return f"""\
[[tests]]
id = "flip"
procedure = "flip"
recordings = ["{RECORDING}"]
plan = {{ axis = "x", settle = "{bench.settle:g} s" }}  # x: of the turn
"""


TEST_OF_MODEL = """\
# The same, after the bias of the ground model was taken off: what is left is the error of that model.
[[tests]]
id = "corrected"
procedure = "flip"
recordings = ["flip"]
plan = {{ axis = "x", settle = "{settle:g} s", corrected = true }}
"""


def instant(seconds: float) -> str:
    """Return a time of the record as UTC."""
    stamp = np.datetime64(round((BEGIN + seconds) * SECOND), "ns")
    return f"{stamp.astype('datetime64[ms]')}Z"


REQUIREMENT = """\
[[requirements]]
id = "R1"
text = "ambient acceleration below 50 ug"
quantity = "ambient_acceleration"
limit = "50 ug"
"""
