"""An IMU on its six faces."""

TITLE = "an IMU laid on its six faces and turned about its axes, without a turntable"
