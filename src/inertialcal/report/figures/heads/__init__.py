"""Figures of a calibration of heads by others on one body."""
