"""Records of a sensor at rest: what they tell of each term, and how long to record."""
