"""Settings of a test of the effects of vibration."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.settings import setting

# Influences that the test is subject to, and what each would change.
INFLUENCES: dict[str, str] = {}


@dataclass(frozen=True)
class Direction:
    """The vibration, as a caller says it of a file."""

    axis: str | None = setting("Body axis that was vibrated along; unknown if not given.", None, example="z")
    control: str | None = setting(
        "Column of the control accelerometer; the one that is named so if not given.", None, example="ctrl1"
    )


@dataclass(frozen=True)
class Plan:
    """How a record is cut, and into which bands."""

    block: float = setting("Length of the means that levels are told from.", 1.0, unit="s", example="0.5 s")
    quiet: float = setting(
        "Level, against the highest, below which the unit counts as at rest.", 0.1, unit="1", example="5 %"
    )
    resolution: float | None = setting(
        "Spacing of the lines of spectra; by default 1/400 of the sample rate.", None, unit="Hz", example="2 Hz"
    )
    drift: bool = setting("The bias may drift evenly over a record.", True)
