"""Figures of sine."""
