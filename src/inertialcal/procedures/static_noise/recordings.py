"""Records of a sensor at rest, from recordings: put on the grid of their sample interval, the warm-up left out.

Averaging times are counted off in samples, so samples must stand where they were taken. Stamps that are repeated or run
backwards are refused; gaps become missing samples. Where the stamps say when packets arrived, or a sample rate was said
in their place, the samples are taken as evenly spaced, which is remarked: gaps are then not visible.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import (
    changed,
    count,
    every,
    extremes,
    finite,
    is_stored,
    keep_unchanged,
    kept,
    made,
    masked,
    without,
)
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND
from ...core.remarks import Remark, gather
from ...core.show.rounding import number
from ...core.units import factor
from ...signals.allan import on_grid
from ...signals.record_quality import record_quality
from ...signals.screening.remarks import remarks_of
from ...signals.screening.resolution import Resolution, resolution_of
from ...signals.screening.screen import NO_READINGS, Screening, screen
from ...signals.threads import pays
from ...signals.time.time_axis import AGAIN, TimeAxis, analyse, step_ends
from .axis_noise import Early
from .plan import Plan
from .readings import AtRest, Readings, Run

LARGEST = 1e60  # reading: beyond it fourth powers overflow
FLAG = "flag"  # where the sample interval comes from, when the user said it
NOT_TIME = "not_time"  # remark of reading on a column that was taken for no time
UNIT_OF_TIME = "time_unit_unknown"
AGREES = 0.01  # relative difference of intervals that is passed over
NO_GAP = 1.4  # sample intervals: a longer step is a gap
FEWEST = 2  # samples of a record
SAME_TIME = 1e-3  # relative difference of averaging time and sample interval that is that of two clocks
CHANGES = ("level_step", "noise_change", "slow_wave")  # findings about the record as a whole
SAID_ELSEWHERE = ("missing", "disturbed")  # findings: with the gaps of the curve, and with other disturbances


def readings_from(plan: Plan, recordings: Sequence[AtRest]) -> Readings:
    """Return the records of a test.

    Raises
    ------
    DataError
        If there is none (``no_records``) or they differ in their axes (``wrong_column``); if one has no sample interval
        (``no_time``), stamps that are repeated (``time_repeated``) or run backwards (``time_backwards``), a channel
        of text (``wrong_column``) or of impossible size (``wrong_value``), averages that overlap (``averaging_time``),
        or nothing left after the warm-up (``nothing_left``).
    """
    if not recordings:
        raise DataError("no recordings of a sensor at rest", code="no_records")
    axes = tuple(recordings[0].channels)
    for one in recordings:
        if tuple(one.channels) != axes:
            what = f"axes {', '.join(one.channels)}, the first recording has {', '.join(axes)}"
            raise DataError(what, one.place, do="Name recordings of the same axes", code="wrong_column")
    found = [_run(plan, one, len(recordings) == 1) for one in recordings]
    several = len(recordings) > 1
    remarks = [
        remark.at(one.place) if several else remark
        for one, (_, own) in zip(recordings, found, strict=True)
        for remark in own
    ]
    read = [remark for one in recordings for remark in one.recording.remarks]
    return Readings(tuple(run for run, _ in found), gather([*read, *remarks]))


def _run(plan: Plan, one: AtRest, alone: bool) -> tuple[Run, list[Remark]]:
    grid = grid_of(one)
    averaging = averaging_of(one, grid.interval)
    values: dict[str, NDArray[Any]] = {}
    present: dict[str, NDArray[np.bool_]] = {}
    for axis, name in one.channels.items():
        values[axis], there = _samples(one, name, grid)
        if there is not None:
            present[axis] = there
    quantity = one.quantity
    if quantity == "angle":  # unsigned codes as signed ones, so that a step back is one
        signed = {
            axis: changed(x, lambda part: part.astype(np.int64), np.int64) if x.dtype.kind == "u" else x
            for axis, x in values.items()
        }
        values = {axis: steps_of(x) for axis, x in signed.items()}
        present = {
            axis: made(len(there) - 1, bool, lambda a, b, own=there: own[a + 1 : b + 1] & own[a:b], there[1:])  # type: ignore[misc]
            for axis, there in present.items()
        }
        quantity = "increment"
    skipped, remarks = max(int(np.ceil(plan.warm_up / grid.interval - 1e-9)), 0), list(grid.remarks)
    if skipped:
        length = number(len(next(iter(values.values()))) * grid.interval)
        if skipped >= len(next(iter(values.values()))):
            what = f"a warm-up of {number(plan.warm_up)} s, the record is {length} s long"
            raise DataError(what, one.place, do="Leave out less", code="nothing_left")
        what = f"the first {number(plan.warm_up)} s of {length} s left out as warm-up"
        remarks.append(Remark("warm_up_left_out", "info", what))
    run = Run(
        {axis: data[skipped:] for axis, data in values.items()},
        {axis: there[skipped:] for axis, there in present.items()},
        grid.interval,
        averaging,
        quantity,
        one.place,
        skipped,
        None if grid.clock is None else grid.clock[len(one.recording) - len(next(iter(values.values()))) + skipped :],
        one.recording.source.path,
        cut_off=one.cut_off or one.recording.cut_off,
        power_up=one.power_up,
    )
    shown = {axis: _shown_sample(one, axis, present.get(axis), skipped) for axis in values}
    if not pays(len(run)) or run.present or any(map(is_stored, run.values.values())):
        run, bad = screened(plan, run, shown, one.screening)
        return run, [*remarks, *bad]
    early = Early(plan, run, {axis: sample.times for axis, sample in shown.items()}, alone)
    try:
        looked, bad = screened(plan, run, shown, one.screening, early)
        early.given_to(looked)
    except BaseException:
        early.end()
        raise
    return looked, [*remarks, *bad]


def steps_of(x: NDArray[Any]) -> NDArray[Any]:
    """Return what each sample adds to the one before, shape (n - 1,)."""
    return made(len(x) - 1, x.dtype, lambda a, b: np.diff(x[a : b + 1]), x[1:])


def _samples(one: AtRest, name: str, grid: Grid) -> tuple[NDArray[Any], NDArray[np.bool_] | None]:
    """Return the samples of a channel on the grid, and where there is one; None where there is one everywhere."""
    data = one.recording.channel(name).data
    if data.dtype.kind not in "iuf":
        raise DataError(f"column {name!r} holds no numbers", one.place, code="wrong_column")
    keep_unchanged(data)
    largest = float(np.nanmax(np.abs(extremes(data, infinite=False)), initial=0.0))
    if largest > LARGEST:
        what = f"column {name!r} reaches {largest:.3g}"
        raise DataError(what, one.place, "no sensor reads so much", "Look at the file", "wrong_value")
    stamps = one.recording.time_ns
    if not grid.placed or stamps is None:
        return data, None
    try:
        return on_grid(data, stamps, grid.interval)
    except DataError as error:
        first = error.problems[0]
        where = f"{one.place}: {first.where}" if first.where else one.place
        raise DataError(first.what, where, first.why, first.do, first.code) from None


def _shown_sample(one: AtRest, axis: str, present: NDArray[np.bool_] | None, skipped: int) -> ShownSample:
    """Return how samples of an axis are shown: in which unit, and at which row of the file."""
    channel = one.recording.channel(one.channels[axis])
    own, shown = channel.unit or "", one.shown or channel.unit or ""

    def place(sample: int) -> str:
        at = skipped + sample
        return one.recording.place(at if present is None else int(np.count_nonzero(present[:at])))

    return ShownSample(factor(own, shown) if own and shown else 1.0, shown, place)


@dataclass(frozen=True, eq=False)
class Grid:
    """How samples stand in time."""

    interval: float  # From sample to sample [s]
    placed: bool = False  # Whether the stamps put them on the grid of it
    # shape (n,): Time of each since the first [s], for messages, where samples are taken as evenly spaced
    clock: Array | None = None
    remarks: tuple[Remark, ...] = ()  # What to say


def grid_of(one: AtRest) -> Grid:
    """Return the sample interval, whether samples are to be put on its grid by their stamps, and what to say.

    Raises
    ------
    DataError
        If it has no sample interval (``no_time``), or stamps that are repeated or run backwards.
    """
    recording = one.recording
    given = recording.sample_interval
    stamps = recording.time_ns
    if given is None or not given > 0.0:
        hint = "; ".join(remark.what for remark in recording.remarks if remark.code == NOT_TIME)
        what = "sample interval not known" + (f": {hint}" if hint else "")
        do = "Sort the rows, or add" if hint else "Add"
        do += " the sample rate (--sample-rate HZ) or the time column (--time-column)"
        unsure = [remark for remark in recording.remarks if remark.code == UNIT_OF_TIME]
        if unsure and not hint:
            what, do = f"{what}: {unsure[0].what}", unsure[0].do
        raise DataError(what, one.place, "averaging times are counted in samples", do, "no_time")
    if stamps is None or len(stamps) < FEWEST:
        return Grid(given)
    mean = (int(stamps[-1]) - int(stamps[0])) / SECOND / (len(stamps) - 1)
    shortest, longest = step_ends(stamps)
    even = mean > 0.9 * given and shortest > 0.0 and longest <= NO_GAP * given * SECOND
    if recording.interval_from != FLAG and even:  # the quick answer for most records
        return Grid(mean)
    axis = analyse(stamps)
    if recording.interval_from == FLAG:
        what = "sample rate given: samples taken as evenly spaced, time stamps not used"
        if axis.lost + len(axis.repeated) + len(axis.backward):
            bad = f"{len(axis.repeated)} repeated and {len(axis.backward)} backward stamps"
            what += f", though they show {axis.lost} missing sample(s), {bad}"
            return Grid(given, False, recording.seconds, (Remark("stamps_not_used", "warning", what, one.place),))
        return Grid(given, False, recording.seconds, (Remark("stamps_not_used", "info", what, one.place),))
    regular = axis.pattern == "regular" and axis.interval is not None
    _refuse_disorder(axis, one, regular)
    if not regular or axis.interval is None:
        what = "time stamps are those of packets: samples taken as evenly spaced, gaps cannot be seen"
        return Grid(given, False, recording.seconds, (Remark("stamps_not_used", "warning", what, one.place),))
    uneven = len(axis.gaps) > 0 or abs(axis.interval - given) > AGREES * given
    return Grid(given, True) if uneven else Grid(mean)


def _refuse_disorder(axis: TimeAxis, one: AtRest, regular: bool) -> None:
    """Refuse stamps that run backwards, and repeated ones where each stamp means its own sample."""
    why = "averaging times are counted in samples, in order of time"
    if len(axis.backward):
        what, at, code = f"{len(axis.backward)} stamp(s) run backwards", axis.backward, "time_backwards"
    elif regular and len(axis.repeated):
        what, at, code = f"{len(axis.repeated)} repeated stamp(s)", axis.repeated, "time_repeated"
    else:
        return
    row = one.recording.first_row
    place = f"{one.recording.source.path}:{row + int(at[0])}" if row else f"{one.place}: sample {int(at[0]) + 1}"
    raise DataError(what, place, why, AGAIN, code)


def averaging_of(one: AtRest, interval: float) -> float | None:
    """Return the averaging time of a sample [s]: the sample interval, where they differ only as two clocks do.

    A user gives both times by one clock, and the stamps may be those of another: their ratio counts.

    Raises
    ------
    DataError
        If averages overlap, or last no time.
    """
    said = one.recording.averaging_time
    if said is None:
        return None
    stated = one.recording.sample_interval or interval
    scaled = said * interval / stated if abs(stated / interval - 1.0) <= AGREES else said
    if abs(scaled / interval - 1.0) <= SAME_TIME:
        return interval
    if not 0.0 < scaled <= interval:
        what = f"an averaging time of {number(said)} s every {number(interval)} s"
        why = "overlapping averages share their noise, and 0 s averages nothing"
        do = "Give the averaging time of a sample: at most the sample interval"
        raise DataError(what, one.place, why, do, "averaging_time")
    return scaled


@dataclass(frozen=True)
class ShownSample:
    """How a sample of an axis is shown."""

    times: float  # What a value is multiplied by
    unit: str  # Of the product; empty where nobody said
    place: Callable[[int], str]  # Gives ``file:row`` of a sample

    def value(self, value: float) -> str:
        """Return a value with its unit."""
        return f"{number(value * self.times, 5)} {self.unit}".strip()


def screened(
    plan: Plan, run: Run, shown: Mapping[str, ShownSample], screening: bool = True, early: Early | None = None
) -> tuple[Run, list[Remark]]:
    """Return a record without the samples that are no readings, and what its channels show.

    Parameters
    ----------
    plan : Plan
        Says whether such samples are kept.
    run : Run
        As recorded, the warm-up left out.
    shown : mapping of ShownSample
        How a sample of each axis is shown.
    screening : bool
        False keeps them whatever the plan says.
    early : Early, optional
        That is at work on the record already.
    """
    left_out = screening and plan.disturbed == "leave_out"
    found: dict[str, Screening] = {}
    bad: dict[str, dict[str, int]] = {}
    fine: dict[str, Resolution] = {}
    present, remarks = dict(run.present), []
    for axis, values in run.values.items():
        there = run.there(axis)
        whole = every(there, np.all)
        x = values if whole else masked(values, there)
        one = found[axis] = _undisturbed(screen(x), x, run.interval, left_out)
        known = None if early is None else early.resolution(axis)
        fine[axis] = known or resolution_of(values if whole else kept(values, there), shown[axis].times)
        if "stuck" in one and one["stuck"].count == len(run):
            continue  # the curve says that the channel is constant
        left, counts = there, bad.setdefault(axis, {})
        for code in (code for code in NO_READINGS if code in one and code != "missing"):
            before, left = left, without(left, one.screened(x, (code,)))
            counts[code] = count(before, np.asarray) - count(left, np.asarray)
        if left_out and any(counts.values()):
            present[axis] = left
        fate = "left out" if left_out else "kept in"
        said = remarks_of(one, axis, shown[axis].place, shown[axis].value, run.interval, fate)
        own_remarks = (remark for remark in said if remark.code not in SAID_ELSEWHERE)
        remarks += [replace(remark, axis=axis, recording=run.name) for remark in own_remarks]
    return replace(run, present=present, found=found, bad=bad, resolution=fine, screened=left_out), remarks


def _present(run: Run, axis: str) -> NDArray[Any]:
    """Return the samples of an axis that are there."""
    values, there = run.values[axis], run.there(axis)
    return values if there.all() else values[there]


def _undisturbed(found: Screening, x: NDArray[Any], interval: float, left_out: bool) -> Screening:
    """Return what a channel shows without its disturbances, which raise the noise and shift the level where they are.

    They are left out of the figures, so they are no change of the whole record.
    """
    if not left_out or not {*found.codes} & {*CHANGES}:
        return found
    bad = found.screened(x)
    quality = record_quality(masked(x, without(finite(x), bad)), interval)
    if not quality.disturbances or not quality.at_rest:
        return found
    again = screen(quality.cleaned())
    others = tuple(one for one in found.findings if one.code not in CHANGES)
    return replace(found, findings=(*others, *(one for one in again.findings if one.code in CHANGES)))
