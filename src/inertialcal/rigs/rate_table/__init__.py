"""A three-axis rate gyro on a stepped rate table."""

TITLE = "a three-axis rate gyro on a stepped rate table, five power-ups to fit and three held out"
