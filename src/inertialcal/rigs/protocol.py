"""Twin of a campaign: what its engineer would hand over, and the truth that he does not know.

All of it follows from the seed. The campaign file is the same for all seeds, but for two marks that are filled in
when it is written: `SEED`, and `SEAL` for the SHA-256 of the truth, by which results that were made with that file
can be told from all others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from ..core.errors import UsageError
from ..core.estimate import Array
from ..core.influence import Influence
from ..core.recording import Recording

SEED, SEAL = "@SEED@", "@SEAL@"

Bench = TypeVar("Bench")

Drawn = Mapping[str, float | list[float] | list[list[float]]]


@dataclass(frozen=True)
class TrueValue:
    """True value of a quantity, named as the rows of the results name it, in an SI unit.

    Of one test and one condition where they are given; of all tests where no test is given.
    """

    quantity: str
    axis: str
    value: float
    unit: str
    test: str = ""
    condition: str = ""


@dataclass(frozen=True)
class Fault:
    """A mistake that a campaign can hold.

    Parameters
    ----------
    what : str
        What is wrong.
    shows : str
        Code of the error or remark that names it, or words of the reason why a quantity is not estimated.
    change : mapping
        Settings of the bench that differ.
    """

    what: str
    shows: str
    change: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class PlannedMass:
    """Where a mass is planned to dwell.

    Parameters
    ----------
    start : ndarray, shape (n,)
        Of each dwell, since that of the first [s].
    dwell, move : float
        Length of each, and pause between two [s].
    position : ndarray, shape (n,)
        Of the mass [m].
    applied : ndarray, shape (n,)
        Its attraction along the input axis [m/s^2].
    drive : str
        Name of the order.
    samples_per_cycle : int
        Dwells of a cycle.
    u_applied : float or None
        Relative standard uncertainty of the amplitude (1).
    """

    start: Array
    dwell: float
    move: float
    position: Array
    applied: Array
    drive: str
    samples_per_cycle: int
    u_applied: float | None = None


@dataclass(frozen=True)
class NamedPart:
    """Samples [start, stop) of a recording with the name that a protocol gives them: ``"x+"``, or ``"x_rot"``.

    A turn has its angle [rad].
    """

    label: str
    start: int
    stop: int
    angle: float | None = None


@dataclass(frozen=True, eq=False)
class Twin:
    """One simulated campaign.

    Parameters
    ----------
    rig : str
        Name in the dict of rigs.
    seed : int
        Everything else follows from it.
    fault : str
        Name of the mistake in it; empty where there is none.
    campaign : str
        Text of campaign.toml, with the marks `SEED` and `SEAL`.
    recordings : mapping of str to Recording
        By the file that the campaign names; channels named by their columns, stamps as the logger writes them.
    truth : tuple of TrueValue
        What the results are measured by.
    drawn : mapping
        Errors of the standards, and how the bench really stood, SI: what nobody told the reduction.
    schedules : mapping of str to PlannedMass
        Of a moved mass, by the file that the campaign names.
    protocols : mapping of str to tuple of NamedPart
        What is known of positions and turns, by the file that the campaign names.
    """

    rig: str
    seed: int
    fault: str
    campaign: str
    recordings: Mapping[str, Recording]
    truth: tuple[TrueValue, ...]
    drawn: Drawn
    schedules: Mapping[str, PlannedMass] = field(default_factory=dict[str, PlannedMass])
    protocols: Mapping[str, tuple[NamedPart, ...]] = field(default_factory=dict[str, tuple[NamedPart, ...]])


def drawn_error(influence: Influence | None, rng: np.random.Generator) -> float:
    """Return the unknown error of a standard, drawn as its certificate says [its unit]; 0 where there is none."""
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))


def with_fault(
    build: Callable[[Bench, int], Twin], bench: Bench, faults: Mapping[str, Fault], seed: int, fault: str
) -> Twin:
    """Return the campaign of a seed, with one mistake in it if asked.

    Parameters
    ----------
    build : callable
        Bench and seed -> twin.
    bench : dataclass
        As it is without a mistake.
    faults : mapping
        Mistakes that the rig knows.
    seed : int
        Of all draws.
    fault : str
        Name of the mistake; empty: none.

    Raises
    ------
    UsageError
        If there is no mistake of that name.
    """
    if fault and fault not in faults:
        raise UsageError(f"no fault {fault!r}", do=f"There are: {', '.join(faults)}", code="unknown_name")
    changed = replace(bench, **faults[fault].change) if fault else bench  # type: ignore[type-var]
    return replace(build(changed, seed), fault=fault)
