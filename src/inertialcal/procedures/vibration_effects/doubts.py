"""What a run on a shaker shows that it should not: columns that have changed places.

The control shows vibration over its rest as nothing else in the file: it drove the table by that. A gyro whose
reading rises ten times as far over its rest is no gyro (``swapped_channels``); nor is an accelerometer on the item
shaken ten times as hard as its fixture over a whole band. An accelerometer that moves least along the axis vibrated
along has other axes than it says (``axes_disagree``), and so has a part of a test where each axis rests at the level
that another axis had before. Of a gyro whose axes are exchanged throughout a shaker shows nothing: a rate table does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations

import numpy as np

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from .readings import Vibrated, block_means, block_squares
from .segments import Segment

RISES = 10.0  # rms of the loudest blocks over that of the quietest, that is vibration
FARTHER = 10.0  # times as far as the control, that nothing rises which rides on it
HARDER = 10.0  # rms of an accelerometer over that of the control, that no item reaches over a whole band
WEAK, STRONGER = 0.3, 3.0  # along the axis vibrated along, over the control; of another axis, over that
QUIETEST, LOUDEST = 5.0, 95.0  # of the blocks [%]
SAME = 0.03  # of the distance between levels at rest as named, that is left where axes change places

Run = tuple[Vibrated, int, Sequence[Segment]]


def doubts(runs: Sequence[Run]) -> Iterator[Remark]:
    """Yield what runs show, cut into blocks of so many samples and into segments, that they should not."""
    for run, size, _ in runs:
        yield from _control(run, size)
    yield from _axes_at_rest(runs)


def _control(run: Vibrated, size: int) -> Iterator[Remark]:
    if run.rms:
        if below := int(np.count_nonzero(run.control < 0.0)):
            what = f"recording {run.name}: {below} samples of control_rms are below zero: that is no level"
            do = "Check which column is the level; of an acceleration say control"
            yield Remark("swapped_channels", "error", what, run.file, below, do, recording=run.name)
        return
    control = np.sqrt(block_squares(run.control, size, False))
    each = {axis: np.sqrt(block_squares(values, size, False)) for axis, values in run.axes.items()}
    rise, rises = _rise(control), {axis: _rise(values) for axis, values in each.items()}
    for axis, own in rises.items():
        what, over = "", _loud(each[axis]) / max(_loud(control), 1e-300)
        if run.unit.startswith("rad") and own > RISES and own > FARTHER * rise:
            what = f"{axis} rises {number(own, 2)} times over its rest, the control {number(rise, 2)} times"
        elif not run.unit.startswith("rad") and own > RISES and over > HARDER:
            what = f"{axis} vibrates {number(over, 2)} times as hard as the control"
        if what:
            do = "Check which column is the control, and its unit: it seems to have changed places with this axis"
            yield Remark("swapped_channels", "error", f"recording {run.name}: {what}", run.file, do=do, axis=axis,
                         recording=run.name)  # fmt: skip
            return
    yield from _along(run, each, control)


def _along(run: Vibrated, each: Mapping[str, Array], control: Array) -> Iterator[Remark]:
    """Yield an accelerometer that moves least along the axis that it was vibrated along."""
    along = run.direction
    if not run.unit.startswith("rad") and along in each and _rise(control) > RISES:
        part = {axis: _loud(values) / _loud(control) for axis, values in each.items()}
        most = max(part, key=part.__getitem__)
        if part[along] < WEAK and part[most] > STRONGER * part[along]:
            what = f"recording {run.name}: vibrated along {along}, {along} reads {number(part[along], 2)} of the "
            what += f"control, {most} {number(part[most], 2)}"
            do = "Check the columns of the axes, the mounting, and the axis of the recording"
            yield Remark("axes_disagree", "error", what, run.file, do=do, axis=along, recording=run.name)


def _loud(values: Array) -> float:
    return float(np.nanpercentile(values, LOUDEST))


def _rise(values: Array) -> float:
    """Return how far a channel rises over its rest."""
    quiet = float(np.nanpercentile(values, QUIETEST))
    return _loud(values) / quiet if quiet > 0.0 else np.inf if _loud(values) > 0.0 else 1.0


def _axes_at_rest(runs: Sequence[Run]) -> Iterator[Remark]:
    """Yield the first part at rest of a test where the axes have each other's level."""
    before: Mapping[str, float] = {}
    told = ""
    for run, size, segments in runs:
        means = {axis: block_means(values, size) for axis, values in run.axes.items()}
        for one in (each for each in segments if each.rest):
            part = {axis: values[one.first : one.stop] for axis, values in means.items()}
            level = {axis: float(np.nanmean(x)) for axis, x in part.items() if np.isfinite(x).any()}
            if len(level) < 2 or (before and set(level) != set(before)):
                continue
            if not before:
                before, told = level, run.name
                continue
            axes = list(before)
            own = sum(abs(level[axis] - before[axis]) for axis in axes)
            scatter = sum(float(np.nanstd(x)) / np.sqrt(len(x)) for x in part.values())
            others = [order for order in permutations(axes) if list(order) != axes]
            apart = {
                order: sum(abs(level[a] - before[b]) for a, b in zip(axes, order, strict=True)) for order in others
            }
            best = min(others, key=apart.__getitem__)
            if own > RISES * scatter and apart[best] < SAME * own:
                moved = ", ".join(f"{a} where {b} was" for a, b in zip(axes, best, strict=True) if a != b)
                what = f"recording {run.name}: at rest after {one.first * size * run.interval:.4g} s lies {moved}"
                what += f" ({told})" if told != run.name else ""
                do = "Check the columns of the axes: they seem to have changed places"
                yield Remark("axes_disagree", "error", what, run.file, do=do, recording=run.name)
                return
