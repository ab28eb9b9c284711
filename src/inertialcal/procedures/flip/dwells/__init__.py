"""Dwells of a turned head cut from its recordings."""
