"""Scale factor of an accelerometer in orbit from a mass that is turned around it: programme, runs, what they give."""
