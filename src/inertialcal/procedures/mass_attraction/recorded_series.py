"""The 1969 programme on a series of a recording: a column of any file that is read, or an array.

The series is laid on its sample times; what is missing stays a gap, which the programme closes up. The drive is at zero
and rising at the first sample, as in the report, whose first position is the middle one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import FILE_UNIT, divide, kind, parse_quantity
from ...files import read
from ...files.memory import numbers_of, the_only
from ...files.text.headers import bare_name
from ...signals.programme1969 import cards
from ...signals.programme1969.cards import RecordedCase, Request
from ...signals.programme1969.programme import NG
from .deck import REDUCTIONS, SAMPLES_PER_CYCLE, Deck1969, reduce_deck, reduced_case

MOST = 4000  # samples: the correlations and the centred mean take the square of it
SINE = "Use: inertialcal sine FILE --column x=COLUMN --period PERIOD"
UNEVEN = 0.1  # of a sample time, by which a sample may be off
WHOLE = 0.01  # of a sample, by which a cycle may differ from whole samples
LAGS = 0.6  # of the samples, as the report has 60 lags of 100
WORDS = {word: what for what, word in REDUCTIONS.items()}


def programme_1969(
    source: str | Path | Recording | Array,
    *,
    column: str | None = None,
    tilt: str | None = None,
    period: str | None = None,
    half_period: int | None = None,
    sample_time: str | None = None,
    amplitude: str | None = None,
    reductions: Sequence[str] | None = None,
    samples: int | None = None,
    lags: int | None = None,
    lines: int | None = None,
    wrong: Sequence[int] = (),
    units: Mapping[str, str] | None = None,
    time_column: str | None = None,
    start: str | None = None,
    stop: str | None = None,
    mission_start: str | None = None,
) -> Deck1969:
    """Run the analysis programme of 1969 on a deck of cards or a recorded series, and the same reductions done right.

    Parameters
    ----------
    source : path, Recording or array_like, shape (n,)
        Card images (text, a line a card, or packed with gzip), if none of the other arguments is given; else a
        recording of any format that ``read`` takes, or an array with its ``sample_time``.
    column, tilt : str, optional
        Of the accelerometer, the only column of numbers by default; of the tilt meter, none by default.
    period : str, optional
        Of the drive, a whole number of samples: ``"480 s"``. The drive is at zero and rising at the first sample.
    half_period : int, optional
        The same in samples, as on the cards. 2 by default: four samples a cycle.
    sample_time : str, optional
        From sample to sample; goes before the times of the file.
    amplitude : str, optional
        Of the input, such as ``"23 ng"``, for the scale factor.
    reductions : sequence of str, optional
        In their order: ``"none"``, ``"tilt trace"``, ``"straight line"``, ``"harmonics 10"``, ``"adjusted curve 3"``;
        by default all, the tilt trace where there is one. Harmonics go on from the one before, the others start anew.
    samples, lags, lines : int, optional
        Samples used, all whole cycles by default; lags of the correlations and lines of the spectrum, 0.6 and 0.5 of
        them by default.
    wrong : sequence of int, optional
        Positions of wrong values in the series, from 1.
    units : mapping of str to str, optional
        Of columns, as ``read`` takes them.
    time_column, start, stop, mission_start : str, optional
        As ``read`` takes them.

    Returns
    -------
    Deck1969
        Amplitude of the input line by Fourier series and spectrum, standard deviation and scale factor after each
        reduction; ``curves()`` has series with what was removed (of the adjusted curve the centred mean),
        correlations, spectrum and Fourier lines.

    Raises
    ------
    DataError
        ``bad_card``: the message names card and columns; ``uneven``, ``too_long``, ``too_short``, ``whole_cycles``; as
        ``read`` and as the programme where a request cannot be done.
    UsageError
        If a setting is wrong, or it is not clear which column is meant.
    """
    source = the_only(source)
    reading = {"units": units, "time_column": time_column, "start": start, "stop": stop, "mission_start": mission_start}
    own = (column, tilt, period, half_period, sample_time, amplitude, reductions, samples, lags, lines, wrong or None)
    if isinstance(source, str | Path) and all(one is None for one in (*own, *reading.values())):
        return _deck(source)
    step = None if sample_time is None else _positive(sample_time, "sample time", "s")
    if isinstance(source, str | Path):
        recording = read(source, sample_rate=None if step is None else 1.0 / step, **reading)  # type: ignore[arg-type]
    elif isinstance(source, Recording):
        recording = source
    else:
        recording = Recording((Channel("series", numbers_of(source).astype(np.float64)),), sample_interval=step)
    channel, meter = _channel(recording, column, tilt), None
    interval, places = _grid(recording, step)
    x, lean = np.full((2, int(places[-1]) + 1), np.nan)
    x[places] = np.asarray(channel.data, dtype=np.float64)
    if tilt is not None:
        lean[places] = np.asarray(_named(recording, tilt).data, dtype=np.float64)
        meter = lean
    for position in wrong:
        if not 1 <= position <= len(x):
            raise UsageError(
                f"wrong value at position {position}", do=f"The series has 1 to {len(x)}", code="wrong_value"
            )
        x[position - 1] = np.nan
    per_cycle = _samples_per_cycle(period, half_period, interval)
    good = int(np.count_nonzero(np.isfinite(x) & (np.isfinite(lean) if meter is not None else True)))
    used = _used(good, samples, per_cycle, recording.source.path)
    unit = channel.unit or FILE_UNIT
    applied, per_input = None, f"{unit} per unit of input"
    if amplitude is not None:
        said = parse_quantity(amplitude)
        acceleration = kind(said.unit) == "acceleration"
        of_input = "g" if acceleration else said.unit
        applied = (said.to("g") if acceleration else said.value) / NG
        per_input = f"{unit}/{of_input}" if unit == FILE_UNIT else divide(unit, of_input)
        if not applied > 0.0:
            raise UsageError(f"input amplitude {amplitude}", do="It must be above zero", code="wrong_value")
    most = used // 2 - (used // 2) % max(per_cycle // math.gcd(2, per_cycle), 1)  # so that one is the drive's
    spectrum = most if lines is None else lines
    case = RecordedCase(
        used, interval, max(round(LAGS * used), spectrum) if lags is None else lags, spectrum, per_cycle, x, meter,
        applied, tuple(_requests(reductions, used, per_cycle, meter is not None)),
    )  # fmt: skip
    _check_lags(case)
    name = bare_name(channel.name)
    caption = f"{name}: {used} samples of {number(interval, 6)} s, {per_cycle} a cycle"
    caption += f", input {amplitude}" if amplitude is not None else ""
    found = reduced_case(case, name, caption, unit, per_input)
    return Deck1969(recording.source.path, recording.source.sha256, (found,), _remarks(x, good, used, recording))


def _deck(path: str | Path) -> Deck1969:
    try:
        return reduce_deck(path)
    except DataError as error:
        problem = error.problems[0]
        if problem.code != "bad_card" or not problem.where.endswith(":1"):
            raise
        do = "If it is a recording and no deck of cards: --column COLUMN --half-period SAMPLES, or --period"
        raise DataError([replace(problem, do="; ".join(one for one in (problem.do, do) if one))]) from None


def _named(recording: Recording, name: str) -> Channel:
    own = {bare_name(one.name): one.name for one in recording.channels}  # of a header with units
    found = recording.channel(own.get(name, name))
    if found.data.dtype.kind not in "iufb":
        raise DataError(f"column {name!r} holds no numbers", recording.source.path, code="wrong_column")
    return found


def _channel(recording: Recording, column: str | None, tilt: str | None) -> Channel:
    if column is not None:
        return _named(recording, column)
    numbers = [one for one in recording.channels if one.data.dtype.kind in "iufb" and bare_name(one.name) != tilt]
    if len(numbers) != 1:
        what = f"{len(numbers)} columns of numbers: {', '.join(one.name for one in numbers)}"
        raise UsageError(what, recording.source.path, do="Add: --column COLUMN", code="no_column")
    return numbers[0]


def _positive(text: str, name: str, unit: str) -> float:
    value = parse_quantity(text).to(unit)
    if not (math.isfinite(value) and value > 0.0):
        raise UsageError(f"{name} {text}", do="It must be above zero", code="wrong_value")
    return value


def _grid(recording: Recording, stated: float | None) -> tuple[float, NDArray[np.int64]]:
    """Return the sample time [s], and the place of each sample."""
    times, where = recording.seconds, recording.source.path
    interval = stated or recording.sample_interval
    if not interval and times is not None and len(times) > 1:
        interval = float(np.median(np.diff(times)))
    if not interval or len(recording) < 2:
        do = 'Give it: --sample-time "NUMBER s"'
        raise DataError("the series has no sample time", where, do=do, code="no_time")
    if times is None or stated is not None:
        return interval, np.arange(len(recording))
    at = times / interval
    places = np.rint(at).astype(np.int64)
    off = float(np.abs(at - places).max())
    if off > UNEVEN or (np.diff(places) < 1).any():
        what = f"samples lie up to {number(off * interval, 3)} s off a sample time of {number(interval, 6)} s"
        why = "the programme has no times but the number of the sample"
        raise DataError(what, where, why, f"{SINE}, which takes each sample at its own time", "uneven")
    return interval, places


def _samples_per_cycle(period: str | None, half_period: int | None, interval: float) -> int:
    if period is not None and half_period is not None:
        raise UsageError("period and half period: both are given", do="Give one", code="wrong_value")
    if period is None:
        if half_period is not None and half_period < 1:
            what = f"half period of {half_period} samples"
            raise UsageError(what, do="Need 1 or more", code="wrong_value")
        return SAMPLES_PER_CYCLE if half_period is None else 2 * half_period
    cycle = _positive(period, "period", "s") / interval
    if abs(cycle - round(cycle)) > WHOLE or round(cycle) < 3:
        what = f"a period of {period} is {number(cycle, 5)} samples of {number(interval, 6)} s"
        why = "the programme needs a whole number, 3 or more"
        raise DataError(what, why=why, do=f"{SINE}, which takes any period", code="whole_cycles")
    return round(cycle)


def _used(good: int, stated: int | None, per_cycle: int, where: str) -> int:
    """Return how many samples are used: an even number of whole cycles."""
    whole = math.lcm(2, per_cycle)
    used = good // whole * whole if stated is None else stated
    if used > MOST:
        what = f"{used} samples, the programme is run on {MOST} at most (of 1969: 100)"
        raise DataError(what, where, do="Give a part: --from, --to or --samples", code="too_long")
    if used % whole or not whole <= used <= good:
        what = f"{used} samples of {good}"
        why = f"an even number of whole cycles is needed: a multiple of {whole}"
        raise DataError(what, where, why, "Give --samples, or a longer series", "too_short")
    return used


def _requests(texts: Sequence[str] | None, used: int, per_cycle: int, has_tilt: bool) -> list[Request]:
    whole = per_cycle // math.gcd(2, per_cycle)  # of the window's half, S = JA + 1
    width = max(1, -(-4 // whole)) * whole - 1
    default = {cards.HARMONICS: max(1, used // 10), cards.CURVE: width}
    if texts is None:
        every = [what for what in REDUCTIONS if what != cards.TILT or has_tilt]
        return [Request(what, default.get(what, 0)) for what in every]
    found = []
    for one in texts:
        word, size = one.strip().rstrip("0123456789").strip(), one.strip().split(" ")[-1]
        what = WORDS.get(word)
        numbered = size.isdigit()
        if what is None or (numbered and what not in cards.NUMBERED):
            do = "There are: none, tilt trace, straight line, harmonics NUMBER, adjusted curve NUMBER"
            raise UsageError(f"reduction {one!r}", do=do, code="unknown_name")
        if what == cards.TILT and not has_tilt:
            raise UsageError(
                f"reduction {one!r}", do="Add the column of the tilt meter: --tilt COLUMN", code="no_column"
            )
        found.append(Request(what, int(size) if numbered else default.get(what, 0)))
    return found


def _check_lags(case: RecordedCase) -> None:
    if not 2 <= case.MAXK <= case.MAXL < case.N:
        what = f"{case.MAXL} lags and {case.MAXK} lines of {case.N} samples"
        raise UsageError(what, do="Need 2 lines or more, no more lines than lags, and fewer lags than samples")


def _remarks(x: Array, good: int, used: int, recording: Recording) -> tuple[Remark, ...]:
    found = list(recording.remarks)
    if missing := int(np.count_nonzero(np.isnan(x))):
        what = f"{missing} of {len(x)} values are missing or wrong: the programme closes them up"
        found.append(Remark("closed_up", "warning", what, count=missing))
    if used < good:
        what = f"{used} of {good} samples are used: whole cycles"
        found.append(Remark("whole_cycles", "info", what))
    return tuple(found)


__all__ = ["programme_1969"]
