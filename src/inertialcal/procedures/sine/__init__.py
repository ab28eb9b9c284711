"""A known drive in drift: a sine of known period, or a sequence of dwells."""
