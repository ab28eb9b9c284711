"""Recordings of one head that is flipped in several flights: the flips are made of them, the ground model shifted."""

TITLE = "recordings of a triaxial head that is flipped in several flights, with its ground model"
