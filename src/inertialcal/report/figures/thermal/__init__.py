"""Figures of thermal."""
