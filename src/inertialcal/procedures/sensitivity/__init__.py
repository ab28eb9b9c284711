"""Bias and scale factor against conditions that are recorded with the readings: supply, pressure, any channel."""
