"""What a moved mass works on: runs, a value a dwell, or reduced before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...core.remarks import Remark
from ...physics.motion.schedule import Schedule


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of one run, a value a dwell.

    Parameters
    ----------
    name : str
        Of the run.
    schedule : Schedule
        Its n dwells.
    reading : ndarray, shape (n,)
        Mean of each [count/s]; NaN where there is none.
    tilt : ndarray, shape (n,), or None
        Of the pad, as the meter has it [rad]; NaN where there is none, None without a meter.
    temperature : ndarray, shape (n,), or None
        [degC].
    moved : bool
        Whether the mass was moved; in a null run it was not.
    where : str
        Of the readings, for messages.
    """

    name: str
    schedule: Schedule
    reading: Array
    tilt: Array | None = None
    temperature: Array | None = None
    moved: bool = True
    where: str = ""

    @property
    def there(self) -> int:
        """Number of dwells with a reading."""
        return int(np.isfinite(self.reading).sum())


@dataclass(frozen=True)
class Line:
    """One run that was reduced before: its line with the mean amplitude of those beside it, as a document prints them.

    Parameters
    ----------
    name : str
        Of the run.
    applied : float
        Amplitude of the drive; of a null run that of a moved mass [m/s^2].
    response, noise : float
        Amplitude at the drive, and mean amplitude of the lines beside it [count/s].
    beside : int
        How many lines that mean is of.
    u_applied : float
        Relative standard uncertainty of ``applied`` (1).
    moved : bool
        Whether the mass was moved.
    psd_response, psd_noise : float
        The same from the power spectrum [count/s]; NaN where they are not known.
    scatter : float
        Standard deviation of the reduced readings [count/s]; NaN where it is not known.
    where : str
        For messages.
    """

    name: str
    applied: float
    response: float
    noise: float
    beside: int = 8
    u_applied: float = 0.0
    moved: bool = True
    psd_response: float = float("nan")
    psd_noise: float = float("nan")
    scatter: float = float("nan")
    where: str = ""


@dataclass(frozen=True, eq=False)
class Readings:
    """Runs of one instrument.

    Parameters
    ----------
    series : tuple of Run
        With a value a dwell.
    lines : tuple of Line
        Reduced before.
    remarks : tuple of Remark
        What reading them brought up.
    """

    series: tuple[Run, ...] = ()
    lines: tuple[Line, ...] = ()
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of dwells with a reading, and of lines."""
        return sum(run.there for run in self.series) + len(self.lines)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.series) + len(self.lines)
