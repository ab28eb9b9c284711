"""Mistakes of a campaign of the rate suite, each of which the reduction must name."""

from __future__ import annotations

from ..protocol import Fault

FAULTS: dict[str, Fault] = {
    "no_temperature_change": Fault(
        "the chamber was never switched on", "no_temperature_change", {"set_points": (23.0, 23.0, 23.0, 23.0)}
    ),
    "missing_reference": Fault(
        "the reference voltages of the rates were not saved", "missing_reference", {"reference_saved": False}
    ),
    "swapped_axes": Fault("the connectors x and y are exchanged", "axes_mixed", {"wiring": ("y", "x", "z")}),
    "inverted_sign": Fault("the z sensor is not mounted inverted, as is said", "inverted", {"inverted": (-1, 1, 1)}),
    "overlapping_windows": Fault(
        "the windows of a fit and of a hold-out test have hours in common", "overlap", {"overlapping": True}
    ),
    "saturated_end": Fault(
        "the temperature channels reach the end of the converter before the ramp is at its cold end",
        "rail",
        {"nominal_shift": -0.9},
    ),
    "duplicate_recording": Fault(
        "the file of the second ramp in air is a copy of the first", "duplicate_recording", {"copied": True}
    ),
    "only_cooling": Fault("the chamber only cooled", "one_path", {"set_points": (67.0, -30.0)}),
    "wide_requirement": Fault(
        "the bias is required over more than the ramps went through", "outside", {"required_degc": (-40.0, 85.0)}
    ),
    "no_zero_reference": Fault(
        "the rate table was never still",
        "never_still",
        {
            "rates_deg_s": (0.1, -0.1, 0.2, -0.2, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0, 4.5, -4.5),
            "zero_reference": False,
        },
    ),
}
