"""What the live page shows of an acquisition: state as text, traces as numbers, deviations and spectra.

The page asks for each by a word. Nothing grows with time: traces are least and most of each pixel, deviations and
spectra those of the last `ROLLING` samples. Of traces a page is told what is new to it, and pages that have the same
are told the same bytes.

Assumed for deviations and spectra: samples evenly spaced at the rate at which they came over the last seconds; rows
that were lost are closed up. Ends of a deviation are those of `signals.allan`, for 68 % at one averaging time; a sensor
that is moved shows its motion there, not its noise.
"""

from __future__ import annotations

import asyncio
import json
import math
import re
import struct
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from ...core.errors import InertialcalError
from ...core.estimate import Array
from ...core.recording import SECOND
from ...signals.allan import allan
from ...signals.spectrum.psd import psd
from ..acquisition.live import InstrumentView, Recent, Shown, Told, View
from ..clock import Clock

ROLLING = 2**15  # samples behind deviations and spectra
SEGMENT = 2**10  # samples of a segment of a spectrum
DRAWN = 100  # points of a spectrum, equally far apart on its axis
RENEWED = 4.0  # [s] of this computer from one set of deviations to the next
FEWEST = 16  # samples of a deviation
POINTS, SPAN = (10, 2000), (0.1, 86400.0)  # that a page may ask for
SHARED = 0.03  # [s] for which traces are given to other pages as they are
STALE = 0.3  # [s] for which it is believed which instruments there are
MANY = 8  # frames that are kept
ASKED = re.compile(r"(\d{1,5}) (\d{1,6}(?:\.\d{1,3})?) (\d{1,9})((?: \d{1,2}=\d{1,15}){0,64})", re.ASCII)
HEAD, PART = struct.Struct("<IIdd"), struct.Struct("<IIIId")  # see ``LiveContent.traces``
Plain = str | int | float | bool | None | Sequence["Plain"] | dict[str, "Plain"]


class LiveContent:
    """What is shown of an acquisition, for any number of pages.

    Parameters
    ----------
    shown : Shown
        Acquisition of this process, or of another that is followed.
    """

    largest = 2048

    def __init__(self, shown: Shown) -> None:
        places = files(__package__)
        self.page, self.script = (
            places.joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "page.js")
        )
        self._shown = shown
        self._lock, self._machine = threading.Lock(), Clock()
        self._noise, self._due = "", -math.inf
        self._view: View | None = None
        self._stale = self._utc = 0.0
        self._frames: dict[str, tuple[float, bytes]] = {}  # By what was asked: when it was made [s], and what

    async def answer(self, asked: str | bytes) -> str | bytes | None:
        """Return the answer to what a page asks; None where it asks for what is not given."""
        if asked == "state":
            return self.state()
        if asked == "noise":
            return await asyncio.to_thread(self.noise)
        drawn = drawing(asked) if isinstance(asked, str) else None
        if drawn is None or not isinstance(asked, str):
            return None
        now = self._machine.seconds()
        made, data = self._frames.get(asked, (-math.inf, b""))
        if now - made >= SHARED:
            data = self.traces(drawn)
            while len(self._frames) > MANY:
                self._frames.pop(next(iter(self._frames)))
            self._frames[asked] = (now, data)
        return data

    def state(self) -> str:
        """Return state, instruments, step, disk and remarks, the latest first, as JSON."""
        view = self._shown.view()
        step = view.step
        return _json({
            "kind": "state", "state": view.state, "why": view.why, "status": view.status,
            "title": view.title, "elapsed": view.elapsed,
            "written": view.written, "free": view.free, "full_in": view.full_in,
            "step": None if step is None else {
                "number": step.number, "count": step.count, "name": step.name, "left": step.left,
                "values": [[name, value, unit] for name, value, unit in step.values],
            },
            "instruments": [_instrument(one) for one in view.instruments],
            "remarks": [_remark(told) for told in reversed(view.remarks)],
        })  # fmt: skip

    def traces(self, drawn: Drawing) -> bytes:
        """Return least and most of each channel in parts of the last seconds of all instruments, where they are new.

        Parameters
        ----------
        drawn : Drawing
            What is drawn, and what the page has of it.

        Returns
        -------
        bytes
            Little endian: number of instruments, and of the recording: parts of another one are to be forgotten (uint32
            each), now by the clock of the acquisition and by UTC [s] (float64 each); for each its place in the state,
            channels c, parts p and 0 (uint32), when its newest sample came [s] (float64), then: number of each part, of
            the width ``span / points``, shape (p,), and least of each channel, shape (c,) (float64); least and most of
            each part above the least of its channel, shape (c, p) each (float32). NaN where there is no value. The
            first part may be one that the page has: it has grown.
        """
        width, parts, view = drawn.span / drawn.points, [], self._seen()
        had = drawn.had if drawn.run == view.run else {}
        for i, one in enumerate(view.instruments):
            shown = _readings(one)
            if not shown:
                continue
            recent = self._shown.recent(one.name, width, had.get(i, -drawn.points))
            if len(recent.parts):
                parts.append(_packed(i, recent, shown))
        now = self._shown.seconds()
        return HEAD.pack(len(parts), view.run, now, now + self._utc) + b"".join(parts)

    def _seen(self) -> View:
        """Return which instruments there are, as of late."""
        now = self._machine.seconds()
        if self._view is None or now >= self._stale:
            self._view, self._stale = self._shown.view(), now + STALE
            self._utc = self._view.utc_ns / SECOND - self._shown.seconds()
        return self._view

    def noise(self) -> str:
        """Return deviations and spectra of each instrument as JSON; made anew each few seconds at most."""
        with self._lock:
            if self._machine.seconds() >= self._due:
                shown = [self._of_noise(one) for one in self._shown.view().instruments]
                self._noise = _json({"kind": "noise", "instruments": shown})
                self._due = self._machine.seconds() + RENEWED
            return self._noise

    def _of_noise(self, one: InstrumentView) -> Plain:
        shown = _readings(one)
        if not shown or not one.row_rate:
            return None
        seconds, values = self._shown.samples(one.name, ROLLING)
        values, interval = values[:, shown], 1.0 / one.row_rate
        if len(seconds) < FEWEST:
            return None
        tau, deviation, low, high = _deviations(values, interval)
        frequency, density = _spectrum(values, interval)
        return {
            "tau": tau, "deviation": deviation, "low": low, "high": high, "frequency": frequency, "density": density,
            "samples": len(values), "seconds": len(values) * interval,
        }  # fmt: skip


