"""Figures of random vibration."""
