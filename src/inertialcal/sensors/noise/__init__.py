"""Noise of a sensor as a sum of terms: what each looks like when sampled, which ones a record shows, and how large.

``fit`` takes the overlapping Allan deviation of one run, or of several, to a NoiseFit: values with intervals, and for
each term that the record does not show the reason, an upper limit, and the record that would show it. The terms can be
drawn (``expected_variance``, ``sampled_spectrum``), simulated, planned for (``plan_record``, ``forecast``) and handed
to a filter (``state_space``, ``to_kalibr``, ...). Values are SI inside; ``shown_units`` are those of data sheets.
"""

from ...core.key import Kind
from ...core.units import kind_of_unit
from .expected import continuous_spectrum, expected_variance, sampled_spectrum
from .fitting.estimator import fit
from .fitting.goodness import ChiSquare
from .fitting.noise_fit import NoiseFit, Parameter, TermEstimate, duration
from .fitting.problem import AllanLike, Run
from .planner import Forecast, RecordPlan, forecast, plan_record
from .simulate import simulate
from .state_space import StateSpace, bias_state, combined, discretise, flicker_bank, state_space
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
    converted,
    parameter_unit,
    quantity_name,
    sample_unit,
    shown_units,
)
from .to_filters import FilterBlock, to_gtsam, to_kalibr, to_kf_gins, to_openvins, to_px4, to_ros

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
    "to_openvins",
    "to_px4",
    "to_ros",
]
