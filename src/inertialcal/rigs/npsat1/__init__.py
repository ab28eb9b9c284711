"""The rate-sensor suite of a small satellite."""

TITLE = "a three-axis rate-sensor suite: thermal ramps in air and vacuum, rate table, noise"
