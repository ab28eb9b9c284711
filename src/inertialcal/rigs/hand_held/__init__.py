"""An IMU laid down and turned by hand."""

TITLE = "an IMU laid by hand into many positions, without a turntable"
