"""Rig of a vibration test: an item on a shaker, swept with a sine before and after vibration.

The modes of the item are drawn about those of its design; vibration lets them settle a little, or cracks it. The
controller keeps the level but for a ripple and harmonics; two accelerometers on the fixture record what it keeps. The
clock of the recorder is off by one unknown error for the whole campaign.

A gyro rides beside the first control accelerometer (``gyro``): vibration rectifies in it, and it is recorded at rest
and on a rate table before and after, over several power-ups. The random run has a notch about the first mode of the
item.

True values: natural frequency, Q and transmissibility at that frequency of each mode, relative to the mean of both
control accelerometers; and their changes. Of the gyro: its noise, bias and scale factors, and its rectification against
the control as it reads.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...core.key import At
from ...core.recording import SECOND, Channel, Recording
from ...signals.vibration.profile import Profile
from ..parts.campaign import drawn_error, drawn_errors
from ..protocol import Rig, on_bench
from ..twin import Drawn, Extra, Fault, TrueValue, Twin
from . import TITLE
from .campaign import GYRO_FILE, RUN_FILE, campaign_text, rest_file, survey_file
from .gyro import at_rest, draw_gyro, gyro_truth, shaken, turned
from .motion import Item, drive, fixture_ratio, moved, random_drive
from .setup import COLUMNS, CONTROLS, GYRO, NODES, PROFILE, SURVEYS, Bench

__all__ = ["FAULTS", "RIG", "Bench", "build"]

BEGIN = 1_283_260_200  # 2010-08-31 13:10:00 UTC [s]
FAULTS: dict[str, Fault] = {
    "wrong_rate": Fault("the sweep goes at twice the rate that is stated", "sweep_rate", {"speed": 2.0}),
    "level_high": Fault("the surveys are 2 dB too high", "drive_level", {"level": 0.25 * 10.0**0.1}),
    "clipped_drive": Fault("the amplifier cuts the drive off", "clipped_drive", {"clipped": 0.75}),
    "loose_fixture": Fault(
        "the fixture is loose: it swings between the control accelerometers", "control_disagrees",
        {"fixture": (620.0, 6.0)}, also=("control_lost",),
    ),
    "swapped_channels": Fault(
        "control and response have changed places", "swapped_channels", {"swapped": True}, also=("control_disagrees",)
    ),
    "samples_lost": Fault("the recorder drops 40 samples", "lost_samples", {"lost": 40}),
    "run_high": Fault("the random run is 2 dB too high", "", {"random_db": 2.0}, "covered"),
    "notch_missing": Fault(
        "the random run is driven without the notch of its profile", "", {"notched": False}, "covered"
    ),
    "bias_shift": Fault("the vibration shifts the bias of the gyro", "", {"bias_shift": 0.06}, "covered"),
    "scale_shift": Fault("the vibration changes a scale factor of the gyro", "", {"scale_shift": 0.005}, "covered"),
    "noisier": Fault("the vibration makes the gyro noisier", "", {"noisier": 1.5}, "covered"),
    "cracked": Fault("the vibration cracks the item", "", {"crack": 0.07}, "covered"),
}  # fmt: skip


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The test as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, *of_surveys = np.random.default_rng(seed).spawn(2 + len(SURVEYS))
    items = draw_items(bench, of_unit)
    error = drawn_error(bench.clock, of_bench)
    gain = drawn_error(bench.standards.get("control_accelerometer.scale_factor"), of_bench)
    recordings = {
        survey_file(name): _recording(bench, items[name], (error, gain), rng)
        for name, rng in zip(SURVEYS, of_surveys, strict=True)
    }
    extras = {}
    truth = list(true_values(bench, items, gain))
    gyro = draw_gyro(bench, np.random.default_rng([seed, 2]))
    of_table = np.random.default_rng([seed, 5])
    rate = drawn_error(bench.standards.get("rate_table.rate"), of_table)
    for name, recording in turned(bench, gyro, BEGIN, 1.0 + rate, of_table) if bench.power_ups else ():
        recordings[rest_file(name)] = recording
    truth += gyro_truth(bench, gyro, gain)
    for name, recording in at_rest(bench, gyro, BEGIN, np.random.default_rng([seed, 3])):
        recordings[rest_file(name)] = recording
    if bench.full_level:
        of_run, of_noise = np.random.default_rng([seed, 1]).spawn(2)
        table = random_drive(bench, of_run)
        on = slice(round(bench.rest * bench.sample_rate), len(table) - round(bench.rest * bench.sample_rate))
        seen = {name: values[on] for name, values in moved(bench, table, items["before"], error).items()}
        recordings[RUN_FILE] = _saved_recording(bench, seen, gain, of_noise)
        rng = np.random.default_rng([seed, 4])
        control = Channel(CONTROLS[0], _saved(bench, table * (1.0 + gain), rng), "g", "campaign")
        read = shaken(bench, gyro, table, rng)
        riding = [Channel(GYRO[axis], data, "deg/s", "campaign", axis, "gyro") for axis, data in read.items()]
        recordings[GYRO_FILE] = _stamped(bench, [control, *riding])
        text = "frequency [Hz],density [g2/Hz]\n" + "".join(f"{f:g},{level:g}\n" for f, level in NODES)
        frequency, level = np.array(NODES).T
        extras = {PROFILE: Extra(Profile(frequency, level * STANDARD_GRAVITY.value**2), text)}
    # a clock that is fast makes the rate that is said too low
    off = {"clock.rate": -error, "control_accelerometer.scale_factor": gain, "rate_table.rate": -rate}
    errors = drawn_errors(bench.standards, off)
    drawn: Drawn = {
        "clock_error": error,
        "control_gain_error": gain,
        "modes_before": items["before"].modes.ravel().tolist(),
        "gyro_linear_square_bias_scale": [[one.linear, one.square, one.bias, one.scale] for one in gyro.values()],
        "table_rate_error": rate,
    }
    return Twin(campaign_text(bench), recordings, tuple(truth), drawn, extras, errors)


def draw_items(bench: Bench, rng: np.random.Generator) -> dict[str, Item]:
    """Return the item before and after vibration."""
    nominal = np.array(bench.modes)
    before = nominal.copy()
    before[:, :2] *= 1.0 + bench.spread * rng.uniform(-1.0, 1.0, (len(nominal), 2))
    after = before.copy()
    settled = bench.settling * rng.uniform(-1.0, 1.0, (len(nominal), 2))
    after[:, :2] *= 1.0 + settled * [1.0, 10.0]
    after[0, :2] *= 1.0 - bench.crack * np.array([1.0, 5.0])
    return {"before": Item(before), "after": Item(after)}


def peaks(bench: Bench, item: Item, across: bool, gain: float = 0.0) -> Array:
    """Return the transmissibility at the frequency of each mode, relative to the mean of both controls as they read."""
    own = item.modes[:, 0]
    mean = 0.5 * (1.0 + fixture_ratio(bench, own))
    return np.abs(item.transmissibility(own, across) / mean) / (1.0 + gain)


def true_values(bench: Bench, items: dict[str, Item], gain: float) -> Iterator[TrueValue]:
    """Yield the modes of both surveys, and what they differ by."""
    for axis in COLUMNS:
        both = {name: np.column_stack([item.modes[:, :2], peaks(bench, item, axis == "y", gain)])
                for name, item in items.items()}  # fmt: skip
        for name, figures in both.items():
            for k, (frequency, q, peak) in enumerate(figures.tolist(), 1):
                yield TrueValue("resonance_frequency", axis, frequency, "Hz", name, at=At("mode", float(k), ""))
                yield TrueValue("amplification", axis, q, "1", name, at=At("mode", float(k), ""))
                yield TrueValue("transmissibility", axis, peak, "1", name, at=At("mode", float(k), ""))
        changes = both["after"] / both["before"] - 1.0
        for k, row in enumerate(changes.tolist(), 1):
            for quantity, value in zip(("resonance_frequency", "amplification", "transmissibility"), row, strict=True):
                yield TrueValue(f"{quantity}_change", axis, value, "1", "after", at=At("mode", float(k), ""))


def _recording(bench: Bench, item: Item, errors: tuple[float, float], rng: np.random.Generator) -> Recording:
    """Return one survey, as the recorder saves it."""
    clock_error, gain = errors
    bench = replace(bench, sample_rate=bench.survey_rate)
    table = drive(bench, clock_error, rng)
    seen = moved(bench, table, item, clock_error)
    if bench.lost:
        kept = np.delete(np.arange(len(table)), np.arange(bench.lost) + len(table) // 2)
        seen = {name: values[kept] for name, values in seen.items()}
    return _saved_recording(bench, seen, gain, rng)


def _saved_recording(bench: Bench, moving: Mapping[str, Array], gain: float, rng: np.random.Generator) -> Recording:
    seen = {name: values * (1.0 + gain) if name in CONTROLS else values for name, values in moving.items()}
    saved = {name: _saved(bench, values, rng) for name, values in seen.items()}
    if bench.swapped:
        saved["control_1"], saved["x"] = saved["x"], saved["control_1"]
    channels = [Channel(name, saved[name], "g", "campaign") for name in CONTROLS]
    channels += [Channel(column, saved[axis], "g", "campaign", axis, "acc") for axis, column in COLUMNS.items()]
    return _stamped(bench, channels)


def _stamped(bench: Bench, channels: list[Channel]) -> Recording:
    """Return channels as a recording, with the time that the recorder writes."""
    elapsed = np.rint(np.arange(len(channels[0].data)) * (SECOND / bench.sample_rate)).astype(np.int64)
    stamps = BEGIN * SECOND + elapsed
    return Recording(tuple(channels), stamps, 1.0 / bench.sample_rate, 0.0, "utc", "column", time_column="unix_s")


def _saved(bench: Bench, values: Array, rng: np.random.Generator) -> Array:
    noisy = values + bench.noise * rng.standard_normal(len(values))
    return np.asarray(np.round(np.round(noisy / bench.resolution) * bench.resolution, 6))


def small(bench: Bench) -> Bench:
    """Return the same test, made faster: a shorter band, a faster sweep."""
    return replace(
        bench,
        start=60.0,
        stop=900.0,
        per_minute=24.0,
        sample_rate=4000.0,
        survey_rate=4000.0,
        full_level=0.0,
        power_ups=0,
    )


RIG = Rig(
    "shaker",
    TITLE,
    on_bench(build, Bench()),
    FAULTS,
    # General faults of a rate table belong to rigs that fit a model there and hold turns out
    tests=("sine_survey", "vibration", "vibration_effects", "static_noise"),
)
