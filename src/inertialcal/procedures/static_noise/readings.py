"""What a test of noise works on: records of a sensor at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import finite, made
from ...core.estimate import Array
from ...core.recording import Recording
from ...core.remarks import Remark
from ...sensors.noise.simulate import simulate as samples_of
from ...sensors.noise.terms import Term
from ...signals.allan import Allan
from ...signals.names import Quantity
from ...signals.screening.resolution import Resolution
from ...signals.screening.screen import Screening
from .plan import Plan


@dataclass(frozen=True, eq=False)
class Run:
    """One record of a sensor at rest, on the regular grid of its sample interval."""

    # shape (n,): Of each axis, SI, or in the unit of the file where the sensor is of no known kind; NaN: missing
    values: Mapping[str, NDArray[Any]]
    present: Mapping[str, NDArray[np.bool_]]  # shape (n,): Of an axis: where a sample is there; absent where all are
    interval: float  # From sample to sample [s]
    averaging: float | None = None  # What each sample is the mean of [s]; None when nobody said
    quantity: Quantity = "rate"  # What a sample is: a rate, or what was added in it. Angles are differenced before
    name: str = ""  # Of the record, for messages
    warm_up: int = 0  # Samples left out at the start
    # shape (n,): Time of each sample since the first of the recording [s], for messages; None where samples are
    # counted
    clock: Array | None = None
    file: str = ""  # Of its recording
    found: Mapping[str, Screening] = field(default_factory=dict[str, Screening])  # What axes show, where they do
    # Samples of an axis that are no readings, by code: left out of ``present``, or kept where ``screened`` is False
    bad: Mapping[str, Mapping[str, int]] = field(default_factory=dict[str, Mapping[str, int]])
    # Of an axis: below it lines in a spectrum mean nothing; absent where it is not known
    resolution: Mapping[str, Resolution] = field(default_factory=dict[str, Resolution])
    screened: bool = True  # Whether samples that are no readings, and disturbances, are left out
    cut_off: float | None = None  # Of a low pass, as the sensor or the file states it [Hz]; None when nobody said
    power_up: str = ""  # In which it was made; empty where not said
    # Deviations that terms are fitted to, by axis and unit, of all samples that are there: taken once
    curves: dict[tuple[str, str], Allan] = field(
        init=False, default_factory=dict["tuple[str, str]", "Allan"], repr=False
    )

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    def there(self, axis: str) -> NDArray[np.bool_]:
        """Return where an axis has a sample, shape (n,)."""
        values, given = self.values[axis], self.present.get(axis)
        if given is None:
            return finite(values)
        return made(len(values), bool, lambda a, b: np.isfinite(values[a:b]) & given[a:b], values, given)

    def left_out(self, axis: str) -> int:
        """Return how many samples of an axis are left out, since they are no readings; but disturbances."""
        bad = self.bad.get(axis, {}) if self.screened else {}
        return sum(count for code, count in bad.items() if code != "disturbed")

    def time(self, sample: int) -> float:
        """Return when a sample was taken, since the first of the recording, warm-up included [s]."""
        if self.clock is not None:
            return float(self.clock[sample])
        return (self.warm_up + sample) * self.interval

    @property
    def length(self) -> float:
        """Of the record [s]."""
        return len(self) * self.interval

    def rates(self, axis: str) -> Array:
        """Return the samples of an axis as rates, shape (n,), not to be changed; NaN where one is missing."""
        values, there = self.values[axis], self.present.get(axis)
        if values.dtype == np.float64 and self.quantity == "rate" and there is None:
            return values

        def part(first: int, stop: int) -> Array:
            found: Array = values[first:stop].astype(np.float64)
            if self.quantity != "rate":
                found /= self.interval
            if there is not None:
                found[~there[first:stop]] = np.nan
            return found

        return made(len(values), np.float64, part, values, *(() if there is None else (there,)))


@dataclass(frozen=True, eq=False)
class Readings:
    """Records of one sensor at rest."""

    records: tuple[Run, ...]  # All with the same axes
    remarks: tuple[Remark, ...] = ()  # What reading them brought up

    def __len__(self) -> int:
        """Return the number of records."""
        return len(self.records)

    @property
    def runs(self) -> int:
        """Number of records: each is taken as a run by itself."""
        return len(self.records)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read, in order."""
        return tuple(self.records[0].values) if self.records else ()

    @property
    def length(self) -> float:
        """Of all records together [s]."""
        return sum(run.length for run in self.records)


@dataclass(frozen=True, eq=False)
class AtRest:
    """A recording of a sensor at rest."""

    recording: Recording  # With its channels
    channels: Mapping[str, str]  # Which channel is which axis
    quantity: Quantity = "rate"  # What its samples are
    name: str = ""  # For messages; its file where not given
    shown: str = ""  # Unit that samples are told in; that of the channel where not given
    screening: bool = True  # Whether samples that are no readings are left out
    cut_off: float | None = None  # Of the sensor's low pass [Hz]; as the file states it where not given
    power_up: str = ""  # In which it was made; empty where not said

    @property
    def place(self) -> str:
        """Name of the recording, for messages."""
        return self.name or self.recording.source.path or "recording"


@dataclass(frozen=True)
class Truth:
    """Terms of each axis, and how they are recorded."""

    terms: Mapping[str, tuple[Term, ...]]  # Of each axis [SI]
    samples: int  # Of each record
    interval: float  # From sample to sample [s]
    averaging: float | None = None  # What each sample is the mean of [s]; the interval by default
    runs: int = 1  # Records


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return records of the terms, after the warm-up of the plan."""
    skipped = int(np.ceil(plan.warm_up / truth.interval - 1e-9))
    runs = []
    for number in range(truth.runs):
        drawn = {
            axis: samples_of(terms, truth.samples + skipped, truth.interval, rng, truth.averaging)[skipped:]
            for axis, terms in truth.terms.items()
        }
        runs.append(Run(drawn, {}, truth.interval, truth.averaging, "rate", f"run {number + 1}", skipped))
    return Readings(tuple(runs))
