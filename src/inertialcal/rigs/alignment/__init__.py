"""A unit with fine gyros at rest, turned by 180 deg between two positions."""

TITLE = "accelerometers and fine gyros at rest in two positions, turned by 180 deg about the vertical, 10 Hz"
