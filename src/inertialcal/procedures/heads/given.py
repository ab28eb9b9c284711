"""What a file of a head is taken for: three axes of an accelerometer, or of a gyro, and where the head is described."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...core.errors import UsageError
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec


def split_label(given: str) -> tuple[str, str]:
    """Return the head that a caller names a file by, and the file: ``"tsh1=a.csv"``."""
    label, equals, path = given.partition("=")
    return ("", given) if not equals or Path(given).exists() else (label.strip(), path)


def described(given: GivenFile, spec: InputSpec) -> list[Described]:
    """Return the head, and the gyro where the file has one.

    Raises
    ------
    UsageError
        ``missing`` without a file of the body.
    """
    body = given.own.get("body")
    if body is None:
        do = f"Add: {given.add('body', 'body.toml')}"
        raise UsageError("where the heads are is not said", given.name, "positions and orientations are needed", do,
                         "missing")  # fmt: skip
    kinds = {one.quantity for one in given.recording.channels}
    found = []
    for sensor, quantity in (("acc", "accelerometer"), ("gyro", "gyro")):
        if given.said.sensor is not None and given.said.sensor not in (sensor, quantity):
            continue
        if quantity not in kinds and ("gyro" if sensor == "acc" else "accelerometer") in kinds:
            continue
        if quantity == "gyro" and quantity not in kinds:
            continue
        one = described_channels(replace(given, said=replace(given.said, sensor=sensor)), spec)
        if quantity == "accelerometer":
            head = {"file": str(body)} | ({"name": given.label} if given.label else {})
            one = replace(one, entry={**one.entry, "head": head})
        found.append(one)
    return found
