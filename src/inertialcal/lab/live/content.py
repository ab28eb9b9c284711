"""What the live page shows of a running acquisition: state as text, traces as numbers, deviations and spectra.

The page asks for each by a word. Nothing grows with time: traces are least and most of each pixel, deviations and
spectra those of the last `ROLLING` samples, findings those of the last `SCREENED`.

Assumed for deviations and spectra: samples evenly spaced at the rate at which they came over the last seconds; rows
that were lost are closed up. Ends of a deviation are those of `signals.allan`, for 68 % at one averaging time; a sensor
that is moved shows its motion there, not its noise.
"""

from __future__ import annotations

import asyncio
import json
import math
import struct
import threading
from collections.abc import Sequence
from importlib.resources import files

import numpy as np

from ...core.errors import InertialcalError
from ...core.estimate import Array
from ...signals.allan import allan
from ...signals.screening.remarks import remarks_of
from ...signals.screening.screen import Code, screen
from ...signals.spectrum.psd import psd
from ..acquisition.acquisition import Acquisition
from ..acquisition.live import InstrumentView, Recent, Told
from ..clock import Clock

ROLLING = 2**15  # samples behind deviations and spectra
SCREENED = 2**13  # samples that are looked through
SEGMENT = 2**10  # samples of a segment of a spectrum
DRAWN = 100  # points of a spectrum, equally far apart on its axis
RENEWED = 4.0  # [s] of this computer from one set of deviations to the next
FEWEST = 16  # samples of a deviation
POINTS, SPAN = (10, 2000), (0.1, 86400.0)  # that a page may ask for
# of a channel that is no axis of a sensor, as a set point is: it may stand still
STILL: tuple[Code, ...] = ("stuck", "repeated", "repeated_samples", "saturated")
HEAD, PART = struct.Struct("<Id"), struct.Struct("<IIIId")  # see ``LiveContent.traces``
Plain = str | int | float | bool | None | Sequence["Plain"] | dict[str, "Plain"]


class LiveContent:
    """What is shown of an acquisition, for any number of pages.

    Parameters
    ----------
    acquisition : Acquisition
        That runs.
    """

    largest = 256

    def __init__(self, acquisition: Acquisition) -> None:
        places = files(__package__)
        self.page, self.script = (
            places.joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "page.js")
        )
        self._acquisition = acquisition
        self._lock, self._machine = threading.Lock(), Clock()
        self._noise, self._due = "", -math.inf

    async def answer(self, asked: str | bytes) -> str | bytes | None:
        """Return the answer to what a page asks; None where it asks for what is not given."""
        if asked == "state":
            return self.state()
        if asked == "noise":
            return await asyncio.to_thread(self.noise)
        drawn = drawing(asked) if isinstance(asked, str) else None
        return None if drawn is None else self.traces(*drawn)

    def state(self) -> str:
        """Return state, instruments, step, disk and remarks, the latest first, as JSON."""
        view = self._acquisition.view()
        step = view.step
        return _json({
            "kind": "state", "state": view.state, "title": view.title, "elapsed": view.elapsed,
            "written": view.written, "free": view.free, "full_in": view.full_in,
            "step": None if step is None else {
                "number": step.number, "count": step.count, "name": step.name, "left": step.left,
                "values": [[name, value, unit] for name, value, unit in step.values],
            },
            "instruments": [_instrument(one) for one in view.instruments],
            "remarks": [_remark(told) for told in reversed(view.remarks)],
        })  # fmt: skip

    def traces(self, points: int, span: float) -> bytes:
        """Return least and most of each channel in parts of the last seconds of all instruments.

        Parameters
        ----------
        points : int
            Parts of the span: pixels of a drawing.
        span : float
            Of the clock of the acquisition [s].

        Returns
        -------
        bytes
            Little endian: number of instruments (uint32), now [s] (float64); for each its place in the state, channels
            c, points p and 0 (uint32), end of the last part [s] (float64), then float64: least of each channel, shape
            (c,); float32: how long before the end each part ends [s], shape (p,); least and most of each part above
            the least of its channel, shape (c, p) each. NaN where there is no value.
        """
        parts = []
        for i, one in enumerate(self._acquisition.view().instruments):
            shown = _readings(one)
            if not shown:
                continue
            recent = self._acquisition.recent(one.name, span, points)
            if len(recent.seconds):
                parts.append(_packed(i, recent, shown))
        return HEAD.pack(len(parts), self._acquisition.clock.seconds()) + b"".join(parts)

    def noise(self) -> str:
        """Return deviations, spectra and findings of each instrument as JSON; made anew each few seconds at most."""
        with self._lock:
            if self._machine.seconds() >= self._due:
                shown = [self._of_noise(one) for one in self._acquisition.view().instruments]
                self._noise = _json({"kind": "noise", "instruments": shown})
                self._due = self._machine.seconds() + RENEWED
            return self._noise

    def _of_noise(self, one: InstrumentView) -> Plain:
        shown = _readings(one)
        if not shown or not one.row_rate:
            return None
        seconds, values = self._acquisition.samples(one.name, ROLLING)
        values, interval = values[:, shown], 1.0 / one.row_rate
        if len(seconds) < FEWEST:
            return None
        tau, deviation, low, high = _deviations(values, interval)
        frequency, density = _spectrum(values, interval)
        looked = values[-SCREENED:]
        return {
            "tau": tau, "deviation": deviation, "low": low, "high": high, "frequency": frequency, "density": density,
            "samples": len(values), "seconds": len(values) * interval, "looked": len(looked) * interval,
            "findings": [text for i, place in enumerate(shown) for text in _findings(looked[:, i], one, place)],
        }  # fmt: skip


def drawing(text: str) -> tuple[int, float] | None:
    """Return points and span [s] that a page asks for, ``"600 10"``; None where it asks for what is not given."""
    count, _, length = text.partition(" ")
    try:
        points, span = int(count), float(length)
    except ValueError:
        return None
    inside = POINTS[0] <= points <= POINTS[1] and SPAN[0] <= span <= SPAN[1]
    return (points, span) if inside else None


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
    base = np.where(np.isfinite(low), low, np.inf).min(axis=0)
    base = np.where(np.isfinite(base), base, 0.0)
    end = float(recent.seconds[-1])
    return b"".join((
        PART.pack(place, len(shown), len(low), 0, end), base.astype("<f8").tobytes(),
        (end - recent.seconds).astype("<f4").tobytes(), (low - base).T.astype("<f4").tobytes(),
        (high - base).T.astype("<f4").tobytes(),
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


def _findings(x: Array, one: InstrumentView, place: int) -> list[str]:
    channel = one.channels[place]
    remarks = remarks_of(
        screen(x, at_rest=False), channel.name, shown=lambda value: f"{value:.6g} {channel.unit}".rstrip(),
        interval=1.0 / one.row_rate if one.row_rate else None,
    )  # fmt: skip
    return [remark.what for remark in remarks if channel.axis or remark.code not in STILL]
