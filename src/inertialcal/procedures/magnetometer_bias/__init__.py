"""Bias of a gyro in orbit from a magnetometer: no attitude needed."""
