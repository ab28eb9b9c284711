"""Figures of rate table."""
