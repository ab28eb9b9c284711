"""Heads on one body: two or more that are calibrated calibrate the others."""
