"""Noise of a sensor at rest: terms with their intervals, what the records cannot tell, how long to record."""
