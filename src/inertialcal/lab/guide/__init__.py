"""Calibration by hand, guided: what to do next, what is known so far, and when it is enough."""
