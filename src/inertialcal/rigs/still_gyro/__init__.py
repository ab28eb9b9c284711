"""A gyro triad at rest."""
