"""An IMU laid down and turned by hand."""

TITLE = "an IMU placed by hand in many positions, without a turntable"
