"""Figures of the rate table."""
