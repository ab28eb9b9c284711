"""An IMU laid down and turned by hand."""
