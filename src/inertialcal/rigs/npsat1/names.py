"""Names in the campaign of the simulated rate suite: tests, recordings, files, temperatures."""

from __future__ import annotations

from ...core.axes import AXES
from .setup import AIR, VACUUM

NAMES = {AIR: "thermal_ambient", VACUUM: "thermal_vacuum", "rate_table": "rate", "noise": "noise"}  # tests for the fit


def degrees(temperature: float) -> str:
    """Return a temperature as a condition and a setting have it."""
    return f"{temperature:g} degC"


def recording_name(what: str, number: int) -> str:
    """Return the name of a recording: of a condition, of an axis that is turned, at rest."""
    return f"{what}_run{number}" if what in AXES else f"{what}_{number}"


def recording_file(what: str, number: int) -> str:
    """Return the file of a recording, in the campaign folder."""
    return f"recordings/{recording_name(what, number)}.csv"
