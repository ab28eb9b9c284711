"""One gyro triad on a rate table, as reduced readings."""
