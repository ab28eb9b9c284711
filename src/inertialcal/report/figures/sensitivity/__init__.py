"""Figures of a sensitivity test."""
