"""How results look: tables in a terminal and a notebook, data frames, rounding to the uncertainty."""
