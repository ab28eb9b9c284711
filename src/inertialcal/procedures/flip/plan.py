"""What a flip is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ...core.axes import AXES
from ...core.constants import STANDARD_GRAVITY
from ...core.influence import Influence, Standards

Axis = Literal["x", "y", "z"]


# Influences that a flip is subject to, and what each would change.
INFLUENCES = {
    "turn.angle": "bias and ambient acceleration by half the other turned axis' ambient acceleration, times the angle",
    "turn.axis": "all results: ambient acceleration along the turn enters, and the control axis feels the others",
    "converter.zero": "bias in full: an offset of the electronics turns with the head as the bias does",
    "sensor.scale_factor": "bias and ambient acceleration in proportion; bias by what was taken off before, too",
}


@dataclass(frozen=True)
class Plan:
    """How the head was turned and how the readings are to be reduced.

    Parameters
    ----------
    axis : {"x", "y", "z"}
        Head axis about which it was turned; its own readings are the control.
    noise : {"slow", "pairs"}
        Where the uncertainty comes from: a model of the record's white and 1/f noise, or the scatter of equally long
        and equally spaced quiet stretches elsewhere in the record.
    drift : {"none", "ambient", "bias", "temperature"}
        What changes between the dwells of a flip and is fitted: ambient acceleration or bias in proportion to time,
        or bias in proportion to temperature. Needs three dwells.
    block : float
        Length of the block means that show the noise [s]; longer in a long record with long windows.
    settle : float
        Left out at the start of every window: settling of the turn and of the sensor's filters [s].
    low_pass : float
        Cut-off of the low-pass that stands beside the mean [Hz].
    subset : float
        Length of the sub-means of the published way [s].
    subsets : int
        How many of them.
    missing : float
        A window with a larger part of its samples missing, invalid or at the rail is not read.
    corrected : bool
        The bias of a model was taken off before: what is left of it is called ``model_bias_error``.
    raw_bias : float
        Size of what was taken off before [m/s^2]: the scale factor's uncertainty acts on it too. 0: what the ground
        model predicts, where the readings come with it.
    largest_ambient : float
        Ambient acceleration beyond this is a mistake in units or positions, not orbit [m/s^2].
    largest_bias : float
        Bias beyond this is one, too [m/s^2].
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    axis: Axis = "x"
    noise: Literal["slow", "pairs"] = "slow"
    drift: Literal["none", "ambient", "bias", "temperature"] = "none"
    block: float = field(default=10.0, metadata={"unit": "s"})
    settle: float = field(default=0.0, metadata={"unit": "s"})
    low_pass: float = field(default=0.01, metadata={"unit": "Hz"})
    subset: float = field(default=6.0, metadata={"unit": "s"})
    subsets: int = field(default=10, metadata={"above": 1})
    missing: float = field(default=0.1, metadata={"above": 0.0})
    corrected: bool = False
    raw_bias: float = field(default=0.0, metadata={"unit": "m/s^2"})
    largest_ambient: float = field(default=0.1 * STANDARD_GRAVITY.value, metadata={"unit": "m/s^2"})
    largest_bias: float = field(default=0.1 * STANDARD_GRAVITY.value, metadata={"unit": "m/s^2"})
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})

    @property
    def turned(self) -> tuple[str, str]:
        """The two axes across the turn, so that the first, the second and the turn's are right-handed."""
        at = AXES.index(self.axis)
        return AXES[(at + 1) % 3], AXES[(at + 2) % 3]
