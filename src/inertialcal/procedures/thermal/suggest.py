"""What looks like a test over temperature: the command to type next."""

from __future__ import annotations

from ...core.batches import extremes
from ...core.recording import Recording
from ...core.units import kind
from ...files.info.survey import Survey
from ..suggestions import Strength, Suggestion

SWING = 10.0  # change of the temperature that nobody makes by accident [K]


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``thermal`` where sensors with a unit were read while their temperature was made to change."""
    warm = [one for one in recording.channels if one.unit is not None and kind(one.unit) == "temperature"]
    read = [one for one in recording.channels if one.axis and one.quantity in ("gyro", "acc") and one.unit]
    changed = any(high - low > SWING for low, high in (extremes(one.data) for one in warm)) and any(
        one.unit != "count" for one in read
    )
    return Suggestion(("thermal",), Strength.LIKELY) if changed else None
