"""Figures of flip."""
