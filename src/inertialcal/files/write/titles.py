"""Titles: names and units of channels as a file holds them, chosen so that they read back.

A title is the name as it is, where name or metadata tell the unit; else ``name [unit]``. A name that would tell
something else (``voltage_x [rad/s]`` reads as a voltage), or that ends in another unit (``gyro_x_mv``), gives way
to ``gyro_x``, or to ``channel_3``, and a remark says so. The reader itself is asked: nothing is known here of how
it reads names.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ..columns import Column
from ..info.describe import Described, describe
from ..text.headers import bare_name, heading


@dataclass(frozen=True)
class Title:
    """What a file holds of a column: its name, and its unit where the format has a place for it."""

    name: str
    unit: str | None = None


def channel_titles(recording: Recording, in_names: bool) -> tuple[tuple[Title, ...], tuple[Remark, ...]]:
    """Return a title for each channel, and remarks on those that are not what the channel is called.

    Parameters
    ----------
    recording : Recording
        Whose channels are to be written.
    in_names : bool
        Whether the unit has no other place than the name.
    """
    titles: list[Title] = []
    remarks: list[Remark] = []
    for number, channel in enumerate(recording.channels, start=1):
        taken = {title.name for title in titles} | {name for name in recording.names if name != channel.name}
        title = _title(channel, number, taken, in_names)
        titles.append(title)
        remarks += _remarks(channel, title)
    return tuple(titles), tuple(remarks)


def spelled(name: str, unit: str | None, in_names: bool) -> Iterator[Title]:
    """Yield the ways to write a name and a unit, the plainest first."""
    if in_names:
        yield Title(name)
        bare = bare_name(name)
        yield Title(f"{bare} [{unit}]" if unit else bare)
    else:
        yield Title(name, unit)
        yield Title(name, unit or "")  # an empty unit in the metadata: none, whatever the name says


def read_back(title: Title, values: Channel | Column) -> Described:
    """Return what the reader makes of a column with this title."""
    data = values.data if isinstance(values, Channel) else values.values
    return describe([Column(title.name, data, title.unit)], {}, "")[0][0]


def _title(channel: Channel, number: int, taken: set[str], in_names: bool) -> Title:
    own, plain = channel.name.strip(), f"channel_{number}"
    by_kind = [f"{channel.quantity}_{channel.axis}"] if channel.quantity and channel.axis else []
    for name in [*by_kind, own, plain] if contradicts(own, channel.unit) else [own, *by_kind, plain]:
        for title in spelled(name, channel.unit, in_names):
            if _usable(title.name, taken) and read_back(title, channel).unit == channel.unit:
                return title
    return Title(_free(plain, taken), None if in_names else channel.unit)


def contradicts(name: str, unit: str | None) -> bool:
    """Whether the end of a name says another unit: ``gyro_x_mv`` in deg/s."""
    return heading(bare_name(name)).unit not in {None, unit}


def _usable(name: str, taken: set[str]) -> bool:
    return bool(name) and name.isprintable() and name not in taken


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _remarks(channel: Channel, title: Title) -> Iterator[Remark]:
    found = read_back(title, channel)
    if bare_name(title.name) not in {bare_name(channel.name), channel.name.strip()}:
        what = f"column {channel.name!r} is written as {title.name!r}: its name cannot stand with its unit there"
        yield Remark("column_renamed", "warning", what, subject=channel.name)
    if found.unit != channel.unit:
        what = f"the unit of {channel.name!r}, {channel.unit or 'none'}, cannot be written so that it reads back"
        yield Remark("unit_not_kept", "warning", what, do="Write Parquet", subject=channel.name)
