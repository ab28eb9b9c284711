"""Rig and twin: a simulated test bench, and a campaign made on it with the truth that its engineer does not know.

A twin follows from its seed. Two marks in the campaign file are replaced when it is written: `SEED`, and `SEAL` by the
SHA-256 of the truth, which identifies the results made from that file.

A rig of your own is one object, named by an entry point of your package::

    RIG = Rig("centrifuge", "an accelerometer on a centrifuge", on_bench(build, Bench()), FAULTS)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from ..core.errors import UsageError
from ..core.key import At, Key

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from ..core.recording import Recording

SEED, SEAL = "@SEED@", "@SEAL@"
DEMONSTRATION_SEED = 1996

Bench = TypeVar("Bench", bound="DataclassInstance")
Changes: TypeAlias = Mapping[str, object]  # settings of a bench that differ from those without a mistake
Drawn: TypeAlias = Mapping[str, float | list[float] | list[list[float]]]


@dataclass(frozen=True)
class TrueValue:
    """True value of a quantity, with the fields of the rows of the results, in an SI unit.

    Of one test where it is given, else of all.
    """

    quantity: str
    axis: str
    value: float
    unit: str
    test: str = ""
    sensor: str = ""
    power: int = 0
    at: At | None = None

    @property
    def key(self) -> Key:
        """What it is of."""
        return Key(self.quantity, self.axis, self.sensor, self.power, self.at)


@dataclass(frozen=True)
class Fault:
    """A mistake that a campaign can hold.

    Parameters
    ----------
    what : str
        What is wrong.
    shows : str
        Code of the error or remark that names it, or of the reason why a quantity is not estimated.
    change : mapping
        Settings of the bench that differ.
    """

    what: str
    shows: str
    change: Changes

    def put_into(self, bench: Bench) -> Bench:
        """Return a bench with the mistake in it."""
        return replace(bench, **self.change)


@dataclass(frozen=True, eq=False)
class Extra:
    """A file that is not a recording, such as a schedule or a protocol.

    Parameters
    ----------
    content : object
        What its reader makes of it.
    text : str
        The file itself.
    """

    content: object
    text: str


@dataclass(frozen=True, eq=False)
class Twin:
    """One simulated campaign.

    Parameters
    ----------
    campaign : str
        Text of campaign.toml, with the marks `SEED` and `SEAL`.
    recordings : mapping of str to Recording
        By the file that the campaign names; channels named by their columns, stamps as the logger writes them.
    truth : tuple of TrueValue
        The values that results are scored against.
    drawn : mapping
        True errors of the standards and of the bench, SI; unknown to the reduction.
    extras : mapping of str to Extra
        Other files that the campaign names.
    rig : str
        Name of the rig; filled in by it, as are the others below.
    seed : int
        Everything else follows from it.
    fault : str
        Name of the mistake in it; empty for none.
    """

    campaign: str
    recordings: Mapping[str, Recording]
    truth: tuple[TrueValue, ...]
    drawn: Drawn
    extras: Mapping[str, Extra] = field(default_factory=dict[str, Extra])
    rig: str = ""
    seed: int = 0
    fault: str = ""


@dataclass(frozen=True)
class Rig:
    """A test bench that can be simulated.

    Parameters
    ----------
    name : str
        As it is typed: ``"rate_table"``.
    title : str
        One line on it.
    make : callable
        Seed of all draws, and settings of the bench that differ -> `Twin`.
    faults : mapping of str to Fault
        Mistakes that it can simulate, by name.
    demonstration_seed : int
        Seed of its demonstration.
    """

    name: str
    title: str
    make: Callable[[int, Changes], Twin]
    faults: Mapping[str, Fault] = field(default_factory=dict)
    demonstration_seed: int = DEMONSTRATION_SEED

    def twin(self, seed: int, fault: str = "") -> Twin:
        """Return the campaign of a seed, with one mistake in it where a fault is named.

        Parameters
        ----------
        seed : int
            Of all draws.
        fault : str
            Name of the mistake; empty: none.

        Raises
        ------
        UsageError
            If there is no mistake of that name.
        """
        if fault and fault not in self.faults:
            raise UsageError(f"no fault {fault!r}", do=f"There are: {', '.join(self.faults)}", code="unknown_name")
        made = self.make(seed, self.faults[fault].change if fault else {})
        return replace(made, rig=self.name, seed=seed, fault=fault)


def on_bench(build: Callable[[Bench, int], Twin], bench: Bench) -> Callable[[int, Changes], Twin]:
    """Return the function that makes the twins of a rig whose settings are a frozen dataclass.

    Parameters
    ----------
    build : callable
        Bench and seed -> twin.
    bench : dataclass
        The bench without a mistake.
    """
    return lambda seed, changes: build(replace(bench, **changes), seed)
