"""Figures of the effects of vibration."""
