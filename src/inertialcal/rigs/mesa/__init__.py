"""An accelerometer calibrated by a moved mass."""
