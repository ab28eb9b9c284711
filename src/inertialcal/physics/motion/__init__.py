"""Motion of an attracting mass: travel, window, drive, harmonics."""
