"""Figures of static noise."""
