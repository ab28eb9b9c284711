"""Figures of a gyro against a magnetometer in orbit."""
