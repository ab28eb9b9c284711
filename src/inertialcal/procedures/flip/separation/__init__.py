"""Bias apart from ambient acceleration, and its uncertainty."""
