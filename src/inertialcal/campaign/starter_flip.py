"""The part of a first campaign.toml that is about flips: tables of means, and recordings of accelerometers."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

from ..core.recording import Channel, Recording
from ..core.units import kind
from ..files.table import Table
from .flip_table import is_table_of_means, means_columns
from .load import MARK
from .schema import Means

CLOCK_COLUMN = re.compile(r"time column '(.*)'")
AXES = ("x", "y", "z")


def means_of_table(table: Table) -> Means | None:
    """Return which column of a table of means is what; None where it is none.

    Raises
    ------
    UsageError
        If its names do not tell, or not the unit.
    """
    if not is_table_of_means(table):
        return None
    columns = [name for name in table.names if re.fullmatch("position|orientation|attitude|turned", name.lower())]
    unknown = {one: "0 deg" for name in columns for one in table.text(name)}
    return means_columns(table, unknown, None)


def accelerometers(recording: Recording) -> dict[str, Channel]:
    """Return the accelerometer channels by axis."""
    return {
        c.axis: c for c in recording.channels
        if c.axis in AXES and (c.quantity == "acc" or (c.unit is not None and kind(c.unit) == "acceleration"))
    }  # fmt: skip


def flip_parts(tables: Mapping[str, Means], heads: Mapping[str, Recording]) -> list[str]:
    """Return the texts of sensor, recordings and tests; what is not known is marked.

    Parameters
    ----------
    tables : mapping of str to Means
        Tables of means by file.
    heads : mapping of str to Recording
        Recordings by file.
    """
    if not tables and not heads:
        return []
    units = [one.unit for one in tables.values()]
    units += [c.unit for one in heads.values() for c in accelerometers(one).values() if c.unit]
    unit = f"unit = {_text(units[0])}" if units else f'unit = "?"  {MARK}'
    return [
        "# Uncertainties of a flip: without them the results are relative to the fixture.\n"
        '# [standards.turn]\n# angle = { u = "0.2 deg", certificate = "..." }\n# axis = { u = "0.2 deg" }\n',
        f'[sensors.head]\nkind = "accelerometer"\naxes = ["x", "y", "z"]\n{unit}\n',
        *(_means(number, file, one) for number, (file, one) in enumerate(tables.items(), 1)),
        *(_head(number, file, one) for number, (file, one) in enumerate(heads.items(), 1)),
    ]


def _means(number: int, file: str, one: Means) -> str:
    columns = {"axis": one.axis, "position": one.position, "flip": one.flip, "mean": one.mean, "unit": one.unit}
    columns["temperature"] = one.temperature
    angles = ", ".join(f'{_text(name)} = "? deg"' for name in one.angles)
    widths = ", ".join(f"{_text(p)} = {_text(column)}" for p, column in one.half_widths.items())
    parts = [f"{key} = {_text(value)}" for key, value in columns.items() if value is not None]
    parts += [f"half_widths = {{ {widths} }}"] if widths else []
    parts.append(f"angles = {{ {angles} }}")
    return (
        f'[recordings.means{number}]\nsensor = "head"\nfile = {_text(file)}\n'
        f"means = {{ {', '.join(parts)} }}  {MARK}\n\n{_test(f'means{number}')}"
    )


def _head(number: int, file: str, one: Recording) -> str:
    column = CLOCK_COLUMN.search(one.interval_from)
    clock = f"clock = {{ column = {_text(column[1])} }}\n" if column else ""
    channels = [
        f"{axis} = {{ column = {_text(c.name)}, unit = {_text(c.unit or '?')} }}"
        for axis, c in sorted(accelerometers(one).items())
    ]
    known = all(c.unit for c in accelerometers(one).values())
    return (
        f'[recordings.head{number}]\nsensor = "head"\nfile = {_text(file)}\n{clock}'
        f"channels = {{ {', '.join(channels)} }}{'' if known else '  ' + MARK}\n"
        f"positions = [  # when it stood still, and how it was turned then\n"
        f'  {{ start = "?", stop = "?", angle = "0 deg" }},  {MARK}\n'
        f'  {{ start = "?", stop = "?", angle = "180 deg" }},  {MARK}\n]\n\n{_test(f"head{number}")}'
    )


def _test(name: str) -> str:
    return (
        f'[[tests]]\nid = "flip_{name}"\nprocedure = "flip"\nrecordings = ["{name}"]\nplan = {{ axis = "x" }}  {MARK}\n'
    )


def _text(text: str) -> str:
    """TOML string: JSON's escapes are TOML's."""
    return json.dumps(text, ensure_ascii=False)
