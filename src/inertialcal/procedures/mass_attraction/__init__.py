"""Scale factor of an accelerometer from the attraction of a moved mass: its schedule, and what it will give.

A mass is moved between places near the sensor and dwells at each; half the difference of its attraction along the
input axis is the amplitude that is applied, and the sensor's readings follow it in its own drift.
"""

from .schedule import Schedule, repeated

__all__ = ["Schedule", "repeated"]
