"""The bench of a gyro that stands still."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.influence import Influence

SCALE = Influence(0.002, "1", certificate="data sheet of the unit")


@dataclass(frozen=True)
class Bench:
    """The record as it is made.

    Parameters
    ----------
    records, samples : int
        Records, and averages of each.
    interval, averaging : float
        From average to average, and length of each [s].
    walk, rate_walk, flicker : float
        Sizes about which those of a unit are drawn: N [rad/sqrt(s)], K [rad/s/sqrt(s)], B [rad/s].
    skipped : float
        Part of the averages that is not saved (1).
    scale_factor : Influence
        Uncertainty of what turns readings into rates.
    knocked : bool
        Whether somebody knocks against the bench.
    warming : float
        Change of all biases while the unit warms up [rad/s].
    humming : float
        Amplitude of a line in x [rad/s].
    stuck : str
        Axis whose channel hangs; none where empty.
    """

    records: int = 2
    samples: int = 12_000
    interval: float = 2.0
    averaging: float = 1.0
    walk: float = 7e-5
    rate_walk: float = 8e-7
    flicker: float = 3e-5
    skipped: float = 0.001
    scale_factor: Influence = SCALE
    knocked: bool = False
    warming: float = 0.0
    humming: float = 0.0
    stuck: str = ""
