"""What speaks against figures that a fit gives: its own tests, and samples that are no readings."""

from __future__ import annotations

from ...sensors.noise.fitting.noise_fit import NoiseFit
from .readings import Run

CUT = 1e-3  # share of samples at the end of the range from which the noise that is left is no longer whole
DOUBTS = {
    "terms_do_not_explain": "the terms do not explain the Allan deviation",
    "runs_disagree": "the records do not agree",
}  # by the code of a fit's remark


def doubt_of(found: NoiseFit | None) -> str:
    """Return what a fit's own tests speak against it; empty where they do not.

    Parameters
    ----------
    found : NoiseFit or None
        Fit of an axis.
    """
    return " and ".join(DOUBTS[code] for code in (found.fit_warnings if found is not None else ()))


def fault_of(run: Run, axis: str) -> str:
    """Return what samples that are no readings make of the figures: stuck ones that were kept, too many cut ones.

    Parameters
    ----------
    run : Run
        The record.
    axis : str
        Which.
    """
    for one in run.faults:
        if one.axis == axis and one.code == "stuck" and not one.left_out:
            return "stuck samples were kept in"
        if one.axis == axis and one.code == "saturated" and one.count > CUT * len(run):
            return "its noise is cut at the end of the range"
    return ""
