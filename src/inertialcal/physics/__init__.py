"""The world that a sensor is in: earth rate, gravity, attraction, motion."""
