"""What each figure of an alignment is of."""

from __future__ import annotations

from ...core.key import AXES, At, Key

ROLL, PITCH, HEADING, BIAS, VERTICAL, RATE, LATITUDE, EXCESS = (
    "roll", "pitch", "heading", "gyro_bias", "gyro_bias_vertical", "level_earth_rate", "latitude_seen",
    "gravity_excess")  # fmt: skip


def keys_of(positions: int) -> list[Key]:
    """Return what each figure of ``solving.figures`` is of."""
    found = []
    for at in range(positions):
        place = At("position", float(at + 1), "") if positions > 1 else None
        found += [Key(name, at=place) for name in (ROLL, PITCH, HEADING)]
    return [*found, *(Key(BIAS, axis) for axis in AXES), Key(VERTICAL), Key(RATE), Key(LATITUDE), Key(EXCESS)]
