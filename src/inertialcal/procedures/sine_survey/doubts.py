"""What a sweep and the fit of its modes show that they should not, each by its cause."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...statistics.intervals import coverage_factor
from .plan import Plan
from .sweep import LOST
from .swept import OfAxis, Swept

FALSE_ALARM = 1e-3  # of a remark on a clean survey
OFF_RATE, OFF_RANGE, OFF_LEVEL = 0.01, 0.05, 0.1  # relative, from which a sweep is another one than stated
WEAK = 0.5  # of the level, below which the control is lost
DISTORTED, CLIPPED, EVEN = 0.1, 0.02, 3.0  # harmonics over the drive; third of a clipped one, over the second
FLATTER = 3.0  # times as flat as the control, that only a controlled channel is
RIPPLE = 0.2  # of the logarithm of a level
APART = 0.1  # of their mean, that control channels may differ by
EXPLAINED = 0.98
HIGH = 0.4  # of the sample rate


class Say(Protocol):
    """Makes a remark on one sweep."""

    def __call__(self, code: str, what: str, do: str, error: bool = False) -> Remark:
        """Return it: its code, what was found, what to do."""
        ...


def doubts(plan: Plan, swept: Swept) -> Iterator[Remark]:
    """Yield what a sweep shows that it should not."""
    one, shaken = swept.sweep, swept.shaken

    def said(code: str, what: str, do: str, error: bool = False) -> Remark:
        return Remark(code, "error" if error else "warning", f"recording {swept.label}: {what}", shaken.where, do=do,
                      recording=shaken.name)  # fmt: skip

    yield from _other_than_stated(plan, swept, said)
    yield from _of_drive(swept, said)
    if one.highest > HIGH * shaken.rate:
        what = f"the sweep goes to {number(one.highest, 4)} Hz, sampled at {number(shaken.rate, 5)} Hz"
        yield said("aliasing", f"{what}: what lies above half of that folds back", "Sample five times as fast or more")
    steps = np.abs(np.diff(one.left))
    if len(steps) and float(steps.max()) > LOST:
        at = int(np.argmax(steps))
        what = f"the drive jumps by {number(float(steps[at]), 2)} of a cycle at {one.times[at]:.4g} s"
        do = "Check for lost samples: all later ones are out of step. Repeat the sweep"
        yield said("lost_samples", what, do, error=True)


def _other_than_stated(plan: Plan, swept: Swept, said: Say) -> Iterator[Remark]:
    one = swept.sweep
    if (rate := plan.stated_rate) is not None:
        law, stated = rate
        word = {"log": "octaves a minute", "linear": "Hz a second"}
        size = {"log": 60.0, "linear": 1.0}
        own = f"{number(abs(one.rate) * size[one.law], 4)} {word[one.law]}"
        if law != one.law or abs(abs(one.rate) / stated - 1.0) > OFF_RATE:
            what = f"the sweep goes at {own}, stated are {number(stated * size[law], 4)} {word[law]}"
            yield said("sweep_rate", what, "Correct the rate that is stated, or repeat the sweep")
    if (ends := plan.stated_range) is not None:
        own_ends = (one.start, one.stop)
        if all(_apart(own_ends, way) > OFF_RANGE for way in (ends, ends[::-1])):  # up, or down
            what = f"the sweep goes from {number(one.start, 4)} to {number(one.stop, 4)} Hz, stated are"
            what += f" {number(ends[0], 4)} to {number(ends[1], 4)} Hz"
            yield said("sweep_range", what, "Correct what is stated, or repeat the sweep")
    level = float(np.median(one.amplitude))
    if plan.level is not None and abs(level / plan.level - 1.0) > OFF_LEVEL:
        decibel = 20.0 * math.log10(level / plan.level)
        what = f"the control is {decibel:+.1f} dB off: {number(level, 4)} m/s^2, stated {number(plan.level, 4)} m/s^2"
        yield said("drive_level", what, "Check the level, and the scale factor of the control accelerometer")


def _apart(one: Sequence[float], other: Sequence[float]) -> float:
    return max(abs(a / b - 1.0) for a, b in zip(one, other, strict=True))


def _of_drive(swept: Swept, said: Say) -> Iterator[Remark]:
    one, shaken = swept.sweep, swept.shaken
    frequency, level = one.frequency(one.times), float(np.median(one.amplitude))
    inner = slice(max(1, len(frequency) // 50), -max(1, len(frequency) // 50))
    weak = np.flatnonzero(one.amplitude[inner] < WEAK * level)
    flatness = _flatness(one.amplitude[inner])
    for axis in shaken.responses:
        own = _amplitude(swept, axis)[inner]
        if flatness > RIPPLE and _flatness(own) * FLATTER < flatness:
            what = f"{axis} keeps its level along the sweep, the control does not"
            do = "Check which column is the control: they have changed places"
            yield said("swapped_channels", what, do, error=True)
            return
    if len(weak) > 2:
        lost = np.sort(frequency[inner][weak])
        what = (
            f"the control falls below {WEAK:g} of its level between {number(lost[0], 3)} and {number(lost[-1], 3)} Hz"
        )
        yield said("control_lost", what, "Check the controller, and the mounting of the control accelerometer")
    second, third = (np.where((k + 2) * frequency < 0.45 * shaken.rate, one.harmonics[k], np.nan) for k in (0, 1))
    if np.isfinite(third).any():
        size, even = float(np.nanmedian(third)), float(np.nanmedian(second))
        total = float(np.nanmedian(np.sqrt(np.nansum(one.harmonics**2, axis=0))))
        if size > CLIPPED and size > EVEN * even:
            what = (
                f"the drive has {number(100.0 * size, 2)} % of the third harmonic, {number(100.0 * even, 2)} % of the"
            )
            do = "Lower the gain of the amplifier, or the level: a wave that is cut off has odd harmonics"
            yield said("clipped_drive", f"{what} second: it is clipped", do)
        elif total > DISTORTED:
            what = f"the drive is distorted: {number(100.0 * total, 2)} % of harmonics (median along the sweep)"
            yield said("distortion", what, "Check amplifier and mounting; resonances do not suffer, levels do")
    if len(shaken.controls) > 1:
        yield from _control_apart(swept, said)


def _control_apart(swept: Swept, said: Say) -> Iterator[Remark]:
    one = swept.sweep
    each = {role: np.abs(amplitudes(swept, values)) for role, values in swept.shaken.controls.items()}
    frequency = one.frequency(one.times)
    for role, own in each.items():
        others = np.mean([values for name, values in each.items() if name != role], axis=0)
        m = min(len(own), len(frequency))
        ratio = np.abs(own[:m] / others[:m] - 1.0)
        if float(np.quantile(ratio, 0.9)) > APART and role == max(
            each, key=lambda name: float(np.std(np.log(np.maximum(each[name], 1e-300))))
        ):
            at = float(frequency[:m][int(np.argmax(ratio))])
            what = f"{role} reads up to {number(100.0 * float(ratio.max()), 2)} % off the others, most at"
            do = "Check how fixture and accelerometers are fastened: a loose one moves by itself"
            yield said("control_disagrees", f"{what} {number(at, 3)} Hz", do)


def _flatness(amplitude: Array) -> float:
    return float(np.std(np.log(np.maximum(amplitude, 1e-300))))


def amplitudes(swept: Swept, values: Array) -> NDArray[np.complex128]:
    """Return the complex amplitude of a channel at the drive, at the times of the sums of the sweep."""
    one, rate = swept.sweep, swept.shaken.rate
    edges = np.concatenate([[1.5 * one.times[0] - 0.5 * one.times[1]], 0.5 * (one.times[1:] + one.times[:-1]),
                            [1.5 * one.times[-1] - 0.5 * one.times[-2]]])  # fmt: skip
    first, stop = max(0, round(edges[0] * rate)), min(len(values), round(edges[-1] * rate))
    t = np.arange(first, stop) / rate
    starts = np.clip(np.round(edges[:-1] * rate).astype(np.int64) - first, 0, len(t) - 1)
    turned = values[first:stop] * np.exp(-1j * one.phase(t))
    counts = np.diff(np.append(starts, len(t)))
    return np.asarray(2.0 * np.add.reduceat(turned, starts) / np.maximum(counts, 1))


def _amplitude(swept: Swept, axis: str) -> Array:
    return np.abs(amplitudes(swept, swept.shaken.responses[axis]))


def fit_doubts(of_axis: OfAxis, swept: Sequence[Swept]) -> Iterator[Remark]:
    """Yield what the modes leave, and where sweeps differ by more than their noise."""
    modes, axis = of_axis.modes, of_axis.axis
    if modes.explained < EXPLAINED:
        what = f"{axis}: the modes explain {number(100.0 * modes.explained, 3)} % of the response"
        do = "Check whether the item moves with the control point, chatters, or is driven by something else"
        yield Remark("unexplained", "warning", what, do=do, axis=axis)
    if not len(modes) or not len(of_axis.each):
        return
    tests = len(of_axis.each) * (len(of_axis.each) - 1) // 2 * len(modes) * 2
    chance = 1.0 - FALSE_ALARM / max(tests, 1)
    for (i, one), (j, other) in combinations(enumerate(of_axis.each), 2):
        for k in range(len(modes)):
            for place, values, word in ((3 * k, "frequency", "frequency"), (3 * k + 1, "amplification", "Q")):
                a, b = (float(getattr(each, values)[k]) for each in (one, other))
                u = math.sqrt(one.covariance[place, place] + other.covariance[place, place])
                dof = float(min(one.dof[place], other.dof[place]))
                if u > 0.0 and abs(b - a) > coverage_factor(dof, chance) * u and abs(b / a - 1.0) > 1e-3:
                    what = f"{axis}: {word} of the mode at {number(float(modes.frequency[k]), 4)} Hz is {number(a, 5)}"
                    what += f" in {swept[i].label}, {number(b, 5)} in {swept[j].label}"
                    do = "The item is not linear, or it changed between the sweeps: compare sweeps of one direction"
                    yield Remark("not_linear", "warning", what, do=do, axis=axis)
                    return
