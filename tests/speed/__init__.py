"""Speed of what a user calls, as ratios to named peers: the table of ``make bench``."""
