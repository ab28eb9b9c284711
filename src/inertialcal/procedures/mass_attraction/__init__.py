"""Scale factor of an accelerometer from the attraction of a moved mass: its schedule, its runs, what they give."""
