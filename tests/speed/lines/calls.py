"""Calls on recordings in memory, whole: plan, screening, fit, model and figures, as a user waits for them.

No other program does as much. So each is watched against a plain fit of all its samples, which does far less and meets
the same load of the machine. What is wanted is a time: 50 ms for positions, 15 ms over temperature.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording
from inertialcal.signals.remembered import forget

from ..comparison import Work, line
from .files import Kept

GRAVITY = 9.807  # m/s^2
SAMPLES, EVERY = 5_000, 2  # of a record over temperature [s]
ORDER = 3


def as_first(call: Callable[[], object]) -> Callable[[], object]:
    """Return a call of which nothing is remembered."""

    def alone() -> object:
        forget()
        return call()

    return alone


def positions(rig: str, again: bool) -> Work:
    with TemporaryDirectory() as folder:
        ic.simulate(rig, Path(folder) / rig, 1)
        recording = ic.read(Path(folder) / rig / "recordings" / "hand1.csv")
    units = {"acc": "m/s^2", "gyro": "rad/s"}
    call = partial(ic.positions, recording, units=units, gravity=f"{GRAVITY} m/s2", latitude="45.8 deg")
    call()
    force = np.column_stack([recording.channel(f"acc_{axis}").data for axis in "xyz"])
    row, column = np.tril_indices(3)

    def length_error(values: Array) -> Array:
        matrix = np.zeros((3, 3))
        matrix[row, column] = values[:6]
        error: Array = np.linalg.norm((force - values[6:]) @ matrix.T, axis=1) - GRAVITY
        return error

    start = np.concatenate([np.eye(3)[row, column], np.zeros(3)])
    return Work(call if again else as_first(call), lambda: least_squares(length_error, start))


for name in ("six_faces", "hand_held"):
    for more in ("", ", again"):
        build = partial(positions, name, bool(more))
        line(f"ic.positions, {name}{more}", peer="scipy least_squares of |f| = g", goal=0.0)(build)


def over_temperature(start: float, rng: np.random.Generator) -> Recording:
    """Return three gyros through a swing of 80 degC."""
    at = np.arange(SAMPLES) * float(EVERY)
    warm = 25.0 + 40.0 * np.sin(2.0 * np.pi * at / at[-1] + start)
    bias = 0.1 + 2e-3 * (warm - 25.0) + 1e-5 * (warm - 25.0) ** 2
    axes = [Channel(axis, bias + rng.normal(0.0, 0.01, SAMPLES), "deg/s", "header", axis) for axis in "xyz"]
    channels = (*axes, Channel("temperature", warm, "degC", "header", "", "temperature"))
    return Recording(channels, (at * 1e9).astype(np.int64), float(EVERY))


def thermal(again: bool) -> Work:
    rng = np.random.default_rng(1)
    recordings = [over_temperature(start, rng) for start in (0.0, 1.0)]
    call = partial(ic.thermal, recordings)
    call()
    warm, *outputs = (
        np.concatenate([one.channel(name).data for one in recordings]) for name in ("temperature", "x", "y", "z")
    )
    return Work(call if again else as_first(call), lambda: [np.polyfit(warm, one, ORDER) for one in outputs])


for more in ("", ", again"):
    title = f"ic.thermal, 3 axes, 2 x 5e+03 samples{more}"
    line(title, peer="numpy.polyfit, order 3, of each", goal=0.0)(partial(thermal, bool(more)))


@line("ic.run of a campaign, cold, 39 files", peer="pandas.read_csv, pyarrow, of its recordings", goal=0.0)
def cold_run() -> Work:
    folder = TemporaryDirectory()
    campaign = Path(folder.name) / "npsat1"
    ic.simulate("npsat1", campaign, 1)
    recordings = sorted((campaign / "recordings").rglob("*.csv"))
    assert ic.check(campaign).inputs
    own = partial(ic.run, campaign, write=False)  # then nothing is kept for the next
    return Work(Kept(folder, own), lambda: [pd.read_csv(one, engine="pyarrow") for one in recordings])
