"""What a campaign says of a recording under a known drive: the schedule of what was applied."""

from __future__ import annotations

from ...core.schema_words import Strict, Text


class KnownDrive(Strict):
    """drive = {...}: a table of the dwells of the drive, which begins with the recording."""

    schedule: Text
