"""A sensor head's ground model: what it reads on the ground, and how it corrects readings."""
