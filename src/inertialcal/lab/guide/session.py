"""A guided calibration from its start to its files: what comes is recorded, judged and, at the end, reduced.

The acquisition records all that comes (`acquisition`). Meanwhile `Session.step`, called again and again, gives the
guide what is new. When the guide has enough, the procedure itself is run on what is on the disk by then, and has the
last word. Then the recording is sealed; what counts of it - without positions that were taken back, up to the sample at
which it was enough - becomes `COUNTED`, and the folder a campaign whose run gives figures, models and report.

Pages and terminals read `Session.shown` and call `undo` and `finish`; any thread may. All else is of one thread.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...campaign.calls.call import Reduced, call
from ...campaign.engine.run import Outcome, run
from ...core.errors import DataError, InertialcalError, UsageError
from ...core.estimate import Array
from ...core.recording import SECOND, ClockRate, Recording
from ...core.show.rounding import number, uncertainty, with_uncertainty
from ...core.units import factor
from ...files.models.formats import FORMATS
from ...files.models.model_file import ModelFile, export
from ...files.models.model_json import dump_model
from ...files.write.recording import write
from ...procedures.given import GROUP, Said
from ...sensors.model.model_set import ModelSet
from ..acquisition.acquisition import Acquisition
from ..acquisition.lab_file import Lab
from ..acquisition.live import RENEWED
from ..acquisition.seal import Summary, recorded, seal
from ..clock import Clock
from ..instruments.device import Device
from ..instruments.links.phone import PhoneLink
from ..instruments.protocol import Instrument
from .engine import Guide, Known, Notice, State
from .stream import Samples, Stream
from .words import named

COUNTED = "guided.parquet"
USUAL = {"bias": "1 mg", "scale_factor_error": "0.1 %", "misalignment": "0.1 deg"}  # wanted where nothing is said
USUAL_PHONE = {"bias": "10 mg", "scale_factor_error": "0.5 %", "misalignment": "0.5 deg"}  # of rounded readings
SHOWN = {"bias": "mg", "scale_factor_error": "%", "misalignment": "deg"}  # units
SHOWN_GYRO = {"bias": "deg/s", "scale_factor_error": "%", "misalignment": "deg"}
NAMES = {"bias": "bias", "scale_factor_error": "scale factor", "misalignment": "misalignment"}
FIRST, FIRST_TIME = 64, 1.0  # rows, and seconds of them, before anything is judged
MOST_FIRST = 4096  # rows without a time between them
NEW = 0.2  # [s] of new rows that are judged together
SILENT, PAUSE = 2.0, 1.0  # [s] of the clock, and of the machine, without a row, until it is said
RUN, RAIL_TURN = 8, np.radians(12.0)  # equal samples, and by how much the force turns meanwhile, that are a rail
PRESS = "Open this page on the phone, lay it down with its screen up, and press the button below"
AWAY = "The phone sends nothing: open this page on it again, and keep its screen on. What was measured so far counts"
RAIL_FORCE, RAIL_RATE = 4.0, 0.1  # that is no rail if it is less [m/s^2], [rad/s]
TURNED = 3  # positions, in which every channel changes
WARMED = 2.0  # change of temperature that is told [K]
WORDS = {  # what to do, in large letters
    "waiting": "Waiting", "lay_down": "Lay it down", "hold_still": "Hold still", "turn": "Turn now",
    "repeated": "Another position", "held_in_hand": "Put it down", "unplugged": "No signal", "refused": "Stop",
    "enough": "Enough", "out_of_reach": "Not possible", "working": "Wait", "done": "Done",
}  # fmt: skip
# remarks of samples, by who does not know that the sensor is laid and turned: what of it matters is looked for here
OF_SAMPLES = RENEWED - {"save_intervals", "disk_filling"}
DRIFT = 2e-3  # of the clock of an instrument: no quartz is so far off
KEPT = 30  # notices that are shown
PATIENCE = 20.0  # [s] of the machine for the disk to have what was judged


@dataclass(frozen=True)
class Asked:
    """What a calibration is to give.

    Parameters
    ----------
    target : mapping of str to str
        Standard uncertainty wanted, as `Guide` takes it.
    settings : mapping of str to object
        What is said of the readings and the site, as `positions` takes it.
    rest : float
        Shortest rest that counts [s].
    labels, sides : mapping of str to str
        Names of faces and axes, as `Guide` takes them.
    formats : sequence of str
        Of the models for others.
    """

    target: Mapping[str, str] = field(default_factory=dict[str, str])
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    rest: float = 3.0
    labels: Mapping[str, str] = field(default_factory=dict[str, str])
    sides: Mapping[str, str] = field(default_factory=dict[str, str])
    formats: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """A parameter as it is shown."""

    name: str  # "bias x", "gyro bias x"
    value: str
    unit: str
    u: str  # Standard uncertainty
    asked: bool  # Whether an uncertainty was asked for
    ratio: float | None  # Its interval over that of what is wanted; None where nothing is, or nothing is known
    reached: bool


@dataclass(frozen=True)
class Shown:
    """What a page or a terminal shows."""

    phase: str = "waiting"  # ``"waiting"`` for rows, ``"guiding"``, ``"working"``, ``"done"``
    code: str = "waiting"  # As of `State`; or ``"working"``, ``"done"``
    text: str = "Waiting for the sensor"
    said: str = "Waiting for the sensor"  # The text as it was when it began to mean what it means; else it is the same
    positions: int = 0
    to_go: int | None = None
    still: bool = False
    fill: float = 0.0  # Of the rest that is needed, 0 to 1
    up: tuple[float, float, float] | None = None
    target: tuple[float, float, float] | None = None
    lies: str = ""  # What points up, in words
    next: str = ""  # What should point up next
    figures: tuple[Figure, ...] = ()
    history: Mapping[str, Sequence[float | None]] = field(default_factory=dict)  # Ratio of each after each position
    notices: tuple[str, ...] = ()  # The latest last
    temperature: str = ""

    @property
    def word(self) -> str:
        """What to do, in large letters."""
        return WORDS[self.code]


@dataclass(frozen=True, eq=False)
class Ended:
    """What came out."""

    summary: Summary
    reached: bool  # Whether every uncertainty that was asked for is reached, by the figures on the recording
    why: str  # Why there are no figures; empty where there are
    found: Reduced | None
    outcome: Outcome | None
    figures: tuple[Figure, ...]
    written: Mapping[str, str]  # What stands where


class Session:
    """A guided calibration.

    Parameters
    ----------
    lab : Lab
        With one instrument that is the IMU.
    folder : path
        New or empty.
    asked : Asked
        What it is to give.
    clock : Clock, optional
        By default that of the lab.
    instruments : sequence of Instrument, optional
        In place of those of the lab.
    """

    def __init__(
        self,
        lab: Lab,
        folder: str | Path,
        asked: Asked,
        clock: Clock | None = None,
        instruments: Sequence[Instrument] | None = None,
    ) -> None:
        self.folder, self.asked = Path(folder), asked
        self.acquisition = Acquisition(lab, folder, clock, instruments)
        self.clock = self.acquisition.clock
        self.name = self._imu(lab)
        self.phone = lab.file.instruments[self.name].link == "phone"
        self.target = dict(asked.target) or dict(USUAL_PHONE if self.phone else USUAL)
        self.labels = dict(asked.labels) or ({"z+": "screen", "y+": "top of the screen"} if self.phone else {})
        self.shown = Shown(text=PRESS, said=PRESS) if self.phone else Shown()
        self.guide: Guide | None = None
        self.stream: Stream | None = None
        self.ended: Ended | None = None
        self.state: State | None = None
        self._undo, self._finish = threading.Event(), threading.Event()
        self._notices: deque[str] = deque(maxlen=KEPT)
        self._taken = 0  # Rows that were given to the guide
        self._came, self._stamp = self.clock.seconds(), 0  # When the last row came [s]; its time for the guide [ns]
        self._lots: list[tuple[int, int, int]] = []  # First row, first and last stamp of what was given together
        self._gone: list[tuple[int, int]] = []  # Rows that were taken back, and those that are not accepted
        self._before: Array | None = None  # The last samples of sensors
        self._ends: tuple[Array | float, Array | float] = (np.inf, -np.inf)  # Least and largest of each so far
        self._found: set[tuple[str, str]] = set()
        self._range: tuple[Array, Array] | None = None  # Least and most of each channel since some position
        self._ranged = 0  # That position
        self._told: set[tuple[str, str]] = set()
        self._temperatures: tuple[float, float, float] | None = None  # First, last, last that was told [degC]
        self._history: dict[str, list[float | None]] = {}
        self._counted = -1

    def _imu(self, lab: Lab) -> str:
        layouts = {name: dialect.layout for name, dialect in lab.dialects.items()}
        rows = [name for name, one in layouts.items() if one is not None and len(one.channels) >= 3]
        if len(rows) != 1:
            what = f"{len(rows)} instruments could be the IMU" if rows else "no instrument gives three channels or more"
            do = "Leave one in LAB.toml: " + ", ".join(rows) if rows else "Describe its fields in its dialect"
            raise UsageError(what, do=do, code="no_source")
        return rows[0]

    # ---- from any thread ----

    @property
    def page_link(self) -> PhoneLink | None:
        """Where a page puts what its sensors say; None where nobody asks a page."""
        found = self.acquisition.instrument(self.name)
        link = found.link if isinstance(found, Device) else None
        return link if isinstance(link, PhoneLink) else None

    def undo(self) -> None:
        """Take the last position back, soon."""
        self._undo.set()

    def finish(self) -> None:
        """End it, soon, with what there is."""
        self._finish.set()

    # ---- while it goes on ----

    def start(self) -> None:
        """Connect, and begin to record. Raises as `Acquisition.start`."""
        self.acquisition.start()

    def step(self) -> bool:
        """Look at what came; return whether it goes on.

        Raises
        ------
        InertialcalError
            If it cannot be told what the instrument sends, or the acquisition failed.
        """
        over = self.acquisition.wait(NEW / 4.0)
        if self._undo.is_set():
            self._undo.clear()
            self._take_back()
        count, seconds, values = self.acquisition.since(self.name, self._taken)
        enough, away = False, self.clock.seconds() - self._came
        if len(seconds) and (over or self._is_new(seconds)):
            enough = self._take(count, seconds, values)
        elif self.guide is not None and away > SILENT and self.clock.real(away) > PAUSE:
            self._say(self.guide.silent(self._stamp + round(away * SECOND)))
        self._remarks()
        if enough and self._is_enough():
            return False
        return not (over or self._finish.is_set())

    def _is_new(self, seconds: Any) -> bool:
        apart = float(seconds[-1] - seconds[0])
        if self.guide is not None:
            return apart >= NEW or self.clock.seconds() - seconds[0] >= NEW
        if len(seconds) >= MOST_FIRST and apart <= 0.0:
            do = f"Name a field with role time or counter in its dialect, or add to instruments.{self.name}: interval"
            raise UsageError(f"{self.name}: nothing tells when its rows were measured", do=do, code="no_time")
        return len(seconds) >= FIRST and apart >= FIRST_TIME

    def _take(self, count: int, seconds: Any, values: Any) -> bool:
        """Give the guide what is new; return whether it has enough."""
        if self.guide is None or self.stream is None:
            self.guide, self.stream = self._open(seconds, values)
        samples = self.stream.add(seconds, values)
        first = count - len(seconds)
        state = self.guide.add(samples.time_ns, samples.force, samples.rate)
        self._gone += [(first + int(k), first + int(k) + 1) for k in np.flatnonzero(~state.accepted)]
        self._lots.append((first, int(samples.time_ns[0]), int(samples.time_ns[-1])))
        self._taken, self._came, self._stamp = count, self.clock.seconds(), int(samples.time_ns[-1])
        if samples.temperature is not None:
            self._warm(float(np.nanmean(samples.temperature)))
        self._say(state)
        self._look(values, samples, state.positions)
        return state.code == "enough"

    def _open(self, seconds: Any, values: Any) -> tuple[Guide, Stream]:
        """Decide what the rows are, and begin to guide."""
        layout = self.acquisition.lab.dialects[self.name].layout
        assert layout is not None  # noqa: S101 - it has given rows
        layout = replace(layout, interval=self.acquisition.lab.file.instruments[self.name].interval)
        interval = layout.interval or float(seconds[-1] - seconds[0]) / (len(seconds) - 1)
        said = Said(**dict(self.asked.settings))
        stream = Stream(layout, values, interval, said, self.name)
        guide = Guide(
            self.target, 1.0 / interval, rest=self.asked.rest, gravity=stream.gravity, gravity_u=stream.gravity_u,
            latitude=stream.campaign.file.site.latitude, gyros=stream.gyros, labels=self.labels,
            sides=self.asked.sides,
        )  # fmt: skip
        return guide, stream

    def _take_back(self) -> None:
        found = None if self.guide is None else self.guide.undo()
        if found is None:
            self._notices.append("There is no position to take back")
            self.shown = replace(self.shown, notices=tuple(self._notices))
            return
        began, state = found
        lot = next((one for one in reversed(self._lots) if one[1] <= began), self._lots[0])
        after = self._lots.index(lot) + 1
        stop = self._lots[after][0] if after < len(self._lots) else self._taken
        share = (began - lot[1]) / max(lot[2] - lot[1], 1)
        self._gone.append((lot[0] + int(np.clip(round(share * (stop - lot[0])), 0, stop - lot[0])), self._taken))
        self._counted = -1
        self._say(state)

    def _say(self, state: State) -> None:
        """Show a state."""
        if state.code == "unplugged" and self.phone:
            state = replace(state, text=AWAY)
        self.state, guide, before = state, self.guide, self.shown
        assert guide is not None  # noqa: S101 - it made the state
        figures = tuple(self._figures(state.known))
        if state.positions != self._counted:
            self._counted = state.positions
            for one in figures:
                past = self._history.setdefault(one.name, [])
                past[state.positions :] = []
                past += [None] * (state.positions - len(past)) + [one.ratio]
        for notice in state.notices:
            self._notices.append(notice.text)
        same = (before.code, before.target, before.positions) == (state.code, state.target, state.positions)
        if not same:
            self.acquisition.publish(f"{WORDS[state.code]}: {state.text}")
        rest = guide.plan.shortest or 1.0
        fill = 0.0 if state.rest_left is None else 1.0 - min(state.rest_left / (rest + 0.5), 1.0)
        self.shown = Shown(
            "guiding", state.code, state.text, before.said if same else state.text, state.positions, state.to_go,
            state.still, fill, state.up, state.target, self._named(state.up), self._named(state.target), figures,
            {name: tuple(one) for name, one in self._history.items()}, tuple(self._notices), self._temperature(),
        )  # fmt: skip

    def _named(self, direction: tuple[float, float, float] | None) -> str:
        return "" if direction is None else named(np.array(direction), self.labels)

    def _figures(self, known: Sequence[Known]) -> Iterator[Figure]:
        """Yield what is shown of the parameters."""
        for one in known:
            row = one.row
            of_gyro = row.key.sensor == "gyro"
            units = SHOWN_GYRO if of_gyro else SHOWN
            if row.key.quantity not in units or row.case.beside or row.reason.code == "of_frame":
                continue
            unit = units[row.key.quantity]
            scale = factor(row.unit, unit)
            value = with_uncertainty(*(None if each is None else scale * each for each in (row.value, row.u)))
            u = "not known yet" if row.u is None else uncertainty(scale * row.u)
            shown = f"{'gyro ' * of_gyro}{NAMES[row.key.quantity]} {row.key.axis}"
            yield Figure(shown, value, unit, u, one.wanted is not None, one.ratio, one.reached)

    def _look(self, values: Array, samples: Samples, positions: int) -> None:
        """Look for channels that do not follow the turns, and for those at the end of their range."""
        (view,) = (one for one in self.acquisition.view().instruments if one.name == self.name)
        axes = [i for i, one in enumerate(view.channels) if one.role == "reading" and one.axis]
        low, high = (np.fmin.reduce(values, axis=0), np.fmax.reduce(values, axis=0))
        if self._range is not None:
            low, high = np.fmin(self._range[0], low), np.fmax(self._range[1], high)
        self._range = (low, high)
        if positions >= self._ranged + TURNED:
            for i in axes:
                if low[i] == high[i]:
                    name, at = view.channels[i].name, number(float(low[i]), 4)
                    self._find(
                        "stuck", name, f"{name} reads {at} however it lies. Look at the wiring and at the logger"
                    )
            self._ranged, self._range = positions, None
        self._look_for_rails(samples)

    def _look_for_rails(self, samples: Samples) -> None:
        """Look for channels that stay at one value while the direction of the force turns.

        It is the largest or least that they have had: a phone's browser rounds, and what lies across a turn stays at 0.
        """
        sensors = [one for one in (samples.force, samples.rate) if one is not None]
        values = np.vstack([*([] if self._before is None else [self._before]), np.hstack(sensors)])
        self._before = values[-RUN:]
        self._ends = (np.fmin(self._ends[0], values.min(axis=0)), np.fmax(self._ends[1], values.max(axis=0)))
        begin = values[:-RUN]
        same = np.array([np.all(values[k : k + RUN] == values[k], axis=0) for k in range(len(begin))])
        same &= (begin == self._ends[0]) | (begin == self._ends[1])
        same &= np.abs(begin) > np.repeat([RAIL_FORCE, RAIL_RATE], 3)[: begin.shape[1]]
        if not same.any():
            return
        unit = values[:, :3] / np.maximum(np.linalg.norm(values[:, :3], axis=1, keepdims=True), 1e-9)
        turned = np.einsum("ij,ij->i", unit[: len(begin)], unit[RUN - 1 : RUN - 1 + len(begin)]) < np.cos(RAIL_TURN)
        for k in np.flatnonzero(np.any(same & turned[:, None], axis=0)):
            name = f"{('acc', 'gyro')[k // 3]} {'xyz'[k % 3]}"
            self._find("rail", name, f"{name} stays at one value while it turns: at the end of its range, or "
                       "stuck. Turn it more slowly, or set a wider range; look at its wiring")  # fmt: skip

    def _find(self, code: str, channel: str, text: str) -> None:
        if (code, channel) not in self._found:
            self._found.add((code, channel))
            self._notices.append(text)
            self.shown = replace(self.shown, notices=tuple(self._notices))

    def _remarks(self) -> None:
        """Show what the acquisition remarks: the cable, lost rows, the disk."""
        new = []
        for told in self.acquisition.view().remarks:
            if told.remark.code in OF_SAMPLES:
                continue
            key = (told.remark.code, told.remark.what)
            if key not in self._told:
                self._told.add(key)
                do = "" if self.phone else told.remark.do  # which is about cables
                new.append(f"{told.remark.what}{f'. {do}' if do else ''}")
        if new:
            self._notices += new
            self.shown = replace(self.shown, notices=tuple(self._notices))

    def _warm(self, now: float) -> None:
        if not np.isfinite(now):
            return
        first, _, told = self._temperatures or (now, now, now)
        if abs(now - told) > max(WARMED, abs(told - first)):
            told = now
            change = number(abs(now - first), 2)
            self._notices.append(f"The temperature has {'risen' if now > first else 'fallen'} by {change} K: biases are"
                                 " means over that; let it warm up first for one temperature")  # fmt: skip
        self._temperatures = (first, now, told)

    def _temperature(self) -> str:
        if self._temperatures is None:
            return ""
        first, now, _ = self._temperatures
        return f"{now:.1f} degC, {now - first:+.1f} K since the beginning"

    # ---- the end ----

    def _is_enough(self) -> bool:
        """Run the procedure on what is on the disk; where that is not enough, ask for one position more."""
        guide, machine = self.guide, Clock()
        assert guide is not None  # noqa: S101 - it had enough
        text = "Enough. Looking at the whole recording"
        self.shown = replace(self.shown, phase="working", code="working", text=text, said=text)
        until = machine.seconds() + PATIENCE
        while machine.seconds() < until:
            (view,) = (one for one in self.acquisition.view().instruments if one.name == self.name)
            if view.acknowledged >= self._taken or self.acquisition.wait(NEW):
                break
        try:
            recording = self._counted_of(recorded(self.folder, self.name))
            found = call("positions", recording, self._settings(), options=True)
            state = guide.judge(found.result.rows())
            if state.code != "enough" and recording.clock is not None:
                self._look_for_the_clock(guide.known(found.result.rows()), recording.clock)
        except DataError as error:
            state = guide.judge(())
            state = replace(state, notices=(Notice("not_reduced", str(error.problems[0])),))
        if state.code == "enough":
            return True
        self._notices.append("The whole recording needs one position more")
        self._say(state)
        return False

    def _look_for_the_clock(self, known: Sequence[Known], clock: ClockRate) -> None:
        """Say where gyro scale factors were asked for better than the clock is known: no position helps there."""
        wanted = [one.wanted for one in known if one.wanted is not None
                  and (one.row.key.sensor, one.row.key.quantity) == ("gyro", "scale_factor_error")]  # fmt: skip
        stated = "clock.rate" in (self.asked.settings.get("standards") or {})
        if not stated and min(wanted, default=math.inf) <= clock.u:
            known_to = f"The rate of the sensor's clock is known to {uncertainty(100.0 * clock.u)} %"
            do = "Record longer, ask for less, or state clock.rate"
            self._find("clock", "", f"{known_to}, and scale factors of its gyros no better. {do}")

    def _settings(self) -> dict[str, Any]:
        said: dict[str, Any] = {
            name: value for name, value in self.asked.settings.items() if value not in (None, {}, [])
        }
        return said | {"shortest": f"{self.asked.rest!r} s"}

    def _counted_of(self, recording: Recording) -> Recording:
        """Return what counts of a recording."""
        kept = np.zeros(len(recording), dtype=np.bool_)
        kept[: self._taken] = True
        for first, stop in self._gone:
            kept[first:stop] = False
        if kept.all():
            return recording
        stamps = recording.stamps
        assert stamps is not None  # noqa: S101 - it was recorded with time
        channels = tuple(replace(one, data=np.asarray(one.data)[kept]) for one in recording.channels)
        return replace(recording, channels=channels, time_ns=np.asarray(stamps)[kept])

    def end(self) -> Ended:
        """Stop, seal, reduce and write; the result stays in `ended`.

        Raises
        ------
        InertialcalError
            What ended the acquisition, if that was a fault; what cannot be written.
        """
        text = "Making the figures, the model and the report"
        self.shown = replace(self.shown, phase="working", code="working", text=text, said=text, target=None, next="")
        self.acquisition.stop()
        self.acquisition.wait()
        summary = seal(self.folder)
        self.ended = self._reduced(summary)
        text = self._last_words(self.ended)
        count = self.shown.positions if self.ended.found is None else len(self.ended.found.result.readings)
        self.shown = replace(self.shown, phase="done", code="done", text=text, said=text, notices=tuple(self._notices),
                             positions=count, to_go=None,
                             figures=self.ended.figures or self.shown.figures)  # fmt: skip
        return self.ended

    def _reduced(self, summary: Summary) -> Ended:
        sealed = next((one for one in summary.instruments if one.name == self.name), None)
        guide = self.guide
        if sealed is None or guide is None:
            return Ended(summary, False, "nothing was recorded that could be judged", None, None, (), {})
        from ...files import read  # noqa: PLC0415

        drift = 0.0 if sealed.clocks.estimate is None else float(sealed.clocks.estimate.values[1])
        if abs(drift) > DRIFT:
            self._notices.append(
                f"By its own clock the sensor is {number(100.0 * abs(drift), 2)} % off this computer's, or "
                "its rows came later and later, as on a busy computer: gyro scale factors are by this computer's clock"
            )
        path = self.folder / COUNTED
        counted = self._counted_of(read(sealed.file))
        write(path, replace(counted, remarks=()))
        written = {"what counts": str(path)}
        try:
            found = call("positions", [path], self._settings(), options=True)
            guide.judge(found.result.rows())
        except DataError as error:
            return Ended(summary, False, str(error.problems[0]), None, None, (), written)
        figures = tuple(self._figures(guide.known(found.result.rows())))
        reached = all(one.reached for one in figures if one.asked)
        written["campaign"] = str(found.write_campaign(self.folder))
        outcome = run(self.folder)
        written["report"] = str(self.folder / "out" / "report.html")
        for form in self.asked.formats:
            written |= self._exported(found, form)
        return Ended(summary, reached and bool(figures), "", found, outcome, figures, written)

    def _exported(self, found: Reduced, form: str) -> dict[str, str]:
        """Write the models in a format, a file a sensor where it holds one; what cannot be written is told."""
        models = {GROUP[kind]: ModelFile(self.name, dump_model(one).encode(), ModelSet((one,)))
                  for kind, one in found.models.items()}  # fmt: skip
        parts = (
            {f"_{name}": [one] for name, one in models.items()}
            if FORMATS[form].one_sensor
            else {"": [*models.values()]}
        )
        written = {}
        for name, sources in parts.items():
            target = self.folder / f"calibration{name}.{form}"
            try:
                if not sources:
                    raise DataError("no model was made of these figures", code="no_model")
                export(sources[0], form, target, True, sources[1:])
            except InertialcalError as error:
                self._notices.append(f"{form}: {error.problems[0]}")
            else:
                written[f"{form}{name.replace('_', ' ')}"] = str(target)
        return written

    def _last_words(self, ended: Ended) -> str:
        if ended.why:
            return f"No figures: {ended.why}"
        count = len(ended.found.result.readings) if ended.found is not None else 0
        if ended.reached:
            return f"Done after {count} positions: every figure is known as well as was asked for"
        return f"Ended after {count} positions, before every figure was known as well as was asked for"


__all__ = ["COUNTED", "Asked", "Ended", "Figure", "Session", "Shown"]
