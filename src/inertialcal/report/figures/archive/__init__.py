"""Figures of an archive: the history of a unit, the trend of a quantity."""
