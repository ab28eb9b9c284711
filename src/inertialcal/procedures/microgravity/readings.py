"""Records of the environment: samples on one clock each, stretches without a gap, what was taken off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, cast

from numpy.typing import NDArray

from ...core.batches import where_steps
from ...core.errors import DataError
from ...core.key import AXES, Origin
from ...core.recording import SECOND, Recording, Times
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.unknowns import Unknowns
from ..corrections import corrected
from ..protocol import Correction, Source
from ..static_noise.readings import AtRest
from ..static_noise.recordings import grid_of
from .curve_file import Requirement, read_requirement
from .plan import Plan

if TYPE_CHECKING:
    from .entry import EnvironmentEntry

GAP = 1.5  # sample intervals, from which a step is a gap
SAME_RATE = 1e-3  # by which sample rates of stretches may differ
OTHER_AXES = "not_sensor_axes"  # remark of the reader
HERTZ = 2.5  # sample rate over cut-off, where nobody states the cut-off


@dataclass(frozen=True, eq=False)
class Track:
    """One record."""

    values: tuple[NDArray[Any], ...]  # an array an axis, shape (n,), NaN where missing [m/s^2]
    axes: tuple[str, ...]
    stretches: tuple[tuple[int, int], ...]  # first and stop of each
    starts: tuple[float, ...]  # of each stretch, since the first sample of all records [s]
    interval: float  # [s]
    name: str = ""
    file: str = ""
    cut_off: float | None = None
    taken_off: Mapping[Origin, Unknowns] = field(default_factory=dict["Origin", "Unknowns"])
    corrected: tuple[str, ...] = ()  # axes that an earlier test took something off

    def __len__(self) -> int:
        return len(self.values[0])


@dataclass(frozen=True, eq=False)
class Readings:
    """All records of a test, in order of time."""

    tracks: tuple[Track, ...]
    requirement: Requirement | None = None
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(map(len, self.tracks))

    @property
    def runs(self) -> int:
        """Number of records."""
        return len(self.tracks)


def readings_from(plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
    """Return the records of a test.

    Raises
    ------
    DataError
        ``no_axes``, ``several_clocks``, ``overlapping_files``, ``wrong_frame``, ``rate_changes``; as the grid of a
        record at rest.
    """
    named = [(source, label, one) for source in sources for label, one in source.recordings()]
    off: list[Mapping[Origin, Unknowns]] = [{} for _ in named]
    made = [one for _, _, one in named]
    if corrections:
        made, off = corrected(corrections, [(label, one) for _, label, one in named])
    begin = min((int(one.time_ns[0]) for one in made if one.time_ns is not None and len(one)), default=0)
    tracks, remarks, spans = [], [], []
    after = 0.0
    for (source, label, before), one, unknowns in zip(named, made, off, strict=True):
        if (plan.bias or corrections) and any(remark.code == OTHER_AXES for remark in one.remarks):
            what = f"recordings.{label}: the axes of the readings are not those of the sensor"
            raise DataError(what, source.file, "a bias is that of an axis of the sensor",
                            "Read them in the axes of the sensor (frame)", "wrong_frame")  # fmt: skip
        found, said = _track(one, source, label, begin, after)
        found = replace(found, taken_off=unknowns, corrected=_taken_off(before, one))
        after = found.starts[-1] + (found.stretches[-1][1] - found.stretches[-1][0]) * found.interval
        tracks.append(found)
        spans.append((found.starts[0], after, label, source.file))
        remarks += [*one.remarks, *said]
    rates = sorted({round(1.0 / one.interval, 3) for one in tracks})
    if rates[-1] > rates[0] * (1.0 + SAME_RATE):
        what = f"records of {len(rates)} sample rates: {', '.join(f'{rate:g}' for rate in rates[:6])} Hz"
        raise DataError(what, sources[0].file, "their spectra have other lines", "Give each rate a test of its own",
                        "several_clocks")  # fmt: skip
    for (_, stop, first, _), (start, _, second, file) in pairwise(sorted(spans)):
        if start < stop - 0.5 * tracks[0].interval:
            what = f"{second} begins {number(stop - start, 4)} s before {first} ends"
            raise DataError(what, file, "the same time would count twice", "Leave one of them out", "overlapping_files")
    if len({one.axes for one in tracks}) > 1:
        what = f"records of other axes: {'; '.join(sorted({', '.join(one.axes) for one in tracks}))}"
        raise DataError(what, sources[0].file, do="Give records of the same axes", code="no_axes")
    return Readings(tuple(sorted(tracks, key=lambda one: one.starts[0])), _requirement(sources), tuple(remarks))


def _requirement(sources: Sequence[Source]) -> Requirement | None:
    for source in sources:
        entry = cast("EnvironmentEntry", source.entry)
        if entry.curve is not None:
            return source.read_file(entry.curve, read_requirement)
    return None


def _taken_off(before: Recording, after: Recording) -> tuple[str, ...]:
    """Return the axes of a recording that something was taken off: a flip has no bias of the axis of its turn."""
    return tuple(axis for axis in AXES if axis in after.names
                 and after.channel(axis).data is not before.channel(axis).data)  # fmt: skip


def _track(one: Recording, source: Source, label: str, begin: int, after: float) -> tuple[Track, Sequence[Remark]]:
    axes = tuple(axis for axis in AXES if axis in one.names)
    if not axes:
        raise DataError(f"recordings.{label}: no axis x, y or z", source.file, code="no_axes")
    grid = grid_of(AtRest(one, dict(zip(axes, axes, strict=True)), "rate", label))
    times = one.time_ns if grid.clock is None else None
    stretches = _stretches(len(one), times, grid.interval)
    if times is None:
        starts = tuple(after + first * grid.interval for first, _ in stretches)
    else:
        starts = tuple((int(times[first]) - begin) / SECOND for first, _ in stretches)
        _check_rate(stretches, times, grid.interval, label, source.file)
    values = tuple(one.channel(axis).data for axis in axes)
    cut_off = source.facts.cut_off or one.cut_off
    return Track(values, axes, stretches, starts, grid.interval, label, source.file, cut_off), grid.remarks


def _stretches(n: int, times: Times | None, interval: float) -> tuple[tuple[int, int], ...]:
    if times is None:
        return ((0, n),)
    longest = GAP * interval * SECOND
    edges = [0, *where_steps(times, lambda step: step > longest).tolist(), n]
    return tuple(pairwise(edges))


def _check_rate(stretches: Sequence[tuple[int, int]], times: Times, interval: float, label: str, file: str) -> None:
    """Refuse a record whose sample rate changes on the way."""
    for first, stop in stretches:
        if stop - first < 100:
            continue
        own = (int(times[stop - 1]) - int(times[first])) / SECOND / (stop - 1 - first)
        middle = (first + stop) // 2
        half = (int(times[middle]) - int(times[first])) / SECOND / (middle - first)
        if max(abs(own / interval - 1.0), abs(half / own - 1.0)) > 10.0 * SAME_RATE:
            what = f"recordings.{label}: the sample rate changes: {number(1.0 / interval, 5)} Hz, then"
            what += f" {number(1.0 / (2.0 * own - half if own != half else own), 5)} Hz"
            raise DataError(what, file, "spectra need one rate", "Take a part of one rate", "rate_changes")
