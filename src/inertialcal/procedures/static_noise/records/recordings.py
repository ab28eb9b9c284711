"""Records of a sensor at rest, from recordings: put on the grid of their sample interval, the warm-up left out.

Averaging times are counted off in samples, so samples must stand where they were taken. Stamps that are repeated or run
backwards are refused; gaps become missing samples. Where the stamps say when packets arrived, or a sample rate was said
in their place, the samples are taken as evenly spaced, which is remarked: gaps are then not seen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.remarks import Remark, gather
from ....core.show.rounding import number
from ....core.units import factor
from ....signals.allan import on_grid
from ..plan import Plan
from ..readings import Readings, Run
from .at_rest import AtRest
from .clock import Grid, averaging_of, grid_of
from .faults import Told, without_faults

LARGEST = 1e60  # reading: beyond it fourth powers overflow


def readings_from(plan: Plan, recordings: Sequence[AtRest]) -> Readings:
    """Return the records of a test.

    Parameters
    ----------
    plan : Plan
        Its ``warm_up`` is left out at the start of each.
    recordings : sequence of AtRest
        All with the same axes.

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
    found = [_run(plan, one) for one in recordings]
    several = len(recordings) > 1
    remarks = [
        remark.at(one.place) if several else remark
        for one, (_, told) in zip(recordings, found, strict=True)
        for remark in told
    ]
    read = [remark for one in recordings for remark in one.recording.remarks]
    return Readings(tuple(run for run, _ in found), gather([*read, *remarks]))


def _run(plan: Plan, one: AtRest) -> tuple[Run, list[Remark]]:
    grid = grid_of(one)
    averaging = averaging_of(one, grid.interval)
    values: dict[str, NDArray[Any]] = {}
    present: dict[str, NDArray[np.bool_]] = {}
    for axis, name in one.channels.items():
        values[axis], there = _samples(one, name, grid)
        if there is not None:
            present[axis] = there
    quantity = one.quantity
    if quantity == "angle":
        values, present = _differenced(values, present)
        quantity = "increment"
    skipped, more = _skipped(plan, one, next(iter(values.values())), grid.interval)
    run = Run(
        {axis: data[skipped:] for axis, data in values.items()},
        {axis: there[skipped:] for axis, there in present.items()},
        {axis: one.scale.get(axis, 1.0) for axis in values},
        grid.interval,
        averaging,
        quantity,
        one.place,
        skipped,
        None if grid.clock is None else grid.clock[len(one.recording) - len(next(iter(values.values()))) + skipped :],
    )
    run, bad = without_faults(plan, run, {axis: _told(one, axis, present.get(axis), skipped) for axis in values})
    return run, [*grid.remarks, *more, *bad]


def _samples(one: AtRest, name: str, grid: Grid) -> tuple[NDArray[Any], NDArray[np.bool_] | None]:
    """Return the samples of a channel on the grid, and where there is one; None where there is one everywhere."""
    data = one.recording.channel(name).data
    if data.dtype.kind not in "iuf":
        raise DataError(f"column {name!r} holds no numbers", one.place, code="wrong_column")
    _refuse_sizes(data, name, one)
    return _placed(data, one, grid.interval) if grid.placed else (data, None)


def _told(one: AtRest, axis: str, present: NDArray[np.bool_] | None, skipped: int) -> Told:
    """Return how samples of an axis are told: in which unit, and at which row of the file."""
    channel, first = one.recording.channel(one.channels[axis]), one.recording.first_row
    own, shown = channel.unit or "", one.shown or channel.unit or ""

    def row(sample: int) -> int:
        at = skipped + sample
        return first + (at if present is None else int(np.count_nonzero(present[:at]))) if first else 0

    return Told(factor(own, shown) if own and shown else 1.0, shown, row)


def _refuse_sizes(data: NDArray[Any], name: str, one: AtRest) -> None:
    """Refuse numbers that are no reading: their squares are beyond what a number can hold."""
    largest = float(np.max(np.abs(data, where=np.isfinite(data), out=np.zeros(len(data))), initial=0.0))
    if largest > LARGEST:
        what = f"column {name!r} reaches {largest:.3g}"
        raise DataError(what, one.place, "no sensor reads so much", "Look at the file", "wrong_value")


def _placed(data: NDArray[Any], one: AtRest, interval: float) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    stamps = one.recording.time_ns
    assert stamps is not None  # noqa: S101 - asked before
    try:
        return on_grid(data, stamps, interval)
    except DataError as error:
        first = error.problems[0]
        where = f"{one.place}: {first.where}" if first.where else one.place
        raise DataError(first.what, where, first.why, first.do, first.code) from None


def _differenced(
    values: Mapping[str, NDArray[Any]], present: Mapping[str, NDArray[np.bool_]]
) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
    """Return the increments of an integrated signal; unsigned codes as signed ones, so that a step back is one."""
    signed = {axis: x.astype(np.int64) if x.dtype.kind == "u" else x for axis, x in values.items()}
    steps = {axis: np.diff(x) for axis, x in signed.items()}
    return steps, {axis: there[1:] & there[:-1] for axis, there in present.items()}


def _skipped(plan: Plan, one: AtRest, data: NDArray[Any], interval: float) -> tuple[int, list[Remark]]:
    """Return how many samples the warm-up takes."""
    count = int(np.ceil(plan.warm_up / interval - 1e-9))
    if count <= 0:
        return 0, []
    if count >= len(data):
        what = f"a warm-up of {number(plan.warm_up)} s, the record is {number(len(data) * interval)} s long"
        raise DataError(what, one.place, do="Leave out less", code="nothing_left")
    what = f"the first {number(plan.warm_up)} s of {number(len(data) * interval)} s are left out: the warm-up"
    return count, [Remark("warm_up_left_out", "info", what)]
