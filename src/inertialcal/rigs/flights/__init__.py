"""Several flights of one head: what flips found over the years, and the ground model that they shift."""

TITLE = "flips of one triaxial head over several flights, with its ground model: launches shift it, and it ages"
