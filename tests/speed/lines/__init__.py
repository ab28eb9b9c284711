"""The lines of the table of speed, by what they are of; each module enters its own (``speed.comparison``)."""