@dataclass(frozen=True)
class Drawing:
    """What a page draws, and has."""

    points: int
    span: float  # [s]
    run: int  # Of the recording that it has parts of
    had: Mapping[int, int]  # The last part that it has of an instrument, by its place


def drawing(text: str) -> Drawing | None:
    """Return what a page asks for: ``"600 10 0 1=812"``, points, span [s], recording, parts; None if not given."""
    found = ASKED.fullmatch(text)
    if found is None:
        return None
    points, span, run = int(found[1]), float(found[2]), int(found[3])
    had = (one.split("=") for one in found[4].split())
    inside = POINTS[0] <= points <= POINTS[1] and SPAN[0] <= span <= SPAN[1]
    return Drawing(points, span, run, {int(place): int(part) for place, part in had}) if inside else None


def _json(content: Plain) -> str:
    return json.dumps(content, ensure_ascii=False, allow_nan=False)


def _readings(one: InstrumentView) -> list[int]:
    return [i for i, channel in enumerate(one.channels) if channel.role == "reading"]


def _instrument(one: InstrumentView) -> Plain:
    channels: list[Plain] = [[one.channels[i].name, one.channels[i].unit] for i in _readings(one)]
    return {
        "name": one.name, "identity": one.identity, "connected": one.connected, "rows": one.rows,
        "acknowledged": one.acknowledged, "rate": one.row_rate, "damaged": one.damaged, "doubled": one.doubled,
        "late": one.late, "lost": one.lost, "intervals": one.intervals, "channels": channels,
    }  # fmt: skip


def _remark(told: Told) -> Plain:
    return {"utc": told.utc_ns / 1e6, "severity": told.remark.severity, "text": str(told.remark)}


def _packed(place: int, recent: Recent, shown: list[int]) -> bytes:
    low, high = recent.low[:, shown], recent.high[:, shown]
    base = np.fmin.reduce(low, axis=0)
    base = np.where(np.isfinite(base), base, 0.0)
    return b"".join((
        PART.pack(place, len(shown), len(low), 0, recent.newest), recent.parts.astype("<f8").tobytes(),
        base.astype("<f8").tobytes(), (low - base).T.astype("<f4").tobytes(), (high - base).T.astype("<f4").tobytes(),
    ))  # fmt: skip


def _columns(values: Array) -> list[Plain]:
    """Return each channel as a list, None for what is no number."""
    return [[float(one) if math.isfinite(one) else None for one in column] for column in values.T.tolist()]


def _deviations(values: Array, interval: float) -> tuple[Plain, Plain, Plain, Plain]:
    try:
        found = allan(values, interval, quantity="rate")
    except InertialcalError:  # too few samples, or none that is there
        return [], [], [], []
    return found.tau.tolist(), _columns(found.deviation), _columns(found.lo), _columns(found.hi)


def _spectrum(values: Array, interval: float) -> tuple[Plain, Plain]:
    """Return frequencies and root densities, the mean of what is drawn at one place."""
    try:
        found = psd(values, interval, segment=min(SEGMENT, len(values) // 4))
    except InertialcalError:
        return [], []
    place = np.floor(DRAWN * np.log(found.frequency / found.frequency[0]) / np.log(SEGMENT / 2)).astype(np.int64)
    first = np.flatnonzero(np.diff(place, prepend=-1))
    count = np.diff(first, append=len(place))
    density = np.add.reduceat(found.density, first, axis=0) / count[:, None]
    density[:, np.all(values == values[:1], axis=0)] = 0.0  # a channel that stays: what is left of its mean is rounding
    return (np.add.reduceat(found.frequency, first) / count).tolist(), _columns(np.sqrt(density))
