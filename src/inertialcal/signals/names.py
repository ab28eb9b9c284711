"""Names of ways to look at a record, as plans and options have them. Free of numpy."""

from __future__ import annotations

from typing import Literal

Deviation = Literal[
    "overlapping", "non_overlapping", "modified", "hadamard", "overlapping_hadamard", "total", "modified_total",
    "hadamard_total",
]  # fmt: skip
Quantity = Literal["rate", "increment", "angle"]  # what a sample is
Method = Literal["welch", "multitaper"]  # of a spectrum
