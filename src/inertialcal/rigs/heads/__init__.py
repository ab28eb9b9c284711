"""Accelerometer heads on one satellite, a gyro beside them."""

TITLE = "four accelerometer heads and a gyro on one satellite: two are calibrated, one lies off their line, 1 s samples"
