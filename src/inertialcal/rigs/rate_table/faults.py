"""Mistakes of a rate-table test, each of which the reduction must name."""

from __future__ import annotations

from ..protocol import Fault

FAULTS: dict[str, Fault] = {
    "swapped_axis": Fault("the columns x and y hold each other's sensor", "axes_mixed", {"wiring": ("y", "x", "z")}),
    "wrong_sign": Fault("the z sensor is not mounted inverted, as is said", "inverted", {"inverted": (-1, 1, 1)}),
    "saturated_step": Fault(
        "the highest rate lies beyond the converter",
        "rail",
        {"rates_deg_s": (0.0, 0.5, -0.5, 1.5, -1.5, 0.0, 3.0, -3.0, 6.0, -4.5, 0.0)},
    ),
    "missing_reference": Fault(
        "the reference voltages were not saved", "missing_reference", {"reference_saved": False}
    ),
    "bit_low": Fault("the built-in test is low throughout", "never_valid", {"built_in_test": 0.4}),
    "only_positive": Fault(
        "the table turned one way only",
        "few_rates",
        {"rates_deg_s": (0.0, 0.5, 1.0, 1.5, 2.0, 0.0, 3.0, 3.5, 4.0, 4.5, 0.0)},
    ),
    "axis_not_turned": Fault("the unit was not turned about z", "not_turned", {"turned": ("x", "y")}),
    "never_still": Fault(
        "no dwell at rest",
        "never_still",
        {"rates_deg_s": (0.5, -0.5, 1.5, -1.5, 2.5, -2.5, 3.0, -3.0, 4.5, -4.5)},
    ),
    "rate_off": Fault("the table turns 15 % slower than it says", "rate_disagrees", {"table_gain": 0.85}),
}
