"""The analysis programme of the 1969 report, step by step as its listing has it: for comparison, not for use.

What the report's numbers are made of: two series of up to 100 samples, one of the accelerometer and one of the tilt
meter; four reductions; correlations, spectrum and Fourier coefficients; scale factor. Rules that are wrong or odd are
kept and named at each function: wrong positions are closed up (which shifts the phase of all that follows), the highest
line has twice its weight, the moving mean shrinks towards the ends of the record and takes 1.3 % of the signal with
it. The right way stands in ``signals.programme1969.reductions`` and ``signals.sine``.

It lies with the signals, not with the procedure that uses it: from cards to numbers it knows of no mass and no
schedule.

Where the listing in the text at hand carries reading errors, the reading is the one under which the step does what the
report says of it; each is named. Samples are counted from 1 in the report and from 0 here; time index 0 is the first
sample in both (the listing uses I - 1, appendix A prints I).

References
----------
.. [1] K. Reinel, Accelerometer Calibration in the Low g Range by Means of Mass Attraction, NASA TM X-53857, 1969,
   appendices A and B.
"""

from .analysis import Analysis, ScaleFactor, analyse, scale_factor
from .cards import Deck, MeasuredCase, Request, SyntheticCase, read_cards
from .case import Step, closed_up, run_case, series_of, synthetic
from .steps import adjusted_curve, straight_line, tilt_trace, without_harmonics

__all__ = [
    "Analysis",
    "Deck",
    "MeasuredCase",
    "Request",
    "ScaleFactor",
    "Step",
    "SyntheticCase",
    "adjusted_curve",
    "analyse",
    "closed_up",
    "read_cards",
    "run_case",
    "scale_factor",
    "series_of",
    "straight_line",
    "synthetic",
    "tilt_trace",
    "without_harmonics",
]
