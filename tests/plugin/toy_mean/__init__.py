"""A procedure of another package: the mean reading of a sensor at rest."""
