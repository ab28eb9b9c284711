"""Figures of lots: what units scatter, stations, the course along the lot, units of another kind."""
