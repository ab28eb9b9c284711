"""What a sweep and the fit of its modes show that they should not, each by its cause."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from .lost import lost_samples
from .modal import Modes
from .plan import Plan
from .residual import amplitudes, residual_at_drive
from .sweep import LOST
from .swept import OfAxis, Swept

OFF_RATE, OFF_RANGE, OFF_LEVEL = 0.01, 0.05, 0.1  # relative, from which a sweep is another one than stated
WEAK = 0.5  # of the level, below which the control is lost
DISTORTED, CLIPPED, EVEN = 0.1, 0.02, 3.0  # harmonics over the drive; third of a clipped one, over the second
FLATTER = 3.0  # times as flat as the control, that only a controlled channel is
RIPPLE = 0.2  # of the logarithm of a level
APART = 0.1  # of their mean, that control channels may differ by
EXPLAINED = 0.98
SOME = 4  # modes that a remark names
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
    strong = one.amplitude > WEAK * float(np.median(one.amplitude))  # the phase of nothing is no phase
    steps = np.where(strong[1:] & strong[:-1], np.abs(np.diff(one.left)), 0.0)
    do = "Check the recorder for lost samples: all later ones are out of step. Repeat the sweep"
    if (loss := lost_samples(one, shaken.rate)) is not None:
        count = number(abs(loss.samples), 2)
        what = f"about {count} sample(s) {'are missing' if loss.samples > 0.0 else 'too many'} at {loss.time:.4g} s"
        yield said("lost_samples", f"{what}: behind them the phase of the drive runs beside its law", do, error=True)
    elif len(steps) and float(steps.max()) > LOST:
        at = int(np.argmax(steps))
        what = f"the drive jumps by {number(float(steps[at]), 2)} of a cycle at {one.times[at]:.4g} s"
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


def _amplitude(swept: Swept, axis: str) -> Array:
    return np.abs(amplitudes(swept, swept.shaken.responses[axis]))


def fit_doubts(of_axis: OfAxis, swept: Sequence[Swept], least: float) -> Iterator[Remark]:
    """Yield what the modes leave, and where sweeps differ by more than their noise."""
    sweeps, axis = of_axis.sweeps, of_axis.axis
    if (explained := min(one.explained for one in (sweeps.modes, *sweeps.each))) < EXPLAINED:
        what = f"{axis}: the modes explain {number(100.0 * explained, 3)} % of the response"
        do = "Check whether the item moves with the control point, chatters, or is driven by something else"
        yield Remark("unexplained", "warning", what, do=do, axis=axis)
    own = sweeps.each if sweeps.differ else [sweeps.drawn] * len(swept)
    found = [(one, there) for one, modes in zip(swept, own, strict=True)
             if (there := residual_at_drive(one, axis, modes, least)) is not None]  # fmt: skip
    if found:
        one, there = max(found, key=lambda pair: pair[1].share)
        what = (
            f"{axis}: {number(100.0 * there.share, 2)} % of the resonance near {number(there.frequency, 4)} Hz follows"
        )
        what += f" the drive beside the modes, {one.label} at {there.time:.4g} s: no modes give the whole sweep"
        do = "The item changed during the sweep, or it is not linear: look for what came loose, sweep up and down again"
        yield Remark("changed_in_sweep", "warning", what, one.shaken.where, do=do, axis=axis)
    if not sweeps.differ:
        return
    told = [
        f"{', '.join(_modes_named(one)) or 'none'} in {label}"
        for label, one in zip(of_axis.labels, sweeps.each, strict=True)
    ]
    what = f"{axis}: the sweeps differ by more than their noise: {'; '.join(told)}"
    do = "The item changed between them, or it is not linear: set sweeps of one direction and level against each other"
    yield Remark("sweeps_differ", "warning", what, do=do, axis=axis)


def _modes_named(modes: Modes) -> list[str]:
    pairs = zip(modes.frequency.tolist(), modes.amplification.tolist(), strict=True)
    return [f"{number(f, 5)} Hz (Q {number(q, 4)})" for f, q in pairs][:SOME]
