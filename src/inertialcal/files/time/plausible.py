"""Whether a time axis can be true: a body changes its temperature only so fast.

Temperature-cycling chambers ramp at 15 K/min (0.25 K/s, JESD22-A104); four times that is taken as the end of
what is possible. The swing must be 5 K at least, so that noise is no swing. A temperature in another unit than
K or degC is judged by its numbers (degF changes 1.8 times as fast).
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from .stamps import EPOCH_UNITS

FASTEST = 1.0  # [K/s]
SMALLEST_SWING = 5.0  # [K]
BLOCKS = 100
SAMPLE_RATES = (0.01, 1e5)  # that come into question where the unit of time is not known [Hz]


def time_remarks(recording: Recording) -> tuple[Remark, ...]:
    """Return a remark where the temperature changes faster than anything can.

    Where a time column has no unit, each unit is tried that gives a sample rate of 0.01 Hz to 100 kHz.
    """
    temperatures = [c for c in recording.channels if c.quantity == "temperature"]
    if not temperatures:
        return ()
    seconds = recording.seconds
    if seconds is not None:
        return _remark(temperatures[0], seconds, recording, "")
    clocks = [c for c in recording.channels if c.quantity == "time" and c.unit is None]
    return tuple(
        remark
        for clock in clocks[:1]
        for unit, per_second in EPOCH_UNITS.items()
        if _possible(stamps := clock.data.astype(np.float64) / per_second)
        for remark in _remark(temperatures[0], stamps, recording, f" if {clock.name!r} is in {unit}")
    )


def _possible(seconds: Array) -> bool:
    """Whether the unit gives a usual sample rate."""
    step = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 0.0
    return step > 0.0 and SAMPLE_RATES[0] <= 1.0 / step <= SAMPLE_RATES[1]


def _remark(temperature: Channel, seconds: Array, recording: Recording, condition: str) -> tuple[Remark, ...]:
    """Swing from the coldest to the warmest block, over the time between them."""
    size = max(1, len(seconds) // BLOCKS)
    count = len(seconds) // size
    values = temperature.data.astype(np.float64)[: count * size].reshape(count, size)
    filled = np.isfinite(values).all(axis=1)
    level = np.median(values[filled], axis=1)
    middle = seconds[: count * size].reshape(count, size).mean(axis=1)[filled]
    if len(level) < 2:
        return ()
    cold, warm = int(np.argmin(level)), int(np.argmax(level))
    swing, between = float(level[warm] - level[cold]), abs(float(middle[warm] - middle[cold]))
    if swing < SMALLEST_SWING or swing <= FASTEST * between:
        return ()
    what = (
        f"{temperature.name!r} changes by {swing:.3g} within {between:.3g} s{condition}: "
        f"nothing changes its temperature faster than {FASTEST:g} K/s, so the stamps are wrong"
    )
    do = "Find out the true sample rate (--sample-rate), or the unit of time"
    return (Remark("time_axis_implausible", "warning", what, where=recording.source.path, do=do),)
