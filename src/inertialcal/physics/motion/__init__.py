"""Motion of an attracting mass: travel, window, drive, harmonics."""

from .clearance import least_distance, refuse_overlap
from .drive import ORDER, Drive, drive, harmonics, sine_of_field, sine_of_position
from .travel import Travel, Window, best_window, position_of, travel_of_body, travel_of_table

__all__ = [
    "ORDER",
    "Drive",
    "Travel",
    "Window",
    "best_window",
    "drive",
    "harmonics",
    "least_distance",
    "position_of",
    "refuse_overlap",
    "sine_of_field",
    "sine_of_position",
    "travel_of_body",
    "travel_of_table",
]
