"""Keys of a recording's entry for a turned mass: the programme of its turns, which run it is, and its begin."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, cast

from ...core.errors import Problem
from ...core.schema.quantities import Strict, Text
from ..entries import Entry, EntryKey, SaidTest


class Turned(Strict):
    """turned = {...}: programme of the mass that turns during a recording, which run of it, and its begin.

    Without ``run`` the recording is the run of its own name, or all of them where none has it.
    """

    schedule: Text
    run: Text | None = None
    begin: str | int | float | None = None


class TurnedEntry(Entry, Protocol):
    """A recording with a turned mass."""

    @property
    def turned(self) -> Turned | None:
        """Programme of the mass."""
        ...


KEYS = (EntryKey("turned", Turned, file=lambda turned: turned.schedule),)


def recording_problems(test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
    """Yield a recording without a programme of the mass, or of a sensor that does not count pulses."""
    if cast("TurnedEntry", entry).turned is None:
        what = f"recordings.{name}: programme of the turned mass missing"
        yield Problem(what, test.at("recordings", name), do='Add turned = { schedule = "schedule.csv" }',
                      code="missing_key")  # fmt: skip
    sensor = test.sensors.get(entry.sensor)
    if sensor is not None and sensor.chain.kind != "pulse_rate":
        what = f"test {test.id!r}: turned_mass needs pulses, the chain is of kind {sensor.chain.kind!r}"
        do = 'Set chain = { kind = "pulse_rate", gate = "GATE s" }'
        yield Problem(what, test.at("sensors", entry.sensor, "chain"), do=do, code="wrong_value")
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but the schedule says which part of a recording is a run"
        where = test.at("tests", test.number, "windows")
        yield Problem(what, where, "they would have no effect", "Remove them", "wrong_value")


def plan_problems(test: SaidTest) -> Iterator[Problem]:
    """Yield a plan that does not say the orbit once, or takes a recoil as stated that it does not state."""
    where = test.at("tests", test.number, "plan")
    for name, example in (("mass", "4 kg"), ("radius", "0.2 m")):
        if test.plan.get(name) is None:
            what = f"test {test.id!r}: plan.{name} of the turned mass missing"
            yield Problem(what, where, "its attraction follows from it", f'Add {name} = "{example}"', "missing_key")
    if (test.plan.get("altitude") is None) == (test.plan.get("orbit_period") is None):
        both = "both are given" if test.plan.get("altitude") is not None else "neither is given"
        what = f"test {test.id!r}: plan.altitude and plan.orbit_period: {both}"
        yield Problem(what, where, "the recoil depends on the orbital rate", 'Give one: altitude = "560 km"',
                      "wrong_value")  # fmt: skip
    if test.plan.get("recoil") == "stated" and test.plan.get("satellite") is None:
        what = f'test {test.id!r}: plan.recoil = "stated", but plan.satellite is missing'
        yield Problem(what, where, "the recoil arm is m r / (M + m)", 'Add satellite = "1000 kg"', "missing_key")
