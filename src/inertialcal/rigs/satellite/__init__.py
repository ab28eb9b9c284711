"""A satellite in a low orbit: gyro and magnetometer, no attitude."""

TITLE = "a satellite's gyro and magnetometer over one low orbit, 1 s samples"
