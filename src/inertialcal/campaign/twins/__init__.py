"""Simulated campaigns, and estimates against their truth."""
