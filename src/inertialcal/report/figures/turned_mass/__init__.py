"""Figures of a turned mass and of its plan."""
