"""Units as the command line has them: --unit NAME=UNIT."""

from __future__ import annotations


def units_of(given: list[str]) -> dict[str, str]:
    """Return the units by column or group, as ``--unit`` says them.

    Raises
    ------
    UsageError
        If a text does not have the form.
    """
    from ..core.errors import UsageError

    units = {}
    for text in given:
        name, equals, unit = text.partition("=")
        if not equals or not name or not unit:
            raise UsageError(f"--unit {text!r}: write NAME=UNIT, like gyro=deg/s")
        units[name.strip()] = unit.strip()
    return units
