"""How a source mass is moved, as a user says it: direction, stage, stroke, case of the instrument, times."""

from __future__ import annotations

from dataclasses import dataclass

from ....core.errors import UsageError
from ....core.remarks import Remark
from ....physics.mass_shape import Gain, change
from .drive import DIRECTIONS
from .settings import WANTED, Moved, number, one_of, positive, range_of

CM = 100.0
HOUR = 3600.0
LONGEST = 1e5  # hours of a test


@dataclass(frozen=True)
class Motion:
    """How the mass is moved.

    Parameters
    ----------
    direction : {"along", "across"}
        The input axis.
    stage : tuple of float
        Positions that it has [m].
    ends : tuple of float or None
        Of the stroke [m].
    length : float or None
        Of the best window [m].
    case : float
        How far the instrument reaches from the proof mass [m].
    asked : bool
        Whether anything of a motion was said.
    remarks : tuple of Remark
        What was taken where nobody said.
    """

    direction: Moved
    stage: tuple[float, float]
    ends: tuple[float, float] | None
    length: float | None
    case: float
    asked: bool
    remarks: tuple[Remark, ...] = ()


def motion_of(direction: str, rig: str | None, stroke: str | None, travel: str | None, instrument: str) -> Motion:
    """Return the motion; arguments as `plan_mass_attraction` takes them.

    Raises
    ------
    UsageError
        If a word is none, a length has no unit, or stroke and travel are both given.
    """
    if stroke is not None:
        refuse_beside("--stroke", travel=travel)
    ends = None if stroke is None else range_of(stroke, "stroke")
    length = None if travel is None else positive(travel, "m", "travel", "30.5 cm")
    case = number(instrument, "m", "instrument", "3 cm")
    if not case >= 0.0:
        raise UsageError(f"instrument: {instrument!r} is below zero", do='Write it like "3 cm"', code="wrong_value")
    moved: Moved = one_of(direction, tuple(DIRECTIONS), "direction")
    if rig is not None:
        return Motion(moved, range_of(rig, "rig"), ends, length, case, asked=True)
    stage = (min(0.0, ends[0]), ends[1]) if ends is not None else (0.0, 2.0 * (length or 0.0))
    if ends is None and length is None:
        return Motion(moved, stage, None, None, case, asked=False)
    what = f"--rig is not given: a stage from {CM * stage[0]:g} to {CM * stage[1]:g} cm is taken"
    said = Remark("no_rig", "info", what, do='Say what it can do: --rig "0 cm:60 cm"')
    return Motion(moved, stage, ends, length, case, asked=True, remarks=(said,))


@dataclass(frozen=True)
class Timing:
    """Dwell, pause and length of the test [s]."""

    dwell: float
    move: float
    length: float

    def cycles(self, dwells: int) -> int:
        """Return how many whole cycles of so many dwells there is time for.

        Raises
        ------
        UsageError
            If not even one.
        """
        period = dwells * (self.dwell + self.move)
        if self.length < period:
            raise UsageError(
                f"{self.length / HOUR:g} h are less than one cycle of {period / HOUR:.3g} h",
                do="Give more hours, or shorter dwells",
                code="too_short",
            )
        return int(self.length / period + 1e-9)


def timing_of(dwell: str, move: str, hours: float) -> Timing:
    """Return the times.

    Raises
    ------
    UsageError
        If one has no unit, or is not above zero.
    """
    pause = number(move, "s", "move", "20 s")
    if not pause >= 0.0:
        raise UsageError(f"move: {move!r} is below zero", do='Write it like "20 s"', code="wrong_value")
    if not 0.0 < hours < LONGEST:
        raise UsageError(f"hours: {hours:g}", do=f"Write a number above zero, below {LONGEST:g}", code="wrong_value")
    return Timing(positive(dwell, "s", "dwell", "100 s"), pause, hours * HOUR)


def gain_of(wanted: str, motion: Motion) -> Gain:
    """Return what the shape is best for.

    Raises
    ------
    UsageError
        If it is for a change, and no stroke is given.
    """
    if one_of(wanted, WANTED, "optimise") == "attraction":
        return Gain()
    if motion.ends is None:
        do = 'Say between which positions: --stroke "12.7 cm:43.2 cm"'
        raise UsageError("--optimise change without --stroke", do=do, code="missing")
    x, y, z = DIRECTIONS[motion.direction]
    start, length = motion.ends[0], motion.ends[1] - motion.ends[0]
    return change((length * x, length * y, length * z), start=(start * x, start * y, start * z))


def needed(given: str | None, name: str, like: str) -> str:
    """Return what must be given.

    Raises
    ------
    UsageError
        If it is not.
    """
    if given is None:
        option = name.replace("_", "-")
        raise UsageError(f"--{option} is not given", do=f'Say it: --{option} "{like}"', code="missing")
    return given


def refuse_beside(what: str, **given: object) -> None:
    """Refuse options beside one that contradicts them.

    Raises
    ------
    UsageError
        If one is given.
    """
    beside = [f"--{name}" for name, value in given.items() if value is not None]
    if beside:
        raise UsageError(f"{what} with {', '.join(beside)}", why="they contradict each other", code="contradiction")


def check_choices(
    cube: str | None, count: int | None, inventory: str | None, noise: object, noise_file: object
) -> None:
    """Refuse what says one thing twice.

    Raises
    ------
    UsageError
        With both options.
    """
    if inventory is not None:
        refuse_beside("--inventory", cube=cube, count=count)
    if noise is not None:
        refuse_beside("--noise", **{"noise-from": noise_file})
