"""Which column of a table of reduced means is what, as far as the names tell."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from ....core.errors import DataError, UsageError
from ....core.units import parse_quantity
from ....files.text.table import Table
from ..entry import Means

PATTERNS = {
    "axis": r"^(axis|channel|sensor)$",
    "position": r"^(position|orientation|attitude|turned)$",
    "flip": r"^(flip|rotation|turn|time|time_id)$",
    "mean": r"(^|_)(mean|average|reading|acceleration|acc)(_|$)",
    "temperature": r"(^|_)(temp|temperature)(_|$)",
    "predicted": r"(^|_)predicted(_|$)",
}
WIDTH = re.compile(r"(?:^|_)half_width_(\d\d)(?:_|$)")


def is_table_of_means(table: Table) -> bool:
    """Tell whether a file is a table of means: a column of axes, and one of positions."""
    return _named(table.names, "axis") is not None and _named(table.names, "position") is not None


def means_columns(table: Table, angles: Mapping[str, str], unit: str | None) -> Means:
    """Return which column is what, as ``means`` of a campaign file has it.

    Parameters
    ----------
    table : Table
        As read.
    angles : mapping of str to str
        Angle of each position, ``{"reverse": "180 deg"}``; without any, positions are angles with their unit.
    unit : str or None
        Of the means, where the header does not say it.

    Raises
    ------
    UsageError
        If it is not clear which column is what, in which unit, or at which angle a position is.
    """
    found = {what: _named(table.names, what) for what in PATTERNS}
    path = table.source.path
    if found["mean"] is None:
        what = f"{path}: no column is clearly the mean; it has {', '.join(table.names)}"
        raise UsageError(what, do='Name it "mean", with its unit: mean [ug]', code="no_column")
    spoken = unit or table.unit(found["mean"])
    if spoken is None:
        raise UsageError(f"{path}: nothing says the unit of {found['mean']!r}", do="Say it: --unit ug", code="no_unit")
    positions = list(dict.fromkeys(table.text(str(found["position"]))))
    widths = {f"0.{match[1]}": name for name in table.names if (match := WIDTH.search(_key(name)))}
    return Means(
        axis=str(found["axis"]),
        position=str(found["position"]),
        mean=found["mean"],
        unit=spoken,
        angles={one: _angle(one, angles, str(path)) for one in positions},
        flip=found["flip"],
        temperature=found["temperature"],
        predicted=found["predicted"],
        half_widths=widths,
    )


def _angle(position: str, angles: Mapping[str, str], path: str) -> str:
    text = angles.get(position, position)
    try:
        parse_quantity(text).to("rad")
    except DataError:
        what = f"{path}: position {position!r} has no angle"
        do = f'Say it: --position "{position}=180 deg"'
        raise UsageError(what, do=do, code="no_angle") from None
    return text


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


def _named(names: Sequence[str], what: str) -> str | None:
    found = [name for name in names if re.search(PATTERNS[what], _key(name)) and not WIDTH.search(_key(name))]
    return found[0] if len(found) == 1 else None
