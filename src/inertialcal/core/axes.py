"""Axes of a body, and the kinds of sensors along them. Free of numpy."""

from __future__ import annotations

from typing import Literal

AXES = ("x", "y", "z")  # right-handed; the order of vectors and of matrix columns
Kind = Literal["gyro", "accelerometer"]
