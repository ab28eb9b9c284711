"""What looks like a test on a rate table: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.campaign_text import MARK, quoted
from ...core.errors import InertialcalError
from ...core.recording import Recording
from ...core.units import kind
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey
from ...files.info.table_columns import Guess, names_rates
from ...files.text.table import Table
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion

REDUCED_ROWS = 10_000  # a longer table is no table of dwells
REQUIREMENT = (
    '# [[requirements]]\n# id = "R1"\n# quantity = "rate_error"\n# of = "dwell_mean"\n# limit = "5 %"\n'
    '# where = "abs(rate) >= 0.1 deg/s"\n'
)


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``rate-table`` of reduced readings, a row a dwell, and of gyros that turn beside an applied rate."""
    named = names_rates(channel.name for channel in recording.channels)
    if named and recording.sample_interval is None and len(recording) <= REDUCED_ROWS:
        return Suggestion(("rate-table",), Strength.SURE, complete=True)
    moving = any(remark.code == "not_at_rest" for remark in survey.remarks)
    turned = any(channel.axis and channel.quantity == "gyro" for channel in recording.channels)
    if moving and named and turned:  # counts need the chain of a campaign file
        return Suggestion(("rate-table",), Strength.POSSIBLE, in_campaign=True)
    return None


def claims(file: FolderFile) -> Claim | None:
    """Claim a reduced table and a recording of gyros that turn; in reserve one at rest."""
    recording, columns = file.recording, file.columns
    if recording is None:
        taken = _is_table(file.table, columns)
        return Claim(Strength.LIKELY, lambda: (columns, ())) if taken else None
    if gyros(recording) and (columns.applied or not file.at_rest):
        return Claim(Strength.POSSIBLE, lambda: (recording, ()))
    dwell = gyros(recording) or not accelerometers(recording)
    return Claim(Strength.RESERVE, lambda: (recording, ())) if dwell and file.at_rest else None


def _is_table(table: Table, rates: Guess) -> bool:
    """Whether a file is a reduced table: short, with numbers in the columns whose names say rate and reading."""
    if not (rates.applied and rates.readings and table.rows.size <= REDUCED_ROWS):
        return False
    try:
        return all(np.isfinite(table.numbers(name)).any() for name in (rates.applied, *rates.readings))
    except InertialcalError:  # text
        return False


def draft(contents: Mapping[str, object]) -> Draft:
    """Return the suite of gyros, its recordings and tests, by file: recordings and reduced tables."""
    tables = {file: one for file, one in contents.items() if isinstance(one, Guess)}
    raw = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    said = [one.unit for one in tables.values()]
    said += [c.unit for one in raw.values() for c in gyros(one).values() if kind(c.unit or "1") == "angular_rate"]
    unit = next((one for one in said if one), None)
    unit_line = f"unit = {quoted(unit)}" if unit else f'unit = "?"  {MARK}'
    parts = (
        "# Uncertainties of the rate table: without them the results are relative to the fixture.\n"
        '# [standards.rate_table]\n# rate = { u = "0.05 %", certificate = "..." }\n# mounting = { u = "0.1 deg" }\n',
        f'[sensors.suite]\nkind = "gyro"\naxes = ["x", "y", "z"]\n{unit_line}\n'
        '# range = ["-100 deg/s", "100 deg/s"]\n# chain = { kind = "none", scale_factor = "0.5 V/(deg/s)" }\n',
        *(_raw_entry(number, file, one) for number, (file, one) in enumerate(raw.items(), 1)),
        _raw_test(len(raw)),
        *(_entry(number, file, one) for number, (file, one) in enumerate(tables.items(), 1)),
    )
    return Draft(parts, REQUIREMENT)


def _entry(number: int, file: str, found: Guess) -> str:
    reading = _reading(found)
    rows = [f"applied = {quoted(found.applied or '?')}", f"reading = {reading}"]
    rows += [f"{key} = {quoted(value)}" for key in _keys(found) if (value := getattr(found, key))]
    rows.append(f"unit = {quoted(found.unit or '?')}")
    sure = found.unit is not None and (len(found.readings) == 1 or bool(found.by_axis))
    mark = "" if sure else f"  {MARK}"
    axis = found.axis is None
    plan = f'plan = {{ axis = "{_axis(found)}" }}  {MARK}\n' if axis else ""
    return (
        f'[recordings.table{number}]\nsensor = "suite"\nfile = {quoted(file)}\nrows = {{ {", ".join(rows)} }}{mark}\n\n'
        f'[[tests]]\nid = "rate{number}"\nprocedure = "rate_table"\nrecordings = ["table{number}"]\n{plan}'
    )


def _keys(found: Guess) -> tuple[str, ...]:
    """Columns to name; one scatter column beside several readings cannot be told whose it is."""
    one = len(found.readings) == 1
    return ("scatter", "samples", "axis", "group", "run") if one else ("samples", "axis", "group", "run")


def _raw_entry(number: int, file: str, one: Recording) -> str:
    clock = [f"column = {quoted(one.time_column)}"] if one.time_column else []
    clock += ['stamp = "middle"', 'interval = "? s"', 'averaging = "? s"']
    channels = ['applied = { column = "?", unit = "?" }']
    channels += [
        f"{axis} = {{ column = {quoted(c.name)}, unit = {quoted(c.unit or '?')} }}" for axis, c in gyros(one).items()
    ]
    return (
        f'[recordings.rec{number}]\nsensor = "suite"\nfile = {quoted(file)}\n'
        f'axis = "?"  {MARK}\nrun = "?"  {MARK}\n'
        f"clock = {{ {', '.join(clock)} }}  {MARK}\nchannels = {{ {', '.join(channels)} }}  {MARK}\n"
    )


def _raw_test(count: int) -> str:
    """Return one test of all recordings: which axis was turned stands with each."""
    if not count:
        return ""
    names = ", ".join(f'"rec{number}"' for number in range(1, count + 1))
    return f'[[tests]]\nid = "rate"\nprocedure = "rate_table"\nrecordings = [{names}]\n'


def _reading(found: Guess) -> str:
    if len(found.readings) > 1 and found.by_axis:
        return "{ " + ", ".join(f"{axis} = {quoted(name)}" for axis, name in found.by_axis.items()) + " }"
    return quoted(found.readings[0])


def _axis(found: Guess) -> str:
    return next(iter(found.by_axis)) if len(found.by_axis) == 1 else "x"
