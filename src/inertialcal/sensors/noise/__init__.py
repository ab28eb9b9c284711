"""Noise of a sensor as a sum of terms: what each looks like when sampled, which ones a record shows, and how large.

``fit`` takes the overlapping Allan deviation of one run, or of several, to a NoiseFit: values with intervals, and for
each term that the record does not show the reason, an upper limit, and the record that would show it. The terms can be
drawn (``expected_variance``, ``sampled_spectrum``), simulated, planned for (``plan_record``, ``forecast``) and handed
to a filter (``state_space``, ``to_kalibr``, ...). Values are SI inside; ``shown_units`` are those of data sheets.
"""

from ...core.axes import Kind
from .allan_of_terms import expected_variance
from .filter_block import FilterBlock
from .fitting.estimator import fit
from .fitting.goodness import ChiSquare
from .fitting.noise_fit import NoiseFit, Parameter, TermEstimate, duration
from .flicker_bank import flicker_bank
from .forecast import Forecast, forecast
from .planner import RecordPlan, plan_record
from .runs import AllanLike, Run
from .simulate import simulate
from .spectrum_of_terms import continuous_spectrum, sampled_spectrum
from .state_space import StateSpace, bias_state, combined, discretise, state_space
from .terms import (
    TERMS,
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    quantity_name,
)
from .to_filters import to_gtsam, to_kalibr, to_kf_gins, to_px4
from .units import converted, kind_of_unit, parameter_unit, sample_unit, shown_units

__all__ = [
    "TERMS",
    "AllanLike",
    "BiasInstability",
    "ChiSquare",
    "FilterBlock",
    "Forecast",
    "GaussMarkov",
    "Kind",
    "NoiseFit",
    "Parameter",
    "Quantization",
    "RandomWalk",
    "RateRamp",
    "RateRandomWalk",
    "RecordPlan",
    "Run",
    "Sinusoid",
    "StateSpace",
    "Term",
    "TermEstimate",
    "bias_state",
    "combined",
    "continuous_spectrum",
    "converted",
    "discretise",
    "duration",
    "expected_variance",
    "fit",
    "flicker_bank",
    "forecast",
    "kind_of_unit",
    "parameter_unit",
    "plan_record",
    "quantity_name",
    "sample_unit",
    "sampled_spectrum",
    "shown_units",
    "simulate",
    "state_space",
    "to_gtsam",
    "to_kalibr",
    "to_kf_gins",
    "to_px4",
]
