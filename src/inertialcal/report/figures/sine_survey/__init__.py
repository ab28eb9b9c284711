"""Figures of a sine survey."""
