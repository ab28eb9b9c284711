"""Where a peer is faster, from the ratios that ``make bench STORE=--store`` keeps."""

from __future__ import annotations

from speed.table import stored

from .found import Line, Table


def tables() -> list[Table]:
    """Return the ratios below 1, the worst first."""
    lines = tuple(
        Line((name, ratio), judged=False)
        for name, ratio in sorted(stored().items(), key=lambda one: one[1])
        if ratio < 1.0
    )
    text = (
        "Processor time of the peer over that of the tool, below 1: here the peer is faster. [Speed](speed.md) has "
        "all ratios, their peers, and what a call does that its peer does not."
    )
    return [Table("Slower than a peer", text, ("call", "ratio"), (0, 2), lines)]
