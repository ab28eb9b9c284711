"""The likely cause of a recording that reads something else than was applied: sign, unit, axes, sample rate, gain.

What is judged is the response: what each channel reads of a quantity that is known (the rate of a table, gravity, what
the other recordings read), over its nominal. A sound recording reads 1 along the axis and little on the others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from math import isfinite, log

from ..core.remarks import Remark, Severity
from ..core.units import factor

UNITS: Mapping[str, Sequence[str]] = {  # that are taken for each other, by kind
    "angular_rate": ("rad/s", "deg/s", "deg/h"),
    "acceleration": ("m/s^2", "g", "cm/s^2", "ft/s^2"),
}
PREFIXES = {"milli": 1e3, "micro": 1e6, "nano": 1e9}
RATES = (2.0, 4.0, 5.0, 8.0, 10.0)  # sample rates that are taken for each other, as ratios
NEAR = 0.1  # relative difference from a known factor
CLEAR = 0.5  # response of an axis below which another one may be what was read


@dataclass(frozen=True)
class Cause:
    """Why a recording disagrees."""

    code: str
    what: str  # What it reads, and the likely cause
    do: str

    def remark(self, recording: str, file: str, axis: str = "", severity: Severity = "error") -> Remark:
        """Return the remark that names the recording and its file."""
        return Remark(self.code, severity, f"{recording}: {self.what}", file, do=self.do, axis=axis, subject=recording)


def likely_cause(
    response: Mapping[str, float],
    axis: str,
    tolerance: float,
    kind: str = "",
    applied: str = "the applied quantity",
    sampled: bool = False,
    doubt: Mapping[str, float] | None = None,
) -> Cause | None:
    """Return why a response is not the nominal one; None where it is, or where it is not known.

    Parameters
    ----------
    response : mapping of str to float
        What each channel reads of a quantity along one axis, over its nominal.
    axis : str
        Along which it was applied; also the name of the channel that should read 1 of it.
    tolerance : float
        Relative difference from the nominal that is a calibration matter.
    kind : str
        Of unit of the readings, ``"angular_rate"`` or ``"acceleration"``; empty where units cannot be mistaken.
    applied : str
        What was applied, for the message.
    sampled : bool
        Whether the quantity is an angle or a time, which a wrong sample rate changes.
    doubt : mapping of str to float, optional
        How far each response may be off by its scatter.

    Examples
    --------
    >>> likely_cause({"x": 0.0175, "y": 1e-5}, "x", 0.2, "angular_rate").code
    'unit_disagrees'
    >>> likely_cause({"x": 0.01, "y": -0.998}, "x", 0.2).code
    'axes_disagree'
    >>> likely_cause({"x": 1.01, "y": 0.02}, "x", 0.2) is None
    True
    """
    own, off = response.get(axis, float("nan")), doubt or {}
    others = {name: abs(response[name]) - off.get(name, 0.0) for name in response if name != axis}
    most = max((name for name, value in others.items() if isfinite(value)), key=others.__getitem__, default="")
    if isfinite(own) and most and others[most] > max(CLEAR, 2.0 * (abs(own) + off.get(axis, 0.0))):
        what = f"{axis} was turned, but {most} reads {response[most]:+.3g} of {applied}, and {axis} {own:+.3g}"
        return Cause("axes_disagree", what, "Check the axis named, the file, the columns and the mounting")
    tolerance += off.get(axis, 0.0)
    if not isfinite(own) or abs(own - 1.0) <= tolerance:
        return None
    inverted, unit = abs(own + 1.0) <= tolerance, unit_mistaken(abs(own), kind)
    why, code, do = ", which should be 1", "gain_disagrees", "Check units, scale factor, gain and columns"
    if inverted:
        why, code = ": the sign is inverted", "sign_disagrees"
        do = "Check the sign of the column, the sense of the applied quantity and the mounting"
    elif unit:
        why, code = f": {unit}" + (", with the sign inverted" if own < 0.0 else ""), "unit_disagrees"
        do = "State the unit of this recording"
    elif sampled and any(_near(own, ratio) or _near(own, 1.0 / ratio) for ratio in RATES):
        why, code, do = ": the sample rate is wrong", "sample_rate_disagrees", "Check the sample rate"
    return Cause(code, f"{axis} reads {own:+.4g} of {applied}{why}", do)


def unit_mistaken(ratio: float, kind: str) -> str:
    """Return which unit was taken for another, where readings are this many times too large; empty for none."""
    for actual, stated in permutations(UNITS.get(kind, ()), 2):
        if _near(ratio, factor(stated, actual)):
            return f"these are readings in {actual}, taken for {stated}"
    for prefix, size in PREFIXES.items():
        if _near(ratio, size):
            return f"the readings carry a prefix {prefix} that was not stated"
        if _near(ratio, 1.0 / size):
            return f"the stated unit has a prefix {prefix}, the readings have not"
    return ""


def _near(ratio: float, size: float) -> bool:
    return ratio > 0.0 and abs(log(ratio / size)) < NEAR
