"""Noise terms fitted to Allan deviations: likelihood, profile, limits, order."""
