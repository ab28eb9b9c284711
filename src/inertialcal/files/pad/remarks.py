"""What a user should know of an archive record: what was applied already, what was not, and how its time was made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...core.times import instant_text
from .header import PadHeader
from .time import Stamps

PLACEHOLDER = (1.23, 4.46, 7.89)  # BiasCoeff of several heads in the archive, digits in a row
LONGER = 1.5  # step, in intervals, from which samples are missing
BLOCK = 2**18  # stamps


def header_remarks(header: PadHeader, where: str) -> tuple[Remark, ...]:
    """Return what the header says was done to the data, and the bias that it gives and that was not applied."""
    said = [f"DataQualityMeasure {header.quality!r}"] if header.quality else []
    said += [f"{name} {value:g}" for name, value in (("Gain", header.gain),) if value is not None]
    said += [f"CutoffFreq {header.cutoff:g} Hz"] if header.cutoff is not None else []
    said += [f"ScaleFactor {_triple(header.scale_factor)}"] if header.scale_factor else []
    remarks = []
    if said:
        do = "What was done to the data is in them: it is not done again here"
        remarks.append(Remark("as_archived", "info", f"the header says: {', '.join(said)}", where, do=do))
    if header.bias is not None and any(header.bias):
        digits = " (placeholder digits, which several heads have)" if header.bias == PLACEHOLDER else ""
        what = f"BiasCoeff {_triple(header.bias)}{digits} in the header is not applied"
        remarks.append(Remark("bias_not_applied", "warning" if digits else "info", what, where))
    return tuple(remarks)


def time_remarks(stamps: Stamps, sample_rate: float, where: str) -> tuple[Remark, ...]:
    """Return how the stamps were made, and whether the file's own run away from them."""
    n = len(stamps.time_ns)
    if stamps.drifts:
        off = 1e6 * (stamps.interval * sample_rate - 1.0)
        what = (
            f"the file's own time runs away from TimeZero + n/({sample_rate:.9g} Hz) by up to "
            f"{stamps.deviation:.4g} s ({off:+.3g} ppm): its stamps say {1.0 / stamps.interval:.9g} Hz"
        )
        do = f"If the stamps are right: --sample-rate {1.0 / stamps.interval:.9g}"
        return (Remark("stamps_drift", "warning", what, where, do=do),)
    what = (
        f"stamps made as TimeZero + n/({sample_rate:.9g} Hz); the file's own time, 32 bits wide, agrees within "
        f"{1e6 * stamps.deviation:.3g} us over {n} samples"
    )
    return (Remark("stamps_made", "info", what, where),)


def gap_remark(time_ns: Times, sample_rate: float, path: str) -> tuple[Remark, ...]:
    """Return one remark on the gaps inside and between the files."""
    interval = SECOND / sample_rate
    after = [
        first + np.flatnonzero(np.diff(time_ns[first : first + BLOCK + 1]) > LONGER * interval)
        for first in range(0, len(time_ns), BLOCK)
    ]
    at = np.concatenate(after) if after else np.empty(0, dtype=np.int64)
    if not len(at):
        return ()
    steps = (time_ns[at + 1] - time_ns[at]).astype(np.float64)
    missing = int(np.rint(steps / interval).sum()) - len(at)
    what = (
        f"gap: {missing} sample(s) missing in all, longest step {steps.max() / SECOND:.6g} s against "
        f"{1e3 / sample_rate:.4g} ms; the first after {instant_text(int(time_ns[at[0]]))}"
    )
    return (Remark("gaps", "warning", what, path, count=len(at)),)


def change_remarks(headers: Sequence[PadHeader], names: Sequence[str]) -> tuple[Remark, ...]:
    """Return what changes from file to file: gain, filter, what was applied."""
    remarks = []
    for code, what, said in (
        ("gain_changed", "Gain", [header.gain for header in headers]),
        ("filter_changed", "CutoffFreq", [header.cutoff for header in headers]),
        ("scale_factor_changed", "ScaleFactor", [header.scale_factor for header in headers]),
        ("quality_changed", "DataQualityMeasure", [header.quality for header in headers]),
    ):
        changes = [i for i in range(1, len(said)) if said[i] != said[i - 1]]
        if changes:
            first = changes[0]
            text = f"{what} changes between files, from {said[first - 1]} to {said[first]}"
            do = "Use one part alone (--from, --to)"
            remarks.append(Remark(code, "warning", text, names[first], count=len(changes), do=do))
    return tuple(remarks)


def _triple(values: Sequence[float] | None) -> str:
    return " ".join(f"{axis}={value:g}" for axis, value in zip("xyz", values or (), strict=False))
