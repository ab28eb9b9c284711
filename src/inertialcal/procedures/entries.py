"""What a campaign says of sensors, recordings and tests, as procedures see it before any recording is read.

A procedure declares its own keys of a recording's entry (`EntryKey`, in its ``entry.py``), from which the schema of
campaign files is made, and checks them in ``Procedure.check``, ``check_recording`` and ``check_entry``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ..core.errors import Problem


class SaidChain(Protocol):
    """From counts to the unit of a sensor."""

    @property
    def kind(self) -> str:
        """``none``, ``adc`` or ``pulse_rate``."""
        ...

    @property
    def scale_factor(self) -> object:
        """Of the data sheet; None where not said."""
        ...


class SaidSensor(Protocol):
    """A sensor of a campaign."""

    @property
    def kind(self) -> str:
        """``gyro`` or ``accelerometer``."""
        ...

    @property
    def unit(self) -> str:
        """That people speak."""
        ...

    @property
    def axes(self) -> Sequence[str]:
        """That it has."""
        ...

    @property
    def mounting(self) -> object:
        """Sensor from body; None where they are the same."""
        ...

    @property
    def chain(self) -> SaidChain:
        """From counts to its unit."""
        ...


class SaidClock(Protocol):
    """Time of a recording."""

    @property
    def mission_start(self) -> str | None:
        """Where mission elapsed time is zero."""
        ...

    @property
    def averaging(self) -> float | None:
        """Time that a sample is the mean of [s]."""
        ...


class Entry(Protocol):
    """What is said of a recording, whichever the procedure; each adds its own keys in its ``entry.py``."""

    @property
    def sensor(self) -> str:
        """Its name."""
        ...

    @property
    def file(self) -> str:
        """In the folder of the campaign."""
        ...

    @property
    def channels(self) -> Mapping[str, Any] | None:
        """Columns by channel; None for a reduced table."""
        ...

    @property
    def clock(self) -> SaidClock | None:
        """Its time."""
        ...

    @property
    def axis(self) -> str | None:
        """That was turned."""
        ...

    @property
    def run(self) -> str | None:
        """Power-up."""
        ...


@dataclass(frozen=True)
class EntryKey:
    """A key of a recording's entry that is one procedure's own.

    Parameters
    ----------
    name, kind : str, object
        As files call it; its type, for pydantic, without ``None``.
    table : bool
        It says the columns of a reduced table; else it goes only with channels.
    apart : bool
        Other columns of one table are other readings.
    alone : bool
        It is of that recording alone: others like it do not have it.
    file : callable, optional
        The other file that its value names.
    grouped : callable, optional
        Whether tests can choose rows of the table by their group; they always can where not given.
    wrong : callable, optional
        What is wrong with its value beyond its type, as text; empty where nothing is.
    readings, run : callable, optional
        Columns of a table that hold readings, and that of the run; a stretch of rows that are equal in all of them is a
        copy.
    """

    name: str
    kind: object
    table: bool = False
    apart: bool = False
    alone: bool = False
    file: Callable[[Any], str] | None = None
    grouped: Callable[[Any], bool] | None = None
    wrong: Callable[[Any], str] | None = None
    readings: Callable[[Any], Sequence[str]] | None = None
    run: Callable[[Any], str | None] | None = None


@dataclass(frozen=True)
class SaidTest:
    """A test as a campaign file says it.

    Parameters
    ----------
    id : str
        Its name.
    windows, plan
        As given; None for all.
    sensors : mapping of str to SaidSensor
        All of the campaign.
    latitude : float or None
        Of the site [rad].
    at : callable
        Place of a key of the file, for messages: ``at("recordings", name)``.
    number : int
        Of the test among those of the file: ``at("tests", number, "windows")``.
    """

    id: str
    windows: Sequence[tuple[int, int]] | None
    plan: Mapping[str, Any]
    sensors: Mapping[str, SaidSensor]
    latitude: float | None
    at: Callable[..., str]
    number: int


def latitude_needed(test: SaidTest) -> Iterator[Problem]:
    """Yield an attitude that says nothing, as the site has no latitude."""
    if test.plan.get("attitude") is not None and test.latitude is None:
        what = f"test {test.id!r}: plan.attitude needs site.latitude"
        where = test.at("tests", test.number, "plan", "attitude")
        yield Problem(what, where, "earth rate depends on both", code="missing_key")


def reading_units(test: SaidTest, settings: Sequence[str]) -> Iterator[Problem]:
    """Yield settings that are in the unit of readings, but not in one of this test's sensors."""
    from ..core.units import kind, parse_quantity  # noqa: PLC0415 - numpy starts slowly

    kinds = {kind(one.unit) for one in test.sensors.values()}
    for name in settings:
        text = test.plan.get(name)
        if isinstance(text, str) and kind(parse_quantity(text).unit) not in kinds:
            where = test.at("tests", test.number, "plan", name)
            what = f"test {test.id!r}: plan.{name} = {text!r} is not in the unit of the sensor"
            yield Problem(what, where, do="Give it in the unit of the readings", code="wrong_value")
