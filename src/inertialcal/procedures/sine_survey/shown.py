"""What a command says of the sweeps that it found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.show.rounding import number

if TYPE_CHECKING:
    from .reduction import Result


def summary(result: Result) -> str:
    """Return one line: each sweep, and the bandwidth of the tracking filter."""
    found = []
    for swept in result.swept:
        one = swept.sweep
        size, word = (60.0, "octaves a minute") if one.law == "log" else (1.0, "Hz a second")
        ends = f"{number(one.start, 4)} to {number(one.stop, 4)} Hz in {number(one.duration, 4)} s"
        way = "up" if one.up else "down"
        found.append(f"{swept.label}: {ends}, {way}, {number(size * abs(one.rate), 4)} {word}")
    band = f"tracking filter (picture): 1/{number(result.plan.tracking / 1.44, 2)} of the frequency"
    return "; ".join([*found, band])
