"""What a file of an alignment is taken for: three accelerometers and three gyros, in one file or in one each."""

from __future__ import annotations

from dataclasses import replace

from ...core.key import Kind
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec

SENSORS: tuple[tuple[str, Kind], ...] = (("acc", "accelerometer"), ("gyro", "gyro"))


def described(given: GivenFile, spec: InputSpec) -> list[Described]:
    """Return the triads that a file holds; of one without names, those that are asked for."""
    kinds = {one.quantity for one in given.recording.channels}
    said = {given.said.sensor} - {None}
    wanted = [one for one in SENSORS if not said or said & {*one}]
    there = [one for one in wanted if kinds & {*one}] or wanted
    found = []
    for name, _ in there:
        one = described_channels(replace(given, said=replace(given.said, sensor=name)), spec)
        found.append(replace(one, columns={f"{name}_{what}": column for what, column in one.columns.items()}))
    return found
