"""Records at rest: their clock, faults and disturbances."""
