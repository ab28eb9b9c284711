"""Simulators of vibration that share nothing with the estimators."""
