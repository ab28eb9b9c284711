"""Sample rates of the recordings of a test: which of them is not that of the others."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from ...core.remarks import Remark

ALIKE = 1.05  # ratio of rates that are the same
WRONG_BY = 1.5  # ratio from which they are not


def rate_remarks(recordings: Sequence[tuple[str, str, float]]) -> tuple[Remark, ...]:
    """Return a remark for each recording that has another sample rate than most of the same sensor.

    Parameters
    ----------
    recordings : sequence of (str, str, float)
        Name, file and sample rate [Hz] of each.
    """
    rates = [rate for _, _, rate in recordings]
    if len(rates) < 2 or max(rates) < WRONG_BY * min(rates):
        return ()
    usual = median(rates)
    most = 2 * sum(_ratio(rate, usual) <= ALIKE for rate in rates) > len(rates)
    do = "Check the unit of time and the sample rate of each"
    if not most:
        slow, fast = (pick(recordings, key=lambda one: one[2]) for pick in (min, max))
        what = f"recording {slow[0]} has {slow[2]:.6g} Hz, recording {fast[0]} {fast[2]:.6g} Hz"
        return (Remark("sample_rate_disagrees", "warning", what, f"{slow[1]}, {fast[1]}", do=do),)
    return tuple(
        Remark(
            "sample_rate_disagrees", "warning", f"recording {name} has {rate:.6g} Hz, most others {usual:.6g} Hz",
            file, do=do, subject=name,
        )
        for name, file, rate in recordings
        if _ratio(rate, usual) >= WRONG_BY
    )  # fmt: skip


def _ratio(one: float, other: float) -> float:
    return max(one / other, other / one)
