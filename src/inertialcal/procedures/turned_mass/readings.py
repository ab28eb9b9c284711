"""Readings of a turned-mass campaign: recordings cut into the runs of their programme.

A sample is the mean over its gate and belongs to a run if all of it lies there; what lies in none is left out and
counted. Gaps stay gaps: each sample keeps its time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.times import read_elapsed, read_instant
from ...physics.motion.turns import Turn
from ..corrections import corrected
from ..protocol import Correction, Source
from .entry import Turned, TurnedEntry
from .programme import read_programme

SAME = 0.01  # relative difference of gate and averaging time that rounding explains
FEWEST = 12  # samples of a run
HALF = 0.5  # of the time of a run, that must have readings


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of one run."""

    turn: Turn  # Of the programme
    times: Array  # Middles of the gates from the start of the run [s], shape (n,)
    reading: Array  # Mean over each gate [count/s], shape (n,)
    gate: float  # [s]
    where: str = ""  # File, for messages
    recording: str = ""  # As the campaign calls it

    @property
    def name(self) -> str:
        """Of the run."""
        return self.turn.run

    @property
    def angle(self) -> Array:
        """Angle of the mass in the middle of each gate [rad]."""
        return np.asarray(self.turn.angle + self.turn.rate * self.times)


@dataclass(frozen=True, eq=False)
class Readings:
    """Runs of one instrument, and remarks from reading them."""

    series: tuple[Run, ...]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of readings."""
        return sum(len(one.reading) for one in self.series)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.series)


def readings_from(sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
    """Return the runs of all recordings, after corrections.

    What is not known of a correction changes no amplitude: a constant does not turn with the mass.

    Raises
    ------
    DataError
        ``gate_disagrees`` if gate and averaging time differ; ``no_time``, ``no_run``, ``schedule_differs`` where record
        and programme do not belong together; ``run_twice``.
    """
    runs: list[Run] = []
    remarks: list[Remark] = []
    for source in sources:
        turned = cast("TurnedEntry", source.entry).turned
        assert turned is not None  # noqa: S101 - as the file was checked
        programme = source.read_file(turned.schedule, read_programme)
        named = source.recordings()[0]
        body = corrected(corrections, [named])[0][0] if corrections else named[1]
        gate = _gate(source, body)
        for one in _cut(source, body, gate, turned, _chosen(source, turned, programme)):
            if any(one.name == other.name for other in runs):
                what = f"run {one.name} is in two recordings"
                do = "Name each recording as its run, or give it turned.run"
                raise DataError(what, source.file, "its readings would count twice", do, "run_twice")
            runs.append(one)
        remarks += list(body.remarks)
    return Readings(tuple(runs), tuple(remarks))


def _gate(source: Source, body: Recording) -> float:
    gate = float(source.facts.gate or 0.0)
    averaging = None if source.entry.clock is None else source.entry.clock.averaging
    if averaging is not None and abs(averaging / gate - 1.0) > SAME:
        what = f"recordings.{source.name}: clock.averaging is {averaging:g} s, the gate of the chain {gate:g} s"
        why = "the scale factor would be wrong by their ratio"
        raise DataError(what, source.file, why, "Correct the wrong one", "gate_disagrees")
    if body.time_ns is None or len(body.time_ns) < FEWEST:
        what = f"{source.name}: the recording has no time" if body.time_ns is None else (
            f"{source.name}: {len(body.time_ns)} samples")  # fmt: skip
        raise DataError(what, source.file, "the phase of the turn needs it", "Name the time column", "no_time")
    step = float(np.median(np.diff(body.time_ns))) / SECOND
    if gate > step * (1.0 + SAME):
        what = f"{source.name}: a gate of {gate:g} s, but a sample every {step:g} s"
        why = "gates cannot overlap; the scale factor would be wrong by their ratio"
        raise DataError(what, source.file, why, "Correct the gate", "gate_disagrees")
    return gate


def _chosen(source: Source, turned: Turned, programme: Sequence[Turn]) -> list[Turn]:
    named = source.name if any(one.run == source.name for one in programme) else None
    run = named if turned.run is None else turned.run.strip(" \t")  # as cells are
    chosen = [one for one in programme if run in (None, one.run)]
    if not chosen:
        what = f"{source.name}: no run {run!r} in {turned.schedule}"
        raise DataError(what, source.file, do=f"There are: {', '.join(one.run for one in programme)}", code="no_run")
    return chosen


def _cut(source: Source, body: Recording, gate: float, turned: Turned, turns: Sequence[Turn]) -> Iterator[Run]:
    """Yield the runs of a recording."""
    assert body.time_ns is not None  # noqa: S101 - checked with the gate
    axis = next(one for one in source.facts.axes if one in (source.entry.channels or {}))
    rate = np.asarray(body.channel(axis).data, dtype=np.float64) * (source.facts.output_scale_factor or 1.0)
    there = np.isfinite(rate)
    first = int(body.time_ns[0]) - round(0.5 * gate * SECOND)
    zero = _begin(source, body, turned, first - round(turns[0].start * SECOND))
    seconds = (body.time_ns - zero) / SECOND
    slack = SAME * gate
    for turn in turns:
        inside = (seconds - 0.5 * gate >= turn.start - slack) & (seconds + 0.5 * gate <= turn.stop + slack) & there
        step = float(np.median(np.diff(seconds)))
        covered = np.count_nonzero(inside) * step / (turn.stop - turn.start)
        if np.count_nonzero(inside) < FEWEST or covered < HALF:
            what = f"{source.name}: {100.0 * covered:.0f} % of run {turn.run} have readings"
            span = f"the recording lasts from {seconds[0] - 0.5 * gate:.0f} s to {seconds[-1] + 0.5 * gate:.0f} s"
            why = f"{span} of the programme, the run from {turn.start:.0f} s to {turn.stop:.0f} s"
            do = "Check begin, the clock, and start and stop of the programme"
            raise DataError(what, source.file, why, do, "schedule_differs")
        yield Run(turn, seconds[inside] - turn.start, rate[inside], gate, source.file, source.name)


def _begin(source: Source, body: Recording, turned: Turned, by_default: int) -> int:
    """Return when the programme starts on the clock of a recording [ns]."""
    if turned.begin is None:
        return by_default
    try:
        return (read_instant if body.epoch == "utc" else read_elapsed)(turned.begin)
    except ValueError as error:
        clock = "UTC" if body.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {source.file} is {clock}"
        raise DataError(f"recordings.{source.name}.turned.begin: {error}", why=why, code="wrong_time") from None


def with_turn(run: Run, turn: Turn) -> Run:
    """Return a run as if it had been made by another turn, which starts when it did."""
    return replace(run, turn=replace(turn, run=run.name, start=run.turn.start, stop=run.turn.stop))
