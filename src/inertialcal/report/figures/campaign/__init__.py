"""Figures of a whole campaign or of its model."""
