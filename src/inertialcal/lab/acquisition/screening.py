"""Samples are looked through while they come: a channel that is stuck, at a rail, glitches, or says nothing more.

The gate is that of every record (`signals.screening`), of a sensor that may be moved. Windows overlap, so that what
lies across the end of one is found in the next. What is found of a channel is one remark that is renewed when its count
has doubled, and at the end. A channel that is no axis of a sensor, as a set point is, may stand still. By `silent` an
instrument is named whose rows stay away although its link is there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...files.loggers.rows import RowChannel
from ...signals.screening.screen import Code, Finding, screen
from ...signals.time.samples import Indices
from ..clock import Clock
from .live import Track

WINDOW = 2**15  # samples that are looked through at once, at most: most of a look does not depend on how many
OVERLAP = 2**11  # of them, that were looked through before
FEWEST = 2**8  # new samples that are worth a look ...
LEAST = 2**6  # ... and at the end
EVERY = 10.0  # [s] of samples between two looks
SILENT, TIMES = 5.0, 20.0  # [s] without a row, and of the usual time from row to row, after which that is remarked
HASTE = 2.0  # [s] of this computer, before that is
STILL: tuple[Code, ...] = ("stuck", "repeated", "saturated")  # what a channel that is no axis may be
SAID: dict[Code, tuple[str, str]] = {
    "glitch": ("samples far from their neighbours", "Look at cables and supply"),
    "disturbed": ("samples are disturbed", "Look for knocks, cables and supply"),
    "saturated": ("samples lie at the end of the range", "Take a larger range, or less input"),
    "stuck": ("samples are stuck", "Look at the sensor and its wiring"),
    "repeated": ("samples repeat earlier ones, one by one", "Look at the buffers of the logger"),
    "missing": ("samples are no numbers", "Look at what the instrument sends"),
}


@dataclass
class _Known:
    """What was found of a channel."""

    count: int = 0  # Samples
    told: int = 0  # Of them, that were remarked
    upto: int = 0  # Sample behind the last that was counted
    first: float = 0.0  # When the first of them came [s]
    last: float = 0.0
    value: float = np.nan  # That is held


class Watch:
    """What is looked for in the samples of an instrument.

    Parameters
    ----------
    name : str
        Of the instrument.
    track : Track
        Its samples.
    clock : Clock
        Of the acquisition.
    """

    def __init__(self, name: str, track: Track, clock: Clock) -> None:
        self.name, self._track, self._clock = name, track, clock
        self._channels = [(i, one) for i, one in enumerate(track.layout.channels) if one.role == "reading"]
        self._known: dict[tuple[str, Code], _Known] = {}
        self._looked = self._unseen = 0  # Samples
        self._begin = clock.seconds()
        self._silent = False

    def look(self, last: bool = False) -> Iterator[Remark]:
        """Look through what is new; yield what is to be said."""
        rate = self._track.row_rate()
        enough = LEAST if last else min(max(FEWEST, EVERY * (rate or 0.0)), WINDOW - OVERLAP)
        while self._track.rows - self._looked >= enough:
            begin, seconds, values = self._track.from_sample(self._looked - OVERLAP, WINDOW)
            self._unseen += max(begin - self._looked, 0)
            for i, channel in self._channels:
                self._screened(channel, values[:, i], seconds, begin)
            self._looked = begin + len(seconds)
        yield from self._remarks(last)
        if not last:
            yield from self._silence(rate)

    def _screened(self, channel: RowChannel, x: Array, seconds: Array, begin: int) -> None:
        for one in screen(x, at_rest=False).findings:
            if one.code not in SAID or (one.code in STILL and not channel.axis):
                continue
            known = self._known.setdefault((channel.name, one.code), _Known())
            places = _beyond(one, known.upto - begin)
            if not len(places):
                continue
            known.first = known.first if known.count else float(seconds[places[0, 0]])
            known.count += int(np.sum(places[:, 1] - places[:, 0] + 1))
            known.last, known.upto = float(seconds[places[-1, 1]]), begin + int(places[-1, 1]) + 1
            known.value = float(one.value[-1]) if one.code != "repeated" else np.nan

    def _remarks(self, last: bool) -> Iterator[Remark]:
        units = {one.name: one.unit for _, one in self._channels}
        for (name, code), known in self._known.items():
            if known.count == known.told or (known.count < 2 * known.told and not last):
                continue
            known.told = known.count
            what, do = SAID[code]
            held = f" at {number(known.value, 6)} {units[name]}".rstrip() if np.isfinite(known.value) else ""
            span = f"{known.first - self._begin:.1f} s to {known.last - self._begin:.1f} s after the beginning"
            yield Remark(code, "warning", f"{name}: {what}{held}, {span}", self.name, known.count, do, subject=name)
        if self._unseen and last:
            what = "samples came faster than they could be looked through"
            yield Remark("not_screened", "info", what, self.name, self._unseen, "Look through the sealed file")

    def _silence(self, rate: float | None) -> Iterator[Remark]:
        """Yield that no row comes any more, once, and again after it has come back."""
        if rate is None:
            return
        newest, _ = self._track.samples(1)
        away = self._clock.seconds() - float(newest[-1])
        silent = away > max(SILENT, TIMES / rate) and self._clock.real(away) > HASTE
        if silent and not self._silent:
            what = f"no row for {away:.0f} s, at {number(rate, 3)} Hz before"
            yield Remark("silent", "warning", what, self.name, do="Look at the instrument: its link is there")
        self._silent = silent


def _beyond(one: Finding, first: int) -> Indices:
    """Return the places of a finding, less what lies before a sample."""
    places = one.places[one.places[:, 1] >= first].copy()
    places[:, 0] = np.maximum(places[:, 0], first)
    return places
