"""Figures of the acceleration environment in orbit."""
