"""An IMU on its six faces."""

TITLE = "an IMU placed on its six faces and turned about its axes, without a turntable"
