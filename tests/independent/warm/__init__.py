"""Simulators of units at several temperatures."""
