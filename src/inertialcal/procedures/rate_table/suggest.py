"""What looks like a test on a rate table: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...core.campaign_text import Noted
from ...core.errors import InertialcalError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.units import kind
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey
from ...files.info.table_columns import Guess, guess_channels, names_rates
from ...files.text.headers import heading
from ...files.text.table import Table
from ...files.time.dates import looks_dated
from ...files.time.stamps import looks_iso
from ..suggestions import (
    Claim,
    Draft,
    FolderFile,
    Question,
    Strength,
    Suggestion,
    channel_tables,
    fill_in,
    one_of,
    recording_table,
    sensor_table,
    unit_of,
)
from .given import following, following_axis, goes_in_steps

REDUCED_ROWS = 10_000  # a longer table is no table of dwells
RATES = "deg/s, rad/s, rpm"
NO_RATE = "No column says the rate of the table. Name it, or take its line out and give a table of the dwells here: "
NO_RATE += 'schedule = { file = "FILE.csv", start = "start", stop = "stop", rate = "rate", unit = "deg/s" }'
REQUIREMENT = {"quantity": "rate_error", "of": "dwell_mean", "limit": "5 %", "where": "abs(rate) >= 0.1 deg/s"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``rate-table`` of reduced readings, a row a dwell, and of gyros that turn beside an applied rate."""
    channels = [one for one in recording.channels
                if one.quantity != "index" and (one.unit is None or kind(one.unit) != "acceleration")]  # fmt: skip
    found = guess_channels(channels)
    applied = found.applied
    named = applied is not None or names_rates(channel.name for channel in channels)
    if named and recording.sample_interval is None and len(recording) <= REDUCED_ROWS:
        return Suggestion(("rate-table",), Strength.SURE, complete=True)
    moving = any(remark.code == "not_at_rest" for remark in survey.remarks)
    turned = {axis: one for axis, one in gyros(recording).items() if one.name != applied}
    moving = moving or (applied is not None and _turns(np.asarray(recording.channel(applied).data, dtype=float)))
    if moving and named and (turned or len(found.readings) == 1):
        axis = turned_axis(recording) if turned else "AXIS"
        options = f"--axis {axis}" if axis and len(turned) != 1 else ""
        return Suggestion(("rate-table",), Strength.POSSIBLE, in_campaign=True, options=options)
    return None


def _turns(rate: Array) -> bool:
    """Whether the rate of a table, shape (n,), goes in steps."""
    known = rate[np.isfinite(rate)]
    return len(known) > 0 and bool(known.max() > known.min()) and goes_in_steps(rate)


def turned_axis(recording: Recording) -> str:
    """Return the axis that follows the rate of the table, by its readings; empty where none clearly does."""
    applied = guess_channels(recording.channels).applied
    turned = {axis: one.name for axis, one in gyros(recording).items() if one.name != applied}
    return "" if applied is None else following_axis(recording, applied, turned)


def claims(file: FolderFile) -> Claim | None:
    """Claim a reduced table and a recording of gyros that turn; in reserve one at rest."""
    recording, columns = file.recording, file.columns
    if recording is None:
        taken = _is_table(file.table, columns)
        return Claim(Strength.LIKELY, lambda: (_followed(file.table, columns), ())) if taken else None
    if gyros(recording) and (columns.applied or not file.at_rest):
        return Claim(Strength.POSSIBLE, lambda: (recording, ()))
    dwell = gyros(recording) or not accelerometers(recording)
    return Claim(Strength.RESERVE, lambda: (recording, ())) if dwell and file.at_rest else None


def _followed(table: Table, rates: Guess) -> Guess:
    """Return columns of a table with the axis whose readings follow the rate."""
    readings = {axis: table.numbers(name, required=False) for axis, name in rates.by_axis.items()}
    return replace(rates, follows=following(table.numbers(rates.applied or "", required=False), readings))


def _is_table(table: Table, rates: Guess) -> bool:
    """Whether a file is a reduced table: short, with numbers in the columns whose names say rate and reading."""
    if not (rates.applied and rates.readings and table.rows.size <= REDUCED_ROWS):
        return False
    columns = zip(table.names, table.cells, strict=True)
    timed = any(heading(name).quantity == "time" or looks_iso(cells) or looks_dated(cells) for name, cells in columns)
    try:
        if (timed or table.sampled) and goes_in_steps(table.numbers(rates.applied)):
            return False  # a recording
        return all(np.isfinite(table.numbers(name)).any() for name in (rates.applied, *rates.readings))
    except InertialcalError:  # text
        return False


