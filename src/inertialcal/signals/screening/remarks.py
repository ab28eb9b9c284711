"""What is said of the findings of a channel: one remark for each kind."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...core.remarks import Remark
from ...core.show.rounding import number
from .screen import NO_READINGS, Code, Finding, Screening

DO: dict[Code, str] = {
    "glitch": "Look at the logger and the wiring; compare the figures with and without these samples",
    "disturbed": "Leave it out, or record again undisturbed",
    "saturated": "Use a wider range: saturated samples hide part of the input",
    "stuck": "Look at the wiring and at the logger",
    "repeated": "Remove the copy: it adds no information",
    "repeated_samples": "Log at the rate of the sensor, or slower",
    "missing": "Look at the logger",
    "level_step": "Split the record at the step: terms of long averaging times are wrong across it",
    "noise_change": "Look for what changed, and take the parts as two records",
    "slow_wave": "Look for a thermostat or a duty cycle: slow terms fitted across it are wrong",
}


def remarks_of(
    found: Screening,
    name: str,
    place: Callable[[int], str] = "sample {}".format,
    shown: Callable[[float], str] = "{:g}".format,
    interval: float | None = None,
    fate: str = "",
) -> tuple[Remark, ...]:
    """Return one remark for each kind of finding, in the order of the findings.

    Parameters
    ----------
    found : Screening
        Of the channel.
    name : str
        Of the channel.
    place : callable
        Gives the place of a sample in words: row or time.
    shown : callable
        Gives a value of the channel with its unit.
    interval : float, optional
        From sample to sample [s]; without it lengths are in samples.
    fate : str
        What becomes of samples that are no readings: ``"left out"``.
    """

    def long(samples: float) -> str:
        return f"{_three(samples * interval)} s" if interval else f"{_three(samples)} samples"

    return tuple(
        Remark(
            one.code, "warning",
            f"{name}: {_what(one, found, long, shown)}{f'; {fate}' if fate and one.code in NO_READINGS else ''}",
            place(one.first), len(one.places), DO[one.code], subject=name, index=one.first,
        )
        for one in found.findings
    )  # fmt: skip


def _what(one: Finding, found: Screening, long: Callable[[float], str], shown: Callable[[float], str]) -> str:
    of_all = f"{one.count} of {found.samples} samples"
    lie, repeat, are = ("lies", "repeats", "is") if one.count == 1 else ("lie", "repeat", "are")
    largest = int(np.nanargmax(np.abs(one.size))) if np.isfinite(one.size).any() else 0
    size = _three(abs(float(one.size[largest])))
    if one.code == "noise_change":
        ratio = float(one.size[np.argmax(np.abs(np.log(one.size)))])
        return f"the noise changes to {_three(ratio)} times what it was"
    values = " and ".join(shown(float(value)) for value in np.unique(one.value[np.isfinite(one.value)])[:3])
    texts: dict[Code, str] = {
        "glitch": f"{of_all} {lie} up to {size} standard deviations of the noise from their neighbours",
        "disturbed": f"disturbed for {long(one.count)} in all, by up to {size} standard deviations of the noise",
        "saturated": f"{of_all} {lie} at the end of the range, {values}",
        "stuck": f"stuck at {values} for {long(one.count)} in all",
        "repeated": f"{of_all} {repeat} those {long(float(one.value[0]))} before, one by one",
        "repeated_samples": f"{of_all} {repeat} the sample before",
        "missing": f"{of_all} {are} missing",
        "level_step": f"the level steps by up to {size} standard deviations of the noise",
        "slow_wave": f"a wave of {long(float(one.value[0]))}, {size} standard deviations of the noise high",
    }
    return texts[one.code]


def _three(value: float) -> str:
    """Return a value of three digits, in full: 1000, not 1e+03."""
    return number(float(number(value, 3))) if np.isfinite(value) else "-"
