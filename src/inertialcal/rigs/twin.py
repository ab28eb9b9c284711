"""Twin: a campaign made on a simulated rig, with the truth that its engineer does not know, and the faults it can hold.

A twin follows from its seed. Two marks in the campaign file are replaced when it is written: `SEED`, and `SEAL` by the
SHA-256 of the truth, which identifies the results made from that file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from ..core.errors import DataError, UsageError
from ..core.key import At, Key

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from ..core.recording import Recording
    from .faults.scene import Scene

SEED = "@SEED@"
SEAL = "@SEAL@"
MIDDLE = {"normal": 1.959964, "rectangular": 0.95 * math.sqrt(3.0)}  # half width of 95 % [standard uncertainties]

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


Expectation = Literal["refused", "named", "covered"]


OF_TEST = {"faces": "positions"}  # what only some rigs of a procedure have
WORDS = {"sigma", "samples", "times"}  # units of a size that are no units of core.units


@dataclass(frozen=True)
class Fault:
    """A mistake that a campaign can hold: a bench that differs, or a change of what was recorded on a sound one.

    Parameters
    ----------
    what : str
        What is wrong.
    shows : str
        Code of the error or remark that names it, or of the reason why a quantity is not estimated. Empty where
        nothing needs to be said.
    change : mapping
        Settings of the bench that differ.
    expects : {"named", "refused", "covered"}
        A remark, reason or refusal with the code that names a spoiled recording; a refusal with the code; intervals
        that hold the truth all the same, or, where there is a code, that code.
    also : tuple of str
        Other codes that name it, on some rigs or at some sizes.
    size : float, optional
        Default of its size, where it has one.
    unit : str
        Of the size: one of core.units, or ``"sigma"`` (standard deviations of a sample), ``"samples"``, ``"times"``.
    least, most : float
        Limits of the size.
    tests : tuple of str
        Procedures whose recordings it can spoil, or ``"faces"`` where a protocol names them; empty for a mistake of
        the bench.
    spoil : callable, optional
        Scene and size: changes the scene.
    """

    what: str
    shows: str = ""
    change: Changes = field(default_factory=dict[str, object])
    expects: Expectation = "named"
    also: tuple[str, ...] = ()
    size: float | None = None
    unit: str = ""
    least: float = -math.inf
    most: float = math.inf
    tests: tuple[str, ...] = ()
    spoil: Callable[[Scene, float], None] | None = None

    @property
    def codes(self) -> tuple[str, ...]:
        """Every code that names it."""
        return (*((self.shows,) if self.shows else ()), *self.also)

    @property
    def procedures(self) -> frozenset[str]:
        """Those whose recordings it can spoil."""
        return frozenset(OF_TEST.get(name, name) for name in self.tests)

    @property
    def expected(self) -> str:
        """What is expected, in words: ``"refused: overlap"``, ``"remark: glitch"``, ``"intervals hold"``."""
        codes = " or ".join(self.codes)
        covered = f"intervals hold, or named: {codes}" if codes else "intervals hold"
        return {"refused": f"refused: {codes}", "named": f"named: {codes}", "covered": covered}[self.expects]

    @property
    def default(self) -> str:
        """Its default size with its unit; empty where it has none."""
        return "" if self.size is None else size_text(self.size, self.unit)

    def put_into(self, bench: Bench) -> Bench:
        """Return a bench with the mistake in it."""
        return replace(bench, **self.change)


def size_text(size: float, unit: str) -> str:
    """Return a size with its unit: ``"0.3 sigma"``, ``"2 %"``."""
    return f"{size:g} {unit}".rstrip()


def parse_fault(text: str, known: Mapping[str, Fault]) -> tuple[str, float | None]:
    """Return name and size of a fault as it is typed: ``"glitch"``, ``"run_gain=5 %"``, ``"stuck_codes=200"``.

    Parameters
    ----------
    text : str
        A name, or a name and a size.
    known : mapping of str to Fault
        Those of the rig, by name.

    Raises
    ------
    UsageError
        ``unknown_name`` if there is no fault of that name; ``bad_size`` if it has no size, or the size is no number,
        lacks its unit or is beyond the limits.
    """
    name, given, size = (part.strip() for part in text.partition("="))
    fault = known.get(name)
    if fault is None:
        near = get_close_matches(name, known, n=1)
        do = f"Did you mean {near[0]}? " if near else ""
        raise UsageError(f"no fault {name!r}", do=f"{do}There are: {', '.join(known)}", code="unknown_name")
    if not given:
        return name, fault.size
    if fault.size is None:
        raise UsageError(f"fault {name} has no size, but {size!r} is given", do=f"Say: {name}", code="bad_size")
    example = f"Say, for example: {name}={fault.default}"
    value = _number(size, fault.unit)
    if value is None:
        unit = f" [{fault.unit}]" if fault.unit else ""
        raise UsageError(f"fault {name}: {size!r} is not a size{unit}", do=example, code="bad_size")
    if not fault.least <= value <= fault.most:
        ends = (("at least", fault.least), ("at most", fault.most))
        limits = [f"{word} {size_text(end, fault.unit)}" for word, end in ends if math.isfinite(end)]
        what = f"fault {name}: {size_text(value, fault.unit)}, need {' and '.join(limits)}"
        raise UsageError(what, do=example, code="bad_size")
    return name, value


def _number(text: str, unit: str) -> float | None:
    """Return a size in its unit; None where it is none."""
    from ..core.units import parse_quantity  # noqa: PLC0415 - starts slowly; a list of rigs needs no units

    own = unit in WORDS or not unit
    bare = text.removesuffix(unit).strip() if own else text
    try:
        value = float(bare)
    except ValueError:
        if own:
            return None
        try:
            value = parse_quantity(text).to(unit)
        except DataError:
            return None
        return value
    if not own:
        return None  # its unit is missing
    return value if math.isfinite(value) else None


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


@dataclass(frozen=True)
class DrawnError:
    """Error of a standard, as it was drawn for a campaign."""

    influence: str  # As results name it: ``"rate_table.rate"``, ``"converter.zero[y]"``
    error: float  # Stated or read less true, in its standard uncertainties: results change by it times ``shared``
    distribution: str = "normal"  # That it was drawn from

    @property
    def inside(self) -> bool:
        """Whether it lies in the middle 95 % of its distribution."""
        return abs(self.error) <= MIDDLE[self.distribution]


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
    errors : tuple of DrawnError
        Errors of the standards in their standard uncertainties, by the names that results give their influences.
    texts : mapping of str to callable
        Recordings whose file is not the usual CSV: what becomes of its text.
    rig : str
        Name of the rig; filled in by it, as are the others below.
    seed : int
        Everything else follows from it.
    fault : str
        Name of the mistake in it; empty for none.
    size : str
        Its size with the unit; empty where it has none.
    spoiled : tuple of str
        Recordings that a general mistake is in, by their names in the campaign; empty where it is in all of them, in
        the campaign file, or of the bench.
    """

    campaign: str
    recordings: Mapping[str, Recording]
    truth: tuple[TrueValue, ...]
    drawn: Drawn
    extras: Mapping[str, Extra] = field(default_factory=dict[str, Extra])
    errors: tuple[DrawnError, ...] = ()
    texts: Mapping[str, Callable[[str], str]] = field(default_factory=dict)
    rig: str = ""
    seed: int = 0
    fault: str = ""
    size: str = ""
    spoiled: tuple[str, ...] = ()
