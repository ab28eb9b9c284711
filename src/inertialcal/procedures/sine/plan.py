"""Settings of a test of a known drive."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.settings import setting

# Influences that a test of a drive is subject to, and what each would change.
INFLUENCES: dict[str, str] = {}


@dataclass(frozen=True)
class Drive:
    """The drive, as a caller says it of a file."""

    schedule: str | None = setting(
        "CSV of dwells and what is applied in each, in place of a period; it begins with the recording.",
        None, example="dwells.csv",
    )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """Which drive."""

    period: float | None = setting(
        "True time from cycle to cycle, pauses included; else the recording has a schedule of its drive.",
        None,
        unit="s",
        example="480 s",
    )
    phase: float | None = setting(
        "Phase of the sine at the first sample; free if not given.", None, unit="rad", example="90 deg"
    )
