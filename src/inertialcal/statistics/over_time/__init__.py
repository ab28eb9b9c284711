"""Figures of one unit, or of many, over time: drift, control charts."""
