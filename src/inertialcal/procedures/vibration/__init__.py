"""Random vibration to a profile."""
