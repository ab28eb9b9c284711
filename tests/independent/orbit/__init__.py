"""Simulators of tests in orbit."""
