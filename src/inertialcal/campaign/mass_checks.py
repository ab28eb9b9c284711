"""What one key of a campaign file says about another, in a test with a moved mass."""

from __future__ import annotations

from collections.abc import Iterator

from ..core.errors import DataError, Problem
from ..core.units import kind, parse_quantity, same_dimension
from ..procedures.mass_attraction.entry import Lines
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .toml_lines import At


def mass_checks(file: CampaignFile, test: Test, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    """Find a recording without a schedule of the mass, or of a sensor that no pulses are counted of.

    Parameters
    ----------
    file : CampaignFile
        Valid by itself.
    test : Test
        Of procedure ``mass_attraction``.
    name, entry : str, RecordingEntry
        One of its recordings.
    at : callable
        Place of a key path, for messages.
    """
    if entry.channels is not None and entry.mass is None:
        what = f"recordings.{name}: nothing says where the mass was"
        yield Problem(what, at("recordings", name), do='Give mass = { schedule = "schedule.csv" }', code="missing_key")
    sensor = file.sensors.get(entry.sensor)
    if sensor is not None and entry.channels is not None and sensor.chain.kind != "pulse_rate":
        what = f"test {test.id!r}: a moved mass calibrates pulses a second, the chain is {sensor.chain.kind!r}"
        do = 'Give chain = { kind = "pulse_rate", gate = ..., scale_factor = ... }'
        yield Problem(what, at("sensors", entry.sensor, "chain"), do=do, code="wrong_value")
    if test.windows is not None:
        what = f"test {test.id!r}: windows, but a run is read where its schedule says"
        where = at("tests", file.tests.index(test), "windows")
        yield Problem(what, where, "they would have no effect", "Leave them out", "wrong_value")


def line_units(name: str, lines: Lines, at: At) -> Iterator[Problem]:
    """Find units of a table of reduced runs that are of another kind.

    Parameters
    ----------
    name, lines : str, Lines
        The recording.
    at : callable
        Place of a key path, for messages.
    """
    where = at("recordings", name, "lines")
    if kind(lines.applied_unit) != "acceleration":
        what = f"recordings.{name}: applied in {lines.applied_unit!r}, need a unit of acceleration"
        yield Problem(what, where, code="wrong_value")
    if not same_dimension(lines.unit, "count/s"):
        what = f"recordings.{name}: response in {lines.unit!r}, need pulses a second"
        yield Problem(what, where, do="Write count/s", code="wrong_value")
    if lines.u_applied is not None:
        try:
            parse_quantity(lines.u_applied).to(lines.applied_unit, difference=True)
        except DataError as error:
            yield Problem(f"recordings.{name}.lines.u_applied: {error.problems[0].what}", where, code="wrong_value")
