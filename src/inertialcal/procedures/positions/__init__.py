"""Positions: accelerometers and gyros from static positions and the rotations between them, without a turntable."""
