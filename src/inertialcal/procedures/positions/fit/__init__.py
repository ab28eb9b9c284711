"""What positions and rotations tell of accelerometers and gyros."""
