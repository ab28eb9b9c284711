"""Attraction of bodies: field, gradient, and the mean over a proof mass."""
