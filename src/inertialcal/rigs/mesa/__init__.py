"""An accelerometer calibrated by a moved mass."""

TITLE = "a pulse-rate accelerometer before a moved mass of lead"
