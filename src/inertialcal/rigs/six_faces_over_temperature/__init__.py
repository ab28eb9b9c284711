"""An IMU on its six faces at several temperatures."""

TITLE = "an IMU placed on its six faces at several temperatures, accelerometers whose matrix and bias change"
