"""A rate-sensor suite where its supply, temperature and pressure change."""

TITLE = "a three-axis rate-sensor suite: bias and scale factor against supply, temperature, pressure and warm-up"
