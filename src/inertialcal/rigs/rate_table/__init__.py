"""A three-axis rate gyro on a stepped rate table."""

TITLE = "a three-axis rate gyro on a stepped rate table, six power-ups to fit and six held out"
