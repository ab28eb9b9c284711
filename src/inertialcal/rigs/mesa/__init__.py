"""An accelerometer calibrated by a moved mass."""

TITLE = "a pulse-rate accelerometer and a moved mass of lead"
