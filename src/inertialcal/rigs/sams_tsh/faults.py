"""Mistakes of a flip, each of which the reduction must name."""

from __future__ import annotations

from ..protocol import Fault

FAULTS: dict[str, Fault] = {
    "not_turned": Fault("the turn back stops 60 deg short", "not_turned_by_angle", {"stopped_deg": (0.0, 60.0)}),
    "other_axis": Fault("the head was turned about z, not x", "turned_about_other_axis", {"turn_axis": "z"}),
    "gain_changed": Fault("the gain of y changes inside a window", "gain_changed", {"gain_change": (1350.0, "y", 0.1)}),
    "too_short": Fault(
        "the head is turned back before the settling is over",
        "shorter_than_settling",
        {"turn_starts": (1200.0, 1215.0)},
    ),
    "missing_position": Fault(
        "what was recorded in the turned position is lost", "missing_position", {"lost": (1202.0, 2404.0)}
    ),
    "at_rails": Fault("x at gain 1000 is beyond the converter", "rail", {"gains": (1000.0, 100.0, 10.0)}),
    "magnitude": Fault("recorded in g, said to be in ug", "magnitude", {"saved": "g", "said": "ug"}),
    "robot_arm": Fault("the robot arm moves during a flip", "disturbed", {"arm": (2250.0, 2600.0)}),
    "wrong_sign": Fault(
        "y is wired the wrong way: half turns do not show it, a quarter turn does",
        "not_turned_by_angle",
        {
            "signs": (1, -1, 1),
            "turn_starts": (900.0, 1800.0, 2700.0),
            "positions_deg": (90.0, 180.0, 0.0),
            "stopped_deg": (0.0, 0.0, 0.0),
        },
    ),
}
