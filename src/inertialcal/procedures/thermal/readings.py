"""What a thermal test works on: recordings of a unit whose temperature changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.remarks import Remark


@dataclass(frozen=True, eq=False)
class Sweep:
    """One recording of a unit at rest while its temperature changed.

    Parameters
    ----------
    name, run, place : str
        Of the recording; its power-up, empty where not given; its file, for messages.
    time : ndarray, shape (n,), or None
        Since power-up [s]; None where no time is known.
    temperature : mapping of str to ndarray, shape (n,)
        Of each axis' sensor [degC].
    outputs : mapping of str to ndarray, shape (n,)
        Reading of each axis [rad/s] or [m/s^2]; NaN where missing.
    references : mapping of str to mapping of str to ndarray, shape (n,)
        Name of a reference voltage -> axis -> its volts [V].
    pressure : ndarray, shape (n,), or None
        [Pa]
    """

    name: str
    run: str
    place: str
    time: Array | None
    temperature: Mapping[str, Array]
    outputs: Mapping[str, Array]
    references: Mapping[str, Mapping[str, Array]] = field(default_factory=dict[str, Mapping[str, Array]])
    pressure: Array | None = None

    def __len__(self) -> int:
        return len(next(iter(self.outputs.values()))) if self.outputs else 0


@dataclass(frozen=True, eq=False)
class Readings:
    """Recordings of one unit.

    Parameters
    ----------
    sweeps : tuple of Sweep
        Those of a run in order of time.
    unit : {"rad/s", "m/s^2"}
        Of the readings.
    remarks : tuple of Remark
        What reading them brought up.
    """

    sweeps: tuple[Sweep, ...]
    unit: str = "rad/s"
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one) for one in self.sweeps)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read, in order."""
        return tuple(axis for axis in AXES if any(axis in one.outputs for one in self.sweeps))

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the runs, in the order of their first recording."""
        return tuple(dict.fromkeys(one.run for one in self.sweeps))

    @property
    def runs(self) -> int:
        """Number of runs that can be told apart; 0 where none is given."""
        return len([label for label in self.labels if label])

    @property
    def where(self) -> str:
        """Place of the first recording, for messages."""
        return self.sweeps[0].place if self.sweeps else ""


def span_of(readings: Readings, axis: str) -> tuple[float, float]:
    """Return the lowest and highest temperature of an axis' sensor [degC]; NaN where there is none."""
    values = [one.temperature[axis] for one in readings.sweeps if axis in one.temperature]
    found = [one[np.isfinite(one)] for one in values]
    every = np.concatenate(found) if found else np.zeros(0)
    return (float(every.min()), float(every.max())) if len(every) else (np.nan, np.nan)
