"""A moved mass planned: shape, motion, orbit, what its test would tell."""
