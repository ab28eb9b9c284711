"""An IMU on its six faces."""
