"""A recording of a sensor at rest, with what its channels mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ....core.recording import Recording
from ....signals.names import Quantity


@dataclass(frozen=True, eq=False)
class AtRest:
    """A recording of a sensor at rest."""

    recording: Recording  # With its channels
    channels: Mapping[str, str]  # Which channel is which axis
    # SI unit a unit of the channel; 1 where not said
    scale: Mapping[str, float] = field(default_factory=dict[str, float])
    quantity: Quantity = "rate"  # What its samples are
    name: str = ""  # For messages; its file where not given
    shown: str = ""  # Unit that samples are told in; that of the channel where not given

    @property
    def place(self) -> str:
        """Name of the recording, for messages."""
        return self.name or self.recording.source.path or "recording"
