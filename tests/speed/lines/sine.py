"""A known drive in drift, whole call, against least squares of the drive and a cubic, which does far less."""

from __future__ import annotations

from functools import partial

import numpy as np

import inertialcal as ic
from inertialcal.core.estimate import Array

from ..comparison import Work, line

RATE, DEGREE = 100.0, 3  # [Hz], of the drift


def sine(n: int) -> Work:
    cycles = 100.3
    rng, turns = np.random.default_rng(1), np.arange(n) * (cycles / n)
    x = rng.normal(size=n) + 0.5 * np.sin(2.0 * np.pi * turns + 0.3)
    period = f"{n / RATE / cycles!r} s"
    place = np.linspace(-1.0, 1.0, n)

    def cubic() -> Array:
        drive = [np.sin(2.0 * np.pi * turns), np.cos(2.0 * np.pi * turns)]
        columns = np.column_stack([*drive, np.vander(place, DEGREE + 1)])
        found: Array = np.linalg.lstsq(columns, x, rcond=None)[0]
        return found

    call = partial(ic.sine, x, sample_rate=RATE, period=period)
    own = next(row for row in call().rows if row.quantity == "amplitude")
    assert own.value is not None
    assert own.u is not None
    assert abs(own.value - float(np.hypot(*cubic()[:2]))) < own.u
    return Work(call, cubic, moved=x.nbytes)


for size in (20_000, 1_000_000):
    line(f"ic.sine, {size:.0e} samples", peer="numpy.linalg.lstsq with a cubic", goal=1.0)(partial(sine, size))
