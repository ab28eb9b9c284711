"""Curves of a run: the control against its profile, each channel, level over time, power by third of an octave."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...signals.vibration.profile import fractional_octaves
from .plan import CONTROL
from .rows import P

if TYPE_CHECKING:
    from .reduction import Result

THIRDS = 3  # of an octave
ACCELERATION, DENSITY = "g", "g^2/Hz"  # as people speak
MOST = 4000  # points of a channel's spectrum


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI."""
    return [_control(result), *_channels(result), _levels(result), _bands(result)]


def _density(values: Array, unit: str = "m/s^2") -> Column:
    si = "(m/s^2)^2/Hz" if unit == "m/s^2" else "(rad/s)^2/Hz"
    return Column(values, si, DENSITY if unit == "m/s^2" else "(deg/s)^2/Hz")


def _control(result: Result) -> Curve:
    """Return density, profile, and the interval that holds for all lines together."""
    one = result.deviation
    low, high = one.interval(one.together(P))
    columns = {
        "frequency": Column(one.frequency, "Hz"),
        "density": _density(one.density),
        "profile": _density(one.profile),
        "lo": _density(one.profile * 10.0 ** (0.1 * low)),
        "hi": _density(one.profile * 10.0 ** (0.1 * high)),
        "deviation": Column(one.value, "dB"),
        "dof": Column(one.edf),
        "bandwidth": Column(one.high - one.low, "Hz"),
    }
    return Curve("vibration_control", CONTROL, columns)


def _channels(result: Result) -> list[Curve]:
    """Return the density of each channel from below the profile to half of the sampling frequency."""
    found = []
    f = result.spectra.frequency
    use = np.flatnonzero(f >= 0.5 * result.band[0])
    use = use[:: max(1, -(-len(use) // MOST))]
    names = result.channels if len(result.channels) > 1 else ()
    for place, one in enumerate(result.channels):
        if one in names:
            columns = {
                "frequency": Column(f[use], "Hz"),
                "density": _density(result.spectra.density[use, place], one.power.unit),
            }
            found.append(Curve("vibration_channel", one.name, columns, picture=True))
    return found


def _levels(result: Result) -> Curve:
    levels = result.levels
    columns = {
        "time": Column(levels.time, "s"),
        "level": Column(levels.level, "dB"),
        "full": Column(levels.full.tolist()),
        "chance": Column(np.full(len(levels.time), levels.deviation), "dB"),
    }
    return Curve("vibration_levels", CONTROL, columns)


def _bands(result: Result) -> Curve:
    """Return the level in thirds of an octave, with its interval, and that of the profile."""
    edges = fractional_octaves(*result.band, THIRDS)
    density, edf = result.controlled(result.fine)
    rows = []
    for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        square, dof = result.fine.band(density, edf, low, high)
        u = math.hypot(math.sqrt(0.5 / dof) if dof > 0.0 else math.nan, result.control.u)
        rows.append((math.sqrt(low * high), low, high, math.sqrt(square), math.sqrt(square) * u,
                     result.target.rms(low, high), dof))  # fmt: skip
    made = np.array(rows).reshape(-1, 7)
    columns = {
        "frequency": Column(made[:, 0], "Hz"),
        "low": Column(made[:, 1], "Hz"),
        "high": Column(made[:, 2], "Hz"),
        "rms": Column(made[:, 3], "m/s^2", ACCELERATION),
        "u": Column(made[:, 4], "m/s^2", ACCELERATION),
        "profile": Column(made[:, 5], "m/s^2", ACCELERATION),
        "dof": Column(made[:, 6]),
    }
    return Curve("vibration_bands", CONTROL, columns)


__all__ = ["curves"]
