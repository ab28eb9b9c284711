"""An accelerometer in orbit calibrated by a turned mass."""

TITLE = "a pulse-rate accelerometer in orbit and a mass that turns around it"
