"""One gate for every record: what in the samples of a channel is no reading, or not of the same kind as the rest."""
