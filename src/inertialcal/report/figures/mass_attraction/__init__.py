"""Figures of mass attraction."""
