"""Alignment of a unit at rest: roll, pitch and heading from gravity and the rate of the earth."""
