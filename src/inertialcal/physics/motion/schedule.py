"""Schedule of a mass-attraction test: where the mass dwells, when, and what it applies there.

A cycle is a whole number of dwells. With a dwell of 100 s, a move of 20 s and four dwells a cycle, the drive has the
period 480 s, as in [1]_: the pauses count. Times run from the schedule's own zero, which is not the recording's.

References
----------
.. [1] Reinel, NASA TM X-53857, 1969, Appendix B.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import PlanError
from ...core.estimate import Array

Drive = Literal["sine", "square", "abab", "custom"]
DRIVES: tuple[str, ...] = get_args(Drive)
UNITS = {"start": "s", "stop": "s", "position": "m", "applied": "m/s^2"}  # columns of a file, for every dwell
MERCURY = {"mercury": "rad"}  # of a tilt meter, where it was computed
ON_TIME = 1e-9  # of a step, by which a dwell may begin before the one before it has ended: rounding


@dataclass(frozen=True, eq=False)
class Schedule:
    """Dwells in order.

    Parameters
    ----------
    start : ndarray, shape (n,)
        Of each dwell, since the schedule's zero [s].
    dwell : float
        Length of each [s].
    move : float
        Pause between two of them [s]; where starts are not even, the shortest.
    position : ndarray, shape (n,)
        Of the mass on its travel [m].
    applied : ndarray, shape (n,)
        Component of its attraction along the input axis [m/s^2].
    drive : {"sine", "square", "abab", "custom"}
        In which order.
    samples_per_cycle : int
        Dwells a cycle.
    u_applied : float, optional
        Relative standard uncertainty of the amplitude applied [1]; None where nobody said.
    mercury : ndarray, shape (n,), optional
        Tilt of the surface of a meter's mercury that the mass makes, as the meter reads it [rad].

    Raises
    ------
    PlanError
        If lengths differ, a number is not finite, starts do not rise or dwells overlap, or nothing changes.
    """

    start: Array
    dwell: float
    move: float
    position: Array
    applied: Array
    drive: Drive = "custom"
    samples_per_cycle: int = 2
    u_applied: float | None = None
    mercury: Array | None = None

    def __post_init__(self) -> None:
        for name in self._columns:
            object.__setattr__(self, name, _numbers(name, getattr(self, name)))
        self._check_lengths()
        self._check_times()
        self._check_drive()

    def __len__(self) -> int:
        return len(self.start)

    @property
    def _columns(self) -> tuple[str, ...]:
        """Names of what each dwell has."""
        return ("start", "position", "applied", *(() if self.mercury is None else ("mercury",)))

    @property
    def step(self) -> float:
        """From the start of a dwell to that of the next [s]."""
        return self.dwell + self.move

    @property
    def period(self) -> float:
        """Of the drive [s]."""
        return self.samples_per_cycle * self.step

    @property
    def frequency(self) -> float:
        """Of the drive [Hz]."""
        return 1.0 / self.period

    @property
    def middle(self) -> Array:
        """Middles of the dwells, shape (n,) [s]."""
        return self.start + 0.5 * self.dwell

    @property
    def stop(self) -> Array:
        """Ends of the dwells, shape (n,) [s]."""
        return self.start + self.dwell

    @property
    def amplitude(self) -> float:
        """Half of the largest less the smallest acceleration applied [m/s^2]."""
        return float(np.ptp(self.applied) / 2.0)

    def csv(self, notes: Mapping[str, str]) -> str:
        """Return the schedule as CSV: what holds for all dwells in comments, then a row a dwell, to the last bit.

        Parameters
        ----------
        notes : mapping of str to str
            What else stands above the rows for whoever reads them.
        """
        doubt = [] if self.u_applied is None else [f"# u of applied: {self.u_applied!r}"]
        there = UNITS if self.mercury is None else UNITS | MERCURY
        heads = [
            f"# drive: {self.drive}",
            f"# dwells a cycle: {self.samples_per_cycle}",
            f"# dwell: {float(self.dwell)!r} s",
            f"# move: {float(self.move)!r} s",
            *doubt,
            *(f"# {name}: {value}" for name, value in notes.items()),
            ",".join(["dwell", *(f"{name} [{unit}]" for name, unit in there.items())]),
        ]
        columns = [getattr(self, name).tolist() for name in there]
        rows = [",".join([str(i), *map(repr, row)]) for i, row in enumerate(zip(*columns, strict=True), 1)]
        return "\n".join([*heads, *rows, ""])

    def _check_lengths(self) -> None:
        shapes = {name: np.shape(getattr(self, name)) for name in self._columns}
        if len(set(shapes.values())) > 1 or len(self.start) < 2:
            found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise PlanError(f"a schedule needs two or more dwells, each with a place: {found}", code="schedule")

    def _check_times(self) -> None:
        if not (np.isfinite(self.dwell) and self.dwell > 0.0):
            raise PlanError(f"a dwell of {self.dwell:g} s", do="It must be positive", code="schedule")
        if not (np.isfinite(self.move) and self.move >= 0.0):
            raise PlanError(f"a move of {self.move:g} s", do="It cannot be below zero", code="schedule")
        late = np.diff(self.start) < self.dwell - ON_TIME * self.step
        if late.any():
            i = int(np.argmax(late))
            raise PlanError(
                f"dwell {i + 2} starts at {self.start[i + 1]:g} s, before dwell {i + 1} ends at {self.stop[i]:g} s",
                do="Sort the dwells by time; they must not overlap",
                code="schedule",
            )

    def _check_drive(self) -> None:
        if self.drive not in DRIVES:
            raise PlanError(f"drive {self.drive!r} is not known: {', '.join(DRIVES)}", code="unknown_drive")
        if self.samples_per_cycle < 2:
            raise PlanError(f"{self.samples_per_cycle} dwell(s) per cycle: a drive needs two or more", code="schedule")
        if not self.amplitude > 0.0:
            raise PlanError(
                "the same acceleration is applied in every dwell",
                why="the sensor does not respond to it",
                code="schedule",
            )
        if self.u_applied is not None and not 0.0 <= self.u_applied < np.inf:
            raise PlanError(
                f"a relative uncertainty of {self.u_applied:g} of the applied acceleration", code="schedule"
            )


def repeated(
    positions: ArrayLike,
    applied: ArrayLike,
    *,
    cycles: int,
    dwell: float,
    move: float,
    drive: Drive = "custom",
    u_applied: float | None = None,
    mercury: ArrayLike | None = None,
) -> Schedule:
    """Return the schedule of one cycle repeated, evenly in time from zero.

    Parameters
    ----------
    positions, applied : array_like, shape (dwells of a cycle,)
        Of the mass [m]; along the input axis there [m/s^2].
    cycles : int
        How many.
    dwell, move : float
        [s].
    drive : {"sine", "square", "abab", "custom"}
        Name of the order.
    u_applied : float, optional
        Relative standard uncertainty of the amplitude [1].
    mercury : array_like, shape (dwells of a cycle,), optional
        Tilt of a meter's mercury there [rad].

    Raises
    ------
    PlanError
        If there is no cycle, or as `Schedule`.
    """
    if cycles < 1:
        raise PlanError(f"a schedule of {cycles} cycles", do="One or more are needed", code="schedule")
    place, field = np.asarray(positions, dtype=float), np.asarray(applied, dtype=float)
    start: Array = np.arange(cycles * len(place), dtype=np.float64) * (dwell + move)
    return Schedule(
        start, dwell, move, np.tile(place, cycles), np.tile(field, cycles), drive, len(place), u_applied,
        None if mercury is None else np.tile(np.asarray(mercury, dtype=float), cycles),
    )  # fmt: skip


def _numbers(name: str, given: ArrayLike) -> Array:
    """Read-only numbers of one column."""
    values = np.array(given, dtype=float)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise PlanError(f"{name} of a schedule: finite numbers in one row are needed", code="schedule")
    values.setflags(write=False)
    return values