def asks(contents: Mapping[str, object]) -> list[Question]:
    """Return what the first file that does not say it leaves open: the axis that was turned, the unit of the rate."""
    asked: dict[tuple[str, str], Question] = {}
    turned = {file: axis for file, one in contents.items() if (axis := _turned_in(one))}
    each = len(set(turned.values())) > 1  # one answer is not right for all
    for file, one in contents.items():
        of_axis = () if each and file in turned else _asked_axis(file, one)
        for question in (*of_axis, *_asked_unit(file, one)):
            asked.setdefault((question.name, question.group), question)
    return list(asked.values())


def _turned_in(one: object) -> str:
    """Return the axis that follows the rate of the table, by its readings; empty where none clearly does."""
    return turned_axis(one) if isinstance(one, Recording) else one.follows or "" if isinstance(one, Guess) else ""


def _asked_axis(file: str, one: object) -> Iterator[Question]:
    if isinstance(one, Recording):
        follows = turned_axis(one)
        seen = f"{file}: {follows} follows the rate of the table" if follows else f"{file}: turned on a rate table"
    elif isinstance(one, Guess) and one.axis is None and len(one.by_axis) != 1:
        follows, seen = one.follows or "", f"{file}: a table of dwells"
    else:
        return
    yield Question("axis", seen, "Axis that was turned? (x, y or z)", follows, wrong=one_of(AXES))


def _asked_unit(file: str, one: object) -> Iterator[Question]:
    if isinstance(one, Recording):
        applied = guess_channels(one.channels).applied
        if applied is not None and one.channel(applied).unit is None:
            ask = f"Unit of the rate of the table? ({RATES}, ...)"
            seen = f"{file}: {applied} without a unit"
            yield Question("units", seen, ask, group=applied, wrong=unit_of("angular_rate"))
    elif isinstance(one, Guess) and one.unit is None and one.applied_unit is None and one.reading_unit is None:
        yield Question("units", f"{file}: rates without a unit", f"Unit? ({RATES}, ...)", group="gyro",
                       wrong=unit_of("angular_rate"))  # fmt: skip


def draft(contents: Mapping[str, object]) -> Draft:
    """Return the suite of gyros, its recordings and tests, by file: recordings and reduced tables."""
    tables = {file: one for file, one in contents.items() if isinstance(one, Guess)}
    raw = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    units = [one.unit for one in tables.values()]
    units += [c.unit for one in raw.values() for c in gyros(one).values() if kind(c.unit or "1") == "angular_rate"]
    suite = sensor_table("gyro", units) | {
        "range": Noted(["-100 deg/s", "100 deg/s"], example=True),
        "chain": Noted({"kind": "none", "scale_factor": "0.5 V/(deg/s)"}, example=True),
    }
    recordings = {f"rec{number}": _recording(file, one) for number, (file, one) in enumerate(raw.items(), 1)}
    tests: list[dict[str, object]] = []
    if recordings:  # one test: the turned axis stands with each recording
        tests.append({"id": "rate", "procedure": "rate_table", "recordings": list(recordings)})
    for number, (file, one) in enumerate(tables.items(), 1):
        recordings[f"table{number}"] = {"sensor": "suite", "file": file, "rows": _rows(one)}
        test: dict[str, object] = {"id": f"rate{number}", "procedure": "rate_table", "recordings": [f"table{number}"]}
        if one.axis is None:
            axis = next(iter(one.by_axis)) if len(one.by_axis) == 1 else one.follows or "?"
            test["plan"] = fill_in({"axis": axis})
        tests.append(test)
    standard = Noted({"rate": {"u": "0.05 %", "certificate": "..."}, "mounting": {"u": "0.1 deg"}}, example=True)
    return Draft({"suite": suite}, recordings, tests, REQUIREMENT, {"rate_table": standard})


def _rows(found: Guess) -> dict[str, object] | Noted:
    """Return the columns of a reduced table; one column of scatter does not say which of several readings it is of."""
    alone = len(found.readings) == 1
    keys = ("scatter", "samples", "axis", "group", "run") if alone else ("samples", "axis", "group", "run")
    rows = {
        "applied": found.applied or "?",
        "reading": found.readings[0] if alone or not found.by_axis else dict(found.by_axis),
        **{key: column for key in keys if (column := getattr(found, key))},
        "unit": found.unit or found.reading_unit or "?",
    }
    if found.unit is None and found.applied_unit is not None:
        rows["applied_unit"] = found.applied_unit
    return rows if rows["unit"] != "?" and (alone or found.by_axis) else fill_in(rows)


def _recording(file: str, one: Recording) -> dict[str, object] | Noted:
    applied = guess_channels(one.channels).applied
    unit = None if applied is None else one.channel(applied).unit
    rate: object = {"column": applied or "?", "unit": unit or "?"}
    turned = {axis: channel for axis, channel in gyros(one).items() if channel.name != applied}
    channels = {"applied": rate if unit else fill_in(rate), **channel_tables(turned)}
    table = recording_table("suite", file, one, channels) | {"axis": fill_in(turned_axis(one) or "?")}
    return table if applied else Noted(table, above=NO_RATE)
