"""Figures of the flip."""
