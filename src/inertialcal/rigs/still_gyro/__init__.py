"""A gyro triad at rest."""

TITLE = "a three-axis rate gyro at rest, averages of 1 s saved every 2 s"
