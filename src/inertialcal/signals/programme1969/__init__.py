"""The analysis programme of 1969: its cards, its steps as printed, and the same reductions done right."""
